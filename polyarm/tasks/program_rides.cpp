/// Moves of a program in the frames of belts.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "polyarm/setup/safety_entries.hpp"
#include "polyarm/tasks/program_moves.hpp"

namespace polyarm::cell {

/// The belt that the frame is or hangs on; empty: none.
std::string ProgramMoves::belt_of_frame(const std::string& name) const {
  if (!belts_ || name.empty()) return {};
  const std::string root = chain_of(name).root;
  return belts_->has(root) ? root : std::string{};
}

/// The belt that the robot follows in this move; empty: none.
std::string ProgramMoves::belt_of(const program::Move& move, const Location& where) const {
  if (!belts_) return {};
  std::set<std::string> belts;
  for (const program::Move::Target& target : move.targets) {
    const data::Point* point = target.value.as_point();
    const bool own = point && !point->frame().empty();
    const bool in_frame = target.value.as_record() || (point && !own);
    belts.insert(own        ? belt_of_frame(point->frame())
                 : in_frame ? belt_of_frame(move.named_frame())
                            : std::string{});
  }
  if (belts.size() > 1)
    throw Error(Problem{"bad-move", where, "this move has points on a belt and others that are not on it",
                        "write one move for each of them"});
  std::string belt = belts.empty() ? std::string{} : *belts.begin();
  if (!belt.empty() && move.step.group != 0)
    throw Error(Problem{"bad-move", where, "robots cannot move in step on the belt '" + belt + "'",
                        "write a task for each robot"});
  return belt;
}

/// Of the part that the robot took last: where it was when the robot began to follow it, else where it is
/// now.
Pose ProgramMoves::belt_frame(const std::string& belt, const Arm& arm, const Location& where) const {
  try {
    const BeltPart& part = belts_->part(belt, arm.robot.robot->entry.name);
    return belts_->pose(belt, part, follows(arm, belt) ? arm.ride->travel : belts_->travel(belt).travel);
  } catch (const Error& e) {
    Problem problem = e.problems().front();
    problem.where = where;
    throw Error(problem);
  }
}

/// True if the robot follows the part of the belt that it took last.
bool ProgramMoves::follows(const Arm& arm, const std::string& belt) const {
  return arm.ride && arm.ride->belt == belt && arm.robot.motion && arm.robot.motion->riding() &&
         arm.ride->part.number == belts_->part(belt, arm.robot.robot->entry.name).number;
}

bool ProgramMoves::next_part(const std::string& belt, const std::string& robot) {
  return belts_ && belts_->next_part(belt, name_of(robot));
}

void ProgramMoves::suppose_part(const std::string& belt, const std::string& robot) {
  if (belts_) belts_->suppose_part(belt, name_of(robot));
}

bool ProgramMoves::ready_for(const program::Move& move, const Location& where) {
  if (move.of_base()) return true;
  Arm& arm = arms_[arm_of(move.robot, where)];
  moves::RobotMotion& motion = *arm.robot.motion;
  if (motion.compliance_ends() || arm.yields_next) {
    motion.close();
    return false;
  }
  if (!belts_) return true;
  const std::string belt = belt_of(move, where);
  if (motion.riding() ? !belt.empty() && !motion.ride_ends() && follows(arm, belt) : belt.empty())
    return true;
  motion.close();
  if (motion.riding()) motion.end_ride();
  if (!arm.open.empty() && motion.ended_badly_from(arm.open.front().id)) return !motion.riding();
  if (!motion.at_end() || motion.riding()) return false;
  if (belt.empty()) return true;
  const BeltPart& part = belts_->part(belt, arm.robot.robot->entry.name);
  return belts_->place(belt, part) >= belts_->entry(belt).from;
}

/// True if the part is faster than the TCP may be now: in the first pass of real hardware, or in a reduced
/// profile.
bool ProgramMoves::is_too_fast(const std::string& belt, const BeltPart& part, const Arm& arm) const {
  const double ceiling = arm.robot.motion->options().tcp_ceiling;
  if (ceiling <= 0 && !(first_pass_ && first_pass_())) return false;
  const double most = ceiling > 0 ? std::min(ceiling, kReducedProfile.tcp_speed) : kReducedProfile.tcp_speed;
  const Vec3& at = part.at.position;
  const double radius = belts_->entry(belt).frame.turns ? std::hypot(at.x, at.y) : 1;
  return std::abs(belts_->travel(belt).velocity) * radius > most;
}

void ProgramMoves::begin_ride(const program::Move& move, Arm& arm, const Location& where) {
  const std::string belt = belt_of(move, where);
  if (belt.empty() || arm.robot.motion->riding()) return;
  if (arm.robot.motion->complying())
    throw Error(Problem{"bad-move", where,
                        "a robot that yields to forces cannot follow the belt '" + belt + "'",
                        "write stiff() before this move"});
  const BeltPart& part = belts_->part(belt, arm.robot.robot->entry.name);
  const BeltEntry& entry = belts_->entry(belt);
  if (belts_->place(belt, part) > entry.start_by) {
    belts_->note_missed(belt, part.number);
    throw Error(Problem{"missed", where, "the part on the belt '" + belt + "' has gone too far to follow it",
                        "catch this error and take the next part: on error"});
  }
  if (const double most = arm.robot.motion->options().tcp_ceiling; most > 0)
    throw Error(Problem{
        "limit", where,
        fmt::format("the TCP may not be faster than {:g} m/s now, and a belt adds its own speed", most),
        "robots follow belts only in a profile without a limit of the TCP's speed"});
  if (is_too_fast(belt, part, arm))
    throw Error(Problem{"limit", where,
                        fmt::format("the belt '{}' is faster than the {:g} m/s that the TCP may have now",
                                    belt, kReducedProfile.tcp_speed),
                        "let the belt run more slowly in the first pass of the program"});
  const moves::FrameTravel& travel = belts_->travel(belt);
  arm.robot.motion->feed_ride(travel);
  arm.robot.motion->begin_ride(entry.frame, travel.travel, entry.lead);
  arm.ride = {belt, part, travel.travel};
}

void ProgramMoves::tick_rides() {
  for (Arm& arm : arms_) {
    if (!arm.ride) continue;
    moves::RobotMotion* const motion = arm.robot.motion;
    if (!motion || !motion->riding()) {
      arm.ride.reset();
      continue;
    }
    const std::string& belt = arm.ride->belt;
    motion->feed_ride(belts_->travel(belt));
    if (arm.ride->ended) continue;
    const double place = belts_->place(belt, arm.ride->part), to = belts_->entry(belt).to;
    const bool fast = is_too_fast(belt, arm.ride->part, arm);
    if (place <= to && !fast && !motion->ride_lost()) continue;
    arm.ride->ended = true;
    belts_->note_missed(belt, arm.ride->part.number);
    const char* unit = belts_->entry(belt).frame.turns ? "rad" : "m";
    std::string why = "the robot can no longer follow the part on the belt '" + belt + "'";
    if (place > to)
      why =
          fmt::format("the part on the belt '{}' has left the window, which ends at {:g} {}", belt, to, unit);
    if (fast) why = "the belt '" + belt + "' is faster than the TCP may be now";
    motion->fail_ride({fast ? "limit" : "missed",
                       {},
                       why,
                       fast ? "let the belt run more slowly in the first pass of the program"
                            : "give the robot more time: start_by in cell.yaml, or faster moves"});
  }
}

void ProgramMoves::end_rides() {
  for (Arm& arm : arms_)
    if (arm.ride && arm.robot.motion) arm.robot.motion->end_ride();
}

}  // namespace polyarm::cell
