#include "polyarm/machine/around.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>

#include "polyarm/planning/pose_goals.hpp"
#include "polyarm/surroundings/sweep.hpp"

namespace polyarm::cell {

namespace {

constexpr std::uint64_t kSeed = 1;
constexpr std::size_t kMostSamples = 100'000, kMostStates = 60'000;  // of one search
constexpr double kCheckEvery = 0.004;                                // s
constexpr double kRoom = 0.8;  // of the distance that start and goal leave

class CellObstacles : public moves::Obstacles {
 public:
  CellObstacles(std::shared_ptr<SharedBodies> shared, surroundings::Moment moment, std::size_t own,
                AroundOptions options)
      : shared_(std::move(shared)), moment_(std::move(moment)), own_(own), options_(std::move(options)) {}

  void find_way(const moves::RobotFacts& robot, std::span<const double> from, moves::Move& move) override {
    const std::vector<double> start(from.begin(), from.end());
    moment_.robots[own_].joints = start;
    planning::PlanQuery query{
        start, {nearest_goal(robot, start, move.end())}, robot.chain.lower(), robot.chain.upper()};
    planning::Plan plan = planned(query);
    const Pose* pose = std::get_if<Pose>(&move.end().at);
    if (pose && plan.outcome != planning::PlanOutcome::found &&
        plan.outcome != planning::PlanOutcome::start_touches) {
      query.goals = goals(robot, start, *pose);
      plan = planned(query);
    }
    if (plan.outcome != planning::PlanOutcome::found) refuse(plan, move.end().name);
    collision::Probe& probe = surroundings_->probe();
    const std::vector<double> radii = planning::corner_radii(probe, plan.waypoints, plan.exact);
    move.over.clear();
    for (std::size_t k = 1; k + 1 < plan.waypoints.size(); ++k)
      move.over.push_back({plan.waypoints[k], radii[k]});
    move.targets.back().at = plan.waypoints.back();
  }

  void check(const moves::RobotFacts& robot, const moves::MovePlan& plan,
             std::span<const moves::Move> moves) override {
    const std::shared_ptr<const ContactBodies> bodies = shared_->get();
    for (const moves::PlannedMotion& motion : plan.motions) {
      surroundings::Sweep sweep(bodies->robots, bodies->scene, 0);
      follow(motion, sweep);
      const auto& found = sweep.approaches();
      const auto hit = std::find_if(found.begin(), found.end(),
                                    [&](const auto& a) { return belongs(a.first) || belongs(a.second); });
      if (hit != found.end()) refuse(*hit, robot, motion, moves);
    }
  }

 private:
  bool belongs(const std::string& name) const {
    if (name.starts_with(shared_->get()->robots[own_].name + "/")) return true;
    const description::Scene& scene = shared_->get()->scene;
    for (std::size_t p = 0; p < scene.parts.size() && p < moment_.parts.size(); ++p)
      if (moment_.parts[p].held_by == static_cast<int>(own_) && name == "part " + scene.parts[p].name)
        return true;
    return false;
  }

  /// Held parts go with the robot: they were gripped where the moment has them.
  void follow(const moves::PlannedMotion& motion, surroundings::Sweep& sweep) const {
    surroundings::Moment now = moment_;
    const double duration = motion.path.duration();
    const auto steps = static_cast<std::size_t>(std::ceil(duration / kCheckEvery)) + 1;
    std::vector<double>& q = now.robots[own_].joints;
    q.resize(motion.path.joints());
    std::size_t hint = 0;
    sweep.add(moment_, 0, {});
    sweep.jump();  // moves that are queued before bring it to the start of this motion
    for (std::size_t i = 0; i <= steps; ++i) {
      const double t = duration * static_cast<double>(i) / static_cast<double>(steps);
      motion.path.sample(t, q, {}, {}, {}, hint);
      sweep.add(now, t, {});
    }
    sweep.finish(true);
  }

  [[noreturn]] static void refuse(const surroundings::Approach& hit, const moves::RobotFacts& robot,
                                  const moves::PlannedMotion& motion, std::span<const moves::Move> moves) {
    std::size_t hint = 0;
    const double s = motion.path.profile().at(hit.time, hint).s;
    const auto end = std::lower_bound(motion.ends.begin(), motion.ends.end(), s);
    const std::size_t index =
        std::min(motion.first + static_cast<std::size_t>(end - motion.ends.begin()), moves.size() - 1);
    throw moves::MoveError(
        Error(
            "contact",
            fmt::format("the move to {} of {} would hit something after {:.2f} s: {} is {:.1f} mm inside {}",
                        moves[index].end().name, robot.name, hit.time, hit.first,
                        std::max(0.0, -1e3 * hit.distance), hit.second),
            "add a point on a free path before it; `movej P, around true` finds one"),
        index);
  }

  /// The configuration that a straight joint move would take: what follows is likely taught from there.
  static planning::JointState nearest_goal(const moves::RobotFacts& robot, const std::vector<double>& from,
                                           const moves::MoveTarget& target) {
    if (const Pose* pose = std::get_if<Pose>(&target.at))
      return moves::joints_for(robot, *pose, from, target.name);
    const auto& q = std::get<std::vector<double>>(target.at);
    moves::check_joints(robot, q, target.name);
    return q;
  }

  static std::vector<planning::JointState> goals(const moves::RobotFacts& robot,
                                                 const std::vector<double>& from, const Pose& pose) {
    if (robot.solver) return planning::goals_for(*robot.solver, pose, from);
    return planning::goals_for(ik::InverseKinematics(robot.chain), pose, from);
  }

  /// With the cell's clearance; where start or goal leave less, with most of what they leave.
  planning::Plan planned(const planning::PlanQuery& query) {
    const std::shared_ptr<const ContactBodies> bodies = shared_->get();
    planning::PlanOptions options;
    options.seed = kSeed;
    options.most_samples = kMostSamples;
    options.most_states = kMostStates;
    options.stop = options_.stop;
    double clearance = options_.clearance;
    for (bool narrow = false;; narrow = true) {
      surroundings_ = std::make_unique<surroundings::Surroundings>(bodies->robots, bodies->scene, moment_,
                                                                   own_, clearance);
      planning::Plan plan = planning::plan(surroundings_->probe(), query, options);
      const bool touches = plan.outcome == planning::PlanOutcome::start_touches ||
                           plan.outcome == planning::PlanOutcome::goal_touches;
      if (!touches || narrow || !(plan.contact.distance > 0)) return plan;
      clearance = kRoom * room_of(query);
      if (!(clearance > 0)) return plan;
    }
  }

  /// The smallest distance at the start and at the roomiest goal, at most the clearance.
  double room_of(const planning::PlanQuery& query) {
    collision::Probe& probe = surroundings_->probe();
    double goal = 0;
    for (const planning::JointState& q : query.goals) goal = std::max(goal, probe.nearest(q).distance);
    return std::min({options_.clearance, probe.nearest(query.start).distance, goal});
  }

  [[noreturn]] static void refuse(const planning::Plan& plan, const std::string& name) {
    const std::string what = "no way around obstacles to " + name + ": " + plan.reason;
    switch (plan.outcome) {
      case planning::PlanOutcome::start_touches:
        throw Error("start-in-contact", what, "leave it with a line first: `movel` away from it");
      case planning::PlanOutcome::goal_touches:
        throw Error("goal-in-contact", what, "go to a free point before it, then with `movel` to it");
      case planning::PlanOutcome::out_of_time:
        throw Error("out-of-time", what, "go over a point between");
      default:
        throw Error("no-way", what, "go over a point between, or give the robot more room");
    }
  }

  std::shared_ptr<SharedBodies> shared_;
  surroundings::Moment moment_;
  std::size_t own_;
  AroundOptions options_;
  std::unique_ptr<surroundings::Surroundings> surroundings_;
};

}  // namespace

std::shared_ptr<const ContactBodies> SharedBodies::get() {
  const std::lock_guard lock(mutex_);
  if (!made_) made_ = contact_bodies(robots_, scene_);
  return made_;
}

std::shared_ptr<moves::Obstacles> obstacles_around(std::shared_ptr<SharedBodies> bodies,
                                                   surroundings::Moment moment, std::size_t own,
                                                   AroundOptions options) {
  return std::make_shared<CellObstacles>(std::move(bodies), std::move(moment), own, std::move(options));
}

}  // namespace polyarm::cell
