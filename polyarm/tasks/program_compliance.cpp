/// Robots of a program that yield to forces.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "polyarm/tasks/program_moves.hpp"

namespace polyarm::cell {

namespace {
/// s over which the force is averaged before it is compared with its limit. A tool that slides on a hard
/// surface hops: single readings are several times the mean force, and none is a collision.
constexpr double kMeanOfForce = 0.02;

Vec3 force_in(const Wrench& wrench) {
  return {wrench[0], wrench[1], wrench[2]};
}
}  // namespace

void ProgramMoves::comply(const std::string& robot, const program::Compliance& how, ForceReadings& force) {
  Arm& arm = arms_[arm_of(robot, {})];
  moves::RobotMotion& motion = *arm.robot.motion;
  const std::string& name = arm.robot.robot->entry.name;
  check_compliance(arm.robot.robot->entry);
  const Wrench felt = force.wrench(name);
  if (arm.yields_next || (motion.complying() && !motion.compliance_ends()))
    throw Error("wrong-state", "'" + name + "' yields to forces already",
                "write stiff() before another comply()");
  if (motion.riding())
    throw Error("wrong-state", "'" + name + "' follows a belt and cannot yield to forces",
                "leave the belt first");
  moves::ComplianceSettings settings;
  settings.axes = how.axes;
  settings.push = how.push;
  settings.stiffness = how.stiffness;
  settings.damping = how.damping;
  settings.reach = how.reach;
  arm.yields_next = settings;
  begin_next_compliance(arm, felt, force.time());
  arm.yielding = {how.most, force_in(felt), force.time(), {}};
}

void ProgramMoves::check_compliance(const RobotEntry& robot) {
  const auto motion = robot.parameters.find("motion");
  if (motion == robot.parameters.end() || motion->second != "forward") return;
  throw Error("forward-mode",
              "'" + robot.name + "' has `motion: forward`, and its controller does not yield to forces",
              "leave comply() out, or set `motion: stream`");
}

/// After stiff() the robot first comes to rest.
void ProgramMoves::begin_next_compliance(Arm& arm, const Wrench& felt, Nanoseconds time) const {
  moves::RobotMotion& motion = *arm.robot.motion;
  if (!arm.yields_next || motion.complying()) return;
  motion.feed_wrench(felt, time);
  motion.begin_compliance(*std::exchange(arm.yields_next, std::nullopt));
}

/// A stop that gives the motion up, a discard or another controller ends it by itself.
void ProgramMoves::note_end_of_compliance(Arm& arm) const {
  if (!arm.yielding || arm.yielding->failure || arm.yields_next || arm.robot.motion->complying()) return;
  const std::string& name = arm.robot.robot->entry.name;
  arm.yielding->failure =
      Problem{"signal",
              {},
              "'" + name + "' yields to forces no longer: a stop or a discard has ended it",
              "write comply() again before the next move"};
}

/// A move that relies on a tool that yields does not begin with a stiff one: it fails once.
void ProgramMoves::require_compliance(Arm& arm, const Location& where) const {
  note_end_of_compliance(arm);
  if (!arm.yielding || !arm.yielding->failure || std::exchange(arm.yielding->reported, true)) return;
  Problem problem = *arm.yielding->failure;
  problem.where = where;
  throw Error(std::move(problem));
}

void ProgramMoves::stiff(const std::string& robot) {
  Arm& arm = arms_[arm_of(robot, {})];
  note_end_of_compliance(arm);
  const std::optional<Arm::Yielding> was = std::exchange(arm.yielding, std::nullopt);
  arm.yields_next.reset();
  if (arm.robot.motion->complying()) arm.robot.motion->end_compliance();
  if (was && was->failure) throw Error(*was->failure);
}

void ProgramMoves::tick_compliance(ForceReadings& force) {
  for (Arm& arm : arms_) {
    moves::RobotMotion* const motion = arm.robot.motion;
    if (!motion) continue;
    note_end_of_compliance(arm);
    if (!arm.yielding || arm.yielding->failure) continue;
    const std::string& name = arm.robot.robot->entry.name;
    try {
      const Wrench felt = force.wrench(name);
      begin_next_compliance(arm, felt, force.time());
      motion->feed_wrench(felt, force.time());
      Arm::Yielding& yielding = *arm.yielding;
      const double dt = seconds(force.time() - std::exchange(yielding.felt_at, force.time()));
      yielding.felt = yielding.felt + dt / (dt + kMeanOfForce) * (force_in(felt) - yielding.felt);
      const double size = norm(yielding.felt);
      if (size <= yielding.most) continue;
      arm.yielding->failure =
          Problem{"limit",
                  {},
                  fmt::format("the force at the tool of '{}' is {:.0f} N, more than the {:g} N of comply()",
                              name, size, arm.yielding->most),
                  fmt::format("move more slowly, or allow more: most = {:.0f}N", 2 * arm.yielding->most)};
    } catch (const Error& e) {
      arm.yielding->failure = e.problems().front();
    }
    arm.yields_next.reset();
    arm.yielding->reported = !motion->at_end();  // by the moves that are left
    motion->fail_compliance(*arm.yielding->failure);
  }
}

bool ProgramMoves::yields() const {
  return std::any_of(arms_.begin(), arms_.end(), [](const Arm& arm) { return arm.yielding.has_value(); });
}

bool ProgramMoves::stands(const std::string& robot) const {
  return std::all_of(arms_.begin(), arms_.end(), [&](const Arm& arm) {
    return arm.robot.robot->entry.name != robot || !arm.robot.motion || arm.robot.motion->idle();
  });
}

void ProgramMoves::end_compliance() {
  for (Arm& arm : arms_) {
    arm.yielding.reset();
    arm.yields_next.reset();
    if (arm.robot.motion && arm.robot.motion->complying()) arm.robot.motion->end_compliance();
  }
}

}  // namespace polyarm::cell
