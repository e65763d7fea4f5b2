/// The component in forward mode: the controller interpolates.
#include <memory>

#include "drivers/ur/component.hpp"
#include "polyarm/base/error.hpp"

namespace polyarm::ur {

using hardware::ReturnType;

void UrComponent::make_forward(const hardware::ComponentContext& context, hardware::DriverParameters& p) {
  constexpr double kAcceleration = 10;  // rad/s², of a joint whose description states none
  const hardware::RobotInstance& robot = context.robots.front();
  if (!settings_.io)
    throw Error("bad-value",
                "`motion: forward` sets the speed slider of the controller, and `io: false` forbids it",
                "leave `io` out, or set `motion: stream`");
  if (!positions_)
    throw Error("bad-value", "`motion: forward` needs joints that take positions",
                "add position to the command interfaces of the joints, or set `motion: stream`");
  wire::check_forward(robot, joints_);
  const auto joints = wire::six_revolute_joints(*robot.model, "universal_robots/ur5e");
  MoveFrame frame;
  frame.base = robot.base;
  frame.flange = std::make_shared<const kinematics::Chain>(
      *robot.model, forward::tool_flange(*robot.model, joints.back()->child_link));
  for (std::size_t i = 0; i < 6; ++i) {
    frame.velocity[i] = velocity_limits_[i];
    frame.acceleration[i] = joints[i]->limits.acceleration.value_or(kAcceleration);
  }
  frame.line_acceleration = p.number("line_acceleration");
  p.problems().throw_if_errors();
  settings_.forward = std::move(frame);
}

hardware::ForwardMoves* UrComponent::forward_moves(std::uint32_t layout) noexcept {
  return layout == hardware::kForwardLayout && link_ ? link_->moves() : nullptr;
}

ReturnType UrComponent::write_moves(std::span<const double> commands, const wire::Six& measured) noexcept {
  if (const auto joint = watch_.strays(commands, measured)) {
    link_->fail(Cause::joint_commands, *joint);
    return ReturnType::error;
  }
  last_command_ = link_->command(Mode::hold, {});
  return ReturnType::ok;
}

}  // namespace polyarm::ur
