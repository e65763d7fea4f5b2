/// Robots that lead others, in whole cells in lock-step.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "polyarm/setup/cell_file.hpp"
#include "tests/support/lock_step_cell.hpp"

namespace polyarm::cell {
namespace {

using test::Folder;
using test::Json;
using test::LockStepCell;

/// Two arms of examples/r6bot. The leader is moved by sending commands to its forward controller.
class TeleoperationTest : public ::testing::Test {
 protected:
  void build(const std::string& pair, const std::string& more = "") {
    const std::string r6bot = "{model: " + test::kSixAxes + ", hardware: mock";
    folder.write("signals.yaml", "polyarm: signals/1\ntags:\n  Pedal: {initial: " +
                                     std::string(pedal_at_start ? "true" : "false") +
                                     "}\n  Grip: {initial: false}\n");
    folder.write("controllers.yaml", R"(
controller_manager:
  ros__parameters:
    hand: {type: forward_command_controller/ForwardCommandController}
hand:
  ros__parameters:
    joints: [leader/joint_1, leader/joint_2, leader/joint_3, leader/joint_4, leader/joint_5, leader/joint_6]
    interface_name: position
)");
    folder.write("cell.yaml",
                 "polyarm: cell/1\nrate: 500\nsignals: signals.yaml\ncontrollers: controllers.yaml\n"
                 "robots:\n  leader: " +
                     r6bot + of_leader + "}\n  arm: " + r6bot + ", at: [0, 3, 0]" + more +
                     "}\nteleop:\n  pair: {leader: leader, follower: arm, " + pair + "}\n");
    cell = std::make_unique<LockStepCell>(read_cell_file(folder.path()));
    cell->run(0.05);
  }
  void pedal(bool held) {
    cell->ask({{"request", "tags.set"}, {"name", "Pedal"}, {"value", held}});
    cell->run(0.02);
  }
  /// Moves the leader's hand to these joint values within `duration` s.
  void lead(const std::vector<double>& to, double duration) {
    std::vector<double> from(6);
    for (std::size_t j = 0; j < 6; ++j) from[j] = state("leader", j);
    const int steps = std::max(1, static_cast<int>(duration / 0.01));
    for (int k = 1; k <= steps; ++k) {
      Json data = Json::array();
      for (std::size_t j = 0; j < 6; ++j) data.push_back(from[j] + (to[j] - from[j]) * k / steps);
      cell->give(Json{{"request", "send"}, {"to", "hand"}, {"message", {{"data", data}}}});
      cell->run(0.01);
    }
  }
  double state(const std::string& robot, std::size_t joint) {
    const auto index =
        cell->cell().loop().table().find_state(robot + "/joint_" + std::to_string(joint + 1) + "/position");
    return cell->cell().snapshot().states[*index];
  }
  std::vector<double> joints(const std::string& robot) {
    std::vector<double> out;
    for (std::size_t j = 0; j < 6; ++j) out.push_back(state(robot, j));
    return out;
  }
  Json pair() { return cell->result({{"request", "teleop"}})["pairs"][0]; }
  std::string phase() { return pair()["state"]; }
  static double most(const std::vector<double>& a, const std::vector<double>& b) {
    double out = 0;
    for (std::size_t j = 0; j < a.size(); ++j) out = std::max(out, std::abs(a[j] - b[j]));
    return out;
  }
  const std::vector<double> bent = {0.3, 0.3, -0.4, 0.2, 0.3, -0.2};
  bool pedal_at_start = false;
  std::string of_leader;
  Folder folder;
  std::unique_ptr<LockStepCell> cell;
};

TEST_F(TeleoperationTest, TheFollowerMovesOnlyWhileTheClutchIsHeld) {
  build("clutch: {tag: Pedal}, match: relative");
  const auto begin = joints("arm");
  lead(bent, 0.5);
  EXPECT_EQ(joints("arm"), begin) << "without the clutch nothing moves";
  EXPECT_EQ(phase(), "waiting");
  pedal(true);
  cell->run(0.2);
  EXPECT_EQ(phase(), "following");
  EXPECT_LT(most(joints("arm"), begin), 1e-6) << "engaging does not move";
  auto further = bent;
  for (double& q : further) q += 0.2;
  lead(further, 1);
  cell->run(0.5);
  for (std::size_t j = 0; j < 6; ++j) EXPECT_NEAR(state("arm", j), begin[j] + 0.2, 2e-3);
  pedal(false);
  cell->run(0.5);
  const auto end = joints("arm");
  lead(bent, 0.5);
  cell->run(0.5);
  EXPECT_LT(most(joints("arm"), end), 1e-6);
  EXPECT_EQ(phase(), "waiting");
}

TEST_F(TeleoperationTest, JointsApproachSlowlyAndSaySo) {
  build("clutch: {tag: Pedal}");
  lead(bent, 0.5);
  pedal(true);
  cell->run(0.1);
  const Json now = pair();
  EXPECT_EQ(now["state"], "approaching");
  EXPECT_GT(now["distance"].get<double>(), 0.1);
  EXPECT_EQ(cell->told("approaches the pose of 'leader' slowly"), 1);
  auto before = joints("arm");
  double fastest = 0;
  for (int i = 0; i < 5000 && phase() == "approaching"; ++i) {
    const auto at = joints("arm");
    fastest = std::max(fastest, most(at, before) / seconds(Cell::kTick));
    before = at;
    cell->tick();
  }
  EXPECT_EQ(phase(), "following");
  double limit = 0;
  for (const auto& joint : cell->cell().robots()[1]->joints) limit = std::max(limit, joint.velocity);
  EXPECT_LT(fastest, 0.11 * limit);
  cell->run(1);
  EXPECT_LT(most(joints("arm"), joints("leader")), 2e-3);
}

TEST_F(TeleoperationTest, TheTcpFollowsScaled) {
  build("clutch: {tag: Pedal}, mapping: tcp, scale: 0.5");
  lead(bent, 0.5);
  cell->result({{"request", "jog"},
                {"robot", "arm"},
                {"by", true},
                {"joints", {{"joint_2", 0.5}, {"joint_3", 1.0}, {"joint_5", 0.8}}}});
  cell->run(0.6);
  const Vec3 from = cell->cell().tcp(0).position, at = cell->cell().tcp(1).position;
  pedal(true);
  auto to = bent;
  to[0] += 0.15;
  to[2] += 0.1;
  lead(to, 1);
  cell->run(1);
  EXPECT_EQ(phase(), "following");
  const Vec3 way = cell->cell().tcp(0).position - from, followed = cell->cell().tcp(1).position - at;
  EXPECT_GT(norm(way), 0.03);
  EXPECT_LT(norm(followed - 0.5 * way), 2e-3);
}

TEST_F(TeleoperationTest, AClutchThatIsHeldWhenTheCellStartsMovesNothing) {
  pedal_at_start = true;
  build("clutch: {tag: Pedal}");
  const auto begin = joints("arm");
  lead(bent, 0.3);
  EXPECT_EQ(phase(), "blocked");
  EXPECT_EQ(joints("arm"), begin);
  pedal(false);
  pedal(true);
  cell->run(0.1);
  EXPECT_EQ(phase(), "approaching");
}

/// A fault of the leader's hardware alone: the follower stops by itself and stays.
TEST_F(TeleoperationTest, ALeaderThatIsLostStopsTheFollowerOnly) {
  for (const char* fault : {"nan@600:joint_2", "read_error@600", "deactivate@600", "jump@600:joint_2=1"}) {
    of_leader = std::string(", on_fault: group, parameters: {inject: '") + fault + "'}";
    build("clutch: {tag: Pedal}, match: relative");
    pedal(true);
    std::string seen;
    for (int k = 1; k <= 20; ++k) {  // the fault comes after 1.2 s
      lead(std::vector<double>(6, 0.02 * k), 0.1);
      seen += phase() + " ";
    }
    EXPECT_NE(seen.find("following"), std::string::npos) << fault << ": " << seen;
    EXPECT_EQ(phase(), "blocked") << fault << ": " << seen;
    EXPECT_FALSE(pair()["reason"].get<std::string>().empty());
    const auto stands = joints("arm");
    EXPECT_GT(stands[0], 0.05) << fault;
    cell->run(0.5);
    EXPECT_LT(most(joints("arm"), stands), 1e-6) << fault;
    EXPECT_EQ(cell->result({{"request", "jog.state"}, {"robot", "arm"}})["moving"], false);
  }
}

TEST_F(TeleoperationTest, AStopEndsTheMotionUntilTheClutchIsHeldAgain) {
  build("clutch: {tag: Pedal}, match: relative");
  pedal(true);
  cell->run(0.2);
  ASSERT_EQ(phase(), "following");
  cell->ask({{"request", "control.hold"}});
  cell->run(0.5);
  EXPECT_EQ(phase(), "blocked");
  const auto stands = joints("arm");
  lead(bent, 0.5);
  EXPECT_LT(most(joints("arm"), stands), 1e-6);
}

TEST_F(TeleoperationTest, AKeyIsHeldOnlyAsLongAsItIsRenewed) {
  build("match: relative");
  const auto hold = [&] { cell->ask({{"request", "teleop"}, {"hold", 0.1}}); };
  for (int i = 0; i < 10; ++i) {
    hold();
    cell->run(0.05);
  }
  EXPECT_EQ(phase(), "following");
  cell->run(0.3);
  EXPECT_EQ(phase(), "waiting");
  hold();
  cell->run(0.02);
  cell->ask({{"request", "teleop"}, {"hold", 0}});
  cell->run(0.02);
  EXPECT_EQ(phase(), "waiting");
  EXPECT_EQ(cell->ask({{"request", "teleop"}, {"hold", 5}})["error"]["code"], "bad-argument");
  EXPECT_EQ(cell->ask({{"request", "teleop"}, {"pair", "pear"}})["error"]["code"], "unknown-pair");
}

TEST_F(TeleoperationTest, TheHandIsAClutchAndDrivesTheGripper) {
  build(
      "clutch: {joint: joint_6, closed: 0.5, open: -0.5}, match: relative, "
      "gripper: {joint: joint_5, closed: 0, open: 0.4, tag: Grip}");
  auto hand = bent;
  hand[5] = -0.4;
  lead(hand, 0.3);
  EXPECT_EQ(phase(), "waiting");
  hand[5] = 0.45;
  hand[4] = 0.3;
  lead(hand, 0.5);
  cell->run(0.3);
  EXPECT_EQ(phase(), "following");
  const auto grip = [&] {
    return cell->result({{"request", "tags.list"}, {"names", {"Grip"}}})["tags"][0]["value"].get<bool>();
  };
  EXPECT_FALSE(grip());
  hand[4] = 0.05;
  lead(hand, 0.3);
  EXPECT_TRUE(grip());
  hand[5] = -0.4;
  lead(hand, 0.5);
  EXPECT_EQ(phase(), "waiting");
  EXPECT_EQ(cell->ask({{"request", "teleop"}, {"hold", 0.1}})["error"]["code"], "other-clutch");
}

TEST_F(TeleoperationTest, TheSameHandGivesTheSameMotion) {
  std::vector<double> first;
  for (int run = 0; run < 2; ++run) {
    build("clutch: {tag: Pedal}, mapping: tcp");
    lead(bent, 0.5);
    pedal(true);
    lead({0.4, 0.35, -0.3, 0.2, 0.4, -0.1}, 0.7);
    if (run == 0)
      first = joints("arm");
    else
      EXPECT_EQ(joints("arm"), first);
  }
}

TEST(TeleopEntriesTest, EveryMistakeHasItsPlace) {
  Folder folder;
  const std::string cell = "polyarm: cell/1\nrobots:\n  a: {model: x}\n  b: {model: x}\nteleop:\n";
  const auto codes = [&](const std::string& pairs) {
    std::vector<std::string> out;
    try {
      folder.write("cell.yaml", cell + pairs);
      read_cell_file(folder.path());
    } catch (const Error& e) {
      for (const Problem& problem : e.problems()) {
        out.push_back(problem.code);
        EXPECT_GE(problem.where.line, 5) << problem.text();
      }
    }
    return out;
  };
  using Codes = std::vector<std::string>;
  EXPECT_EQ(codes("  p: {leader: a, follower: b}\n"), Codes{});
  EXPECT_EQ(codes("  p: {leader: a, follower: c}\n"), Codes{"unknown-robot"});
  EXPECT_EQ(codes("  p: {leader: a}\n"), Codes{"missing-key"});
  EXPECT_EQ(codes("  p: {leader: a, follower: a}\n"), Codes{"bad-value"});
  EXPECT_EQ(codes("  p: {leader: a, follower: b, mapping: pose}\n"), Codes{"bad-value"});
  EXPECT_EQ(codes("  p: {leader: a, follower: b, scale: 2}\n"), Codes{"bad-value"});
  EXPECT_EQ(codes("  p: {leader: a, follower: b, mapping: tcp, scale: -2}\n"), Codes{"bad-value"});
  EXPECT_EQ(codes("  p: {leader: a, follower: b, mapping: tcp, match: relative}\n"), Codes{"bad-value"});
  EXPECT_EQ(codes("  p: {leader: a, follower: b, clutch: {tag: T, joint: j}}\n"), Codes{"bad-value"});
  EXPECT_EQ(codes("  p: {leader: a, follower: b, clutch: {joint: j, closed: 1, open: 1}}\n"),
            Codes{"bad-value"});
  EXPECT_EQ(codes("  p: {leader: a, follower: b, joints: {x: {joint: y, scale: 0}}}\n"), Codes{"bad-value"});
  EXPECT_EQ(codes("  p: {leader: a, follower: b, speed: 0}\n"), Codes{"bad-value"});
  EXPECT_EQ(codes("  p: {leader: a, follower: b, color: red}\n"), Codes{"unknown-key"});
  EXPECT_EQ(codes("  p: {leader: a, follower: b}\n  r: {leader: a, follower: b}\n"), Codes{"bad-value"});
}

}  // namespace
}  // namespace polyarm::cell
