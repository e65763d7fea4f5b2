/// Moves of bases with wheels in programs.
#include <utility>

#include "polyarm/tasks/program_moves.hpp"

namespace polyarm::cell {

std::size_t ProgramMoves::base_of(const program::Move& move, const Location& where) const {
  const std::size_t index = robot_of(move.robot, where);
  if (!arms_[index].robot.base)
    throw Error(Problem{"no-base", where,
                        "no controller of wheels drives '" + arms_[index].robot.robot->entry.name + "'",
                        "drive and turn move a base with wheels; an arm has movej, movel and their like"});
  return index;
}

std::optional<Pose> ProgramMoves::base_goal(const program::Move& move, const Location& where) const {
  const program::Move::Target& target = move.targets.front();
  const data::Point* point = target.value.as_point();
  if (!point) return std::nullopt;
  const Arm& arm = arms_[base_of(move, where)];
  const Pose frame =
      point->frame().empty() ? frame_of(move, arm, where) : frame_named(point->frame(), arm, where);
  return frame * point->pose;
}

program::Handle ProgramMoves::start_base(const program::Move& move, const Location& where) {
  const std::size_t index = base_of(move, where);
  moves::BaseMotion* const base = arms_[index].robot.base;
  moves::BaseMove out;
  out.turns = move.kind == program::Move::Kind::turn;
  if (const auto goal = base_goal(move, where))
    out.to = goal;
  else
    out.amount = move.targets.front().value.as_number()->value;
  const auto pace = [&](const std::optional<data::Number>& said, Dimension own, Dimension turning,
                        double& share, double& most, double& most_turning, const char* what) {
    if (!said) return;
    if (said->dimension == Dimension::none) {
      share = said->value;
    } else if (said->dimension == own) {
      most = said->value;
    } else if (out.to && said->dimension == turning) {
      most_turning = said->value;
    } else {
      throw Error(Problem{"bad-move", where, std::string(what) + " does not fit this move",
                          out.turns ? "a turn has 30deg/s and 90deg/s2" : "a drive has 0.2m/s and 0.5m/s2"});
    }
  };
  double whole = 1;
  pace(move.speed, out.turns ? Dimension::angular_speed : Dimension::speed, Dimension::angular_speed,
       out.share, out.speed, out.turn_speed, "the speed");
  pace(move.accel, out.turns ? Dimension::angular_acceleration : Dimension::acceleration,
       Dimension::angular_acceleration, whole, out.acceleration, out.turn_acceleration, "the acceleration");
  if (move.duration && out.to)
    throw Error(
        Problem{"bad-move", where, "a drive to a pose takes no duration", "state a speed: `speed 0.2m/s`"});
  if (move.duration) out.duration = move.duration->value;
  const std::uint64_t id = base->start(out);
  forget_ended();
  asked_[++last_handle_] = {{index, id, id, true}};
  return last_handle_;
}

std::optional<std::size_t> ProgramMoves::only_base(const std::string& robot) const {
  const std::size_t index = robot_of(robot, {});
  const Robot& found = arms_[index].robot;
  return found.motion || !found.base ? std::nullopt : std::optional(index);
}

data::Value ProgramMoves::place_in(const Pose& place, std::size_t base, const std::string& frame) const {
  return data::Point{inverse(frame_named(frame, arms_[base], {})) * place, true};
}

}  // namespace polyarm::cell
