#include "apps/calibrate_read.hpp"

#include <fmt/format.h>

#include <cmath>

#include "apps/client.hpp"
#include "drivers/ur/arm_kinematics.hpp"
#include "polyarm/calibration/arm_errors.hpp"

namespace polyarm::apps {

description::ArmCalibration read_arm(const description::RobotModel& robot, const ReadOptions& options) {
  const ur::Kinematics kinematics =
      ur::read_kinematics(options.host, options.port, static_cast<Nanoseconds>(1e9 * options.timeout));
  const ur::ArmAxes arm = ur::axes_of(kinematics);
  std::vector<calibration::AxisLine> axes;
  for (std::size_t i = 0; i < 6; ++i) axes.push_back({arm.directions[i], arm.points[i]});
  const int tip = robot.tool_link();
  description::ArmCalibration out{robot.name, "the controller at " + options.host,
                                  calibration::origins_for(robot, tip, axes, arm.flange)};
  description::RobotModel calibrated = robot;
  description::apply(out, calibrated);
  std::vector<std::vector<std::string>> rows;
  for (const auto& [name, origin] : out.origins) {
    const Pose& described = robot.joints[static_cast<std::size_t>(robot.find_joint(name))].origin;
    rows.push_back({name, fmt::format("{:.3f}", 1e3 * norm(origin.position - described.position)),
                    fmt::format("{:.4f}", angle_between(origin.rotation, described.rotation) * 180 / M_PI)});
  }
  print_table({"JOINT", "MM", "DEGREES"}, rows);
  const calibration::Residual off = calibration::difference_of(robot, calibrated, tip);
  fmt::print("this arm's tool is up to {:.2f} mm and {:.3f} degrees from where the description has it\n",
             1e3 * off.position, off.rotation * 180 / M_PI);
  return out;
}

}  // namespace polyarm::apps
