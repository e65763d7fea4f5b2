#include "polyarm/description/arm_calibration.hpp"

#include <fmt/format.h>

#include "polyarm/base/text.hpp"
#include "polyarm/yaml/yaml.hpp"

namespace polyarm::description {

ArmCalibration read_arm_calibration(const std::filesystem::path& path) {
  const Yaml yaml = Yaml::load(path.string());
  Problems problems;
  if (yaml["polyarm"].text("") != "arm_calibration/1")
    problems.error(
        "bad-value", yaml.where(), "this is not the calibration of an arm",
        "`polyarm calibrate joints` and `polyarm calibrate read` write such files; the first line is "
        "`polyarm: arm_calibration/1`");
  yaml.check_keys({"polyarm", "robot", "source", "joints"}, problems);
  ArmCalibration out;
  collect(problems, [&] { out.robot = yaml["robot"].text(""); });
  collect(problems, [&] { out.source = yaml["source"].text(""); });
  for (const Yaml::Entry& entry : yaml["joints"].entries())
    collect(problems, [&] { out.origins[entry.key] = entry.value.pose(); });
  if (out.origins.empty() && !problems.has_errors())
    problems.error("missing-key", yaml.where(), "the calibration has no joints", "write it again");
  problems.throw_if_errors();
  return out;
}

std::string arm_calibration_text(const ArmCalibration& calibration) {
  std::string out = "polyarm: arm_calibration/1\n";
  if (!calibration.robot.empty()) out += "robot: " + calibration.robot + "\n";
  if (!calibration.source.empty()) out += "source: \"" + calibration.source + "\"\n";
  out += "# The pose of each joint in its parent link at zero: x y z (m), qx qy qz qw.\njoints:\n";
  for (const auto& [joint, pose] : calibration.origins) {
    const Vec3& p = pose.position;
    const Quaternion& q = pose.rotation;
    out += fmt::format("  {}: [{}, {}, {}, {}, {}, {}, {}]\n", joint, p.x, p.y, p.z, q.x, q.y, q.z, q.w);
  }
  return out;
}

void apply(const ArmCalibration& calibration, RobotModel& model, const Location& where) {
  std::vector<std::string> names;
  for (const Joint& joint : model.joints) names.push_back(joint.name);
  RobotModel changed = model;
  for (const auto& [name, origin] : calibration.origins) {
    const int index = model.find_joint(name);
    if (index < 0)
      throw Error(Problem{"unknown-joint", where,
                          "the calibration has a joint '" + name + "', the robot '" + model.name +
                              "' has none" + did_you_mean(name, names),
                          "use the calibration of this robot"});
    Joint& joint = changed.joints[static_cast<std::size_t>(index)];
    const double shift = norm(origin.position - joint.origin.position),
                 tilt = angle_between(origin.rotation, joint.origin.rotation);
    if (!(shift <= kMostShift && tilt <= kMostTilt))
      throw Error(
          Problem{"other-robot", where,
                  fmt::format("'{}' is {:.1f} mm and {:.2f} degrees away from the description of '{}'", name,
                              1e3 * shift, tilt * 180 / M_PI, model.name),
                  "this calibration belongs to another robot, or `model` is wrong"});
    joint.origin = origin;
  }
  model = std::move(changed);
}

}  // namespace polyarm::description
