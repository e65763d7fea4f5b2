/// The component in forward mode: the controller interpolates.
#include <algorithm>
#include <cmath>
#include <limits>

#include "drivers/fanuc/component.hpp"
#include "polyarm/base/error.hpp"

namespace polyarm::fanuc {

using hardware::ReturnType;

void FanucComponent::make_forward(const hardware::ComponentContext& context, hardware::DriverParameters& p) {
  const hardware::RobotInstance& robot = context.robots.front();
  paced_ = false;  // the interface has no clock
  wire::check_forward(robot, joints_);
  const wire::AxisFacts axes = wire::axis_facts(*robot.model, "fanuc/crx_10ia_l", 1);
  ForwardSettings out;
  out.host = settings_.host;
  out.rmi_port = settings_.rmi_port;
  out.inputs = settings_.inputs, out.outputs = settings_.outputs;
  out.frame.base = robot.base;
  out.frame.flange = std::make_shared<const kinematics::Chain>(*robot.model, axes.flange);
  out.frame.world_height = out.frame.flange->axes().at(1).point.z;
  out.frame.tool = static_cast<int>(p.number("tool_number"));
  out.frame.ramp = p.number("ramp");
  out.window = static_cast<int>(p.number("window"));
  out.poll = nanoseconds(p.number("poll_ms") / 1000);
  out.silence = nanoseconds(p.number("answer_ms") / 1000);
  out.loop_silence = settings_.loop_silence;
  out.connect_timeout = settings_.connect_timeout, out.start_timeout = settings_.start_timeout;
  out.stepped = stepped_forward_;
  p.problems().throw_if_errors();
  flange_ = out.frame.flange;
  world_height_ = out.frame.world_height;
  forward_ = std::make_unique<ForwardLink>(std::move(out));
}

/// What only Stream Motion says is NaN.
ReturnType FanucComponent::read_forward(const hardware::Cycle& cycle, std::span<double> states) noexcept {
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  constexpr std::size_t kForces = 6;
  forward_->fetch();
  const ForwardSample& sample = forward_->sample();
  std::size_t at = show_arm(sample, cycle, kStates, world_height_, states);
  for (std::size_t i = 0; i < kForces; ++i) states[at++] = kUnknown;
  for (const double value : {sample.ready ? 1.0 : 0.0, sample.moving ? 1.0 : 0.0, sample.error ? 1.0 : 0.0,
                             sample.teach ? 1.0 : 0.0, kUnknown, kUnknown, kUnknown, 0.0, 0.0, 0.0})
    states[at++] = value;
  for (std::size_t i = 0; i < static_cast<std::size_t>(settings_.inputs.count); ++i)
    states[at++] = sample.inputs[i];
  for (std::size_t i = 0; i < static_cast<std::size_t>(settings_.outputs.count); ++i)
    states[at++] = sample.outputs[i];
  return forward_->cause() == Cause::none ? ReturnType::ok : ReturnType::error;
}

ReturnType FanucComponent::write_forward(std::span<const double> commands) noexcept {
  if (forward_->cause() != Cause::none) return ReturnType::error;
  if (!active_) return ReturnType::ok;
  std::copy_n(commands.begin() + 6, settings_.outputs.count, outputs_.digital.begin());
  forward_->cycle(outputs_);
  return judge_joints(commands);
}

}  // namespace polyarm::fanuc
