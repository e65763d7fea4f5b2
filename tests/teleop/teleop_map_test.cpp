/// How the pose of a leader becomes a target of its follower.
#include "polyarm/teleop/teleop_map.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "polyarm/catalogue/catalogue.hpp"

namespace polyarm::teleop {
namespace {

using kinematics::Chain;

class TeleopMapTest : public ::testing::Test {
 protected:
  static Chain chain(const std::string& name, const Pose& base = {}) {
    static const description::Catalogue catalogue({std::filesystem::path(POLYARM_SOURCE_DIR) / "robots"});
    const description::RobotModel model = catalogue.load(name);
    return Chain(model, model.tool_link(), base);
  }
  std::vector<double> random_state(const Chain& of) {
    std::vector<double> q;
    for (std::size_t j = 0; j < of.joints(); ++j)
      q.push_back(std::uniform_real_distribution(-1.0, 1.0)(random));
    return q;
  }
  static std::vector<double> values(const jog::JogSetpoint& target, const Chain& of) {
    return {target.joints.begin(), target.joints.begin() + static_cast<std::ptrdiff_t>(of.joints())};
  }
  std::mt19937_64 random{7};
};

TEST_F(TeleopMapTest, TheTargetIsWhereTheFollowerIsWhenTheClutchCloses) {
  const Chain so101 = chain("the_robot_studio/so_101"), ur5e = chain("universal_robots/ur5e");
  PairSettings settings;
  settings.mapping = Mapping::tcp;
  settings.scale = 3;
  settings.turn = from_rpy(0.3, -0.2, 1);
  TeleopMap map(settings, so101, ur5e);
  for (int i = 0; i < 100; ++i) {
    const auto leader = random_state(so101), follower = random_state(ur5e);
    map.engage(leader, follower);
    const Pose target = map.target(leader).target, tcp = ur5e.forward(follower);
    EXPECT_LT(norm(target.position - tcp.position), 1e-12);
    EXPECT_LT(angle_between(target.rotation, tcp.rotation), 1e-7);
  }
}

TEST_F(TeleopMapTest, TheTcpRepeatsTheLeadersWayScaledAndTurned) {
  // The leader's base is turned by 90 degrees in the world, the follower's is not: forward stays forward.
  const Chain leader = chain("universal_robots/ur3", {{1, 2, 0}, from_rpy(0, 0, std::numbers::pi / 2)});
  const Chain follower = chain("universal_robots/ur5e");
  PairSettings settings;
  settings.mapping = Mapping::tcp;
  settings.scale = 2;
  TeleopMap map(settings, leader, follower);
  for (int i = 0; i < 100; ++i) {
    const auto from = random_state(leader), to = random_state(leader), at = random_state(follower);
    map.engage(from, at);
    const jog::JogSetpoint target = map.target(to);
    EXPECT_EQ(target.kind, jog::JogSetpoint::Kind::tcp_target);
    const Pose base = inverse(leader.base());
    const Pose before = base * leader.forward(from), after = base * leader.forward(to),
               tcp = follower.forward(at);
    EXPECT_LT(norm(target.target.position - tcp.position - 2.0 * (after.position - before.position)), 1e-9);
    EXPECT_NEAR(angle_between(target.target.rotation, tcp.rotation),
                angle_between(after.rotation, before.rotation), 1e-6);
    const Quaternion turned = after.rotation * inverse(before.rotation);
    EXPECT_LT(angle_between(target.target.rotation, turned * tcp.rotation), 1e-6);
  }
}

TEST_F(TeleopMapTest, TheOrientationStaysIfTheCellSaysSo) {
  const Chain arm = chain("universal_robots/ur5e");
  PairSettings settings;
  settings.mapping = Mapping::tcp;
  settings.orientation = false;
  TeleopMap map(settings, arm, arm);
  const auto at = random_state(arm);
  map.engage(random_state(arm), at);
  EXPECT_EQ(map.target(random_state(arm)).target.rotation, arm.forward(at).rotation);
}

TEST_F(TeleopMapTest, JointsMatchByNameAndInOrder) {
  const Chain ur5e = chain("universal_robots/ur5e"), ur3 = chain("universal_robots/ur3"),
              irb = chain("abb/irb_120");
  for (const Chain* follower : {&ur3, &irb}) {
    PairSettings settings;
    TeleopMap map(settings, ur5e, *follower);
    const auto leader = random_state(ur5e);
    map.engage(leader, random_state(*follower));
    const auto target = values(map.target(leader), *follower);
    for (std::size_t j = 0; j < target.size(); ++j)
      EXPECT_DOUBLE_EQ(target[j], std::clamp(leader[j], follower->lower()[j], follower->upper()[j]));
  }
}

TEST_F(TeleopMapTest, JointsHaveSignScaleAndOffset) {
  const Chain so101 = chain("the_robot_studio/so_101"), ur5e = chain("universal_robots/ur5e");
  PairSettings settings;
  settings.joints = {{"shoulder_pan", "shoulder_pan_joint", -1, 0.5}, {"elbow_flex", "elbow_joint", 1.5, 0}};
  TeleopMap map(settings, so101, ur5e);
  const auto follower = random_state(ur5e);
  const std::vector<double> leader = {0.2, 0, -0.4, 0, 0};
  map.engage(leader, follower);
  const auto target = values(map.target(leader), ur5e);
  EXPECT_NEAR(target[0], 0.3, 1e-12);
  EXPECT_NEAR(target[2], -0.6, 1e-12);
  EXPECT_EQ(target[1], follower[1]) << "a joint without a leader stays";
  const auto far = map.furthest(leader, follower);
  EXPECT_NEAR(far.much, std::max(std::abs(follower[0] - 0.3), std::abs(follower[2] + 0.6)), 1e-12);
}

TEST_F(TeleopMapTest, RelativeJointsMoveFromWhereTheyAre) {
  const Chain arm = chain("universal_robots/ur5e");
  PairSettings settings;
  settings.relative = true;
  TeleopMap map(settings, arm, arm);
  const auto follower = random_state(arm);
  auto leader = random_state(arm);
  map.engage(leader, follower);
  EXPECT_EQ(values(map.target(leader), arm), follower);
  leader[2] += 0.1;
  EXPECT_NEAR(map.target(leader).joints[2], follower[2] + 0.1, 1e-12);
}

TEST_F(TeleopMapTest, ArmsOfAnotherShapeNeedPairs) {
  const Chain so101 = chain("the_robot_studio/so_101"), ur5e = chain("universal_robots/ur5e");
  PairSettings settings;
  settings.leader = "hand";
  settings.follower = "arm";
  const auto code = [&] {
    try {
      TeleopMap map(settings, so101, ur5e);
    } catch (const Error& e) {
      return e.problems().front().code;
    }
    return std::string("none");
  };
  EXPECT_EQ(code(), "unlike-arms");
  settings.joints = {{"elbow", "elbow_joint", 1, 0}};
  EXPECT_EQ(code(), "unknown-joint");
}

}  // namespace
}  // namespace polyarm::teleop
