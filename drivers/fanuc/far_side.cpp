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

/// At least three digits.
std::string three_digits(int number) {
  const std::string digits = std::to_string(number);
  return std::string(digits.size() < 3 ? 3 - digits.size() : 0, '0') + digits;
}

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

std::span<const wire::OrderKind> FarSide::order_kinds() {
  return kKinds;
}

void FarSide::order_by_hand(const wire::Order& order) {
  if (order.is("e_stop") || order.is("release")) machine_.emergency(order.is("e_stop"));
  if (order.is("fence_open") || order.is("fence_closed")) machine_.fence(order.is("fence_open"));
  if (order.is("t1")) machine_.teach(TeachMode::t1);
  if (order.is("t2")) machine_.teach(TeachMode::t2);
  if (order.is("auto")) machine_.teach(TeachMode::automatic);
  if (order.is("contact")) machine_.touch();
  if (order.is("motn")) machine_.alarm("MOTN-" + three_digits(order.number_or(603)) + " ST: ordered");
  if (order.is("alarm")) machine_.alarm("SRVO-" + three_digits(order.number_or(65)) + " ordered");
  if (order.is("reset")) machine_.reset();
  if (order.is("abort")) rmi_.abort();
  if (order.is("hold") || order.is("continue")) rmi_.pause(order.is("hold"));
  if (order.is("hold")) stream_.program(false);
}

void FarSide::order_on_wires(const wire::Order& order) {
  faults_.take(order);
  order.switch_on({{"power_off", &faults_.silent},
                   {"stuck", &faults_.stuck},
                   {"wrong_version", &faults_.old},
                   {"no_program", &faults_.no_stream},
                   {"refuse", &faults_.refuse},
                   {"busy", &faults_.busy},
                   {"mute", &faults_.mute}});
  if (order.is("terminate")) rmi_.terminate();
  if (order.is("close_rmi") || order.is("power_off")) rmi_.drop();
  if (order.is("power_off")) machine_.stop();
  if (order.is("healthy")) faults_ = {};
}

bool FarSide::step(Nanoseconds patience) {
  return clock_.step(patience, [this] { return faults_.deaf || faults_.silent || !stream_.unanswered(); });
}

void FarSide::cycle() {
  rmi_.cycle(period());
  stream_.cycle();
}

void FarSide::serve() {
  stream_.serve();
  rmi_.serve();
  report_change(stream_.program_runs(), "STREAM_MOTN runs", "STREAM_MOTN ended");
}

}  // namespace polyarm::fanuc
