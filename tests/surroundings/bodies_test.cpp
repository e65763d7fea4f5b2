/// What is around a robot: other robots, held parts, movers, and what may touch what.
#include "polyarm/surroundings/bodies.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/description/tools.hpp"
#include "polyarm/kinematics/chain.hpp"
#include "polyarm/surroundings/sweep.hpp"
#include "tests/surroundings/gantry.hpp"

namespace polyarm::surroundings {
namespace {

TEST(Surroundings, AHeldPartIsTheRobotsAndLiesInNobodysWay) {
  const description::RobotModel model = gantry();
  description::Scene scene;
  scene.floor = false;
  description::Part part;
  part.name = "rod";
  part.shape = box(0.02, 0.02, 0.4);
  scene.parts = {part};
  scene.fixtures = {fixture("table", {1, 1, 0.1}, {0, 0, -0.05})};
  Moment moment = at(0, 0, 0.5);
  moment.parts = {{{{0, 0, 0.28}, {}}, true, 0}};  // from 20 mm below the ball down to z = 0.08
  Surroundings holds({{"", &model, nullptr, -1, false, {}}}, scene, moment, 0, 0);
  const std::vector<double> low{0, 0, 0.41}, high{0, 0, 0.43};
  EXPECT_TRUE(holds.probe().touches_exactly(low)) << "the rod would be at z = -0.01";
  EXPECT_FALSE(holds.probe().touches_exactly(high));
  EXPECT_EQ(holds.probe().nearest(high).first, "part rod");

  moment.parts[0].held_by = -1;
  Surroundings empty({{"", &model, nullptr, -1, false, {}}}, scene, moment, 0, 0);
  EXPECT_FALSE(empty.probe().touches_exactly(std::vector<double>{0.2, 0, 0.1}));
  EXPECT_TRUE(empty.probe().touches_exactly(std::vector<double>{0, 0, 0.3})) << "it is in the way now";
}

TEST(Surroundings, OtherRobotsAndMoversAreWhereTheyAre) {
  const description::RobotModel model = gantry();
  description::Scene scene;
  scene.floor = false;
  scene.movers = {{"door", {0, 0, 2}, 0, 1, 0.5, 0.5}};
  scene.fixtures = {fixture("leaf", {0.1, 0.1, 0.1}, {1, 0, 0})};
  scene.fixtures[0].mover = "door";
  Moment moment;
  moment.robots = {{{}, {0, 0, 0}}, {{{0, 1, 0}, {}}, {0.3, 0, 0}}};
  moment.movers = {0.4};
  const std::vector<Robot> robots{{"one", &model, nullptr, -1, false, {}},
                                  {"two", &model, nullptr, -1, false, {}}};
  Surroundings around(robots, scene, moment, 0, 0);
  EXPECT_TRUE(around.probe().touches_exactly(std::vector<double>{0.3, 1, 0}));
  EXPECT_EQ(around.probe().nearest(std::vector<double>{0.3, 0.9, 0}).second, "two/ball");
  EXPECT_TRUE(around.probe().touches_exactly(std::vector<double>{1, 0, 0.4}));
  EXPECT_FALSE(around.probe().touches_exactly(std::vector<double>{1, 0, 0}));
}

TEST(Surroundings, TheToolIsPartOfTheArmAndTheArmStandsOnTheTable) {
  const description::Catalogue catalogue({std::string(POLYARM_SOURCE_DIR) + "/robots"});
  const description::RobotModel model = catalogue.load("universal_robots/ur3");
  const description::Tool tool = description::find_tool("parallel_gripper", "");
  const Robot arm{"arm", &model, &tool, -1, false, {}};
  const auto body = robot_body(arm);
  std::vector<std::string> attached;
  for (const collision::LinkBody& link : body->links())
    if (link.attached) attached.push_back(link.name);
  EXPECT_EQ(attached, (std::vector<std::string>{"tool", "fingers"}));
  description::Scene scene;
  scene.floor = false;
  scene.fixtures = {fixture("table", {1, 1, 0.04}, {0, 0, -0.02})};
  Moment moment;
  moment.robots = {{{}, model.start()}};
  Surroundings around({arm}, scene, moment, 0, 0);
  EXPECT_FALSE(around.probe().touches_exactly(model.start())) << around.probe().nearest(model.start()).first;
}

description::Shape upright(double radius, double length, double bottom) {
  description::Shape out;
  out.kind = description::ShapeKind::cylinder;
  out.radius = radius;
  out.length = length;
  out.pose.position.z = bottom + length / 2;
  return out;
}

/// Capsules that reach beyond the flange would make every tool a contact.
TEST(Surroundings, EveryRobotOfTheCatalogueIsFreeOfAToolAtItsFlangeAtHome) {
  const description::Catalogue catalogue({POLYARM_SOURCE_DIR "/robots"});
  description::Scene nothing;
  nothing.floor = false;
  description::Tool plain;  // as wide and long as a tool of this robot's size may be
  plain.name = "plain";
  const description::Tool cup = description::find_tool("suction_cup", ""),
                          gripper = description::find_tool("parallel_gripper", "");
  for (const std::string& name : catalogue.names()) {
    Problems warnings;
    const description::RobotModel model = description::load_robot(name, catalogue, warnings);
    const kinematics::Chain chain(model, model.tool_link());
    const double length = std::clamp(0.2 * chain.reach(), 0.05, 0.3);
    plain.body = {upright(std::min(0.25 * length, 0.04), 0.2 * length, 0),
                  upright(0.12 * length, 0.8 * length, 0.2 * length)};
    for (const description::Tool* tool : std::initializer_list<const description::Tool*>{&plain, &cup, &gripper}) {
      Sweep sweep({{"arm", &model, tool, -1, false, {}}}, nothing, 0);
      Moment home = start_of(nothing);
      home.robots.push_back({{}, model.start()});
      sweep.add(home, 0, [](std::size_t) { return 0; });
      sweep.finish();
      for (const Approach& a : sweep.approaches())
        ADD_FAILURE() << name << " with " << tool->name << ": " << text_of(a);
    }
  }
}

}  // namespace
}  // namespace polyarm::surroundings
