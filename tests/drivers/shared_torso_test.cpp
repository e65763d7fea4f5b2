/// Two arms of one description in physics: one torso, two robots.
#include <gtest/gtest.h>

#include "drivers/mujoco/component.hpp"
#include "polyarm/description/branch.hpp"
#include "polyarm/description/urdf.hpp"
#include "tests/drivers/rig.hpp"
#include "tests/support/two_arms.hpp"

namespace polyarm::test {
namespace {

/// Each arm with a cup above a cube on a table; cubes are at y = 0.2 and -0.2.
struct Pair {
  Pair() {
    Problems problems;
    left = right = description::read_urdf(two_arms(), "pair.urdf", problems);
    description::keep_branch(left, "left_hand");
    description::keep_branch(right, "right_hand");
    cup = description::find_tool("suction_cup", "");
    scene.floor_height = -1;
    scene.kinds = {"cube"};
    description::Fixture top;
    top.name = "table";
    top.shapes = {box({0.4, 0.8, 0.04})};
    top.pose.position = {0.5, 0, 0.08};
    scene.fixtures = {top};
    scene.parts = {cube("one", {0.37, 0.2, 0.12}), cube("two", {0.37, -0.2, 0.12})};
  }
  Rig rig(bool with_head = false) {
    hardware::ComponentContext context;
    context.name = "world";
    context.scene = &scene;
    for (const auto& [name, model] : {std::pair{"left", &left}, std::pair{"right", &right}}) {
      hardware::RobotInstance arm;
      arm.name = name;
      arm.model = model;
      arm.tool = &cup;
      arm.number = static_cast<int>(context.robots.size());
      arm.initial_positions.assign(model->actuated.size(), 0);
      context.robots.push_back(arm);
    }
    if (with_head) {
      Problems problems;
      head = description::read_urdf(head_on_torso(), "head.urdf", problems);
      hardware::RobotInstance on_torso;
      on_torso.name = "head";
      on_torso.model = &head;
      on_torso.base.position.z = 0.58;
      on_torso.on = "left";
      on_torso.number = 2;
      on_torso.initial_positions = {0, 0};
      context.robots.push_back(on_torso);
    }
    return Rig(std::make_unique<drivers::MujocoComponent>(), context);
  }
  description::RobotModel left, right, head;
  description::Tool cup;
  description::Scene scene;
};

TEST(SharedTorso, BothArmsPickAndNobodyTouchesTheTorso) {
  Pair pair;
  Rig rig = pair.rig();
  rig.move({{"left/left_z/position", -0.2595}, {"right/right_z/position", -0.2595}}, 1);
  rig.command("left/tool/vacuum") = rig.command("right/tool/vacuum") = 1;
  rig.run(0.3);
  rig.move({{"left/left_z/position", 0}, {"right/right_z/position", 0}}, 1);
  rig.run(0.2);
  EXPECT_EQ(rig.part(0).held_by, 0);
  EXPECT_EQ(rig.part(1).held_by, 1);
  EXPECT_EQ(rig.findings(), "");
  EXPECT_NEAR(rig.state("right/right_z/position"), 0, 1e-3) << "nothing holds it back";
}

TEST(SharedTorso, ARobotOnTheTorsoOfOneIsOnThatOfTheOther) {
  Pair pair;
  Rig rig = pair.rig(true);
  rig.move({{"head/turn/position", 0.5}}, 0.5);
  EXPECT_EQ(rig.findings(), "");
  EXPECT_NEAR(rig.state("head/turn/position"), 0.5, 1e-3);
}

TEST(SharedTorso, ArmsThatMeetAreAContact) {
  Pair pair;
  Rig rig = pair.rig();
  rig.move({{"left/left_y/position", -0.37}}, 1);
  EXPECT_NE(rig.findings().find("left/tool touches right/tool"), std::string::npos) << rig.findings();
  EXPECT_EQ(rig.findings().find("torso"), std::string::npos) << rig.findings();
}

TEST(SharedTorso, AnArmThatMeetsTheTorsoIsOneContact) {
  Pair pair;
  Rig rig = pair.rig();
  rig.move({{"right/right_x/position", -0.1}}, 1);
  EXPECT_NE(rig.findings().find("right/torso"), std::string::npos) << rig.findings();
  EXPECT_EQ(rig.findings().find("left/torso"), std::string::npos) << rig.findings();
}

}  // namespace
}  // namespace polyarm::test
