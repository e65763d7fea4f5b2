/// Robots of a program that yield to forces.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "polyarm/tasks/program_moves.hpp"

namespace polyarm::cell {

void ProgramMoves::comply(const std::string& robot, const program::Compliance& how, ForceReadings& force) {
  Arm& arm = arms_[arm_of(robot, {})];
  moves::RobotMotion& motion = *arm.robot.motion;
  const std::string& name = arm.robot.robot->entry.name;
  const Wrench felt = force.wrench(name);
  if (motion.complying())
    throw Error("value", "'" + name + "' yields to forces already", "write stiff() before another comply()");
  if (motion.riding())
    throw Error("value", "'" + name + "' follows a belt and cannot yield to forces", "leave the belt first");
  moves::ComplianceSettings settings;
  settings.axes = how.axes;
  settings.push = how.push;
  settings.stiffness = how.stiffness;
  settings.damping = how.damping;
  settings.reach = how.reach;
  motion.feed_wrench(felt, force.time());
  motion.begin_compliance(settings);
  arm.yielding = {how.most, {}};
}

void ProgramMoves::stiff(const std::string& robot) {
  Arm& arm = arms_[arm_of(robot, {})];
  const std::optional<Arm::Yielding> was = std::exchange(arm.yielding, std::nullopt);
  if (arm.robot.motion->complying()) arm.robot.motion->end_compliance();
  if (was && was->failure) throw Error(*was->failure);
}

void ProgramMoves::tick_compliance(ForceReadings& force) {
  for (Arm& arm : arms_) {
    moves::RobotMotion* const motion = arm.robot.motion;
    if (!motion || !motion->complying() || !arm.yielding || arm.yielding->failure) continue;
    const std::string& name = arm.robot.robot->entry.name;
    try {
      const Wrench felt = force.wrench(name);
      motion->feed_wrench(felt, force.time());
      const double size = std::hypot(felt[0], felt[1], felt[2]);
      if (size <= arm.yielding->most) continue;
      arm.yielding->failure =
          Problem{"limit",
                  {},
                  fmt::format("the force at the tool of '{}' is {:.0f} N, more than the {:g} N of comply()",
                              name, size, arm.yielding->most),
                  "move more slowly, or allow more: most = 200N"};
    } catch (const Error& e) {
      arm.yielding->failure = e.problems().front();
    }
    motion->fail_compliance(*arm.yielding->failure);
  }
}

bool ProgramMoves::stands(const std::string& robot) const {
  return std::all_of(arms_.begin(), arms_.end(), [&](const Arm& arm) {
    return arm.robot.robot->entry.name != robot || !arm.robot.motion || arm.robot.motion->idle();
  });
}

void ProgramMoves::end_compliance() {
  for (Arm& arm : arms_) {
    arm.yielding.reset();
    if (arm.robot.motion && arm.robot.motion->complying()) arm.robot.motion->end_compliance();
  }
}

}  // namespace polyarm::cell
