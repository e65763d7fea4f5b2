#include "apps/plan_around.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "apps/plan_moves.hpp"
#include "polyarm/planning/pose_goals.hpp"

namespace polyarm::apps {

namespace {

constexpr double kMeasureEvery = 0.005;  // s

[[noreturn]] void refuse(const planning::Plan& plan, const std::string& move) {
  const char* code = "no-way";
  std::string advice = "try another --seed or more --time, or plan over a point between";
  switch (plan.outcome) {
    case planning::PlanOutcome::start_touches:
      code = "start-in-contact", advice = "move the robot away from it first, or correct the scene";
      break;
    case planning::PlanOutcome::goal_touches:
      code = "goal-in-contact", advice = "choose another target, or correct the scene";
      break;
    case planning::PlanOutcome::out_of_time:
      code = "out-of-time", advice = "give more --time, or plan over a point between";
      break;
    case planning::PlanOutcome::bad_query:
      code = "bad-value", advice = "";
      break;
    default:
      break;
  }
  throw Error(code, move + ": " + plan.reason, advice);
}

std::vector<planning::JointState> goals_of(const moves::RobotFacts& robot, const moves::MoveTarget& target,
                                           const std::vector<double>& from, const std::string& move) {
  if (const auto* q = std::get_if<std::vector<double>>(&target.at)) {
    moves::check_joints(robot, *q, move);
    return {*q};
  }
  const Pose& pose = std::get<Pose>(target.at);
  const ik::InverseKinematics own(robot.chain);
  std::vector<planning::JointState> out = planning::goals_for(own, pose, from);
  if (out.empty()) out.push_back(moves::joints_for(robot, pose, from, move));  // throws the reason
  return out;
}

}  // namespace

PlanAround::PlanAround(const cell::CellRobots& robots, const cell::CellRobot& own,
                       const description::Scene& scene, double clearance, Problems& problems)
    : robot_(*own.facts), bodies_(cell::contact_bodies(robots, scene)) {
  for (const Problem& problem : bodies_->warnings) problems.add(problem);
  std::vector<surroundings::Robot> all = bodies_->robots;
  surroundings::Moment moment = surroundings::start_of(scene);
  std::size_t index = 0;
  for (std::size_t r = 0; r < robots.size(); ++r) {
    moment.robots.push_back({robots[r]->entry.base, robots[r]->start});
    if (robots[r].get() == &own) index = r;
  }
  all[index].name.clear();
  surroundings_ = std::make_unique<surroundings::Surroundings>(all, bodies_->scene, moment, index, clearance);
  for (const std::string& pair : surroundings_->checker().robot().always_touching())
    problems.warning("always-in-contact", {},
                     "the links " + pair + " touch at home or nearly everywhere: this pair is not checked",
                     "correct their shapes, or state the pair in the SRDF");
}

std::vector<PlanAround::Way> PlanAround::around(const std::vector<double>& start,
                                                const std::vector<moves::Move>& moves, std::uint64_t seed,
                                                double seconds) {
  const moves::RobotFacts& robot = robot_;
  collision::Probe& probe = surroundings_->probe();
  using Clock = std::chrono::steady_clock;
  std::vector<Way> out;
  std::vector<double> from = start;
  for (std::size_t i = 0; i < moves.size(); ++i) {
    const std::string text = fmt::format("move {}, {}", i + 1, text_of(moves[i]));
    if (moves[i].kind != moves::MoveKind::joint)
      throw Error("bad-move", text + ": lines, arcs and splines never bend around obstacles",
                  "write movej with --around, or plan without --around");
    planning::PlanQuery query{from, goals_of(robot, moves[i].end(), from, text), robot.chain.lower(),
                              robot.chain.upper()};
    planning::PlanOptions options;
    options.seed = seed;
    options.most_samples = 1'000'000;
    options.most_states = 200'000;
    const Clock::time_point end = Clock::now() + std::chrono::microseconds(std::llround(seconds * 1e6));
    options.stop = [end] { return Clock::now() > end; };
    const planning::Plan plan = planning::plan(probe, query, options);
    if (plan.outcome != planning::PlanOutcome::found) refuse(plan, text);
    const std::vector<double> radii = planning::corner_radii(probe, plan.waypoints, plan.exact);
    std::vector<paths::JointWaypoint> points;
    for (std::size_t k = 0; k < radii.size(); ++k) points.push_back({plan.waypoints[k], radii[k], {}});
    from = plan.waypoints.back();
    if (plan.length < 1e-9) continue;  // already there
    out.push_back({plan.waypoints.size() == 2
                       ? text + ", straight"
                       : fmt::format("{}, over {} point{}", text, plan.waypoints.size() - 2,
                                     plan.waypoints.size() == 3 ? "" : "s"),
                   paths::joint_lines(points)});
  }
  if (out.empty()) throw Error("no-motion", "these moves end where they begin", "name another target");
  return out;
}

void PlanAround::measure(PlannedMotion& motion) {
  PlanState state(motion.joints.size());
  for (PlanSection& section : motion.sections) {
    const double duration = section.end - section.begin;
    const auto steps = static_cast<std::size_t>(std::ceil(duration / kMeasureEvery));
    PlanClearance least;
    for (std::size_t i = 0; i <= steps; ++i) {
      const double t = section.begin + (steps > 0 ? duration * double(i) / double(steps) : 0);
      motion.at(t, state);
      const collision::Contact contact = surroundings_->probe().nearest(state.value[0]);
      if (contact.distance < least.distance)
        least = {contact.distance, contact.first, contact.second, t, contact.on_second};
    }
    if (!std::isfinite(least.distance)) continue;
    section.clearance = least;
    if (!motion.clearance || least.distance < motion.clearance->distance) motion.clearance = least;
    if (least.distance > 0) continue;
    Problem problem;
    problem.code = "contact";
    problem.what =
        fmt::format("{}{} is {:.1f} mm inside {} at {:.3f} s, at ({:.3f}, {:.3f}, {:.3f})",
                    section.name.empty() ? "" : section.name + ": ", least.first, -1000 * least.distance,
                    least.second, least.time, least.point.x, least.point.y, least.point.z);
    problem.advice = "plan movej with --around, or move the target";
    motion.problems.push_back(std::move(problem));
  }
}

}  // namespace polyarm::apps
