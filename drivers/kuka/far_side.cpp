#include "drivers/kuka/far_side.hpp"

#include "polyarm/base/error.hpp"

namespace polyarm::kuka {

namespace {

constexpr wire::OrderKind kKinds[] = {
    {"e_stop", "somebody presses the emergency stop"},
    {"release", "it is released; the drives stay off"},
    {"guard_open", "somebody opens the guard (operator safety)"},
    {"guard_closed", "it is closed; the drives stay off"},
    {"acknowledge", "somebody acknowledges the messages"},
    {"t1", "somebody turns the key: T1"},
    {"t2", "the same: T2"},
    {"aut", "the same: AUT"},
    {"ext", "the same: EXT"},
    {"drives_off", "somebody switches the drives off"},
    {"stop", "somebody stops the program at the smartPAD"},
    {"cancel", "somebody deselects it"},
    {"play", "somebody presses Start for a program that was stopped"},
    {"rsi_off", "RSI ends, the program goes on"},
    {"collision", "a collision stops the robot, with a message"},
    {"small_limit", "the context of RSI allows so many degrees less than it says (359)"},
    {"silent", "RSI sends nothing"},
    {"deaf", "RSI takes no answers"},
    {"late", "so many packets come late and together (10)"},
    {"duplicate", "so many packets come twice (10)"},
    {"reorder", "so many packets come after the next one (10)"},
    {"garbage", "one packet is broken"},
    {"again", "the clock (IPOC) begins anew"},
    {"skip", "the clock jumps ahead by so many ms (10)"},
    {"slow", "the clock has the other cycle"},
    {"stranger", "the packets come from another sender"},
    {"mute", "EthernetKRL gives no answers"},
    {"nonsense", "what it sends is no XML"},
    {"busy", "it has another client"},
    {"close_eki", "it closes its connections"},
    {"other_program", "the program there has another version"},
    {"old_rsi", "RSI 2 (KR C2)"},
    {"seven", "the controller has seven axes"},
    {"rsi_error", "RSI_CREATE returns this number (4)"},
    {"refuse_start", "the program starts neither RSI nor moves"},
    {"refuse_moves", "the program of moves takes none"},
    {"silent_halts", "it never says that it stopped the robot"},
    {"refuse_drives", "the drives do not switch on"},
    {"locked_outputs", "outputs cannot be written"},
    {"power_off", "the controller loses its power"},
    {"healthy", "ends all of these that are not people's doing"},
};

}  // namespace

FarSide::FarSide(FarSideOptions options)
    : options_(std::move(options)),
      machine_(options_.machine),
      moves_(machine_),
      rsi_(machine_, faults_, options_.sen_type),
      eki_(machine_, moves_, faults_),
      clock_(options_.patience) {
  options_.machine = machine_.options();
  eki_.listen(options_.address, options_.eki);
  rsi_.open(options_.address);
  if (options_.rsi > 0) rsi_.send_to(options_.rsi_host, options_.rsi);
  if (options_.running) machine_.start();
  clock_.start(nanoseconds(machine_.period()), {[this](std::vector<int>& open) {
                                                  open.push_back(rsi_.descriptor());
                                                  eki_.descriptors(open);
                                                },
                                                [this] { serve(); }, [this] { return rsi_.waits(); },
                                                [this] {
                                                  moves_.step(machine_.period());
                                                  rsi_.cycle();
                                                }});
}

void FarSide::send_rsi_to(const std::string& host, int port) {
  const auto lock = clock_.lock();
  rsi_.send_to(host, port);
}

std::string FarSide::kinds() {
  return wire::order_list(kKinds);
}

std::vector<wire::TimedOrder> FarSide::timed_orders(const std::string& text) {
  return wire::parse_timed_orders(text, "e_stop@3", kKinds);
}

void FarSide::report(const std::string& text) const {
  if (options_.report) options_.report(text);
}

void FarSide::order(const std::string& fault) {
  const auto [kind, given] = wire::parse_order(fault, kKinds);
  const auto lock = clock_.lock();
  order_by_hand(kind);
  order_on_wires(kind, given);
  report("ordered: " + fault);
}

void FarSide::order_by_hand(const std::string& kind) {
  const auto is = [&](const char* name) { return kind == name; };
  if (is("e_stop") || is("release")) machine_.emergency(is("e_stop"));
  if (is("guard_open") || is("guard_closed")) machine_.guard(is("guard_open"));
  if (is("acknowledge")) machine_.acknowledge();
  if (is("t1")) machine_.set_mode(OperatingMode::t1);
  if (is("t2")) machine_.set_mode(OperatingMode::t2);
  if (is("aut")) machine_.set_mode(OperatingMode::automatic);
  if (is("ext")) machine_.set_mode(OperatingMode::external);
  if (is("drives_off")) machine_.switch_drives(false);
  if (is("stop")) machine_.stop_program();
  if (is("cancel")) machine_.cancel_program();
  if (is("play")) machine_.press_start();
  if (is("rsi_off")) machine_.end_rsi();
  if (is("collision")) machine_.stop_with_message();
}

void FarSide::order_on_wires(const std::string& kind, int number) {
  const auto is = [&](const char* name) { return kind == name; };
  const std::pair<const char*, bool*> kSwitches[] = {{"silent", &faults_.silent},
                                                     {"deaf", &faults_.deaf},
                                                     {"garbage", &faults_.garbage},
                                                     {"again", &machine_.renew_clock},
                                                     {"slow", &machine_.slow},
                                                     {"stranger", &faults_.stranger},
                                                     {"mute", &faults_.mute},
                                                     {"nonsense", &faults_.nonsense},
                                                     {"busy", &faults_.busy},
                                                     {"other_program", &faults_.other_program},
                                                     {"refuse_start", &machine_.refuse_start},
                                                     {"refuse_drives", &machine_.refuse_drives},
                                                     {"locked_outputs", &machine_.locked_outputs},
                                                     {"refuse_moves", &moves_.refuse},
                                                     {"silent_halts", &moves_.confirms_not},
                                                     {"power_off", &faults_.power_off}};
  for (const auto& [name, flag] : kSwitches)
    if (is(name)) *flag = true;
  const auto given = [&](int otherwise) { return number >= 0 ? number : otherwise; };
  if (is("late")) faults_.late = given(10);
  if (is("duplicate")) faults_.duplicate = given(10);
  if (is("reorder")) faults_.reorder = given(10);
  if (is("skip")) machine_.skip = static_cast<std::uint64_t>(given(10));
  if (is("rsi_error")) machine_.rsi_error = given(4);
  if (is("small_limit")) machine_.hidden_limit = given(359);
  if (is("old_rsi")) machine_.options().identity.rsi = 2;
  if (is("seven")) machine_.options().identity.axes = 7;
  if (is("close_eki")) eki_.drop();
  if (is("power_off")) {
    machine_.switch_drives(false);
    machine_.cancel_program();
    eki_.drop();
  }
  if (is("healthy")) make_healthy();
}

void FarSide::make_healthy() {
  faults_ = {};
  machine_.slow = machine_.refuse_start = machine_.refuse_drives = machine_.locked_outputs = false;
  moves_.refuse = moves_.confirms_not = false;
  machine_.rsi_error = 0;
  machine_.hidden_limit = 0;
  machine_.options().identity = options_.machine.identity;
}

void FarSide::hold_clock(bool on) {
  clock_.hold(on);
}

bool FarSide::step(Nanoseconds patience) {
  return clock_.step(
      patience, [this] { return faults_.silent || faults_.power_off || faults_.stranger || !rsi_.waits(); });
}

std::pair<std::uint64_t, std::uint64_t> FarSide::sent() {
  const auto lock = clock_.lock();
  return {rsi_.packets(), rsi_.sent_clock()};
}

std::uint64_t FarSide::answers() {
  const auto lock = clock_.lock();
  return rsi_.answers();
}

std::uint64_t FarSide::requests() {
  const auto lock = clock_.lock();
  return eki_.requests();
}

bool FarSide::takes_moves() {
  const auto lock = clock_.lock();
  return moves_.is_open();
}

void FarSide::serve() {
  rsi_.serve();
  eki_.serve();
  const bool runs = machine_.rsi();
  if (runs == ran_) return;
  ran_ = runs;
  report(runs ? "RSI runs" : "RSI ended");
}

}  // namespace polyarm::kuka
