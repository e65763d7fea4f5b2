/// Which joints are wheels, from the parameters alone: those that the configured controller commands.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "polyarm/plugins/types.hpp"
#include "polyarm/wheels/wheel_names.hpp"
#include "tests/controllers/rig.hpp"

namespace polyarm::controllers {
namespace {

struct BaseCase {
  const char* type;
  Rig::Values parameters;
};

const std::vector<std::string> kJointsOfBases = {"fl", "fr", "rl", "rr"};

std::vector<std::string> of_all(std::initializer_list<const char*> kinds) {
  std::vector<std::string> out;
  for (const std::string& joint : kJointsOfBases)
    for (const char* kind : kinds) out.push_back(joint + "/" + kind);
  return out;
}

class WheelNames : public ::testing::TestWithParam<BaseCase> {};

TEST_P(WheelNames, AreTheJointsThatTheControllerCommands) {
  Parameters implied;
  const std::unique_ptr<Controller> controller = make_controller(GetParam().type, implied);
  Rig rig(*controller, "base", kJointsOfBases, of_all({"position", "velocity"}), of_all({"position", "velocity"}),
          GetParam().parameters);
  std::set<std::string> named, commanded;
  for (const std::string& name : wheel_names(rig.context.parameters)) named.insert("base/" + name);
  ASSERT_EQ(rig.configure(), CallbackReturn::success);
  for (const std::string& command : controller->command_interfaces())
    commanded.insert(command.substr(0, command.rfind('/')));
  EXPECT_FALSE(commanded.empty());
  EXPECT_EQ(named, commanded);
}

INSTANTIATE_TEST_SUITE_P(
    Bases, WheelNames,
    testing::Values(
        BaseCase{"diff_drive_controller/DiffDriveController",
                 {{"left_wheel_names", {"fl", "rl"}},
                  {"right_wheel_names", {"fr", "rr"}},
                  {"wheel_separation", {"0.4"}},
                  {"wheel_radius", {"0.1"}}}},
        BaseCase{"diff_drive_controller/DiffDriveController",
                 {{"left_wheel", {"fl"}},
                  {"right_wheel", {"fr"}},
                  {"wheel_separation", {"0.4"}},
                  {"wheel_radius", {"0.1"}}}},
        BaseCase{"bicycle_steering_controller/BicycleSteeringController",
                 {{"traction_joints_names", {"rl"}},
                  {"steering_joints_names", {"fl"}},
                  {"wheelbase", {"0.4"}},
                  {"traction_wheel_radius", {"0.1"}}}},
        BaseCase{"tricycle_steering_controller/TricycleSteeringController",
                 {{"front_steering", {"true"}},
                  {"rear_wheels_names", {"rr", "rl"}},
                  {"front_wheels_names", {"fl"}},
                  {"wheelbase", {"0.4"}},
                  {"wheel_track", {"0.4"}},
                  {"rear_wheels_radius", {"0.1"}}}},
        BaseCase{"ackermann_steering_controller/AckermannSteeringController",
                 {{"traction_joints_names", {"rr", "rl"}},
                  {"steering_joints_names", {"fr", "fl"}},
                  {"wheelbase", {"0.4"}},
                  {"traction_track_width", {"0.4"}},
                  {"traction_wheels_radius", {"0.1"}}}},
        BaseCase{"tricycle_controller/TricycleController",
                 {{"traction_joint_name", {"fl"}},
                  {"steering_joint_name", {"fr"}},
                  {"wheelbase", {"0.4"}},
                  {"wheel_radius", {"0.1"}}}},
        BaseCase{"mecanum_drive_controller/MecanumDriveController",
                 {{"front_left_wheel_command_joint_name", {"fl"}},
                  {"front_right_wheel_command_joint_name", {"fr"}},
                  {"rear_right_wheel_command_joint_name", {"rr"}},
                  {"rear_left_wheel_command_joint_name", {"rl"}},
                  {"kinematics.wheels_radius", {"0.1"}},
                  {"kinematics.sum_of_robot_center_projection_on_X_Y_axis", {"0.4"}}}},
        BaseCase{"omni_wheel_drive_controller/OmniWheelDriveController",
                 {{"wheel_names", {"fl", "rl", "fr"}}, {"robot_radius", {"0.2"}}, {"wheel_radius", {"0.1"}}}}));

TEST(WheelNamesOfOthers, AreNone) {
  Parameters parameters;
  parameters.set("joints", {"fl", "fr"});
  EXPECT_TRUE(wheel_names(parameters).empty());
}

}  // namespace
}  // namespace polyarm::controllers
