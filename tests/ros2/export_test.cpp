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

#include "polyarm/description/srdf.hpp"
#include "polyarm/description/urdf.hpp"
#include "polyarm/yaml/yaml.hpp"
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
    std::ifstream in(folder_ / "out" / robot_ / name);
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
  std::string robot_;  ///< of several
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
  EXPECT_LT(limits["elbow_joint"]["max_deceleration"].number(), 0) << "Pilz's readers want it so";
  const Yaml ompl = yaml("ompl_planning.yaml");
  EXPECT_EQ(ompl["planning_plugins"].texts(), std::vector<std::string>{"ompl_interface/OMPLPlanner"});
  for (const std::string& planner : ompl["arm"]["planner_configs"].texts())
    EXPECT_TRUE(ompl["planner_configs"][planner].has("type")) << planner;
  EXPECT_EQ(yaml("pilz_industrial_motion_planner_planning.yaml")["default_planner_config"].text(), "PTP");
  const Yaml cartesian = yaml("pilz_cartesian_limits.yaml")["cartesian_limits"];
  EXPECT_GT(cartesian["max_trans_acc"].number(), 0);
  EXPECT_LT(cartesian["max_trans_dec"].number(), 0);
  EXPECT_NE(text("robot.srdf").find("<virtual_joint name=\"fixed_base\""), std::string::npos);
  EXPECT_EQ(yaml("ros2_controllers.yaml")["arm_controller"]["ros__parameters"]["joints"].texts().size(), 6u);
  EXPECT_NE(text("moveit.launch.py").find("move_group"), std::string::npos);
}

/// Of a Panda, its hand among what moves, and of an arm that xacro makes.
TEST_F(ExportMoveIt, APandaAndAnArmInXacroAreReadBackWhole) {
  std::ofstream(folder_ / "arm.urdf.xacro")
      << R"(<robot xmlns:xacro="http://www.ros.org/wiki/xacro" name="maker">
  <xacro:macro name="part" params="name parent length">
    <link name="${name}_link"><collision><origin xyz="0 0 ${length/2}"/><geometry><cylinder radius="0.04" length="${length}"/></geometry></collision></link>
    <joint name="${name}" type="revolute"><parent link="${parent}"/><child link="${name}_link"/><origin xyz="0 0 ${length}"/>
      <axis xyz="0 1 0"/><limit lower="-2" upper="2" velocity="1.5" effort="20"/></joint>
  </xacro:macro>
  <link name="base_link"/>
  <xacro:part name="one" parent="base_link" length="0.3"/>
  <xacro:part name="two" parent="one_link" length="0.25"/>
  <xacro:part name="three" parent="two_link" length="0.2"/>
</robot>)";
  for (const std::string model : {"franka/fer_panda", "arm.urdf.xacro"}) {
    SCOPED_TRACE(model);
    fs::remove_all(folder_ / "out");
    model_ = {};
    std::ofstream(folder_ / "cell.yaml")
        << "polyarm: cell/1\nrobots:\n  arm: {model: " << model << ", hardware: mock}\n";
    export_cell(folder_.string());
    ASSERT_TRUE(group("arm"));
    const Yaml controllers = yaml("moveit_controllers.yaml")["moveit_simple_controller_manager"];
    const std::string name = controllers["controller_names"].texts().front();
    for (const std::string& joint : controllers[name]["joints"].texts()) {
      EXPECT_GE(model_.find_joint(joint), 0) << "a controller moves a joint that the description has not";
      EXPECT_TRUE(yaml("joint_limits.yaml")["joint_limits"].has(joint)) << joint;
    }
    EXPECT_TRUE(yaml("ompl_planning.yaml").has("arm"));
    EXPECT_TRUE(yaml("kinematics.yaml").has("arm"));
    const bool pilz = fs::exists(folder_ / "out" / "pilz_industrial_motion_planner_planning.yaml");
    EXPECT_EQ(pilz, model == "franka/fer_panda") << "it plans where limits of acceleration are known";
  }
}

/// Each has files of its own, stands where it stands in the cell, and is told of its own joints.
TEST_F(ExportMoveIt, TwoArmsAreTwoRobotsInOneWorld) {
  std::ofstream(folder_ / "cell.yaml")
      << "polyarm: cell/1\nrobots:\n  left: {model: universal_robots/ur5e, hardware: mock}\n"
         "  right: {model: universal_robots/ur5e, hardware: mock, xyz: [1, 0.5, 0], rpy: [0, 0, 90deg]}\n";
  robot_ = "left";
  export_cell(folder_.string());
  EXPECT_NE(text("robot.srdf").find("virtual_joint"), std::string::npos) << "it stands at the origin";
  EXPECT_NE(text("moveit.launch.py").find("/left/joint_states"), std::string::npos);
  robot_ = "right";
  model_ = description::read_urdf(text("robot.urdf"), "robot.urdf", problems_);
  description::read_srdf(text("robot.srdf"), "robot.srdf", model_, problems_);
  EXPECT_FALSE(problems_.has_errors());
  EXPECT_EQ(text("robot.srdf").find("virtual_joint"), std::string::npos);
  const int joint = model_.find_joint("world_to_base_link");
  ASSERT_GE(joint, 0);
  EXPECT_EQ(model_.links[static_cast<std::size_t>(model_.root)].name, "world");
  const Pose& origin = model_.joints[static_cast<std::size_t>(joint)].origin;
  EXPECT_NEAR(origin.position.x, 1, 1e-9);
  EXPECT_NEAR(to_rpy(origin.rotation).z, 1.5707963, 1e-6);
  EXPECT_NE(text("moveit.launch.py").find("/right/joint_states"), std::string::npos);
  EXPECT_EQ(yaml("moveit_controllers.yaml")["moveit_simple_controller_manager"]["controller_names"].texts(),
            std::vector<std::string>{"right_joint_trajectory_controller"});
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

TEST_F(ExportMoveIt, ADescriptionWithItsControllersIsEnough) {
  const std::string package = std::string(POLYARM_SOURCE_DIR) + "/tests/ros_packages/two_joints/";
  export_cell(package + "robot.urdf", {"--controllers", package + "controllers.yaml"});
  EXPECT_EQ(model_.name, "two_joints");
  EXPECT_FALSE(model_.groups.empty());
  EXPECT_NE(text("moveit_controllers.yaml").find("joint_trajectory_controller"), std::string::npos);
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
