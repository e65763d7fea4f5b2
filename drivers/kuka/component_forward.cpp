/// The component in forward mode: the controller interpolates.
#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "drivers/kuka/component.hpp"
#include "polyarm/base/error.hpp"

namespace polyarm::kuka {

using hardware::ReturnType;

void KukaComponent::make_forward(const hardware::ComponentContext& context, hardware::DriverParameters& p) {
  const hardware::RobotInstance& robot = context.robots.front();
  if (!settings_.eki)
    throw Error("bad-value", "`motion: forward` needs EthernetKRL, and `eki: false` switches it off",
                "leave `eki` out, or set `motion: stream`");
  paced_ = false;  // EthernetKRL has no clock
  wire::check_forward(robot, joints_);
  const auto joints = wire::six_revolute_joints(*robot.model, "kuka/kr_10_r1100_3");
  ForwardSettings out;
  out.host = settings_.host;
  out.eki_port = settings_.eki_port;
  out.drives_on = settings_.drives_on;
  out.outputs = settings_.outputs;
  out.frame = forward::frame_of(robot, joints, p.number("line_acceleration"));
  out.poll = nanoseconds(p.number("poll_ms") / 1000);
  out.answer = nanoseconds(p.number("answer_ms") / 1000);
  out.watchdog_ms = static_cast<int>(p.number("watchdog_ms"));
  out.timeout = settings_.timeout;
  out.start_timeout = settings_.start_timeout;
  out.loop_silence = settings_.loop_silence;
  out.stepped = stepped_link_;
  p.problems().throw_if_errors();
  flange_ = out.frame.flange;
  readings_ = {};
  forward_ = std::make_unique<ForwardLink>(std::move(out));
}

/// What only RSI says is NaN or 0.
ReturnType KukaComponent::read_forward(const hardware::Cycle& cycle, std::span<double> states) noexcept {
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  forward_->fetch();
  const ForwardSample& sample = forward_->sample();
  const EkiState& s = sample.state;
  const bool seen = sample.count > 0;
  std::size_t at = show_arm(sample, cycle, kStates, 0, states);
  const bool automatic = s.mode == OperatingMode::automatic || s.mode == OperatingMode::external;
  for (const bool on : {s.drives, automatic, s.program == ProgramState::active, s.rsi, s.guard_stop,
                        s.emergency_stop, s.message})
    states[at++] = !seen ? kUnknown : on ? 1.0 : 0.0;
  for (const double value : {seen ? s.speed_override / 100.0 : kUnknown, 0.0, 0.0, 0.0, 0.0})
    states[at++] = value;
  add_signals(s, s.inputs, states.subspan(at));
  return forward_->cause() == Cause::none ? ReturnType::ok : ReturnType::error;
}

ReturnType KukaComponent::write_forward(std::span<const double> commands) noexcept {
  if (forward_->cause() != Cause::none) return ReturnType::error;
  if (!active_) return ReturnType::ok;
  std::copy_n(commands.begin() + 6, settings_.outputs.count, outputs_.digital.begin());
  forward_->cycle(outputs_);
  return judge_joints(commands);
}

std::string KukaComponent::forward_summary() const {
  return fmt::format("KUKA controller at {}, {}, its own motion over EthernetKRL", settings_.host,
                     forward_->identity().robot);
}

}  // namespace polyarm::kuka
