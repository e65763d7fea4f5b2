#include "polyarm/moves/move_plan.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "polyarm/moves/cartesian_joints.hpp"
#include "polyarm/moves/move_geometry.hpp"
#include "polyarm/moves/move_joins.hpp"
#include "polyarm/moves/move_timing.hpp"

namespace polyarm::moves {

namespace {

class Planner {
 public:
  Planner(const RobotFacts& robot, std::span<const Move> moves, const MovePlanOptions& options)
      : r_{robot, moves, options, tcp_distance(robot.chain)} {
    for (const trajectory::JointMotionLimits& l : robot.limits)
      plan_.limits.push_back(
          trajectory::MotionLimits::symmetric(l.velocity * options.joint_share, l.acceleration, l.jerk));
  }

  MovePlan run(std::span<const double> from) {
    std::vector<double> q(from.begin(), from.end());
    for (std::size_t i = 0; i < r_.moves.size();) {
      std::size_t last = i;
      while (last + 1 < r_.moves.size() && belong_together(i, last)) ++last;
      add(move_geometry(r_, i, last, q, plan_.warnings),
          i > 0 && r_.moves[i - 1].blend > 0 && r_.moves[i].over.empty() && r_.moves[i - 1].over.empty());
      i = last + 1;
    }
    close();
    plan_.end = std::move(q);
    return std::move(plan_);
  }

 private:
  /// True if the move after `last` belongs to the geometry that begins with move `first`.
  bool belong_together(std::size_t first, std::size_t last) const {
    const Move& next = r_.moves[last + 1];
    if (is_cartesian(next) != is_cartesian(r_.moves[first])) return false;
    if (!next.over.empty() || !r_.moves[last].over.empty()) return false;
    if (goes_through(r_.moves[first])) return goes_through(r_.moves[last]);
    return r_.moves[last].blend > 0 && !goes_through(next);
  }
  void add(MoveRun run, bool blended) {
    bool joins = blended && !draft_.empty();
    for (MovePart& part : run.sections) {
      if (!(part.to > part.from)) continue;
      if (!std::exchange(joins, false) || !join_moves(r_, draft_, part, plan_.warnings)) close();
      draft_.push_back(std::move(part));
    }
  }

  void close() {
    if (!draft_.empty()) plan_.motions.push_back(time_moves(r_, draft_, plan_.limits));
    draft_.clear();
  }

  PlanRequest r_;
  MoveDraft draft_;
  MovePlan plan_;
};

void check(std::span<const Move> moves, const RobotFacts& robot) {
  for (std::size_t i = 0; i < moves.size(); ++i) {
    const Move& m = moves[i];
    const auto refuse = [&](const char* what, double value, const char* advice) {
      throw MoveError(Error("bad-move",
                            fmt::format("the {} of the move to {} of {} is {}", what,
                                        m.targets.empty() ? "nowhere" : m.end().name, robot.name, value),
                            advice),
                      i);
    };
    if (m.targets.empty()) refuse("number of targets", 0, "a move needs a target");
    if (!(m.speed > 0 && m.speed <= 1)) refuse("share of speed", m.speed, "above 0, at most 1 (100 %)");
    if (!(m.acceleration > 0 && m.acceleration <= 1))
      refuse("share of acceleration", m.acceleration, "above 0, at most 1 (100 %)");
    for (const auto& [name, value] : {std::pair("blend", m.blend),
                                      {"speed", m.tcp_speed},
                                      {"acceleration", m.tcp_acceleration},
                                      {"turning speed", m.turn_speed},
                                      {"turning acceleration", m.turn_acceleration},
                                      {"joint speed", m.joint_speed},
                                      {"joint pace", m.joint_pace},
                                      {"joint acceleration", m.joint_acceleration},
                                      {"duration", m.duration}})
      if (!(value >= 0) || !std::isfinite(value)) refuse(name, value, "it must be above 0");
  }
}

}  // namespace

double MovePlan::duration() const {
  double sum = 0;
  for (const PlannedMotion& motion : motions) sum += motion.path.duration();
  return sum;
}

MovePlan plan_moves(const RobotFacts& robot, std::span<const double> from, std::span<const Move> moves,
                    const MovePlanOptions& options) {
  check(moves, robot);
  return Planner(robot, moves, options).run(from);
}

}  // namespace polyarm::moves
