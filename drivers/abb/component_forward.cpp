/// The component in forward mode: the controller interpolates.
#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "drivers/abb/component.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::abb {

using hardware::ReturnType;

namespace {

/// "0 0 0.05", in m
RapidLoad load_of(double mass, const std::string& text) {
  RapidLoad out{mass, {}};
  const auto words = split_words(text, " ,;");
  bool fine = words.size() == out.centre.size();
  for (std::size_t i = 0; fine && i < out.centre.size(); ++i) {
    const auto value = parse_number(words[i]);
    fine = value && *value >= -5 && *value <= 5;
    if (fine) out.centre[i] = *value * 1000;
  }
  if (!fine)
    throw Error("bad-value", "'" + text + "' in `tool_centre` is no place of a centre of mass",
                "three numbers in metres, for example 0 0 0.05");
  return out;
}

/// Single requests may be late.
void check_times(double poll_ms, int watchdog_ms) {
  constexpr double kReadings = 4;
  if (watchdog_ms < kReadings * poll_ms)
    throw Error("bad-value",
                fmt::format("`watchdog_ms` is {} and `poll_ms` is {:g}: the program would end the session "
                            "between two readings",
                            watchdog_ms, poll_ms),
                "make `watchdog_ms` at least four times `poll_ms`");
}

}  // namespace

void AbbComponent::make_forward(const hardware::ComponentContext& context, hardware::DriverParameters& p) {
  const hardware::RobotInstance& robot = context.robots.front();
  paced_ = false;  // the program has no clock
  wire::check_forward(robot, joints_);
  const auto joints = wire::six_revolute_joints(*robot.model, "abb/irb_120");
  ForwardSettings out;
  static_cast<ControllerSettings&>(out) = settings_;
  out.moves_port = static_cast<int>(p.number("moves_port"));
  out.frame = forward::frame_of(robot, joints, p.number("line_acceleration"));
  out.load = load_of(p.number("tool_mass"), p.text("tool_centre"));
  out.times = {stepped_services_, nanoseconds(p.number("poll_ms") / 1000), settings_.loop_silence};
  out.watchdog_ms = static_cast<int>(p.number("watchdog_ms"));
  out.timeout = settings_.timeout;
  out.start_timeout = settings_.start_timeout;
  out.answer = nanoseconds(p.number("answer_ms") / 1000);
  p.problems().throw_if_errors();
  check_times(p.number("poll_ms"), out.watchdog_ms);
  flange_ = out.frame.flange;
  readings_ = {};
  forward_ = std::make_unique<ForwardLink>(std::move(out));
}

/// Without a session the joints come over Robot Web Services.
ReturnType AbbComponent::read_forward(const hardware::Cycle& cycle, std::span<double> states) noexcept {
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  forward_->fetch();
  const Panel& panel = forward_->panel();
  ForwardSample sample = forward_->sample();
  const bool guided = guided_ && sample.count > 0;
  if (!guided) {
    sample.dq = {};
    sample.count = ++shown_count_;
  }
  sample.q = shown_position(guided ? sample.q : panel.joints, guided, seconds(cycle.period));
  std::size_t at = show_arm(sample, cycle, kStates, 0, states);
  for (int i = 0; i < 6; ++i) states[at++] = kUnknown;  // force
  using Control = Panel::Control;
  for (const bool on : {panel.control == Control::motors_on, panel.automatic, panel.running, false,
                        panel.control == Control::guard_stop, panel.control == Control::emergency_stop})
    states[at++] = on ? 1 : 0;
  for (const double value : {0.0, kUnknown, panel.speed_ratio, kUnknown, 0.0, 0.0, 0.0}) states[at++] = value;
  show_signals(panel, states.subspan(at));
  return forward_->cause() == Cause::none ? ReturnType::ok : ReturnType::error;
}

ReturnType AbbComponent::write_forward(std::span<const double> commands) noexcept {
  if (forward_->cause() != Cause::none) return ReturnType::error;
  if (!active_) return ReturnType::ok;
  take_outputs(commands);
  forward_->cycle(outputs_);
  return judge_joints(commands);
}

}  // namespace polyarm::abb
