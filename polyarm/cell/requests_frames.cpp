/// Requests for frames by three points and tools by four poses.
#include <algorithm>
#include <array>
#include <cmath>

#include "polyarm/cell/point_edits.hpp"
#include "polyarm/data/taught_frames.hpp"

namespace polyarm::cell {

namespace {

Vec3 place_argument(const Json& arguments, const char* name) {
  return vector_value(arguments.value(name, Json()), name);
}

/// Where tool0 was when the point was taught, by its joints.
Pose flange_at(Cell& cell, const CellRobot& robot, const std::string& name) {
  const data::Value& value = place_of(cell, name);
  const data::JointState* joints = value.as_joints();
  if (!joints && value.as_point()->taught) joints = &value.as_point()->taught->joints;
  if (!joints || joints->positions.size() != robot.joints.size())
    throw Error("bad-points", "'" + name + "' does not say in which joints it was taught", "teach it again");
  return robot.facts->chain.forward(joints_by_name(robot.model, *joints, name)) * inverse(robot.tool.tcp);
}

std::vector<Pose> poses_of(Cell& cell, const std::vector<std::string>& names, std::string& frame) {
  std::vector<Pose> out;
  for (const std::string& each : names) {
    const data::Point* point = place_of(cell, each).as_point();
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

Poll points_frame(Cell& cell, const Json& arguments) {
  const std::string name = text_argument(arguments, "name");
  check_point_name(name);
  std::array<Vec3, 3> at;
  std::string frame;
  if (const std::vector<std::string> from = list_argument(arguments, "from"); !from.empty()) {
    const std::vector<Pose> poses = poses_of(cell, from, frame);
    if (poses.size() != 3)
      throw Error("bad-points", "a frame comes from three points",
                  "'from': [origin, one on x, one in the xy plane]");
    for (std::size_t k = 0; k < 3; ++k) at[k] = poses[k].position;
  } else {
    at = {place_argument(arguments, "origin"), place_argument(arguments, "on_x"),
          place_argument(arguments, "in_plane")};
  }
  data::Point out{data::frame_from_points(at[0], at[1], at[2]), false};
  const Vec3 x = at[1] - at[0], y = at[2] - at[0];
  const Json found{
      {"name", name},        {"pose", place_json(out.pose)},
      {"frame", frame},      {"x_length", norm(x)},
      {"y_length", norm(y)}, {"angle", std::acos(std::clamp(dot(x, y) / (norm(x) * norm(y)), -1.0, 1.0))}};
  if (!frame.empty()) out.taught = std::make_shared<data::Taught>(data::Taught{frame, {}, {}, {}});
  if (flag_argument(arguments, "dry")) return at_once(found);
  return then_with(edit_value(cell, set_for(cell, arguments, name), "frame " + name, name, out),
                   [found](Cell&, Json answer) {
                     answer.update(found);
                     return at_once(std::move(answer));
                   });
}

Poll points_tool(Cell& cell, const Json& arguments) {
  const std::string name = text_argument(arguments, "name");
  check_point_name(name);
  std::vector<Pose> poses;
  const std::vector<std::string> from = list_argument(arguments, "from");
  if (from.empty()) {
    const Json given = arguments.value("poses", Json::array());
    if (!given.is_array() || given.size() > 100) throw Error("bad-argument", "'poses' is no list of poses");
    for (const Json& each : given) poses.push_back(pose_value(each));
  } else {
    const CellRobot& robot = *cell.robots()[robot_argument(cell, arguments)];
    for (const std::string& each : from) poses.push_back(flange_at(cell, robot, each));
  }
  const data::TaughtTool tool = data::tool_from_poses(poses);
  const Json found{{"name", name},
                   {"tcp", place_json(tool.tcp)},
                   {"tip", place_json(tool.tip)},
                   {"residuals", tool.residuals},
                   {"rms", tool.rms},
                   {"largest", tool.largest}};
  if (flag_argument(arguments, "dry")) return at_once(found);
  return then_with(
      edit_value(cell, set_for(cell, arguments, name), "tool " + name, name, data::point_of(tool)),
      [found](Cell&, Json answer) {
        answer.update(found);
        return at_once(std::move(answer));
      });
}

}  // namespace

const std::vector<RequestRow>& frame_rows() {
  static const std::vector<RequestRow> table = {
      {{"points.frame",
        {{"name", kText, true},
         {"origin", kAny},
         {"on_x", kAny},
         {"in_plane", kAny},
         {"from", kNames},
         {"file", kText},
         {"dry", kFlag}},
        "{name, pose, frame, angle, x_length, y_length}",
        "a frame from three places, [x, y, z] or points by name `from`: its origin, one on x, one in the xy "
        "plane; `angle` is between the two directions; `dry`: it is only looked at",
        true},
       points_frame},
      {{"points.tool",
        {{"name", kText, true},
         {"poses", kAny},
         {"from", kNames},
         {"robot", kText},
         {"file", kText},
         {"dry", kFlag}},
        "{name, tcp, tip, residuals, rms, largest}",
        "a tool's TCP from four or more poses {p, q} of tool0 (or points `from` which they were taught) with "
        "the tip at one place; `dry`: it is only looked at",
        true},
       points_tool},
  };
  return table;
}

}  // namespace polyarm::cell
