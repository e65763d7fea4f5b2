#pragma once
/// Writes a cell with the JetBot on the mock, fast enough for tests that drive it.
#include <string>

#include "tests/support/folder.hpp"

namespace polyarm::test {

inline constexpr const char* kJetBotControllers = R"(
controller_manager:
  ros__parameters:
    update_rate: 100
    base: {type: diff_drive_controller/DiffDriveController}
base:
  ros__parameters:
    left_wheel_names: ["left_wheel_joint"]
    right_wheel_names: ["right_wheel_joint"]
    wheel_separation: 0.104
    wheel_radius: 0.032
    linear.x.max_velocity: 0.3
    linear.x.min_velocity: -0.3
    linear.x.max_acceleration: 0.5
    linear.x.max_deceleration: -0.5
    angular.z.max_velocity: 2.0
    angular.z.min_velocity: -2.0
    angular.z.max_acceleration: 6.0
    angular.z.max_deceleration: -6.0
    open_loop: true
    position_feedback: false
    cmd_vel_timeout: 0.5
)";

/// `urdf`: a description of the example. `more`: additional keys of the robot's entry ("xyz: [1, 0, 0]").
inline void write_jetbot_cell(const Folder& folder, const std::string& program,
                              const std::string& urdf = "jetbot.urdf.xacro", const std::string& more = {}) {
  folder.write("controllers.yaml", kJetBotControllers);
  folder.write("go.script", program);
  folder.write("cell.yaml", "polyarm: cell/1\nrobots:\n  jetbot: {model: " + std::string(POLYARM_SOURCE_DIR) +
                                "/examples/jetbot/urdf/" + urdf + ", hardware: mock" +
                                (more.empty() ? "" : ", " + more) +
                                "}\ncontrollers: controllers.yaml\nprogram: go\n");
}

}  // namespace polyarm::test
