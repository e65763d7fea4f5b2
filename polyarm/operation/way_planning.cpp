#include "polyarm/operation/way_planning.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "polyarm/base/text.hpp"
#include "polyarm/io/worker.hpp"
#include "polyarm/tasks/program_host.hpp"

namespace polyarm::cell {

namespace {

using namespace protocol;

/// Parses {elbow_joint: 0.5, …}; joints that are not named keep their position.
std::vector<double> joints_at(const PointOwners& cell, const CellRobot& robot, const Map& map) {
  std::vector<double> out = joints_now(cell.machine, robot);
  std::vector<std::string> names;
  for (const controllers::JointFacts& joint : robot.joints)
    names.push_back(joint.name.substr(joint.name.find('/') + 1));
  for (const auto& [key, value] : map) {
    const auto found = std::find(names.begin(), names.end(), key);
    if (found == names.end())
      throw Error("unknown-joint",
                  "'" + robot.entry.name + "' has no joint '" + key + "'" + did_you_mean(key, names));
    const std::optional<double> number = value.number();
    if (!number) throw Error("bad-argument", "'" + key + "' is not a number");
    out[static_cast<std::size_t>(found - names.begin())] = *number;
  }
  return out;
}

moves::MoveTarget target_of(const PointOwners& cell, const CellRobot& robot, const PlanPreview& request) {
  moves::MoveTarget target;
  target.name = request.to.value_or("the target");
  if (request.to) {
    const data::Value& value = place_of(cell.data.store, target.name);
    if (const data::JointState* joints = value.as_joints())
      target.at = cell::joints_by_name(robot.model, *joints, target.name);
    else
      target.at = point_in_world(cell.setup, cell.data.store, *value.as_point(), &robot, &cell.motions);
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

}  // namespace

std::shared_ptr<const PlannedWay> plan_way(const PointOwners& cell, std::size_t i,
                                           const protocol::PlanPreview& request) {
  const CellRobot& robot = *cell.setup.robots[i];
  moves::Move move;
  move.kind = request.kind == protocol::MoveKind::line ? moves::MoveKind::line : moves::MoveKind::joint;
  move.targets.push_back(target_of(cell, robot, request));
  move.speed = std::clamp(request.speed.value_or(1), 0.01, 1.0);
  auto way = std::make_shared<PlannedWay>();
  // Facts and chain are const and live as long as the cell.
  cell.worker.post([way, facts = robot.facts.get(), from = joints_now(cell.machine, robot), move,
                    options = cell.motions.plan_options()] {
    try {
      way->plan = moves::plan_moves(*facts, from, std::vector<moves::Move>{move}, options);
    } catch (const Error& e) {
      way->error = e;
    } catch (...) {
      way->error = Error("internal", "unexpected: " + what_was_thrown());
    }
    way->done.store(true, std::memory_order_release);
  });
  return way;
}

}  // namespace polyarm::cell
