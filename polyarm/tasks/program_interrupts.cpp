/// What traps do to the moves of a task, and which of its moves may touch something.
#include <algorithm>

#include "polyarm/tasks/program_moves.hpp"

namespace polyarm::cell {

const std::string& ProgramMoves::name_of(const std::string& robot) const {
  return arms_[arm_of(robot, {})].robot.robot->entry.name;
}

/// A move that is meant to touch permits it until the next move of this robot begins, of whatever origin.
void ProgramMoves::note_touch(Arm& arm, const Moves& moves, bool touch, const Location& where) {
  constexpr std::size_t kMost = 1000;
  if (touch) arm.touches.push_back({moves.first, moves.last, where});
  while (arm.touches.size() > kMost) arm.touches.pop_front();
}

Location ProgramMoves::touch_of(const moves::RobotMotion& motion) const {
  const std::uint64_t now = motion.move_under_way();
  return touch_of(motion, now != 0 ? now : motion.last_id());
}

/// A tool that yields is meant to touch, at rest and in every move.
Location ProgramMoves::touch_of(const moves::RobotMotion& motion, std::uint64_t move) const {
  if (motion.complying()) return {"comply()"};
  for (const Arm& arm : arms_) {
    if (arm.robot.motion != &motion) continue;
    for (const Arm::Touch& touch : arm.touches)
      if (move >= touch.from && move <= touch.to) return touch.where;
  }
  return {};
}

program::Handle ProgramMoves::suspend(const std::vector<std::string>& robots) {
  return interrupt(robots, false);
}

program::Handle ProgramMoves::resume(const std::vector<std::string>& robots) {
  return interrupt(robots, true);
}

/// Stops these robots (empty: all) for a trap, or ends that.
program::Handle ProgramMoves::interrupt(const std::vector<std::string>& robots, bool ends) {
  Interruption out;
  out.ends = ends;
  const auto take = [&](std::size_t i) {
    moves::RobotMotion* const motion = arms_[i].robot.motion;
    if (!motion) return;
    ends ? motion->resume() : motion->suspend();
    out.arms.push_back(i);
  };
  for (const std::string& robot : robots) take(robot_of(robot, {}));
  for (std::size_t i = 0; robots.empty() && i < arms_.size(); ++i) take(i);
  interruptions_[++last_handle_] = std::move(out);
  return last_handle_;
}

void ProgramMoves::abandon(const std::vector<std::string>& robots) {
  const auto end = [&](std::size_t i) {
    if (moves::RobotMotion* const motion = arms_[i].robot.motion; motion && !motion->resumed()) motion->end(1);
  };
  for (const std::string& robot : robots) end(robot_of(robot, {}));
  for (std::size_t i = 0; robots.empty() && i < arms_.size(); ++i) end(i);
}

bool ProgramMoves::is_over(const Interruption& interruption) const {
  return std::all_of(interruption.arms.begin(), interruption.arms.end(), [&](std::size_t i) {
    const moves::RobotMotion* const motion = arms_[i].robot.motion;
    return !motion || motion->resumed() || (!interruption.ends && motion->suspended());
  });
}

/// A program does not continue from another place than where a trap stopped its robot.
program::Progress ProgramMoves::result_of(const Interruption& over) {
  for (const std::size_t i : over.arms) {
    moves::RobotMotion* const motion = arms_[i].robot.motion;
    std::optional<Problem> why = motion && over.ends ? motion->take_return_failure() : std::nullopt;
    if (!why) continue;
    const bool discarded = why->code == "discarded";
    return discarded ? program::Progress::ended(std::move(*why)) : program::Progress::failed(std::move(*why));
  }
  return program::Progress::done();
}

}  // namespace polyarm::cell
