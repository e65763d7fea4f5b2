/// Two arms of one description as two robots: the torso that both have is one body.
#include <gtest/gtest.h>

#include <algorithm>

#include "polyarm/description/branch.hpp"
#include "polyarm/description/urdf.hpp"
#include "polyarm/surroundings/guard_bodies.hpp"
#include "tests/support/two_arms.hpp"
#include "tests/surroundings/gantry.hpp"

namespace polyarm::surroundings {
namespace {

class SharedBodiesTest : public testing::Test {
 protected:
  SharedBodiesTest() {
    scene.floor = false;
    Problems problems;
    left = right = description::read_urdf(polyarm::test::two_arms(), "pair.urdf", problems);
    description::keep_branch(left, "left_hand");
    description::keep_branch(right, "right_hand");
  }
  std::vector<Robot> robots(const Vec3& right_base = {}) {
    bases = {{}, {right_base, {}}};
    std::vector<Robot> out{{"left", &left, nullptr, -1, false, {}},
                           {"right", &right, nullptr, -1, false, {}}};
    find_shared(out, bases);
    return out;
  }
  Moment at(const std::vector<double>& of_left, const std::vector<double>& of_right = {0, 0, 0, 0, 0}) const {
    Moment out = start_of(scene);
    out.robots = {{bases[0], of_left}, {bases[1], of_right}};
    return out;
  }
  std::string contacts(const Moment& moment, const Vec3& right_base = {}) {
    Sweep sweep(robots(right_base), scene, 0);
    sweep.add(moment, 0, [](std::size_t) { return 0; });
    sweep.finish();
    std::string out;
    for (const Approach& a : sweep.approaches()) out += a.first + " " + a.second + ";";
    return out;
  }

  description::RobotModel left, right;
  description::Scene scene;
  std::vector<Pose> bases{{}, {}};
};

const std::vector<double> kZero{0, 0, 0, 0, 0};

TEST_F(SharedBodiesTest, NoArmTouchesTheTorsoOfTheOther) {
  EXPECT_EQ(contacts(at(kZero)), "");
}

TEST_F(SharedBodiesTest, OneArmInTheOtherIsAContactOfTwoRobots) {
  const std::string found = contacts(at({0, -0.38, 0, 0, 0}));
  EXPECT_NE(found.find("left/left_arm right/right_arm;"), std::string::npos) << found;
  EXPECT_EQ(found.find("torso"), std::string::npos) << found;
}

TEST_F(SharedBodiesTest, AnArmInTheTorsoIsAContactWithItsOwn) {
  EXPECT_EQ(contacts(at({-0.2, 0, 0, 0, 0})), "left/torso left/left_arm;left/left_mount left/left_arm;");
}

TEST_F(SharedBodiesTest, AnotherRobotOfTheDescriptionIsNoPartOfThisOne) {
  const Vec3 near{0.2, 0, 0};
  bases[1].position = near;
  const std::string found = contacts(at(kZero), near);
  EXPECT_NE(found.find("left/left_arm right/torso"), std::string::npos) << found;
}

TEST_F(SharedBodiesTest, GuardsFollowEachBodyOnce) {
  GuardBodies bodies(robots(), scene);
  std::size_t between = 0;
  for (const GuardPair& pair : bodies.pairs()) {
    if (pair.own) continue;
    ++between;
    EXPECT_EQ(bodies.name(pair.a).find("torso"), std::string::npos) << bodies.name(pair.b);
    EXPECT_EQ(bodies.name(pair.b).find("torso"), std::string::npos) << bodies.name(pair.a);
    EXPECT_EQ(bodies.name(pair.b).find("mount"), std::string::npos) << bodies.name(pair.a);
  }
  EXPECT_EQ(between, 25u) << "rail, arm, hand, finger and thumb against those of the other";
}

TEST_F(SharedBodiesTest, PlansOfAnArmKeepFromTheOtherArmAndFromTheTorsoAlone) {
  const std::vector<Robot> both = robots();
  Surroundings around(both, scene, at(kZero), 0, 0.005);
  EXPECT_FALSE(around.probe().touches_exactly(kZero)) << around.probe().nearest(kZero).second;
  EXPECT_TRUE(around.probe().touches_exactly(std::vector<double>{0, -0.38, 0, 0, 0}));
  EXPECT_TRUE(around.probe().touches_exactly(std::vector<double>{-0.2, 0, 0, 0, 0})) << "its own torso";
}

TEST_F(SharedBodiesTest, ARobotOnTheTorsoOfOneIsOnThatOfTheOther) {
  Problems problems;
  const description::RobotModel head =
      description::read_urdf(polyarm::test::head_on_torso(), "head.urdf", problems);
  std::vector<Robot> all{{"left", &left, nullptr, -1, false, {}},
                         {"right", &right, nullptr, -1, false, {}},
                         {"head", &head, nullptr, 0, false, {}}};
  bases.push_back({{0, 0, 0.58}, {}});
  find_shared(all, bases);
  Moment now = at(kZero);
  now.robots.push_back({bases[2], {0, 0}});
  Sweep sweep(all, scene, 0);
  sweep.add(now, 0, [](std::size_t) { return 0; });
  sweep.finish();
  for (const Approach& a : sweep.approaches()) ADD_FAILURE() << text_of(a);
  Surroundings around(all, scene, now, 2, 0.005);
  EXPECT_FALSE(around.probe().touches_exactly(std::vector<double>{0, 0}));
}

/// Both are on one base that drives: they stay on one torso.
TEST_F(SharedBodiesTest, BothMayRideOnOneCarrier) {
  description::RobotModel cart;
  cart.links = {{"cart"}};
  std::vector<Robot> all{{"cart", &cart, nullptr, -1, true, {}},
                         {"left", &left, nullptr, 0, true, {}},
                         {"right", &right, nullptr, 0, true, {}}};
  find_shared(all, {{}, {}, {}});
  EXPECT_TRUE(all[1].shares(left.find_link("torso"), 2));
  EXPECT_TRUE(all[2].shares(right.find_link("torso"), 1));
  all[2].on = -1;
  for (Robot& robot : all) robot.shared.clear();
  find_shared(all, {{}, {}, {}});
  EXPECT_FALSE(all[1].shares(left.find_link("torso"), 2)) << "it may drive away";
}

}  // namespace
}  // namespace polyarm::surroundings
