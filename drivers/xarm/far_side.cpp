#include "drivers/xarm/far_side.hpp"

#include <algorithm>

#include "drivers/xarm/words.hpp"

namespace polyarm::xarm {

namespace {

constexpr Nanoseconds kPatience = 20'000'000;
constexpr wire::OrderKind kKinds[] = {
    {"e_stop", "somebody presses an emergency stop; 1: control box, 2: its input, 3: enabling switch (1)"},
    {"release", "it is released; the error stays"},
    {"error", "an error with this number (31: a collision)"},
    {"warning", "a warning with this number (14)"},
    {"clear", "somebody clears the error in UFACTORY Studio"},
    {"pause", "somebody pauses"},
    {"stop", "somebody presses stop"},
    {"ready", "somebody sets the state to ready"},
    {"teach", "somebody switches manual mode on"},
    {"mode", "another program chooses this mode (0)"},
    {"motors_off", "the motors are switched off"},
    {"push", "somebody moves the first joint by so many degrees (5)"},
    {"other_moves", "something else moves the robot"},
    {"refuse_enable", "the motors do not switch on"},
    {"refuse_mode", "servo mode is not taken"},
    {"refuse_state", "it does not become ready"},
    {"refuse_servo", "servo commands are invalid"},
    {"refuse_moves", "moves are invalid"},
    {"refuse_tool", "another TCP is not taken"},
    {"ignore_stop", "programs cannot stop it"},
    {"locked_outputs", "outputs cannot be written"},
    {"other_axes", "the version names an arm with so many axes (7)"},
    {"silent", "no reports"},
    {"late", "so many reports come late and together (10)"},
    {"nonsense", "one report is not valid"},
    {"short_report", "one report has a length that is too small"},
    {"not_a_number", "one report has a position that is NaN"},
    {"mute", "no answers"},
    {"late_answers", "the answers of so many cycles come late and together (5)"},
    {"bad_answer", "one answer is no frame"},
    {"other_register", "one answer is that to another request"},
    {"twice", "each answer comes twice"},
    {"close_command", "the connections for commands close"},
    {"close_report", "the same for reports"},
    {"power_off", "the controller loses its power"},
    {"healthy", "ends all of these that are not people's doing"},
};

}  // namespace

FarSide::FarSide(FarSideOptions options)
    : options_(std::move(options)),
      machine_(options_.machine),
      ux_(machine_, faults_, std::max(1, options_.real_ms / options_.machine.cycle_ms),
          std::max(1, options_.slow_ms / options_.machine.cycle_ms)),
      clock_(0) {
  ux_.listen(options_.address, options_.ports);
  clock_.start(nanoseconds(machine_.period()),
               {[this](std::vector<int>& open) { ux_.descriptors(open); }, [this] { serve(); },
                [] { return false; }, [this] { ux_.cycle(); }});
}

std::span<const wire::OrderKind> FarSide::order_kinds() {
  return kKinds;
}

void FarSide::order_by_hand(const wire::Order& order) {
  if (order.is("e_stop")) machine_.emergency(std::clamp(order.number_or(1), 1, 3), true);
  if (order.is("release")) machine_.emergency(0, false);
  if (order.is("error")) machine_.raise_error(std::clamp(order.number_or(31), 1, 255));
  if (order.is("warning")) machine_.raise_warning(std::clamp(order.number_or(14), 1, 255));
  if (order.is("clear")) machine_.answer({0, kPrivateProtocol, Register::clean_error, {}});
  if (order.is("pause")) machine_.set_state(static_cast<int>(State::paused));
  if (order.is("stop")) machine_.set_state(static_cast<int>(State::stopped));
  if (order.is("ready")) machine_.set_state(0);
  if (order.is("teach")) machine_.set_mode(static_cast<int>(Mode::joint_teach));
  if (order.is("mode")) machine_.set_mode(std::clamp(order.number_or(0), 0, 7));
  if (order.is("motors_off")) machine_.switch_motors(false);
  if (order.is("push")) machine_.push_by_hand({static_cast<double>(order.number_or(5)), 0, 0, 0, 0, 0, 0});
}

void FarSide::order_on_wires(const wire::Order& order) {
  order.switch_on({{"other_moves", &machine_.other_moves},
                   {"refuse_enable", &machine_.refuse_enable},
                   {"refuse_mode", &machine_.refuse_mode},
                   {"refuse_state", &machine_.refuse_state},
                   {"refuse_servo", &machine_.refuse_servo},
                   {"refuse_moves", &machine_.refuse_moves},
                   {"refuse_tool", &machine_.refuse_tool},
                   {"ignore_stop", &machine_.ignore_stop},
                   {"locked_outputs", &machine_.locked_outputs},
                   {"silent", &faults_.silent},
                   {"nonsense", &faults_.nonsense},
                   {"short_report", &faults_.short_report},
                   {"not_a_number", &faults_.not_a_number},
                   {"mute", &faults_.mute},
                   {"bad_answer", &faults_.bad_answer},
                   {"other_register", &faults_.other_register},
                   {"twice", &faults_.twice},
                   {"power_off", &faults_.power_off}});
  if (order.is("other_axes")) machine_.other_axes = std::clamp(order.number_or(7), 1, 7);
  order.set_count({{"late", &faults_.late, 10}, {"late_answers", &faults_.late_answers, 5}});
  if (order.is("close_command")) ux_.drop_commands();
  if (order.is("close_report")) ux_.drop_reports();
  if (order.is("power_off")) {
    machine_.switch_motors(false);
    ux_.drop_all();
  }
  if (order.is("healthy")) make_healthy();
}

void FarSide::make_healthy() {
  faults_ = {};
  for (bool* one : {&machine_.other_moves, &machine_.refuse_enable, &machine_.refuse_mode,
                    &machine_.refuse_state, &machine_.refuse_servo, &machine_.refuse_moves,
                    &machine_.refuse_tool, &machine_.ignore_stop, &machine_.locked_outputs})
    *one = false;
  machine_.other_axes = 0;
}

bool FarSide::step(Nanoseconds patience) {
  return clock_.step(std::min(patience, kPatience), [this] { return !machine_.awaits_target(); });
}

void FarSide::serve() {
  ux_.serve();
  report_change(machine_.is_ready(), "ready for motion", "not ready for motion");
}

}  // namespace polyarm::xarm
