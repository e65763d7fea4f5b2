#include "tests/cell/requests_cell.hpp"

namespace polyarm {
namespace {

using test::error_of;
using test::FailingMock;
using test::Json;
using test::kSharedJoint;
using test::LockStepCell;
using test::RequestsTest;
using test::what_of;

TEST_F(RequestsTest, ListsControllersWithStateClaimsAndRate) {
  bool found = false;
  for (const Json& c : cell.result({{"request", "control.list"}}))
    if (c["name"] == "follow") {
      found = true;
      EXPECT_EQ(c["type"], "joint_trajectory_controller/JointTrajectoryController");
      EXPECT_EQ(c["state"], "active");
      EXPECT_EQ(c["claimed"], Json({"arm/joint_1/position", "arm/joint_2/position"}));
      EXPECT_EQ(c["rate"], 1000);
    }
  EXPECT_TRUE(found);
  EXPECT_EQ(cell.state_of("tail"), "active");
  EXPECT_EQ(cell.state_of("tail_too"), "inactive");  // joint_6 has one master
}

TEST_F(RequestsTest, ASwitchTakesEffectBetweenTwoCycles) {
  const auto answers =
      cell.give(Json{{"request", "control.switch"}, {"activate", "tail_too"}, {"deactivate", "tail"}});
  EXPECT_TRUE(answers->empty()) << "the loop has not taken it yet";
  for (int i = 0; i < 5; ++i) cell.tick();
  ASSERT_EQ(answers->size(), 1u);
  EXPECT_EQ(answers->front()["result"]["start"], Json({"tail_too"}));
  EXPECT_EQ(answers->front()["result"]["stop"], Json({"tail"}));
  EXPECT_EQ(cell.state_of("tail_too"), "active");
  EXPECT_EQ(cell.state_of("tail"), "inactive");
}

TEST_F(RequestsTest, ADrySwitchSaysWhyNotAndChangesNothing) {
  const Json plan = cell.result({{"request", "control.switch"}, {"activate", "tail_too"}, {"dry", true}});
  EXPECT_FALSE(plan["ok"].get<bool>());
  EXPECT_NE(plan["reason"].get<std::string>().find("arm/joint_6/position"), std::string::npos) << plan;
  EXPECT_EQ(cell.state_of("tail_too"), "inactive");
  const Json forced = cell.result(
      {{"request", "control.switch"}, {"activate", "tail_too"}, {"strictness", "force"}, {"dry", true}});
  EXPECT_TRUE(forced["ok"].get<bool>());
  EXPECT_EQ(forced["stop"], Json({"tail"}));
  EXPECT_EQ(cell.state_of("tail"), "active");
}

TEST_F(RequestsTest, StrictnessesAreThoseOfTheReference) {
  EXPECT_FALSE(cell.ask({{"request", "control.switch"}, {"activate", "tail_too"}})["ok"].get<bool>());
  const Json best =
      cell.result({{"request", "control.switch"}, {"activate", "tail_too"}, {"strictness", "best-effort"}});
  EXPECT_EQ(best["left_out"].size(), 1u) << best;
  EXPECT_EQ(cell.state_of("tail_too"), "inactive");
  EXPECT_TRUE(
      cell.ask({{"request", "control.switch"}, {"activate", "tail_too"}, {"strictness", "force"}})["ok"]
          .get<bool>());
  EXPECT_EQ(cell.state_of("tail_too"), "active");
  EXPECT_EQ(
      error_of(cell.ask({{"request", "control.switch"}, {"activate", "tail"}, {"strictness", "stict"}})),
      "bad-argument");
}

TEST(RequestsOfAManager, ASwitchThatStatesNoStrictnessHasThatOfTheFile) {
  std::string controllers = kSharedJoint;
  controllers.replace(controllers.find("    update_rate: 1000"), 21,
                      "    update_rate: 1000\n    defaults.switch_controller.strictness: force_auto");
  LockStepCell forced{controllers};
  EXPECT_TRUE(forced.ask({{"request", "control.switch"}, {"activate", "tail_too"}})["ok"].get<bool>());
  EXPECT_EQ(forced.state_of("tail_too"), "active");
  EXPECT_EQ(forced.state_of("tail"), "inactive");
  EXPECT_FALSE(
      forced.ask({{"request", "control.switch"}, {"activate", "tail"}, {"strictness", "strict"}})["ok"]
          .get<bool>());
}

TEST(ControllersOfAFile, WhoTellsOfASensorThatIsNotThereIsLeftUnconfigured) {
  std::string controllers = kSharedJoint;
  controllers.replace(controllers.find("    update_rate: 1000"), 21,
                      "    update_rate: 1000\n    wrist: "
                      "{type: force_torque_sensor_broadcaster/ForceTorqueSensorBroadcaster}");
  controllers += "wrist:\n  ros__parameters: {sensor_name: tcp, frame_id: tool0}\n";
  LockStepCell cell{controllers};
  EXPECT_EQ(cell.state_of("wrist"), "unconfigured");
  EXPECT_EQ(cell.state_of("follow"), "active");
}

TEST(ControllersOfAFile, WhoNeedsACommandThatIsNotOfferedIsLeftUnconfiguredWhereAnotherMoves) {
  std::string controllers = kSharedJoint;
  const auto requiring_effort = [&](const char* name) {
    const auto block = controllers.find(std::string("\n") + name + ":\n");
    controllers.replace(controllers.find("interface_name: position", block), 24, "interface_name: effort");
  };
  requiring_effort("tail_too");
  LockStepCell cell{controllers};
  EXPECT_EQ(cell.state_of("tail_too"), "unconfigured");
  EXPECT_EQ(cell.state_of("tail"), "active");
  requiring_effort("tail");
  controllers.replace(controllers.find("command_interfaces: [position]"), 30, "command_interfaces: [effort]");
  LockStepCell nothing_moves{controllers};
  EXPECT_EQ(nothing_moves.state_of("tail"), "unconfigured") << "the cell starts all the same";
}

TEST(ControllersOfAFile, OfTwoThatCommandAJointInTwoWaysWhoFollowsTrajectoriesStarts) {
  const test::Folder folder;
  const std::string controllers = folder.write("controllers.yaml", R"(controller_manager:
  ros__parameters:
    speeds: {type: forward_command_controller/ForwardCommandController}
    follow: {type: joint_trajectory_controller/JointTrajectoryController}
speeds:
  ros__parameters: {joints: [joint_2, joint_3], interface_name: velocity}
follow:
  ros__parameters: {joints: [joint_1, joint_2], command_interfaces: [position], state_interfaces: [position]}
)");
  cell::Overrides overrides;
  overrides.hardware = "mock";
  cell::CellFile file = cell::cell_from_description(test::kSixAxes, {controllers}, overrides);
  LockStepCell chosen_by_default{file};
  EXPECT_EQ(chosen_by_default.state_of("follow"), "active");
  EXPECT_EQ(chosen_by_default.state_of("speeds"), "inactive");
  file.activate = {"speeds"};
  LockStepCell chosen{file};
  EXPECT_EQ(chosen.state_of("speeds"), "active");
}

TEST(ControllersOfAFile, WhoIsNotAskedForMayNameWhatIsNotThere) {
  const test::Folder folder;
  std::string controllers = kSharedJoint;
  controllers.replace(controllers.find("joints: [joint_1, joint_2]"), 26, "joints: [shoulder, joint_2]");
  cell::CellFile file =
      cell::cell_from_description(test::kSixAxes, {folder.write("controllers.yaml", controllers)}, {});
  for (const std::vector<std::string>& asked : {{}, {"tail"}, std::vector<std::string>{"tail", "follow"}}) {
    file.activate = asked;
    LockStepCell cell{file};
    EXPECT_EQ(cell.state_of("follow"), "unconfigured");
    EXPECT_EQ(cell.state_of("tail"), "active");
  }
}

TEST(ControllersOfAFile, OneThatIsNotAvailableRefusesNoCellThatAsksForIt) {
  const test::Folder folder;
  const std::string controllers =
      "controller_manager:\n  ros__parameters:\n    own: {type: their/OwnController}\n"
      "    states: {type: joint_state_broadcaster/JointStateBroadcaster}\n";
  cell::CellFile file =
      cell::cell_from_description(test::kSixAxes, {folder.write("controllers.yaml", controllers)}, {});
  file.activate = {"own", "states"};
  LockStepCell cell{file};
  EXPECT_EQ(cell.state_of("states"), "active");
  EXPECT_EQ(cell.state_of("own"), "gone");
  file.activate = {"nobody", "states"};
  EXPECT_THROW(LockStepCell{file}, Error) << "a name that no file has is a typing error";
}

TEST(ControllersOfAFile, VariablesAreArgumentsOfTheDescription) {
  const test::Folder folder;
  const std::string robot = folder.write("arm.urdf.xacro", R"xml(<robot name="arm" xmlns:xacro="x">
<xacro:arg name="tf_prefix" default="left_"/>
<link name="base"/><link name="tool0"/>
<joint name="$(arg tf_prefix)j" type="revolute"><parent link="base"/><child link="tool0"/>
<limit lower="-1" upper="1" velocity="1" effort="1"/></joint></robot>)xml");
  const std::string controllers = folder.write("controllers.yaml", R"(controller_manager:
  ros__parameters:
    turn: {type: forward_command_controller/ForwardCommandController}
turn:
  ros__parameters: {joints: ["$(var tf_prefix)j"], interface_name: position}
)");
  cell::Overrides overrides;
  overrides.hardware = "mock";
  cell::CellFile file = cell::cell_from_description(robot, {controllers}, overrides);
  const auto claimed = [&] {
    for (const Json& c : LockStepCell{file}.result({{"request", "control.list"}}))
      if (c["name"] == "turn") return c["claimed"];
    return Json();
  };
  EXPECT_EQ(claimed(), Json({"arm/left_j/position"}));
  file.robots.front().arguments["tf_prefix"] = "right_";
  EXPECT_EQ(claimed(), Json({"arm/right_j/position"}));
}

TEST_F(RequestsTest, AControllerWalksThroughItsStates) {
  EXPECT_EQ(cell.result({{"request", "control.state"}, {"name", "tail"}, {"state", "unconfigured"}})["state"],
            "unconfigured");
  EXPECT_EQ(cell.state_of("tail"), "unconfigured");
  EXPECT_EQ(error_of(cell.ask({{"request", "control.cleanup"}, {"name", "tail"}})), "wrong-state");
  EXPECT_EQ(cell.result({{"request", "control.configure"}, {"name", "tail"}})["state"], "inactive");
  EXPECT_EQ(cell.result({{"request", "control.cleanup"}, {"name", "tail"}})["state"], "unconfigured");
  EXPECT_EQ(cell.result({{"request", "control.state"}, {"name", "tail"}, {"state", "active"}})["state"],
            "active");
  EXPECT_EQ(cell.state_of("tail"), "active");
  EXPECT_EQ(error_of(cell.ask({{"request", "control.state"}, {"name", "tail"}, {"state", "actve"}})),
            "bad-argument");
}

TEST_F(RequestsTest, ControllersComeAndGoWhileItRuns) {
  EXPECT_EQ(error_of(cell.ask({{"request", "control.unload"}, {"name", "tail"}})), "wrong-state");
  EXPECT_TRUE(
      cell.ask({{"request", "control.state"}, {"name", "tail"}, {"state", "inactive"}})["ok"].get<bool>());
  EXPECT_TRUE(cell.ask({{"request", "control.unload"}, {"name", "tail"}})["ok"].get<bool>());
  EXPECT_EQ(cell.state_of("tail"), "gone");
  // As the file has it, then of another file, then by its type alone.
  EXPECT_EQ(cell.result({{"request", "control.load"}, {"name", "tail"}})["state"], "inactive");
  EXPECT_EQ(cell.result({{"request", "control.state"}, {"name", "tail"}, {"state", "active"}})["state"],
            "active");
  const std::string file = cell.folder().write(
      "more.yaml",
      "controller_manager:\n  ros__parameters:\n    extra: {type: "
      "forward_command_controller/ForwardCommandController}\nextra:\n  ros__parameters: {joints: [joint_4], "
      "interface_name: position}\n");
  EXPECT_EQ(cell.result({{"request", "control.load"}, {"name", "extra"}, {"file", file}})["state"],
            "inactive");
  const Json typed = cell.result({{"request", "control.load"},
                                  {"name", "typed"},
                                  {"type", "forward_command_controller/ForwardCommandController"},
                                  {"parameters", {{"joints", {"joint_3"}}, {"interface_name", "position"}}}});
  EXPECT_EQ(typed["state"], "inactive") << typed;
  EXPECT_EQ(cell.result({{"request", "control.state"}, {"name", "typed"}, {"state", "active"}})["state"],
            "active");
  EXPECT_EQ(error_of(cell.ask({{"request", "control.load"}, {"name", "unheard"}})), "unknown-controller");
  EXPECT_EQ(error_of(cell.ask({{"request", "control.load"}, {"name", "x"}, {"type", "a/B"}})),
            "unknown-controller-type");
}

TEST_F(RequestsTest, ALoadThatFailsLeavesNothingBehind) {
  const Json request{{"request", "control.load"},
                     {"name", "typed"},
                     {"type", "forward_command_controller/ForwardCommandController"},
                     {"parameters", {{"joints", {"joint_33"}}, {"interface_name", "position"}}}};
  EXPECT_FALSE(cell.ask(request)["ok"].get<bool>());
  EXPECT_EQ(cell.state_of("typed"), "gone");
  EXPECT_NE(error_of(cell.ask(request)), "duplicate-controller");
}

TEST_F(RequestsTest, AHardwareComponentGoesDownWithItsControllersAndComesBack) {
  const Json listed = cell.result({{"request", "hardware.list"}});
  ASSERT_EQ(listed.size(), 1u);
  const std::string name = listed[0]["name"];
  EXPECT_EQ(listed[0]["state"], "active");
  EXPECT_EQ(listed[0]["commands"][0]["claimed_by"], "follow");
  // Inactive: nobody may command, all may read.
  const Json inactive = cell.result({{"request", "hardware.state"}, {"name", name}, {"state", "inactive"}});
  EXPECT_EQ(inactive["state"], "inactive") << inactive;
  EXPECT_EQ(inactive["stopped"].size(), 2u) << inactive;
  EXPECT_EQ(cell.state_of("follow"), "inactive");
  EXPECT_EQ(cell.state_of("joint_state_broadcaster"), "active");
  EXPECT_FALSE(
      cell.ask({{"request", "control.state"}, {"name", "tail"}, {"state", "active"}})["ok"].get<bool>());
  // Unconfigured: nobody may read.
  const Json off = cell.result({{"request", "hardware.state"}, {"name", name}, {"state", "unconfigured"}});
  EXPECT_EQ(off["state"], "unconfigured") << off;
  EXPECT_EQ(off["stopped"], Json({"joint_state_broadcaster"}));
  const Json on = cell.result({{"request", "hardware.state"}, {"name", name}, {"state", "active"}});
  EXPECT_EQ(on["state"], "active") << on;
  EXPECT_EQ(cell.state_of("follow"), "inactive") << "nothing is started by itself";
  EXPECT_EQ(cell.result({{"request", "control.state"}, {"name", "follow"}, {"state", "active"}})["state"],
            "active");
  // From active to unconfigured in one go; finalized is the end.
  EXPECT_EQ(cell.result({{"request", "hardware.state"}, {"name", name}, {"state", "unconfigured"}})["state"],
            "unconfigured");
  EXPECT_EQ(cell.result({{"request", "hardware.state"}, {"name", name}, {"state", "finalized"}})["state"],
            "finalized");
  EXPECT_EQ(error_of(cell.ask({{"request", "hardware.state"}, {"name", name}, {"state", "active"}})),
            "finalized");
  EXPECT_EQ(error_of(cell.ask({{"request", "hardware.state"}, {"name", "nobody"}, {"state", "active"}})),
            "unknown-component");
}

TEST_F(RequestsTest, AFailedComponentIsBroughtBackAndItsControllersAreNamed) {
  const std::string name = cell.result({{"request", "hardware.list"}})[0]["name"];
  FailingMock::fails = true;
  cell.run(0.02);
  FailingMock::fails = false;
  EXPECT_EQ(cell.state_of("follow"), "inactive");
  const Json health = cell.result({{"request", "health"}});
  EXPECT_EQ(health["state"], "fault");
  ASSERT_EQ(health["fallen"].size(), 1u) << health;
  EXPECT_EQ(health["fallen"][0]["controllers"].size(), 3u) << health["fallen"];
  EXPECT_EQ(cell.result({{"request", "health"}})["fallen"], health["fallen"]) << "reading forgets nothing";
  EXPECT_EQ(cell.result({{"request", "hardware.list"}})[0]["state"], "unconfigured")
      << "its on_error says so";
  const Json back = cell.result({{"request", "hardware.recover"}, {"name", name}});
  EXPECT_EQ(back["state"], "active") << back;
  std::set<std::string> fallen;
  for (const Json& controller : back["fallen"]) fallen.insert(controller);
  EXPECT_EQ(fallen, (std::set<std::string>{"follow", "tail", "joint_state_broadcaster"}));
  EXPECT_EQ(health["fallen"][0]["controllers"], back["fallen"]);
  EXPECT_EQ(cell.state_of("follow"), "inactive") << "named, not started";
  EXPECT_EQ(cell.result({{"request", "control.recover"}})["asked"], "recover");
  cell.run(0.01);
  EXPECT_EQ(cell.result({{"request", "health"}})["state"], "held");
  EXPECT_EQ(cell.result({{"request", "control.state"}, {"name", "follow"}, {"state", "active"}})["state"],
            "active");
  cell.result({{"request", "control.resume"}});
  cell.run(0.01);
  EXPECT_EQ(cell.result({{"request", "health"}})["state"], "running");
}

TEST_F(RequestsTest, OneRequestBringsBackAllThatFailedWithItsControllers) {
  FailingMock::fails = true;
  cell.run(0.02);
  FailingMock::fails = false;
  EXPECT_EQ(cell.state_of("follow"), "inactive");
  EXPECT_EQ(cell.result({{"request", "control.recover"}})["asked"], "recover");
  cell.run(0.01);
  const Json back = cell.result({{"request", "hardware.recover"}, {"controllers", true}});
  EXPECT_EQ(back["state"], "active") << back;
  EXPECT_EQ(back["name"], cell.result({{"request", "hardware.list"}})[0]["name"]);
  EXPECT_EQ(back["started"].size(), 3u) << back;
  EXPECT_EQ(cell.state_of("follow"), "active");
  EXPECT_EQ(cell.state_of("tail"), "active");
  cell.result({{"request", "control.resume"}});
  cell.run(0.01);
  EXPECT_EQ(cell.result({{"request", "health"}})["state"], "running");
  // Again with nothing to bring back: there is nothing to start either.
  EXPECT_EQ(cell.result({{"request", "hardware.recover"}, {"controllers", true}})["started"], Json::array());
}

TEST_F(RequestsTest, ControllersWhoseComponentIsBackAlreadyStartByTheSameRequest) {
  const std::string name = cell.result({{"request", "hardware.list"}})[0]["name"];
  FailingMock::fails = true;
  cell.run(0.02);
  FailingMock::fails = false;
  EXPECT_EQ(cell.result({{"request", "control.recover"}})["asked"], "recover");
  cell.run(0.01);
  EXPECT_EQ(cell.result({{"request", "hardware.recover"}, {"name", name}})["fallen"].size(), 3u);
  EXPECT_EQ(cell.state_of("follow"), "inactive");
  const Json back = cell.result({{"request", "hardware.recover"}, {"controllers", true}});
  EXPECT_FALSE(back["started"].empty()) << back;
  EXPECT_EQ(cell.state_of("follow"), "active");
}

TEST_F(RequestsTest, ANamedRecoveryStartsOnlyWhatStoppedWithTheComponent) {
  const std::string name = cell.result({{"request", "hardware.list"}})[0]["name"];
  const auto recover = [&] {
    return cell.result({{"request", "hardware.recover"}, {"name", name}, {"controllers", true}});
  };
  cell.result({{"request", "control.switch"}, {"deactivate", {"tail", "follow"}}});
  EXPECT_EQ(recover()["started"], Json::array()) << "nothing failed";
  EXPECT_EQ(cell.state_of("follow"), "inactive");
  FailingMock::fails = true;
  cell.run(0.02);
  FailingMock::fails = false;
  EXPECT_EQ(recover()["started"], Json::array({"joint_state_broadcaster"}));
  EXPECT_EQ(recover()["started"], Json::array()) << "once only";
  EXPECT_EQ(cell.state_of("follow"), "inactive") << "a person had stopped it";
}

TEST_F(RequestsTest, EveryWayBackForgetsWhatStoppedWithTheComponent) {
  const std::string name = cell.result({{"request", "hardware.list"}})[0]["name"];
  const std::vector<Json> ways{{{"request", "hardware.state"}, {"name", name}, {"state", "active"}},
                               {{"request", "hardware.recover"}, {"name", name}}};
  for (const Json& way : ways) {
    FailingMock::fails = true;
    cell.run(0.02);
    FailingMock::fails = false;
    EXPECT_EQ(cell.result(way)["state"], "active");
    cell.result({{"request", "control.recover"}});
    cell.run(0.01);
    const Json again = cell.result({{"request", "hardware.recover"}, {"name", name}, {"controllers", true}});
    EXPECT_EQ(again["fallen"], Json::array()) << way;
    EXPECT_EQ(cell.state_of("follow"), "inactive") << way;
    cell.result({{"request", "control.switch"}, {"activate", {"follow", "tail", "joint_state_broadcaster"}}});
    cell.result({{"request", "control.resume"}});
    cell.run(0.01);
  }
}

TEST_F(RequestsTest, ParametersAreListedReadAndChanged) {
  const Json listed = cell.result({{"request", "param.list"}, {"name", "follow"}});
  std::set<std::string> keys;
  for (const Json& p : listed) keys.insert(p["key"].get<std::string>());
  EXPECT_TRUE(keys.contains("joints") && keys.contains("constraints.goal_time")) << listed;
  EXPECT_EQ(cell.result({{"request", "param.get"},
                         {"name", "follow"},
                         {"key", "constraints.stopped_velocity_tolerance"}})["value"],
            "0.01");
  const Json change{
      {"request", "param.set"}, {"name", "follow"}, {"values", {{"constraints.goal_time", 2.5}}}};
  const auto answers = cell.give(change);
  EXPECT_TRUE(answers->empty()) << "written between two cycles";
  cell.run(0.01);
  EXPECT_EQ(answers->front()["result"]["changed"], 1);
  EXPECT_EQ(
      cell.result({{"request", "param.get"}, {"name", "follow"}, {"key", "constraints.goal_time"}})["value"],
      "2.5");
  EXPECT_EQ(
      error_of(cell.ask({{"request", "param.set"}, {"name", "follow"}, {"values", {{"joints", "joint_3"}}}})),
      "not-changeable");
  EXPECT_EQ(
      error_of(cell.ask({{"request", "param.get"}, {"name", "follow"}, {"key", "constraints.gaol_time"}})),
      "unknown-parameter");
}

}  // namespace
}  // namespace polyarm
