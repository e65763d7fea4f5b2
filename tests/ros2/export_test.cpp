/// `polyarm export moveit`: what is written is read back, and fits together.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <sstream>
#include <string>

#include "polyarm/base/yaml.hpp"
#include "polyarm/description/srdf.hpp"
#include "polyarm/description/urdf.hpp"
#include "tests/support/command.hpp"

namespace polyarm {
namespace {

namespace fs = std::filesystem;

class ExportMoveIt : public ::testing::Test {
 protected:
  void SetUp() override { fs::create_directories(folder_); }
  void TearDown() override { fs::remove_all(folder_); }

  void export_cell(const std::string& cell, const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments{"export",    "moveit", cell, (folder_ / "out").string(),
                                       "--samples", "2000"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    test::Command command(arguments);
    const auto done = command.wait();
    ASSERT_EQ(done.exit_code, 0) << done.output;
    model_ = description::read_urdf(text("robot.urdf"), "robot.urdf", problems_);
    description::read_srdf(text("robot.srdf"), "robot.srdf", model_, problems_);
    EXPECT_FALSE(problems_.has_errors());
  }
  std::string text(const std::string& name) const {
    std::ifstream in(folder_ / "out" / name);
    EXPECT_TRUE(in) << name;
    return {std::istreambuf_iterator<char>(in), {}};
  }
  Yaml yaml(const std::string& name) const { return Yaml::parse(text(name), name); }
  const description::GroupInfo* group(const std::string& name) const {
    for (const auto& group : model_.groups)
      if (group.name == name) return &group;
    return nullptr;
  }

  const fs::path folder_ = fs::temp_directory_path() / ("polyarm_export_" + std::to_string(::getpid()));
  description::RobotModel model_;
  Problems problems_;
};

TEST_F(ExportMoveIt, AnArmHasItsGroupItsStatesAndItsController) {
  std::ofstream(folder_ / "cell.yaml") << "polyarm: cell/1\nrobots:\n  arm: {model: universal_robots/ur5e, "
                                          "hardware: mock}\ncontrollers: controllers.yaml\n";
  std::ofstream(folder_ / "controllers.yaml") << R"(controller_manager:
  ros__parameters:
    arm_controller: {type: joint_trajectory_controller/JointTrajectoryController}
arm_controller:
  ros__parameters:
    joints: [shoulder_pan_joint, shoulder_lift_joint, elbow_joint, wrist_1_joint, wrist_2_joint, wrist_3_joint]
    command_interfaces: [position]
    state_interfaces: [position, velocity]
)";
  export_cell(folder_.string());
  EXPECT_EQ(text("robot.urdf").find("<capsule"), std::string::npos) << "ROS's reader gives up at it";
  ASSERT_TRUE(group("arm"));
  std::set<std::string> moving;
  for (const int joint : group("arm")->joints)
    if (model_.joints[static_cast<std::size_t>(joint)].moves())
      moving.insert(model_.joints[static_cast<std::size_t>(joint)].name);
  EXPECT_EQ(moving.size(), 6u);
  EXPECT_EQ(model_
                .links[static_cast<std::size_t>(
                    model_.joints[static_cast<std::size_t>(group("arm")->joints.back())].child_link)]
                .name,
            "tool0");
  EXPECT_TRUE(model_.named_states.contains("home"));
  const Yaml controllers = yaml("moveit_controllers.yaml")["moveit_simple_controller_manager"];
  EXPECT_EQ(controllers["controller_names"].texts(), std::vector<std::string>{"arm_controller"});
  EXPECT_EQ(controllers["arm_controller"]["type"].text(), "FollowJointTrajectory");
  EXPECT_EQ(controllers["arm_controller"]["action_ns"].text(), "follow_joint_trajectory");
  EXPECT_EQ(controllers["arm_controller"]["joints"].texts().front(), "shoulder_pan_joint");
  EXPECT_TRUE(yaml("kinematics.yaml").has("arm"));
  const Yaml limits = yaml("joint_limits.yaml")["joint_limits"];
  EXPECT_TRUE(limits["elbow_joint"]["has_velocity_limits"].boolean());
  EXPECT_GT(limits["elbow_joint"]["max_velocity"].number(), 1);
  EXPECT_EQ(yaml("ros2_controllers.yaml")["arm_controller"]["ros__parameters"]["joints"].texts().size(), 6u);
  EXPECT_NE(text("moveit.launch.py").find("move_group"), std::string::npos);
}

/// What sampling left out never touches, in other samples than those that it looked at.
TEST_F(ExportMoveIt, LinksThatAreNeverComparedNeverTouch) {
  export_cell(std::string(POLYARM_SOURCE_DIR) + "/examples/pick_and_place");
  const std::string srdf = text("robot.srdf");
  EXPECT_NE(srdf.find("reason=\"Adjacent\""), std::string::npos);
  EXPECT_NE(srdf.find("reason=\"Never\""), std::string::npos);
  ASSERT_FALSE(model_.allowed_collisions.empty());
  const auto other = description::needless_pairs(model_, 4000, 77);
  std::size_t agreed = 0;
  for (const auto& pair : other)
    agreed += std::count(model_.allowed_collisions.begin(), model_.allowed_collisions.end(),
                         std::array<int, 2>{pair.first, pair.second});
  EXPECT_GE(agreed + 2, model_.allowed_collisions.size()) << "but for what touches in one state of thousands";
}

TEST_F(ExportMoveIt, EveryExampleWithAnArmCanBeExported) {
  for (const char* name : {"r6bot", "sorting", "bin_picking", "so101"}) {
    SCOPED_TRACE(name);
    fs::remove_all(folder_ / "out");
    model_ = {};
    export_cell(std::string(POLYARM_SOURCE_DIR) + "/examples/" + name);
    EXPECT_FALSE(model_.groups.empty());
    const auto again = description::write_srdf(model_, {});
    description::RobotModel read = description::read_urdf(text("robot.urdf"), "robot.urdf", problems_);
    description::read_srdf(again, "again.srdf", read, problems_);
    ASSERT_EQ(read.groups.size(), model_.groups.size());
    for (std::size_t i = 0; i < read.groups.size(); ++i)
      EXPECT_EQ(read.groups[i].joints, model_.groups[i].joints);
    EXPECT_EQ(read.named_states, model_.named_states);
  }
}

}  // namespace
}  // namespace polyarm
