/// Requests that compute a frame from three points, a tool from four poses, or a camera from sightings of a
/// marker.
#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "polyarm/calibration/hand_eye.hpp"
#include "polyarm/calibration/touch.hpp"
#include "polyarm/data/point_in.hpp"
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
  const Pose pose = calibration::frame_from_points(at[0], at[1], at[2]);
  const Vec3 x = at[1] - at[0], y = at[2] - at[0];
  const PointsFrame::Answer found{.point = {},
                                  .name = name,
                                  .pose = pose_facts(pose),
                                  .frame = frame,
                                  .angle = std::acos(std::clamp(dot(x, y) / (norm(x) * norm(y)), -1.0, 1.0)),
                                  .x_length = norm(x),
                                  .y_length = norm(y)};
  if (request.dry) return at_once(found);
  return then(edit_value(cell, set_for(cell.data, request.file, name), "frame " + name, name,
                         data::point_in(pose, frame)),
              [found](const ChangedPoint& changed) {
                PointsFrame::Answer answer = found;
                answer.point.emplace(changed);
                return at_once(answer);
              });
}

std::optional<double> outlier_of(const calibration::Residuals& residuals) {
  if (!residuals.outlier) return std::nullopt;
  return static_cast<double>(residuals.outlier->sample);
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
  const calibration::TouchedTool tool = calibration::tool_from_poses(poses);
  const calibration::NextPose next = calibration::next_touch(poses);
  std::vector<double> residuals;
  for (const calibration::Residual& each : tool.residuals.each) residuals.push_back(each.position);
  const PointsTool::Answer found{.point = {},
                                 .name = name,
                                 .tcp = tool.tcp,
                                 .tip = tool.tip,
                                 .residuals = residuals,
                                 .rms = tool.residuals.rms.position,
                                 .largest = tool.residuals.largest.position,
                                 .sigma = tool.sigma,
                                 .outlier = outlier_of(tool.residuals),
                                 .next = pose_facts(next.flange),
                                 .next_sigma = next.sigma_then};
  if (request.dry) return at_once(found);
  return then(edit_value(cell, set_for(cell.data, request.file, name), "tool " + name, name,
                         data::point_in({tool.tcp, {}}, "tool0")),
              [found](const ChangedPoint& changed) {
                PointsTool::Answer answer = found;
                answer.point.emplace(changed);
                return at_once(answer);
              });
}

/// The pose of a value of the cell's data.
const data::Value& marker_named(const PointOwners& cell, const std::string& name) {
  const data::Value& value = place_of(cell.data.store, name);
  if (!value.as_point())
    throw Error("bad-points", "'" + name + "' is a joint state", "name the pose that the camera writes");
  return value;
}

PointsSighting::Answer points_sighting(const PointOwners& cell, const PointsSighting& request) {
  const std::size_t i = robot_named(cell.setup, request.robot);
  const CellRobot& robot = *cell.setup.robots[i];
  if (!cell.machine.snapshot().standing || !cell.motions.idle(i))
    throw Error("moving", "a robot moves: the camera may have seen the marker from another pose",
                "wait until '" + robot.entry.name + "' is at rest");
  const data::Value& marker = marker_named(cell, request.marker);
  const auto facts = cell.data.store.facts(request.marker);
  PointsSighting::Answer out;
  out.flange = pose_facts(cell.motions.tcp(i) * inverse(robot.tool.tcp));
  out.marker = pose_facts(marker.as_point()->pose);
  // A value that has not changed since the cell began is as old as the cell.
  const Nanoseconds changed = facts ? std::max<Nanoseconds>(0, facts->changed_at) : 0;
  out.age = 1e-9 * static_cast<double>(cell.machine.now() - changed);
  return out;
}

std::vector<calibration::Sighting> sightings_of(const Any& given) {
  constexpr std::size_t kMost = 200;
  const nlohmann::json& list = given.json();
  if (!list.is_array() || list.size() > kMost)
    throw Error("bad-argument", "'sightings' is not a list of at most 200 pairs {flange, marker}");
  std::vector<calibration::Sighting> out;
  for (const nlohmann::json& each : list) {
    if (!each.is_object()) throw Error("bad-argument", each.dump() + " is not a pair {flange, marker}");
    out.push_back({pose_value(each.value("flange", nlohmann::json())),
                   pose_value(each.value("marker", nlohmann::json()))});
  }
  return out;
}

PointsCamera::Answer found_camera(const PointsCamera& request, const std::string& robot) {
  const bool on_hand = request.place.value_or(CameraSeat::hand) == CameraSeat::hand;
  const auto place = on_hand ? calibration::CameraPlace::on_hand : calibration::CameraPlace::beside;
  const std::vector<calibration::Sighting> sightings = sightings_of(request.sightings.value_or(Any{}));
  const calibration::HandEye found = calibration::hand_eye(sightings, place);
  const calibration::NextPose next = calibration::next_sighting(sightings, place, found);
  PointsCamera::Answer out{.name = request.name,
                           .frame = on_hand ? robot + "/flange" : "",
                           .camera = pose_facts(found.camera.pose),
                           .marker = pose_facts(found.marker.pose),
                           .position_rms = found.residuals.rms.position,
                           .rotation_rms = found.residuals.rms.rotation,
                           .position_sigma = found.camera.position_sigma,
                           .rotation_sigma = found.camera.rotation_sigma,
                           .outlier = outlier_of(found.residuals),
                           .next = pose_facts(next.flange),
                           .next_sigma = next.sigma_then};
  for (const calibration::Residual& each : found.residuals.each) {
    out.position_residuals.push_back(each.position);
    out.rotation_residuals.push_back(each.rotation);
  }
  return out;
}

/// Computed on the worker, because it takes longer than a tick; then stored.
Poll<PointsCamera::Answer> points_camera(const PointOwners& cell, const PointsCamera& request) {
  check_point_name(request.name);
  const std::string robot = cell.setup.robots[robot_named(cell.setup, request.robot)]->entry.name;
  Poll<PointsCamera::Answer> found =
      later(cell.worker, [request, robot] { return found_camera(request, robot); });
  if (request.dry) return found;
  const std::string set = set_for(cell.data, request.file, request.name);
  return then(std::move(found), [cell, set](const PointsCamera::Answer& camera) {
    const data::Point point = data::point_in({camera.camera.p, camera.camera.q}, camera.frame);
    return then(edit_value(cell, set, "camera " + camera.name, camera.name, point),
                [camera](const ChangedPoint& changed) {
                  PointsCamera::Answer answer = camera;
                  answer.point.emplace(changed);
                  return at_once(answer);
                });
  });
}

}  // namespace

std::vector<Handler> frame_handlers() {
  return handlers<points_frame, points_tool, points_sighting, points_camera>();
}

}  // namespace polyarm::cell
