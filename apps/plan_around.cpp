#include "apps/plan_around.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "apps/plan_moves.hpp"
#include "polyarm/hulls/robot_bodies.hpp"
#include "polyarm/planning/pose_goals.hpp"

namespace polyarm::apps {

namespace {

constexpr double kFingerThickness = 0.008;  // m, as in physics
constexpr double kMeasureEvery = 0.005;     // s

description::Shape pad(const description::Tool& tool, int side) {
  description::Shape out;
  out.size = {tool.finger_width, kFingerThickness, tool.finger_length};
  out.pose = tool.tcp * Pose{{0, side * (tool.stroke + kFingerThickness) / 2, -tool.finger_length / 2}, {}};
  return out;
}

/// The tool as a body attached to the robot; a parallel gripper is open.
collision::AttachedBody body_of(const description::Tool& tool, int link) {
  collision::AttachedBody out;
  out.name = "tool " + tool.name;
  out.link = link;
  out.shapes = tool.body;
  if (tool.gripper == description::GripperKind::parallel)
    for (const int side : {-1, 1}) out.shapes.push_back(pad(tool, side));
  return out;
}

void warn(Problems& problems, const std::string& what) {
  problems.warning("no-body", {}, what + " has no known body: contacts with it are not found",
                   "give it boxes, cylinders, spheres or capsules");
}

void make_bodies(description::RobotModel& model, description::Tool& tool, description::Scene& scene,
                 Problems& problems) {
  std::vector<description::Shape*> meshes;
  const auto take = [&](std::vector<description::Shape>& shapes) {
    for (description::Shape& shape : shapes)
      if (shape.kind == description::ShapeKind::mesh && shape.pieces.empty()) meshes.push_back(&shape);
  };
  for (description::Link& link : model.links) take(link.collisions);
  take(tool.body);
  for (description::Fixture& fixture : scene.fixtures) take(fixture.shapes);
  if (meshes.empty()) return;
  for (Problem& problem : hulls::make_bodies(meshes, hulls::bodies_cache()).warnings)
    problems.add(std::move(problem));
}

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

Surroundings::Surroundings(const moves::RobotFacts& robot, const description::Tool& tool,
                           description::Scene scene, double clearance, Problems& problems) {
  description::RobotModel model = *robot.model;
  description::Tool own = tool;
  make_bodies(model, own, scene, problems);
  collision::RobotBodyOptions options;
  const int link = model.tool_link();
  if (!own.body.empty() || own.gripper == description::GripperKind::parallel)
    options.attached.push_back(body_of(own, link));
  else if (own.name != "none")
    warn(problems, "tool " + own.name);
  const auto body = std::make_shared<const collision::RobotBody>(model, options);
  for (const std::string& name : body->without_body()) warn(problems, "link " + name);
  for (const std::string& pair : body->always_touching())
    problems.warning("always-in-contact", {},
                     "the links " + pair + " touch at home or nearly everywhere: this pair is not checked",
                     "correct their shapes, or state the pair in the SRDF");
  for (const description::Fixture& fixture : scene.fixtures)
    if (!fixture.shapes.empty() &&
        std::all_of(fixture.shapes.begin(), fixture.shapes.end(), [](const auto& shape) {
          return shape.kind == description::ShapeKind::mesh && shape.pieces.empty();
        }))
      warn(problems, "fixture " + fixture.name);
  collision::CheckerOptions checks;
  checks.T_world_base = robot.chain.base();
  checks.clearance = clearance;
  checker_ = std::make_unique<const collision::Checker>(body, collision::world_of(scene), checks);
  probe_ = std::make_unique<collision::Probe>(*checker_);
}

std::vector<Surroundings::Way> Surroundings::around(const moves::RobotFacts& robot,
                                                    const std::vector<double>& start,
                                                    const std::vector<moves::Move>& moves, std::uint64_t seed,
                                                    double seconds) {
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
    const planning::Plan plan = planning::plan(*probe_, query, options);
    if (plan.outcome != planning::PlanOutcome::found) refuse(plan, text);
    const std::vector<double> radii = planning::corner_radii(*probe_, plan.waypoints, plan.exact);
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

void Surroundings::measure(PlannedMotion& motion) {
  PlanState state(motion.joints.size());
  PlanClearance least;
  const auto steps = static_cast<std::size_t>(std::ceil(motion.duration / kMeasureEvery));
  for (std::size_t i = 0; i <= steps; ++i) {
    const double t = steps > 0 ? motion.duration * double(i) / double(steps) : 0;
    motion.at(t, state);
    const collision::Contact contact = probe_->nearest(state.value[0]);
    if (!(contact.distance < least.distance)) continue;
    least = {contact.distance, contact.first, contact.second, t, contact.on_second};
  }
  if (!std::isfinite(least.distance)) return;
  motion.clearance = least;
  if (least.distance > 0) return;
  const auto section = std::find_if(motion.sections.begin(), motion.sections.end(),
                                    [&](const PlanSection& s) { return least.time <= s.end; });
  Problem problem;
  problem.code = "contact";
  problem.what = fmt::format("{}{} is {:.1f} mm inside {} at {:.3f} s",
                             section == motion.sections.end() ? "" : section->name + ": ", least.first,
                             -1000 * least.distance, least.second, least.time);
  problem.advice = "plan movej with --around, or move the target";
  motion.problems.push_back(std::move(problem));
}

}  // namespace polyarm::apps
