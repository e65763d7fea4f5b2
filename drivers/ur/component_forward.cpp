/// The component in forward mode: the controller interpolates.
#include <algorithm>

#include "drivers/ur/component.hpp"
#include "polyarm/base/error.hpp"

namespace polyarm::ur {

using hardware::ReturnType;

void UrComponent::make_forward(const hardware::ComponentContext& context, hardware::DriverParameters& p) {
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
  MoveFrame frame = forward::frame_of(robot, joints, p.number("line_acceleration"));
  std::copy_n(velocity_limits_.begin(), frame.velocity.size(), frame.velocity.begin());
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
