#include "apps/calibrate_kinds.hpp"

#include <fmt/format.h>

#include <cmath>

#include "apps/verb.hpp"
#include "polyarm/calibration/arm_errors.hpp"
#include "polyarm/calibration/hand_eye.hpp"
#include "polyarm/calibration/touch.hpp"
#include "polyarm/data/point_in.hpp"

namespace polyarm::apps {

namespace {

using calibration::Sample;
using Samples = std::vector<Sample>;
constexpr double kDegrees = 180 / M_PI;

std::string shown(const Pose& pose) {
  const Vec3 &p = pose.position, a = to_rpy(pose.rotation);
  return fmt::format("xyz({:.6f}, {:.6f}, {:.6f}) rpy({:.6f}, {:.6f}, {:.6f})", p.x, p.y, p.z, a.x, a.y, a.z);
}
std::string shown(const std::string& what, const calibration::PoseEstimate& found) {
  return fmt::format("{} is {}, uncertainty {:.3f} mm and {:.4f} degrees", what, shown(found.pose),
                     1e3 * found.position_sigma, found.rotation_sigma * kDegrees);
}
std::string shown(const calibration::NextPose& next) {
  return fmt::format(
      "the next sample that helps most: the flange at {}; it lowers the uncertainty from {:.3f} to {:.3f} mm",
      shown(next.flange), 1e3 * next.sigma_now, 1e3 * next.sigma_then);
}

std::vector<Pose> poses(const Samples& samples, const std::string& name) {
  std::vector<Pose> out;
  for (const Sample& each : samples) out.push_back(each.pose(name));
  return out;
}
std::vector<Vec3> vectors(const Samples& samples, const std::string& name) {
  std::vector<Vec3> out;
  for (const Sample& each : samples) out.push_back(each.vector(name));
  return out;
}

/// The samples of a tool: touches, and at most one motion along z and one along x.
struct Touches {
  std::vector<Pose> flange;
  std::optional<Pose> along_z, along_x;
};
Touches touches(const Samples& samples) {
  Touches out;
  for (const Sample& each : samples) {
    const auto z = each.poses.find("along_z"), x = each.poses.find("along_x");
    if (z != each.poses.end()) out.along_z = z->second;
    if (x != each.poses.end()) out.along_x = x->second;
    if (z == each.poses.end() && x == each.poses.end()) out.flange.push_back(each.pose("flange"));
  }
  if (out.along_z.has_value() != out.along_x.has_value())
    throw Error(Problem{"missing-key", samples.back().where, "only one of along_z and along_x is given",
                        "give both, or none"});
  return out;
}

Calibrated tool(const Samples& samples, const CalibrateOptions& options) {
  const Touches at = touches(samples);
  const calibration::TouchedTool found = calibration::tool_from_poses(at.flange);
  Pose tcp{found.tcp, {}};
  Calibrated out;
  out.residuals = found.residuals;
  std::string direction = "its orientation is that of tool0";
  if (at.along_z) {
    tcp.rotation = calibration::tool_rotation(found.tcp, found.tip, *at.along_z, *at.along_x);
    direction = "its orientation is from the motions along z and x";
  } else if (!options.flat.empty()) {
    const calibration::FlatTool flat = calibration::axis_from_flat_poses(poses(options.flat, "flange"));
    tcp.rotation = calibration::rotation_with_z(flat.axis);
    direction = fmt::format("its z axis is from the flat face, which is up to {:.3f} degrees off",
                            flat.residuals.largest.rotation * kDegrees);
  }
  out.lines = {fmt::format("the TCP in tool0 is {}, uncertainty {:.3f} mm", shown(tcp), 1e3 * found.sigma),
               direction};
  out.point = data::point_in(tcp, "tool0");
  out.next = shown(calibration::next_touch(at.flange));
  return out;
}

Calibrated frame(const Samples& samples, const CalibrateOptions& options) {
  const calibration::MatchedFrame found =
      calibration::frame_from_matches(vectors(samples, "known"), vectors(samples, "point"));
  Calibrated out;
  out.residuals = found.residuals;
  const bool robots = options.kind == "robots";
  out.lines = {shown(robots ? "the base of the other robot" : "the frame", found.frame)};
  if (robots) {
    const Vec3 &p = found.frame.pose.position, a = to_rpy(found.frame.pose.rotation);
    out.lines.push_back(
        fmt::format("in cell.yaml: at: [{:.6f}, {:.6f}, {:.6f}], rpy: [{:.6f}, {:.6f}, {:.6f}]", p.x, p.y,
                    p.z, a.x, a.y, a.z));
  }
  if (samples.size() < 4)
    out.lines.push_back("three places leave little to check; a fourth one shows errors");
  out.point = data::point_in(found.frame.pose, options.in);
  return out;
}

std::vector<calibration::Sighting> sightings(const Samples& samples) {
  std::vector<calibration::Sighting> out;
  for (const Sample& each : samples) out.push_back({each.pose("flange"), each.pose("marker")});
  return out;
}

Calibrated camera(const Samples& samples, const CalibrateOptions& options) {
  const bool on_hand = options.kind == "hand-eye";
  const auto place = on_hand ? calibration::CameraPlace::on_hand : calibration::CameraPlace::beside;
  const auto seen = sightings(samples);
  const calibration::HandEye found = calibration::hand_eye(seen, place);
  Calibrated out;
  out.residuals = found.residuals;
  out.rotations = true;
  out.lines = {shown(on_hand ? "the camera on the flange" : "the camera in the base", found.camera),
               shown(on_hand ? "the marker in the base" : "the marker on the flange", found.marker),
               fmt::format("noise of the sightings: {:.3f} mm and {:.4f} degrees", 1e3 * found.position_noise,
                           found.rotation_noise * kDegrees)};
  out.point = data::point_in(found.camera.pose, !options.in.empty() ? options.in
                                                : on_hand           ? "arm/flange"
                                                                    : "");
  out.next = shown(calibration::next_sighting(seen, place, found));
  return out;
}

const description::RobotModel& robot_of(const CalibrateOptions& options) {
  if (!options.robot) throw WrongUse("bad-usage", "this calibration needs the robot", "--robot MODEL");
  return *options.robot;
}

std::vector<calibration::ArmSample> arm_samples(const Samples& samples,
                                                const description::RobotModel& robot) {
  std::vector<calibration::ArmSample> out;
  for (const Sample& each : samples) {
    calibration::ArmSample one{each.values("q", robot.joint_names()), {}};
    if (const auto point = each.vectors.find("point"); point != each.vectors.end())
      one.measured.position = point->second;
    else
      one.measured = each.pose("measured");
    out.push_back(std::move(one));
  }
  return out;
}

calibration::ArmOptions arm_options(const CalibrateOptions& o) {
  return {o.axes, o.positions, o.base_known, o.target_known};
}

Calibrated joints(const Samples& samples, const CalibrateOptions& options) {
  const description::RobotModel& robot = robot_of(options);
  const calibration::ArmErrors found =
      calibration::arm_errors(robot, robot.tool_link(), arm_samples(samples, robot), arm_options(options));
  Calibrated out;
  out.residuals = found.after;
  out.rotations = !options.positions;
  for (const calibration::ArmNumber& each : found.numbers) {
    const bool length = each.name.find("shift") != std::string::npos;
    const double scale = length ? 1e3 : kDegrees;
    out.lines.push_back(each.identifiable
                            ? fmt::format("{:<32} {:9.4f} {}, uncertainty {:.4f}", each.name,
                                          scale * each.value, length ? "mm" : "degrees", scale * each.sigma)
                            : fmt::format("{:<32} not identifiable from these samples", each.name));
  }
  out.lines.push_back(fmt::format("residuals: {:.3f} mm before, {:.3f} mm now (root mean square)",
                                  1e3 * found.before.rms.position, 1e3 * found.after.rms.position));
  if (!options.target_known) out.lines.push_back(shown("the target in tool0", found.target));
  out.arm = description::ArmCalibration{options.robot_name, fmt::format("{} measured poses", samples.size()),
                                        found.origins};
  return out;
}

calibration::WrenchSample wrench(const Sample& from) {
  return {from.pose("flange").rotation,
          from.vector("force"),
          from.vector("torque"),
          from.vector_or_zero("angular_velocity"),
          from.vector_or_zero("angular_acceleration"),
          from.vector_or_zero("acceleration")};
}

calibration::Payload measured_payload(const Samples& samples, const CalibrateOptions& options) {
  const calibration::PayloadOptions how{options.inertia, true, options.friction};
  if (!samples.empty() && samples.front().joints.contains("tau")) {
    const description::RobotModel& robot = robot_of(options);
    const std::vector<std::string> names = robot.joint_names();
    std::vector<calibration::TorqueSample> list;
    for (const Sample& each : samples) {
      const auto or_zero = [&](const char* name) {
        return each.joints.contains(name) ? each.values(name, names) : std::vector<double>(names.size());
      };
      list.push_back({each.values("q", names), or_zero("v"), or_zero("a"), each.values("tau", names)});
    }
    return calibration::payload_from_torques(robot, robot.tool_link(), list, how);
  }
  std::vector<calibration::WrenchSample> list;
  for (const Sample& each : samples) list.push_back(wrench(each));
  return calibration::payload_from_wrenches(list, how);
}

Calibrated payload(const Samples& samples, const CalibrateOptions& options) {
  const calibration::Payload found = measured_payload(samples, options);
  const bool torques = !samples.empty() && samples.front().joints.contains("tau");
  Calibrated out;
  out.unit = torques ? "N m" : "N";
  out.scale = 1;
  std::vector<calibration::Residual> each;
  for (const double one : found.residuals) each.push_back({one, 0});
  for (const calibration::Residual& one : each)
    out.residuals.largest.position = std::max(out.residuals.largest.position, one.position);
  out.residuals.rms.position = found.rms;
  out.residuals.each = std::move(each);
  const Vec3& c = found.center;
  out.lines = {fmt::format("mass {:.3f} kg, uncertainty {:.3f} kg", found.mass, found.mass_sigma),
               fmt::format("centre ({:.1f}, {:.1f}, {:.1f}) mm, uncertainty {:.1f} mm", 1e3 * c.x, 1e3 * c.y,
                           1e3 * c.z, 1e3 * found.center_sigma)};
  if (found.inertia_known) {
    const auto& i = found.inertia;
    out.lines.push_back(
        fmt::format("inertia about the centre: xx {:.5f}, xy {:.5f}, xz {:.5f}, yy {:.5f}, yz {:.5f}, zz "
                    "{:.5f} kg m², uncertainty {:.5f}",
                    i[0], i[1], i[2], i[3], i[4], i[5], found.inertia_sigma));
  }
  out.residuals.outlier = found.outlier;
  out.payload = found;
  out.lines.push_back("in cell.yaml, of a robot without a tool: payload: " + payload_text(found));
  return out;
}

/// The pose in the middle of poses that should be equal.
Pose middle(const std::vector<Pose>& all) {
  Pose out = all.front();
  for (int round = 0; round < 20; ++round) {
    Vec3 shift, turn;
    for (const Pose& each : all) {
      shift = shift + (1.0 / static_cast<double>(all.size())) * (each.position - out.position);
      turn = turn + (1.0 / static_cast<double>(all.size())) *
                        to_rotation_vector(inverse(out.rotation) * each.rotation);
    }
    out.position = out.position + shift;
    if (norm(turn) > 0)
      out.rotation = normalized(out.rotation * from_axis_angle(normalized(turn), norm(turn)));
  }
  return out;
}

Calibrated against(const std::vector<Pose>& all, bool rotations) {
  const Pose at = middle(all);
  Calibrated out;
  out.rotations = rotations;
  double position = 0, rotation = 0;
  for (const Pose& each : all) {
    const calibration::Residual off{norm(each.position - at.position),
                                    rotations ? angle_between(each.rotation, at.rotation) : 0};
    position += off.position * off.position;
    rotation += off.rotation * off.rotation;
    out.residuals.largest.position = std::max(out.residuals.largest.position, off.position);
    out.residuals.largest.rotation = std::max(out.residuals.largest.rotation, off.rotation);
    out.residuals.each.push_back(off);
  }
  const auto n = static_cast<double>(all.size());
  out.residuals.rms = {std::sqrt(position / n), std::sqrt(rotation / n)};
  return out;
}
}  // namespace

std::string payload_text(const calibration::Payload& payload) {
  const Vec3& c = payload.center;
  return fmt::format("{{mass: {:.3f}kg, center: [{:.4f}, {:.4f}, {:.4f}]}}", payload.mass, c.x, c.y, c.z);
}

Calibrated calibrate(const std::vector<Sample>& samples, const CalibrateOptions& options) {
  if (samples.empty())
    throw Error("bad-points", "there are no samples", "record some: polyarm calibrate --help");
  if (options.kind == "tool") return tool(samples, options);
  if (options.kind == "frame" || options.kind == "robots") return frame(samples, options);
  if (options.kind == "joints") return joints(samples, options);
  if (options.kind == "payload") return payload(samples, options);
  return camera(samples, options);
}

Calibrated check_calibration(const std::vector<Sample>& samples, const Pose& stored,
                             const CalibrateOptions& options) {
  if (samples.empty())
    throw Error("bad-points", "there are no samples", "record some: polyarm calibrate --help");
  std::vector<Pose> places;
  if (options.kind == "tool") {
    for (const Pose& each : touches(samples).flange) places.push_back({(each * stored).position, {}});
    return against(places, false);
  }
  if (options.kind == "frame" || options.kind == "robots") {
    Calibrated out;
    for (const Sample& each : samples) {
      const double off = norm(stored * each.vector("known") - each.vector("point"));
      out.residuals.each.push_back({off, 0});
      out.residuals.largest.position = std::max(out.residuals.largest.position, off);
      out.residuals.rms.position += off * off / static_cast<double>(samples.size());
    }
    out.residuals.rms.position = std::sqrt(out.residuals.rms.position);
    return out;
  }
  if (options.kind != "hand-eye" && options.kind != "eye-to-hand")
    throw WrongUse("bad-usage", "a " + options.kind + " has no check in a data file", {});
  for (const Sample& each : samples)
    places.push_back(options.kind == "hand-eye"
                         ? each.pose("flange") * stored * each.pose("marker")
                         : inverse(each.pose("flange")) * stored * each.pose("marker"));
  return against(places, true);
}

Calibrated check_arm(const std::vector<Sample>& samples, const description::ArmCalibration& stored,
                     CalibrateOptions options) {
  description::RobotModel robot = robot_of(options);
  description::apply(stored, robot);
  // Base and target are fitted, the joints are not: their residuals before the calibration.
  const calibration::ArmErrors found =
      calibration::arm_errors(robot, robot.tool_link(), arm_samples(samples, robot), arm_options(options));
  Calibrated out;
  out.residuals = found.before;
  out.rotations = !options.positions;
  return out;
}

}  // namespace polyarm::apps
