/// Motion by hand through the requests of a whole cell, in lock-step.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "polyarm/base/file.hpp"
#include "polyarm/joint_control/joint_trajectory_controller.hpp"
#include "polyarm/protocol/session.hpp"
#include "polyarm/setup/cell_file.hpp"
#include "tests/cell/requests_cell.hpp"
#include "tests/support/lock_step_cell.hpp"

namespace polyarm::cell {
namespace {

using test::error_of;
using test::Folder;
using test::Json;
using test::LockStepCell;

/// The arm of examples/r6bot on the mock with what a test adds to its cell file.
CellFile cell_file(const Folder& folder, const std::string& more, const std::string& of_robot = "") {
  folder.write("cell.yaml", "polyarm: cell/1\nrobots:\n  arm: {model: " + test::kSixAxes +
                                ", hardware: mock" + of_robot + "}\n" + more);
  return read_cell_file(folder.path());
}

class JogTest : public ::testing::Test {
 protected:
  void start(const std::string& more = "", const std::string& of_robot = "") {
    cell = std::make_unique<LockStepCell>(cell_file(folder, more, of_robot));
    cell->run(0.05);
  }
  double joint(const std::string& name) { return cell->value_of("states", "arm/" + name + "/position"); }
  /// Bends the arm, so that its TCP can go anywhere.
  void bend() {
    const Json answer = cell->result({{"request", "jog"},
                                      {"joints", {{"joint_2", 0.5}, {"joint_3", 1.0}, {"joint_5", 0.8}}},
                                      {"by", true}});
    ASSERT_TRUE(answer.value("done", false)) << answer;
    cell->run(0.5);
  }
  Json jog(Json request) {
    request["request"] = "jog";
    return cell->result(request);
  }

  Folder folder;
  std::unique_ptr<LockStepCell> cell;
};

TEST_F(JogTest, AJointGoesAsLongAsCommandsComeAndThenStops) {
  start();
  Json state = jog({{"joints", {{"joint_2", 0.5}}}});
  ASSERT_TRUE(state.contains("session")) << state;
  for (int i = 0; i < 20; ++i) {
    cell->run(0.05);
    state = jog({{"joints", {{"joint_2", 0.5}}}, {"session", state["session"]}});
  }
  const double moving = joint("joint_2");
  EXPECT_NEAR(moving, 0.5, 0.1);
  EXPECT_EQ(cell->state_of("jog"), "active");
  cell->run(1);
  EXPECT_LT(joint("joint_2") - moving, 0.25);
  const double stopped = joint("joint_2");
  cell->run(0.2);
  EXPECT_EQ(joint("joint_2"), stopped);
  EXPECT_EQ(cell->state_of("jog"), "inactive") << "the joints are back with whoever had them";
  EXPECT_EQ(cell->state_of("joint_trajectory_controller"), "active");
  EXPECT_EQ(cell->value_of("commands", "arm/joint_2/position"), stopped) << "and nothing jumped";
}

TEST_F(JogTest, StepsOfJointsAndTcpEndWhereTheyShould) {
  start();
  bend();
  const double before = joint("joint_1");
  Json state = jog({{"joints", {{"joint_1", "5deg"}}}, {"by", true}});
  EXPECT_TRUE(state.value("done", false)) << state;
  EXPECT_NEAR(joint("joint_1") - before, 5 * std::numbers::pi / 180, 1e-6);
  const Json there = cell->result({{"request", "jog.state"}});
  state = jog({{"tcp", {{"z", "-20mm"}}}, {"frame", "world"}, {"by", true}});
  EXPECT_TRUE(state.value("done", false)) << state;
  const Json now = cell->result({{"request", "jog.state"}});
  EXPECT_NEAR(now["position"][2].get<double>() - there["position"][2].get<double>(), -0.02, 1e-5);
  EXPECT_NEAR(now["position"][0].get<double>(), there["position"][0].get<double>(), 1e-5);
  for (int k = 0; k < 4; ++k)
    EXPECT_NEAR(now["orientation"][k].get<double>(), there["orientation"][k].get<double>(), 1e-4);
}

TEST_F(JogTest, AStopEndsTheSessionAndOnlyANewOneMoves) {
  start();
  Json state = jog({{"joints", {{"joint_1", 0.3}}}, {"hold", 5}});
  const Json session = state["session"];
  cell->run(0.4);
  cell->result({{"request", "control.hold"}});
  cell->run(1);
  const double stopped = joint("joint_1");
  EXPECT_GT(stopped, 0.01);
  EXPECT_EQ(error_of(cell->ask({{"request", "jog"}, {"joints", {{"joint_1", 0.3}}}, {"session", session}})),
            "session-over");
  cell->run(0.5);
  EXPECT_EQ(joint("joint_1"), stopped);
  // Held: a new press moves, and a stop stops that one, too, although nothing else can be stopped any more.
  state = jog({{"joints", {{"joint_1", 0.3}}}, {"hold", 5}});
  ASSERT_TRUE(state.contains("session")) << state;
  cell->run(0.5);
  EXPECT_GT(joint("joint_1"), stopped + 0.02);
  cell->result({{"request", "control.hold"}});
  cell->run(1);
  const double again = joint("joint_1");
  cell->run(0.5);
  EXPECT_EQ(joint("joint_1"), again);
}

TEST_F(JogTest, IsRefusedWhileAProgramRunsAndAllowedWhileItIsHeldWaiting) {
  folder.write("work.script", "wait 100s\n");
  start("program: work.script\n");
  EXPECT_EQ(error_of(cell->ask({{"request", "jog"}, {"joints", {{"joint_1", 0.1}}}})), "program-runs");
  EXPECT_EQ(cell->result({{"request", "jog.state"}})["control"], "program");
  cell->result({{"request", "control.hold"}});
  cell->run(0.2);
  const Json state = jog({{"joints", {{"joint_1", 0.1}}}, {"by", true}});
  EXPECT_TRUE(state.value("done", false)) << state;
  EXPECT_NEAR(joint("joint_1"), 0.1, 1e-6);
  EXPECT_EQ(state["control"], "jog");
  cell->run(1);
  cell->result({{"request", "control.resume"}});
  cell->run(0.2);
  EXPECT_EQ(cell->result({{"request", "jog.state"}})["control"], "program");
}

TEST_F(JogTest, WhatCannotBeIsRefusedWithItsReason) {
  start();
  const auto wrong = [&](const Json& request) { return error_of(cell->ask(request)); };
  EXPECT_EQ(wrong({{"request", "jog"}}), "bad-argument");
  EXPECT_EQ(wrong({{"request", "jog"}, {"joints", {{"joint_9", 1}}}}), "unknown-joint");
  EXPECT_EQ(wrong({{"request", "jog"}, {"joints", {{"joint_1", "20mm"}}}}), "bad-argument");
  EXPECT_EQ(wrong({{"request", "jog"}, {"tcp", {{"z", 0.1}}}, {"frame", "tol"}}), "unknown-frame");
  EXPECT_EQ(wrong({{"request", "jog"}, {"tcp", {{"q", 0.1}}}}), "bad-argument");
  EXPECT_EQ(wrong({{"request", "jog"}, {"tcp", {{"z", 0.1}}}, {"hold", 100}}), "bad-argument");
  EXPECT_EQ(wrong({{"request", "jog"}, {"tcp", {{"z", 0.1}}}, {"robot", "amr"}}), "unknown-robot");
  EXPECT_EQ(wrong({{"request", "profile"}, {"name", "fast"}}), "unknown-profile");
}

TEST_F(JogTest, OneAtATime) {
  start();
  ASSERT_TRUE(jog({{"joints", {{"joint_1", 0.1}}}}).contains("session"));
  EXPECT_EQ(error_of(cell->ask({{"request", "jog"}, {"joints", {{"joint_2", 0.1}}}})), "jogged");
  cell->run(1);
  EXPECT_EQ(error_of(cell->ask({{"request", "jog"}, {"joints", {{"joint_2", 0.1}}}})), "none");
}

/// A robot whose trajectory controller brakes softly when its goal is cancelled.
class SoftlyCancelled : public ::testing::Test {
 protected:
  static constexpr const char* kControllers = R"(
controller_manager:
  ros__parameters:
    update_rate: 1000
    follow: {type: joint_trajectory_controller/JointTrajectoryController}
    joint_state_broadcaster: {type: joint_state_broadcaster/JointStateBroadcaster}
follow:
  ros__parameters:
    joints: [joint_1, joint_2, joint_3, joint_4, joint_5, joint_6]
    command_interfaces: [position]
    state_interfaces: [position, velocity]
    constraints: {decelerate_on_cancel: true, joint_1: {max_deceleration_on_cancel: DECELERATION}}
)";
  /// The robot moves; `deceleration`, rad/s², is how it brakes after cancel().
  void move(const std::string& deceleration) {
    std::string controllers = kControllers;
    controllers.replace(controllers.find("DECELERATION"), 12, deceleration);
    std::string urdf = read_file(test::kSixAxes);
    const std::string plugin = "<plugin>ros2_control_demo_example_7/RobotSystem</plugin>";
    urdf.replace(
        urdf.find(plugin), plugin.size(),
        "<plugin>mock_components/GenericSystem</plugin><param name='calculate_dynamics'>true</param>");
    cell = std::make_unique<LockStepCell>(folder.write("arm.urdf", urdf), controllers);
    cell->run(0.05);
    const Json joints = {"joint_1", "joint_2", "joint_3", "joint_4", "joint_5", "joint_6"};
    const Json point = {{"positions", {1, 0, 0, 0, 0, 0}}, {"time_from_start", 2.0}};
    const Json trajectory = {{"joint_names", joints}, {"points", Json::array({point})}};
    cell->give(Json{{"request", "send"}, {"to", "follow"}, {"goal", true}, {"message", trajectory}});
    cell->run(0.5);
    ASSERT_FALSE(cell->cell().snapshot().standing);
  }
  void cancel() {
    const auto* moves = dynamic_cast<const controllers::JointTrajectoryController*>(
        cell->cell().loop().controllers().find("follow"));
    cell->give(Json{{"request", "goal.cancel"}, {"to", "follow"}, {"goal", moves->status().active.load()}});
    cell->run(0.01);
    ASSERT_EQ(moves->status().active.load(), 0u);
    ASSERT_FALSE(cell->cell().snapshot().standing) << "it brakes";
  }
  Json jog() { return cell->ask({{"request", "jog"}, {"joints", {{"joint_2", 0.1}}}}); }

  Folder folder;
  std::unique_ptr<LockStepCell> cell;
};

TEST_F(SoftlyCancelled, ARobotThatFollowsATrajectoryIsNotJogged) {
  move("5");
  const Nanoseconds asked = cell->cell().now();
  EXPECT_EQ(error_of(jog()), "moving");
  EXPECT_LT(cell->cell().now() - asked, 20'000'000) << "refused at once";
}

TEST_F(SoftlyCancelled, ARobotThatSettlesIsWaitedForAndThenJogged) {
  move("5");
  cancel();
  EXPECT_EQ(cell->cell().jogging().why_not(0), std::nullopt) << "a key can be pressed";
  EXPECT_EQ(error_of(jog()), "none");
  EXPECT_EQ(cell->state_of("jog"), "active");
}

TEST_F(SoftlyCancelled, AKeyThatIsPressedMeanwhileBeginsWhenItStandsAndIsNotLost) {
  move("2.5");  // it brakes longer than a motion lasts without heartbeats
  cancel();
  protocol::JogBegin key;
  key.axis = 1;
  HeldMotions& held = *cell->cell().in().held_motions;
  const std::uint64_t motion = held.begin(key);
  cell->run(0.15);
  EXPECT_TRUE(held.take_events().empty()) << "it still brakes, and nothing is lost before the motion begins";
  cell->run(0.1);
  const std::vector<HeldEvent> events = held.take_events();
  ASSERT_FALSE(events.empty());
  EXPECT_EQ(events.front().what, HeldEvent::What::begun);
  EXPECT_EQ(events.front().motion, motion);
}

TEST_F(SoftlyCancelled, ARobotThatDoesNotComeToRestIsNotJogged) {
  move("0.5");  // it brakes for a second
  cancel();
  const Nanoseconds asked = cell->cell().now();
  EXPECT_EQ(error_of(jog()), "moving");
  EXPECT_GE(cell->cell().now() - asked, 300'000'000);
}

TEST_F(JogTest, TheReducedProfileKeepsTheTcpBelowItsSpeed) {
  start("profile: reduced\nprofiles: {reduced: {tcp_speed: 100mm/s}}\n");
  bend();
  EXPECT_EQ(cell->result({{"request", "profile"}})["profile"], "reduced");
  const auto fastest = [&] {
    Json state = jog({{"tcp", {{"z", 0.5}}}, {"frame", "world"}, {"hold", 5}});
    double out = 0;
    for (int i = 0; i < 40; ++i) {
      cell->run(0.01);
      out = std::max(out, cell->result({{"request", "jog.state"}})["speed"].get<double>());
    }
    jog({{"end", true}});
    cell->run(1);
    return out;
  };
  const double reduced = fastest();
  EXPECT_LE(reduced, 0.1);
  EXPECT_GT(reduced, 0.05);
  cell->result({{"request", "profile"}, {"name", "full"}});
  EXPECT_GT(fastest(), 0.105);
}

TEST_F(JogTest, StopsInTimeBeforeAPlaneAndSaysWhich) {
  start();
  bend();
  const double z = cell->result({{"request", "jog.state"}})["position"][2].get<double>();
  start("workspace:\n  table: {plane: [0, 0, " + std::to_string(z - 0.05) + "], normal: [0, 0, 1]}\n");
  bend();
  const Json state = jog({{"tcp", {{"z", -0.3}}}, {"frame", "world"}, {"by", true}});
  EXPECT_FALSE(state.value("done", true));
  EXPECT_EQ(state["reason"], "workspace table");
  EXPECT_GE(state["position"][2].get<double>(), z - 0.05);
  EXPECT_LT(state["position"][2].get<double>(), z - 0.04);
}

TEST_F(JogTest, HonoursJointRangesOfTheCellFile) {
  start("", ", joint_ranges: {joint_2: [-30deg, 20deg]}");
  const Json state = jog({{"joints", {{"joint_2", 2}}}, {"by", true}});
  EXPECT_FALSE(state.value("done", true));
  EXPECT_EQ(state["reason"], "joint limit joint_2");
  EXPECT_NEAR(joint("joint_2"), 20 * std::numbers::pi / 180, 1e-6);
}

TEST(JogCellFile, WhatIsWrongIsToldWithItsPlace) {
  const Folder folder;
  const auto told = [&](const std::string& more, const std::string& of_robot = "") {
    try {
      const LockStepCell cell(cell_file(folder, more, of_robot));
    } catch (const Error& e) {
      return std::string(e.what());
    }
    return std::string("nothing");
  };
  EXPECT_NE(told("profile: ful\n").find("did you mean 'full'"), std::string::npos);
  EXPECT_NE(told("workspace: {table: {plain: [0, 0, 0]}}\n").find("'table' has none of plane"),
            std::string::npos);
  EXPECT_NE(told("workspace:\n  table: {plane: [0, 0, 0], normal: [0, 0, 0]}\n").find("cell.yaml:5"),
            std::string::npos);
  EXPECT_NE(told("workspace: {box: {inside: [[1, 1, 1], [0, 0, 0]]}}\n").find("without room"),
            std::string::npos);
  EXPECT_NE(told("workspace: {up: {cone: [0, 0, 0], within: 9deg}}\n").find("direction of length zero"),
            std::string::npos);
  EXPECT_NE(told("workspace: {up: {cone: [0, 0, 1], within: 0deg}}\n").find("an angle of 0 degrees"),
            std::string::npos);
  EXPECT_NE(told("workspace: {up: {cone: [0, 0, 1], within: 9deg, axis: w}}\n").find("no axis 'w'"),
            std::string::npos);
  EXPECT_NE(told("workspace: {low: {joint: joint_9, range: [0, 1]}}\n").find("no joint 'joint_9'"),
            std::string::npos);
  EXPECT_NE(told("workspace: {low: {joint: joint_1, range: [1, 0]}}\n").find("is empty: 1 to 0"),
            std::string::npos);
  EXPECT_NE(told("workspace: {up: {cone: [0, 0, 1], within: 9deg, profile: fast}}\n").find("profile 'fast'"),
            std::string::npos);
  EXPECT_NE(
      told("workspace: {up: {plane: [0, 0, 1], normal: [0, 0, 1], beyond: full}}\n").find("beyond: full"),
      std::string::npos);
  EXPECT_NE(told("profiles: {reduced: {while: door}}\n").find("no tag or variable 'door'"),
            std::string::npos);
  EXPECT_NE(told("", ", joint_ranges: {joint_7: [0, 1]}").find("joint_7"), std::string::npos);
  EXPECT_NE(told("", ", joint_ranges: {joint_1: [-9, 1]}").find("wider"), std::string::npos);
  EXPECT_NE(told("profiles: {reduced: {joint_speed: 300%}}\n").find("share"), std::string::npos);
}

}  // namespace
}  // namespace polyarm::cell
