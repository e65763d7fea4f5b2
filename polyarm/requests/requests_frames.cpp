/// Requests that compute a frame from three points, or a tool from four poses.
#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "polyarm/data/taught_frames.hpp"
#include "polyarm/operation/point_edits.hpp"
#include "polyarm/requests/families.hpp"

namespace polyarm::cell {

namespace {

using namespace protocol;

Vec3 place_at(const std::optional<Any>& given, const char* name) {
  return vector_value(given.value_or(Any{}).json(), name);
}

/// The pose of tool0 when the point was taught, from its joints.
Pose flange_at(const PointOwners& cell, const CellRobot& robot, const std::string& name) {
  const data::Value& value = place_of(cell.data.store, name);
  const data::JointState* joints = value.as_joints();
  if (!joints && value.as_point()->taught) joints = &value.as_point()->taught->joints;
  if (!joints || joints->positions.size() != robot.joints.size())
    throw Error("bad-points", "'" + name + "' has no joint values of its teaching", "teach it again");
  return robot.facts->chain.forward(joints_by_name(robot.model, *joints, name)) * inverse(robot.tool.tcp);
}

std::vector<Pose> poses_of(const PointOwners& cell, const std::vector<std::string>& names,
                           std::string& frame) {
  std::vector<Pose> out;
  for (const std::string& each : names) {
    const data::Point* point = place_of(cell.data.store, each).as_point();
    if (!point) throw Error("bad-points", "'" + each + "' is a joint state", "teach it as a pose");
    if (!out.empty() && point->frame() != frame)
      throw Error("bad-points",
                  "'" + each + "' is in the frame '" + point->frame() + "', '" + names.front() + "' in '" +
                      frame + "'",
                  "teach all of them in one frame");
    frame = point->frame();
    out.push_back(point->pose);
  }
  return out;
}

Poll<PointsFrame::Answer> points_frame(const PointOwners& cell, const PointsFrame& request) {
  const std::string& name = request.name;
  check_point_name(name);
  std::array<Vec3, 3> at;
  std::string frame;
  if (request.from && !request.from->empty()) {
    const std::vector<Pose> poses = poses_of(cell, *request.from, frame);
    if (poses.size() != 3)
      throw Error("bad-points", "a frame comes from three points",
                  "'from': [origin, one on x, one in the xy plane]");
    for (std::size_t k = 0; k < 3; ++k) at[k] = poses[k].position;
  } else {
    at = {place_at(request.origin, "origin"), place_at(request.on_x, "on_x"),
          place_at(request.in_plane, "in_plane")};
  }
  data::Point out{data::frame_from_points(at[0], at[1], at[2]), false};
  const Vec3 x = at[1] - at[0], y = at[2] - at[0];
  const PointsFrame::Answer found{.point = {},
                                  .name = name,
                                  .pose = pose_facts(out.pose),
                                  .frame = frame,
                                  .angle = std::acos(std::clamp(dot(x, y) / (norm(x) * norm(y)), -1.0, 1.0)),
                                  .x_length = norm(x),
                                  .y_length = norm(y)};
  if (!frame.empty()) out.taught = std::make_shared<data::Taught>(data::Taught{frame, {}, {}, {}});
  if (request.dry) return at_once(found);
  return then(edit_value(cell, set_for(cell.data, request.file, name), "frame " + name, name, out),
              [found](const ChangedPoint& changed) {
                PointsFrame::Answer answer = found;
                answer.point.emplace(changed);
                return at_once(answer);
              });
}

Poll<PointsTool::Answer> points_tool(const PointOwners& cell, const PointsTool& request) {
  const std::string& name = request.name;
  check_point_name(name);
  std::vector<Pose> poses;
  if (request.from && !request.from->empty()) {
    const CellRobot& robot = *cell.setup.robots[robot_named(cell.setup, request.robot)];
    for (const std::string& each : *request.from) poses.push_back(flange_at(cell, robot, each));
  } else if (request.poses) {
    const nlohmann::json& given = request.poses->json();
    if (!given.is_array() || given.size() > 100)
      throw Error("bad-argument", "'poses' is not a list of poses");
    for (const nlohmann::json& each : given) poses.push_back(pose_value(each));
  }
  const data::TaughtTool tool = data::tool_from_poses(poses);
  const PointsTool::Answer found{.point = {},
                                 .name = name,
                                 .tcp = tool.tcp,
                                 .tip = tool.tip,
                                 .residuals = tool.residuals,
                                 .rms = tool.rms,
                                 .largest = tool.largest};
  if (request.dry) return at_once(found);
  return then(
      edit_value(cell, set_for(cell.data, request.file, name), "tool " + name, name, data::point_of(tool)),
      [found](const ChangedPoint& changed) {
        PointsTool::Answer answer = found;
        answer.point.emplace(changed);
        return at_once(answer);
      });
}

}  // namespace

std::vector<Handler> frame_handlers() {
  return handlers<points_frame, points_tool>();
}

}  // namespace polyarm::cell
