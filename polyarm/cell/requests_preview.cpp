/// Looking along a move before it is made.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "polyarm/base/text.hpp"
#include "polyarm/cell/point_edits.hpp"
#include "polyarm/moves/move_plan.hpp"

namespace polyarm::cell {

namespace {

using namespace protocol;

/// {elbow_joint: 0.5, …}; joints that it does not name stay where they are.
std::vector<double> joints_at(Cell& cell, const CellRobot& robot, const Map& map) {
  std::vector<double> out = joints_now(cell, robot);
  std::vector<std::string> names;
  for (const controllers::JointFacts& joint : robot.joints)
    names.push_back(joint.name.substr(joint.name.find('/') + 1));
  for (const auto& [key, value] : map) {
    const auto found = std::find(names.begin(), names.end(), key);
    if (found == names.end())
      throw Error("unknown-joint",
                  "'" + robot.entry.name + "' has no joint '" + key + "'" + did_you_mean(key, names));
    const std::optional<double> number = value.number();
    if (!number) throw Error("bad-argument", "'" + key + "' is no number");
    out[static_cast<std::size_t>(found - names.begin())] = *number;
  }
  return out;
}

moves::MoveTarget target_of(Cell& cell, const CellRobot& robot, const PlanPreview& request) {
  moves::MoveTarget target;
  target.name = request.to.value_or("the target");
  if (request.to) {
    const data::Value& value = place_of(cell, target.name);
    if (const data::JointState* joints = value.as_joints())
      target.at = cell::joints_by_name(robot.model, *joints, target.name);
    else
      target.at = frame_in_world(cell, value.as_point()->frame()) * value.as_point()->pose;
  } else if (request.joints) {
    target.at = joints_at(cell, robot, *request.joints);
  } else {
    nlohmann::json pose;
    if (request.pose) pose = nlohmann::json::object();
    for (const auto& [key, value] : request.pose.value_or(Map{})) pose[key] = value.json();
    target.at = pose_value(pose);
  }
  return target;
}

PlanPreview::Answer preview_of(const moves::RobotFacts& facts, const std::string& robot, const moves::MovePlan& plan) {
  constexpr int kSamples = 100;
  PlanPreview::Answer out;
  out.robot = robot;
  std::vector<double> q(plan.end.size());
  for (const moves::PlannedMotion& each : plan.motions) {
    std::size_t hint = 0;
    for (int k = 0; k <= kSamples; ++k) {
      each.path.sample(each.path.duration() * k / kSamples, q, {}, {}, {}, hint);
      out.path.push_back(facts.chain.forward(q).position);
    }
  }
  for (const auto& warning : plan.warnings) out.warnings.push_back(warning.problem.text());
  for (std::size_t j = 0; j < plan.end.size(); ++j) out.joints[facts.chain.names()[j]] = plan.end[j];
  out.seconds = plan.duration();
  out.pose = pose_facts(facts.chain.forward(plan.end));
  return out;
}

Poll<PlanPreview::Answer> plan_preview(Cell& cell, const PlanPreview& request) {
  const CellRobot& robot = *cell.robots()[robot_named(cell, request.robot)];
  moves::Move move;
  move.kind = request.kind == MoveKind::line ? moves::MoveKind::line : moves::MoveKind::joint;
  move.targets.push_back(target_of(cell, robot, request));
  move.speed = std::clamp(request.speed.value_or(1), 0.01, 1.0);
  // Facts and chain are const, and stay as long as the cell does.
  return later(cell, [facts = robot.facts.get(), name = robot.entry.name, from = joints_now(cell, robot), move,
                      options = cell.plan_options()] {
    return preview_of(*facts, name, moves::plan_moves(*facts, from, std::vector<moves::Move>{move}, options));
  });
}

}  // namespace

std::vector<Handler> preview_handlers() {
  return handlers<plan_preview>();
}

}  // namespace polyarm::cell
