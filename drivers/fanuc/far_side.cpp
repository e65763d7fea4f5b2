#include "drivers/fanuc/far_side.hpp"

namespace polyarm::fanuc {

namespace {

constexpr wire::OrderKind kKinds[] = {
    {"e_stop", "somebody presses the emergency stop"},
    {"release", "it is released; the alarm stays until a reset"},
    {"fence_open", "somebody opens the fence"},
    {"fence_closed", "it is closed; the alarm stays until a reset"},
    {"t1", "somebody enables the teach pendant: T1"},
    {"t2", "the same: T2"},
    {"auto", "the teach pendant is disabled: AUTO"},
    {"contact", "a collaborative robot stops at a contact"},
    {"motn", "the controller stops with the alarm MOTN-NUMBER (603: no command in time)"},
    {"alarm", "it stops with the alarm SRVO-NUMBER (65: battery)"},
    {"reset", "the RESET button"},
    {"abort", "somebody aborts all programs"},
    {"hold", "somebody holds the program of remote motion"},
    {"continue", "it goes on"},
    {"silent", "Stream Motion neither sends nor answers"},
    {"late", "so many packets come late and together (10)"},
    {"duplicate", "so many packets come twice (10)"},
    {"reorder", "so many packets come after the next one (10)"},
    {"garbage", "one packet is broken"},
    {"deaf", "Stream Motion takes no commands"},
    {"stuck", "the streaming program does not become ready"},
    {"wrong_version", "Stream Motion has version 1"},
    {"no_program", "STREAM_MOTN is not installed"},
    {"refuse", "remote motion is refused"},
    {"busy", "another program uses the Remote Motion Interface"},
    {"mute", "the Remote Motion Interface gives no answers"},
    {"terminate", "it ends the session, as after a long silence"},
    {"close_rmi", "it closes its connections"},
    {"power_off", "the controller loses its power"},
    {"healthy", "ends silent, deaf, stuck, wrong_version, no_program, refuse, busy, mute and power_off"},
};

}  // namespace

FarSide::FarSide(FarSideOptions options)
    : options_(std::move(options)),
      machine_(options_.machine),
      stream_(machine_, faults_, options_.sampling_ms / 1000.0),
      rmi_(machine_, faults_, stream_),
      clock_(options_.patience) {
  stream_.set_version(options_.version);
  stream_.listen(options_.address, options_.stream);
  rmi_.listen(options_.address, options_.rmi, options_.session);
  clock_.start(nanoseconds(period()),
               {[this](std::vector<int>& open) {
                  open.push_back(stream_.descriptor());
                  rmi_.descriptors(open);
                },
                [this] { serve(); }, [this] { return stream_.unanswered(); }, [this] { cycle(); }});
}

std::string FarSide::kinds() {
  return wire::order_list(kKinds);
}

std::vector<wire::TimedOrder> FarSide::timed_orders(const std::string& text) {
  return wire::parse_timed_orders(text, "e_stop@3 release@again reset@again", kKinds);
}

void FarSide::report(const std::string& text) const {
  if (options_.report) options_.report(text);
}

void FarSide::order(const std::string& fault) {
  const auto [kind, given] = wire::parse_order(fault, kKinds);
  const int number = given >= 0 ? given : kind == "motn" ? 603 : kind == "alarm" ? 65 : 10;
  const auto lock = clock_.lock();
  order_by_hand(kind);
  order_on_wires(kind, number);
  std::string digits = std::to_string(number);
  digits.insert(0, digits.size() < 3 ? 3 - digits.size() : 0, '0');
  if (kind == "motn") machine_.alarm("MOTN-" + digits + " ST: ordered");
  if (kind == "alarm") machine_.alarm("SRVO-" + digits + " ordered");
  report("ordered: " + fault);
}

void FarSide::order_by_hand(const std::string& kind) {
  const auto is = [&](const char* name) { return kind == name; };
  if (is("e_stop") || is("release")) machine_.emergency(is("e_stop"));
  if (is("fence_open") || is("fence_closed")) machine_.fence(is("fence_open"));
  if (is("t1")) machine_.teach(TeachMode::t1);
  if (is("t2")) machine_.teach(TeachMode::t2);
  if (is("auto")) machine_.teach(TeachMode::automatic);
  if (is("contact")) machine_.touch();
  if (is("reset")) machine_.reset();
  if (is("abort")) rmi_.abort();
  if (is("hold") || is("continue")) rmi_.pause(is("hold"));
  if (is("hold")) stream_.program(false);
}

void FarSide::order_on_wires(const std::string& kind, int number) {
  const auto is = [&](const char* name) { return kind == name; };
  if (is("silent") || is("power_off")) faults_.silent = true;
  if (is("late")) faults_.late = number;
  if (is("duplicate")) faults_.duplicate = number;
  if (is("reorder")) faults_.reorder = number;
  if (is("garbage")) faults_.garbage = true;
  if (is("deaf")) faults_.deaf = true;
  if (is("stuck")) faults_.stuck = true;
  if (is("wrong_version")) faults_.old = true;
  if (is("no_program")) faults_.no_stream = true;
  if (is("refuse")) faults_.refuse = true;
  if (is("busy")) faults_.busy = true;
  if (is("mute")) faults_.mute = true;
  if (is("terminate")) rmi_.terminate();
  if (is("close_rmi") || is("power_off")) rmi_.drop();
  if (is("power_off")) machine_.stop();
  if (is("healthy")) faults_ = {};
}

void FarSide::hold_clock(bool on) {
  clock_.hold(on);
}

bool FarSide::step(Nanoseconds patience) {
  return clock_.step(patience, [this] { return faults_.deaf || faults_.silent || !stream_.waits(); });
}

std::uint32_t FarSide::sent_sequence() {
  const auto lock = clock_.lock();
  return stream_.sent_sequence();
}

std::uint64_t FarSide::commands() {
  const auto lock = clock_.lock();
  return stream_.commands();
}

bool FarSide::program_runs() {
  const auto lock = clock_.lock();
  return stream_.program_runs();
}

std::uint64_t FarSide::instructions_done() {
  const auto lock = clock_.lock();
  return rmi_.done();
}

void FarSide::cycle() {
  rmi_.cycle(period());
  stream_.cycle();
}

void FarSide::serve() {
  stream_.serve();
  rmi_.serve();
  const bool runs = stream_.program_runs();
  if (runs == ran_) return;
  ran_ = runs;
  report(runs ? "STREAM_MOTN runs" : "STREAM_MOTN ended");
}

}  // namespace polyarm::fanuc
