#include "drivers/kuka/far_side.hpp"

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

std::span<const wire::OrderKind> FarSide::order_kinds() {
  return kKinds;
}

void FarSide::order_by_hand(const wire::Order& order) {
  if (order.is("e_stop") || order.is("release")) machine_.emergency(order.is("e_stop"));
  if (order.is("guard_open") || order.is("guard_closed")) machine_.guard(order.is("guard_open"));
  if (order.is("acknowledge")) machine_.acknowledge();
  if (order.is("t1")) machine_.set_mode(OperatingMode::t1);
  if (order.is("t2")) machine_.set_mode(OperatingMode::t2);
  if (order.is("aut")) machine_.set_mode(OperatingMode::automatic);
  if (order.is("ext")) machine_.set_mode(OperatingMode::external);
  if (order.is("drives_off")) machine_.switch_drives(false);
  if (order.is("stop")) machine_.stop_program();
  if (order.is("cancel")) machine_.cancel_program();
  if (order.is("play")) machine_.press_start();
  if (order.is("rsi_off")) machine_.end_rsi();
  if (order.is("collision")) machine_.stop_with_message();
}

void FarSide::order_on_wires(const wire::Order& order) {
  faults_.take(order);
  order.switch_on({{"again", &machine_.renew_clock},
                   {"slow", &machine_.slow},
                   {"mute", &faults_.mute},
                   {"nonsense", &faults_.nonsense},
                   {"busy", &faults_.busy},
                   {"other_program", &faults_.other_program},
                   {"refuse_start", &machine_.refuse_start},
                   {"refuse_drives", &machine_.refuse_drives},
                   {"locked_outputs", &machine_.locked_outputs},
                   {"refuse_moves", &moves_.refuse},
                   {"silent_halts", &moves_.confirms_not},
                   {"power_off", &faults_.power_off}});
  if (order.is("rsi_error")) machine_.rsi_error = order.number_or(4);
  if (order.is("small_limit")) machine_.hidden_limit = order.number_or(359);
  if (order.is("skip")) machine_.skip = static_cast<std::uint64_t>(order.number_or(10));
  if (order.is("old_rsi")) machine_.options().identity.rsi = 2;
  if (order.is("seven")) machine_.options().identity.axes = 7;
  if (order.is("close_eki")) eki_.drop();
  if (order.is("power_off")) {
    machine_.switch_drives(false);
    machine_.cancel_program();
    eki_.drop();
  }
  if (order.is("healthy")) make_healthy();
}

void FarSide::make_healthy() {
  faults_ = {};
  machine_.slow = machine_.refuse_start = machine_.refuse_drives = machine_.locked_outputs = false;
  moves_.refuse = moves_.confirms_not = false;
  machine_.rsi_error = 0;
  machine_.hidden_limit = 0;
  machine_.options().identity = options_.machine.identity;
}

bool FarSide::step(Nanoseconds patience) {
  return clock_.step(patience, [this] {
    return faults_.silent || faults_.power_off || faults_.stranger || !rsi_.unanswered();
  });
}

void FarSide::serve() {
  rsi_.serve();
  eki_.serve();
  report_change(machine_.rsi(), "RSI runs", "RSI ended");
}

}  // namespace polyarm::kuka
