/// Looking along a move before it is made.
#include <algorithm>

#include "polyarm/base/text.hpp"
#include "polyarm/cell/point_edits.hpp"
#include "polyarm/moves/move_plan.hpp"

namespace polyarm::cell {

namespace {

/// {elbow_joint: 0.5, …}; joints that it does not name stay where they are.
std::vector<double> joints_of(Cell& cell, const CellRobot& robot, const Json& map) {
  std::vector<double> out = joints_now(cell, robot);
  if (!map.is_object()) throw Error("bad-argument", "'joints' is no map of joints and angles");
  std::vector<std::string> names;
  for (const controllers::JointFacts& joint : robot.joints)
    names.push_back(joint.name.substr(joint.name.find('/') + 1));
  for (const auto& [key, value] : map.items()) {
    const auto found = std::find(names.begin(), names.end(), key);
    if (found == names.end())
      throw Error("unknown-joint",
                  "'" + robot.entry.name + "' has no joint '" + key + "'" + did_you_mean(key, names));
    if (!value.is_number()) throw Error("bad-argument", "'" + key + "' is no number");
    out[static_cast<std::size_t>(found - names.begin())] = value.get<double>();
  }
  return out;
}

Poll plan_preview(Cell& cell, const Json& arguments) {
  constexpr int kSamples = 100;
  const std::size_t i = robot_argument(cell, arguments);
  const CellRobot& robot = *cell.robots()[i];
  const std::string how = text_argument(arguments, "kind", "joint");
  if (how != "joint" && how != "line")
    throw Error("bad-argument", "there is no way '" + how + "'", "joint or line");
  moves::Move move;
  move.kind = how == "line" ? moves::MoveKind::line : moves::MoveKind::joint;
  moves::MoveTarget target;
  target.name = text_argument(arguments, "to", "the target");
  if (arguments.contains("to")) {
    const data::Value& value = place_of(cell, target.name);
    if (const data::JointState* joints = value.as_joints())
      target.at = joints_by_name(robot.model, *joints, target.name);
    else
      target.at = frame_in_world(cell, value.as_point()->frame()) * value.as_point()->pose;
  } else if (arguments.contains("joints")) {
    target.at = joints_of(cell, robot, arguments["joints"]);
  } else {
    target.at = pose_value(arguments.value("pose", Json()));
  }
  move.targets.push_back(std::move(target));
  move.speed = std::clamp(number_argument(arguments, "speed", 1), 0.01, 1.0);
  // Facts and chain are const and stay for as long as the cell.
  return later<Json>(
      cell,
      [facts = robot.facts.get(), from = joints_now(cell, robot), move, options = cell.plan_options()] {
        const moves::MovePlan plan = moves::plan_moves(*facts, from, std::vector<moves::Move>{move}, options);
        Json path = Json::array();
        std::vector<double> q(from.size());
        for (const moves::PlannedMotion& each : plan.motions) {
          std::size_t hint = 0;
          for (int k = 0; k <= kSamples; ++k) {
            each.path.sample(each.path.duration() * k / kSamples, q, {}, {}, {}, hint);
            path.push_back(place_json(facts->chain.forward(q).position));
          }
        }
        Json problems = Json::array();
        for (const auto& warning : plan.warnings) problems.push_back(warning.problem.text());
        Json joints = Json::object();
        for (std::size_t j = 0; j < plan.end.size(); ++j) joints[facts->chain.names()[j]] = plan.end[j];
        return Json{{"ok", true},          {"reason", ""},
                    {"path", path},        {"seconds", plan.duration()},
                    {"joints", joints},    {"pose", place_json(facts->chain.forward(plan.end))},
                    {"warnings", problems}};
      },
      [robot = robot.entry.name](Cell&, Json& out) {
        out["robot"] = robot;
        return out;
      });
}

}  // namespace

const std::vector<RequestRow>& preview_rows() {
  static const std::vector<RequestRow> table = {
      {{"plan.preview",
        {{"to", kText},
         {"joints", kMap},
         {"pose", kMap},
         {"kind", kText},
         {"robot", kText},
         {"speed", kNumber}},
        "{ok, reason, robot, path: [[x, y, z]], seconds, joints, pose, warnings}",
        "the way `to` a point, joints or a pose {p, q} from where the robot stands, of `kind` joint or line; "
        "nothing moves",
        false},
       plan_preview},
  };
  return table;
}

}  // namespace polyarm::cell
