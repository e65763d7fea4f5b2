#include "drivers/yaskawa/far_side.hpp"

#include <algorithm>
#include <utility>

#include "drivers/yaskawa/inform.hpp"

namespace polyarm::yaskawa {

namespace {

constexpr wire::OrderKind kKinds[] = {
    {"e_stop", "somebody presses the emergency stop"},
    {"release", "it is released; the servos stay off"},
    {"teach", "somebody turns the key of the pendant: teach"},
    {"play", "the same: play, without remote"},
    {"remote", "the same: remote"},
    {"servo_off", "the servos go off"},
    {"hold", "somebody presses hold; 1: at the pendant, 2: outside, 3: by a command (1)"},
    {"unhold", "every hold is released"},
    {"stop_job", "somebody stops the job INIT_ROS"},
    {"alarm", "an alarm with this number (4107)"},
    {"error", "an error on the pendant"},
    {"reset", "somebody resets alarms and errors"},
    {"touch", "the robot is touched (power and force limiting)"},
    {"let_go", "that ends"},
    {"refuse_step", "the controller refuses the next step of a motion"},
    {"refuse_speed", "points are too fast for it"},
    {"refuse_servo", "the servos do not switch on"},
    {"stuck_job", "the job does not come to its wait for MotoROS"},
    {"other_moves", "something else moves the robot"},
    {"push", "somebody moves the first axis by so many degrees (5)"},
    {"busy", "so many points find the controller busy (10)"},
    {"silent", "MotoROS sends no states"},
    {"late", "so many states come late and together (10)"},
    {"nonsense", "one state is no message"},
    {"mute", "MotoROS gives no answers about motion"},
    {"bad_answer", "one of them is no message"},
    {"other_group", "its states are of another control group"},
    {"other_client", "another client moves the robot"},
    {"close_motion", "MotoROS closes the connection for motion"},
    {"close_state", "the same for states"},
    {"close_io", "the same for signals"},
    {"io_mute", "it gives no answers about signals"},
    {"locked_outputs", "outputs cannot be written"},
    {"hses_mute", "the Ethernet server gives no answers"},
    {"hses_nonsense", "what it sends is no answer"},
    {"hses_refuse", "it refuses each request"},
    {"hses_twice", "it answers twice"},
    {"hses_lost", "so many of its answers get lost (1)"},
    {"no_job", "the job POLYARM is not loaded"},
    {"no_ladder", "no ladder hears the heartbeat of forward mode"},
    {"locked_places", "position variables cannot be written"},
    {"deaf_hold", "a hold by a command is confirmed, and the job runs on"},
    {"meddle", "somebody changes the numbers of moves"},
    {"other_tool", "somebody selects another tool"},
    {"power_off", "the controller loses its power"},
    {"healthy", "ends all of these that are not people's doing"},
};

constexpr std::uint32_t kAlarm = 4107;
constexpr const char* kAlarmName = "OUT OF RANGE (ABSO DATA)";

}  // namespace

FarSide::FarSide(FarSideOptions options)
    : options_(std::move(options)),
      machine_(options_.machine),
      job_(machine_, variables_, moves_job()),
      moto_(machine_, faults_, options_.order,
            std::max(1, (options_.state_ms + options_.machine.interpolation_ms / 2) /
                            options_.machine.interpolation_ms)),
      hses_(machine_, variables_, faults_),
      clock_(0) {
  machine_.tool = options_.tool;
  job_.watchdog = options_.watchdog;
  moto_.listen(options_.address, options_.motion, options_.state, options_.io);
  hses_.open(options_.address, options_.hses);
  clock_.start(nanoseconds(machine_.period()), {[this](std::vector<int>& open) {
                                                  moto_.descriptors(open);
                                                  open.push_back(hses_.descriptor());
                                                },
                                                [this] { serve(); }, [] { return false; },
                                                [this] {
                                                  job_.step(machine_.period());
                                                  moto_.cycle();
                                                }});
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
  order_by_hand(kind, given);
  order_on_wires(kind, given);
  report("ordered: " + fault);
}

void FarSide::order_by_hand(const std::string& kind, int number) {
  const auto is = [&](const char* name) { return kind == name; };
  const auto given = [&](int otherwise) { return number >= 0 ? number : otherwise; };
  if (is("e_stop") || is("release")) machine_.emergency(is("e_stop"));
  if (is("teach")) machine_.turn_key(KeySwitch::teach);
  if (is("play")) machine_.turn_key(KeySwitch::play);
  if (is("remote")) machine_.turn_key(KeySwitch::remote);
  if (is("servo_off")) machine_.switch_servo(false);
  if (is("hold")) machine_.hold(std::clamp(given(1), 1, 3), true);
  if (is("unhold"))
    for (int which = 1; which <= 3; ++which) machine_.hold(which, false);
  if (is("stop_job")) machine_.stop_job();
  if (is("alarm")) machine_.raise_alarm(static_cast<std::uint32_t>(given(kAlarm)), kAlarmName);
  if (is("error")) machine_.raise_error();
  if (is("reset")) machine_.reset();
  if (is("touch") || is("let_go")) machine_.touch(is("touch"));
  if (is("push")) machine_.push_by_hand({static_cast<double>(given(5)), 0, 0, 0, 0, 0});
}

void FarSide::order_on_wires(const std::string& kind, int number) {
  const auto is = [&](const char* name) { return kind == name; };
  const std::pair<const char*, bool*> kSwitches[] = {{"refuse_step", &machine_.refuse_step},
                                                     {"refuse_speed", &machine_.refuse_speed},
                                                     {"refuse_servo", &machine_.refuse_servo},
                                                     {"stuck_job", &machine_.stuck_job},
                                                     {"other_moves", &machine_.other_moves},
                                                     {"silent", &faults_.silent},
                                                     {"nonsense", &faults_.nonsense},
                                                     {"mute", &faults_.mute},
                                                     {"bad_answer", &faults_.bad_answer},
                                                     {"other_group", &faults_.other_group},
                                                     {"other_client", &faults_.other_client},
                                                     {"io_mute", &faults_.io_mute},
                                                     {"locked_outputs", &faults_.locked_outputs},
                                                     {"hses_mute", &faults_.hses_mute},
                                                     {"hses_nonsense", &faults_.hses_nonsense},
                                                     {"hses_refuse", &faults_.hses_refuse},
                                                     {"hses_twice", &faults_.hses_twice},
                                                     {"no_job", &faults_.no_job},
                                                     {"no_ladder", &job_.no_ladder},
                                                     {"locked_places", &faults_.locked_places},
                                                     {"deaf_hold", &machine_.deaf_hold},
                                                     {"power_off", &faults_.power_off}};
  for (const auto& [name, flag] : kSwitches)
    if (is(name)) *flag = true;
  const auto given = [&](int otherwise) { return number >= 0 ? number : otherwise; };
  if (is("busy")) machine_.busy = given(10);
  if (is("late")) faults_.late = given(10);
  if (is("hses_lost")) faults_.hses_lost = given(1);
  if (is("meddle")) variables_.set_number("D080", variables_.number("D080") + 40);
  if (is("other_tool")) machine_.tool.position.x += 0.1;
  if (is("close_motion")) moto_.drop_motion();
  if (is("close_state")) moto_.drop_states();
  if (is("close_io")) moto_.drop_io();
  if (is("power_off")) {
    machine_.switch_servo(false);
    moto_.drop_all();
  }
  if (is("healthy")) make_healthy();
}

void FarSide::make_healthy() {
  faults_ = {};
  machine_.refuse_servo = machine_.stuck_job = machine_.refuse_step = machine_.refuse_speed =
      machine_.other_moves = false;
  machine_.busy = 0;
  machine_.deaf_hold = job_.no_ladder = false;
  machine_.tool = options_.tool;
}

bool FarSide::step(Nanoseconds patience) {
  return clock_.step(by_requests_ ? patience : 0, [this] {
    const std::uint64_t now = hses_.requests();
    return std::exchange(stepped_at_, now) != now;
  });
}

std::pair<std::uint64_t, std::uint64_t> FarSide::sent() {
  const auto lock = clock_.lock();
  return {moto_.states(), moto_.newest()};
}

std::uint64_t FarSide::requests() {
  const auto lock = clock_.lock();
  return moto_.requests() + hses_.requests();
}

void FarSide::serve() {
  moto_.serve();
  hses_.serve();
  if (machine_.ready() == ready_) return;
  ready_ = machine_.ready();
  report(ready_ ? "the job INIT_ROS waits for MotoROS" : "no motion any more");
}

}  // namespace polyarm::yaskawa
