/// A fault of one robot where the cell says that it stops this robot alone.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>

#include "polyarm/plugins/types.hpp"
#include "tests/support/lock_step_cell.hpp"

namespace polyarm {
namespace {

using test::Folder;
using test::Json;
using test::LockStepCell;

std::string description() {
  const auto joint = [](const std::string& name, const std::string& parent, const std::string& child) {
    return "<joint name='" + name + "' type='revolute'><parent link='" + parent + "'/><child link='" + child +
           "'/><axis xyz='0 0 1'/><limit lower='-3' upper='3' velocity='2' effort='10'/></joint>";
  };
  const auto driven = [&](const std::string& block, const std::string& name) {
    return "<ros2_control name='" + block +
           "' type='system'><hardware><plugin>mock_components/GenericSystem</plugin></hardware><joint "
           "name='" +
           name +
           "'><command_interface name='position'/><state_interface name='position'/>"
           "<state_interface name='velocity'/></joint></ros2_control>";
  };
  return "<robot name='r'><link name='l0'/><link name='l1'/><link name='l2'/>" + joint("a", "l0", "l1") +
         joint("b", "l1", "l2") + driven("shoulder", "a") + driven("hand", "b") + "</robot>";
}

/// Two robots of two components each; `base` is as the test says.
struct TwoGroups {
  Folder folder;
  std::unique_ptr<LockStepCell> cell;

  explicit TwoGroups(const std::string& base, const std::string& arm = "",
                     const std::string& controllers = "") {
    folder.write("r.urdf", description());
    if (!controllers.empty()) folder.write("controllers.yaml", controllers);
    const std::string file =
        folder.write("cell.yaml", "polyarm: cell/1\nrobots:\n  arm: {model: r.urdf, hardware: declared" +
                                      arm + "}\n  base: {model: r.urdf, hardware: declared" + base + "}\n" +
                                      (controllers.empty() ? "" : "controllers: controllers.yaml\n"));
    cell = std::make_unique<LockStepCell>(cell::read_cell_file(file));
  }
  Json move(const std::string& robot, double to, double duration = 2) {
    return cell->ask({{"request", "send"},
                      {"to", robot + "_joint_trajectory_controller"},
                      {"message",
                       {{"joint_names", {"a", "b"}},
                        {"points", {{{"positions", {to, -to}}, {"time_from_start", duration}}}}}}});
  }
  Json health() { return cell->result({{"request", "health"}}); }
  double at(const std::string& joint) { return cell->value_of("states", joint + "/position"); }
  std::string state_of(const std::string& robot) {
    return cell->state_of(robot + "_joint_trajectory_controller");
  }
};

struct GroupRow {
  const char* name;
  std::string inject;
  std::string more;
  std::string cause;
};

class GroupFaultTable : public testing::TestWithParam<GroupRow> {
 protected:
  std::string base(const std::string& on_fault) const {
    return ", parameters: {inject: \"" + GetParam().inject + "\"" + GetParam().more + "}" + on_fault;
  }
};

TEST_P(GroupFaultTable, StopsItsRobotAloneAndAPersonBringsItBack) {
  TwoGroups two(base(", on_fault: group"));
  ASSERT_TRUE(two.move("base", 1.5)["ok"].get<bool>());
  ASSERT_TRUE(two.move("arm", 1.5)["ok"].get<bool>());
  two.cell->run(1.2);
  const Json health = two.health();
  EXPECT_EQ(health["state"], "running") << health;
  ASSERT_EQ(health["fallen"].size(), 2u) << "both its components: " << health;
  for (const Json& fallen : health["fallen"]) EXPECT_EQ(fallen["cause"], GetParam().cause);
  EXPECT_EQ(two.state_of("base"), "inactive");
  EXPECT_EQ(two.state_of("arm"), "active");
  ASSERT_EQ(two.cell->cell().group_faults().size(), 1u) << "told once";
  const double stopped = two.at("base/b"), moving = two.at("arm/a");
  EXPECT_GT(moving, 0.1);
  EXPECT_LT(moving, 1.4) << "in the middle of its motion";
  two.cell->run(1.5);
  EXPECT_NEAR(two.at("arm/a"), 1.5, 1e-6) << "the other has gone on to its end";
  if (std::isfinite(stopped)) {
    EXPECT_NEAR(two.at("base/b"), stopped, 1e-9);
  }

  // Nothing but a person moves it: not the loop's own resume, not a recovered component.
  EXPECT_FALSE(two.move("base", 0.3).value("ok", false));
  two.cell->result({{"request", "control.resume"}});
  for (const Json& fallen : health["fallen"]) {
    const Json back = two.cell->result({{"request", "hardware.recover"}, {"name", fallen["component"]}});
    EXPECT_EQ(back["state"], "active") << back;
    EXPECT_EQ(back["next"], "start its controllers");
  }
  two.cell->run(0.1);
  EXPECT_TRUE(two.health()["fallen"].empty());
  const double from = two.at("base/a");
  EXPECT_EQ(two.state_of("base"), "inactive");
  two.cell->result({{"request", "control.switch"}, {"activate", {"base_joint_trajectory_controller"}}});
  two.cell->run(0.1);
  EXPECT_EQ(two.state_of("base"), "active");
  EXPECT_NEAR(two.at("base/a"), from, 1e-9) << "the old motion is forgotten";
}

TEST_P(GroupFaultTable, StopsEverythingWhereTheCellSaysNothing) {
  TwoGroups two(base(""), ", on_fault: group");
  two.move("base", 1.5);
  two.move("arm", 1.5);
  two.cell->run(1.2);
  EXPECT_EQ(two.health()["state"], "fault");
  EXPECT_EQ(two.health()["cause"], GetParam().cause);
  const double at = two.at("arm/a");
  two.cell->run(1.5);
  EXPECT_NEAR(two.at("arm/a"), at, 1e-6);
  EXPECT_LT(at, 1.4);
  EXPECT_TRUE(two.cell->cell().group_faults().empty());
}

const std::string kComponentFailed = "a hardware component failed";
INSTANTIATE_TEST_SUITE_P(
    All, GroupFaultTable,
    testing::Values(GroupRow{"read", "read_error@800", "", kComponentFailed},
                    GroupRow{"write", "write_error@800", "", kComponentFailed},
                    GroupRow{"deactivate", "deactivate@800", "", kComponentFailed},
                    GroupRow{"nan", "nan@800", "", "a measured joint position is NaN or infinite"},
                    GroupRow{"jump", "jump@800=0.6", "", "a measured joint position jumped"},
                    GroupRow{"freeze", "freeze@500", ", following_error: 0.05",
                             "a joint does not follow its command"}),
    [](const testing::TestParamInfo<GroupRow>& row) { return row.param.name; });

TEST(GroupFaults, AJointOutsideItsLimitsStopsItsRobotAlone) {
  for (const bool alone : {true, false}) {
    TwoGroups two(
        std::string(", parameters: {inject: \"jump@4500=0.025\"}") + (alone ? ", on_fault: group" : ""),
        alone ? "" : ", on_fault: group");
    ASSERT_TRUE(two.move("base", 2.995, 4)["ok"].get<bool>());
    two.cell->run(4.2);
    ASSERT_TRUE(two.move("arm", 1.5)["ok"].get<bool>());
    two.cell->run(1);
    const Json health = two.health();
    EXPECT_EQ(health["state"], alone ? "running" : "fault") << health;
    EXPECT_EQ(two.state_of("arm"), "active");
    if (!alone) continue;
    EXPECT_EQ(two.state_of("base"), "inactive");
    ASSERT_EQ(health["fallen"].size(), 2u) << health;
    EXPECT_EQ(health["fallen"][0]["cause"], "a joint is far outside its limits");
    const std::string reason = two.cell->cell().group_faults().front().what;
    EXPECT_NE(reason.find("far outside its limits"), std::string::npos) << reason;
    two.cell->run(1.5);
    EXPECT_NEAR(two.at("arm/a"), 1.5, 1e-6) << "the other has gone on to its end";
  }
}

/// Holds joints where they are, and fails when it is told to.
class Failing : public controllers::Controller {
 public:
  static inline bool fails = false;
  controllers::CallbackReturn on_configure(controllers::ControllerContext& context) override {
    for (const std::string& joint : context.parameters.list("joints")) {
      claim_command(context.whole_joint(joint) + "/position");
      claim_state(context.whole_joint(joint) + "/position");
    }
    return controllers::CallbackReturn::success;
  }
  controllers::ReturnType update(const hardware::Cycle&, const controllers::Verdict&) noexcept override {
    for (std::size_t i = 0; i < command_interfaces().size(); ++i) set_command(i, state(i));
    return fails ? controllers::ReturnType::error : controllers::ReturnType::ok;
  }
};

TEST(GroupFaults, AControllerThatFailsStopsTheRobotAloneThatItWorksOn) {
  if (!controllers::find_controller_type("test/Failing"))
    controllers::register_controller_type(
        {"test/Failing", [] { return std::make_unique<Failing>(); }, "fails when it is told to"});
  const std::string controllers = R"(
controller_manager:
  ros__parameters:
    arm_joint_trajectory_controller: {type: joint_trajectory_controller/JointTrajectoryController}
    fails: {type: test/Failing}
arm_joint_trajectory_controller: {ros__parameters: {joints: [arm/a, arm/b]}}
fails: {ros__parameters: {joints: [base/a, base/b]}}
)";
  for (const bool alone : {true, false}) {
    Failing::fails = false;
    TwoGroups two(alone ? ", on_fault: group" : "", "", controllers);
    const Json sent =
        two.cell->ask({{"request", "send"},
                       {"to", "arm_joint_trajectory_controller"},
                       {"message",
                        {{"joint_names", {"arm/a", "arm/b"}},
                         {"points", {{{"positions", {1.5, -1.5}}, {"time_from_start", 2.0}}}}}}});
    ASSERT_TRUE(sent["ok"].get<bool>()) << sent;
    two.cell->run(0.5);
    Failing::fails = true;
    two.cell->run(0.2);
    Failing::fails = false;
    const Json health = two.health();
    EXPECT_EQ(health["state"], alone ? "running" : "fault") << health;
    EXPECT_EQ(two.cell->state_of("fails"), "inactive");
    EXPECT_EQ(two.state_of("arm"), "active");
    if (!alone) continue;
    ASSERT_EQ(health["fallen"].size(), 2u) << health;
    EXPECT_EQ(health["fallen"][0]["cause"], "a controller failed");
    two.cell->run(2);
    EXPECT_NEAR(two.at("arm/a"), 1.5, 1e-6) << "the other has gone on to its end";
    for (const Json& fallen : health["fallen"])
      EXPECT_EQ(two.cell->result({{"request", "hardware.recover"}, {"name", fallen["component"]}})["state"],
                "active");
    two.cell->result({{"request", "control.switch"}, {"activate", {"fails"}}});
    two.cell->run(0.1);
    EXPECT_EQ(two.cell->state_of("fails"), "active");
    EXPECT_TRUE(two.health()["fallen"].empty());
  }
}

TEST(GroupFaults, AStopOfAPersonStopsEveryGroup) {
  for (const char* how : {"control.hold", "control.stop"}) {
    TwoGroups two(", on_fault: group", ", on_fault: group");
    two.move("base", 1.5);
    two.move("arm", 1.5);
    two.cell->run(0.8);
    two.cell->result({{"request", how}});
    two.cell->run(0.8);
    EXPECT_EQ(two.health()["state"], "held");
    const double arm = two.at("arm/a"), base = two.at("base/a");
    EXPECT_LT(arm, 1.4);
    two.cell->run(1);
    EXPECT_NEAR(two.at("arm/a"), arm, 1e-9) << how;
    EXPECT_NEAR(two.at("base/a"), base, 1e-9) << how;
  }
}

TEST(GroupFaults, AStopStillStopsTheOthersAfterAFaultOfOne) {
  TwoGroups two(", on_fault: group, parameters: {inject: read_error@400}");
  two.move("base", 1.5);
  two.move("arm", 1.5);
  two.cell->run(0.8);
  ASSERT_EQ(two.health()["state"], "running");
  two.cell->result({{"request", "control.hold"}});
  two.cell->run(0.8);
  EXPECT_EQ(two.health()["state"], "held");
  EXPECT_LT(two.at("arm/a"), 1.4);
}

TEST(GroupFaults, FaultsOfTwoRobotsOfWhichOneStopsEverythingStopEverything) {
  TwoGroups two(", on_fault: group, parameters: {inject: read_error@500}",
                ", parameters: {inject: read_error@500}");
  two.cell->run(0.7);
  EXPECT_EQ(two.health()["state"], "fault");
}

TEST(GroupFaults, AControllerOfBothTiesThemTogether) {
  TwoGroups two(", on_fault: group, parameters: {inject: read_error@800}", "", R"(
controller_manager:
  ros__parameters:
    update_rate: 1000
    both: {type: joint_trajectory_controller/JointTrajectoryController}
both:
  ros__parameters:
    joints: [arm/a, arm/b, base/a, base/b]
    command_interfaces: [position]
    state_interfaces: [position]
)");
  ASSERT_EQ(two.cell->state_of("both"), "active");
  two.cell->run(1);
  EXPECT_EQ(two.health()["state"], "fault");
  EXPECT_EQ(two.cell->state_of("both"), "inactive");
}

TEST(GroupFaults, AnOnlyRobotStopsTheCell) {
  Folder folder;
  folder.write("r.urdf", description());
  LockStepCell cell(cell::read_cell_file(
      folder.write("cell.yaml",
                   "polyarm: cell/1\nrobots:\n  arm: {model: r.urdf, hardware: declared, on_fault: group, "
                   "parameters: {inject: read_error@100}}\n")));
  cell.run(0.3);
  EXPECT_EQ(cell.result({{"request", "health"}})["state"], "fault");
}

TEST(GroupFaults, WhatOnFaultCannotBeIsRefused) {
  EXPECT_THROW(TwoGroups(", on_fault: robot"), Error);
}

}  // namespace
}  // namespace polyarm
