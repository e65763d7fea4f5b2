#include "drivers/mock/mock.hpp"

#include <limits>
#include <random>

#include "tests/drivers/rig.hpp"
#include "tests/support/realtime_guard.hpp"

namespace polyarm::test::mock_test {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();

description::InterfaceInfo interface(const std::string& name, std::optional<double> initial = {}) {
  description::InterfaceInfo out;
  out.name = name;
  out.initial_value = initial;
  return out;
}

/// The two-link arm as a <ros2_control> block declares it: all three motions of the shoulder, position of the
/// elbow.
description::HardwareInfo declared() {
  description::HardwareInfo out;
  out.name = "system";
  description::ComponentInfo shoulder{"shoulder", "joint"};
  for (const char* name : {"position", "velocity", "acceleration"}) {
    shoulder.command_interfaces.push_back(interface(name));
    shoulder.state_interfaces.push_back(interface(name));
  }
  description::ComponentInfo elbow{"elbow", "joint"};
  elbow.command_interfaces = {interface("position")};
  elbow.state_interfaces = {interface("position", 0.7)};
  description::ComponentInfo force{"wrist_force", "sensor"};
  force.state_interfaces = {interface("fx"), interface("fy", 2.5)};
  description::ComponentInfo lamp{"lamp", "gpio"};
  lamp.command_interfaces = {interface("light")};
  lamp.state_interfaces = {interface("light"), interface("current")};
  out.components = {shoulder, elbow, force, lamp};
  return out;
}

Rig mock(const Stage& stage, std::map<std::string, std::string> parameters = {}, bool with_block = false) {
  hardware::ComponentContext context = stage.context();
  context.parameters = std::move(parameters);
  if (with_block) context.robots[0].hardware = {declared()};
  return Rig(std::make_unique<drivers::MockComponent>(), context);
}

Stage arm() {
  Stage out;
  out.model = two_links();
  out.start = {0.1, 0.2};
  return out;
}

const std::map<std::string, std::string> kDynamics = {{"calculate_dynamics", "true"}};

TEST(Mock, SaysThatEffortsMoveNothing) {
  const Stage stage = arm();
  hardware::ComponentContext context = stage.context();
  context.robots[0].hardware = {declared()};
  drivers::MockComponent plain, pushed;
  ASSERT_EQ(plain.on_init(context), hardware::CallbackReturn::success);
  EXPECT_EQ(plain.summary().find("efforts"), std::string::npos) << plain.summary();
  context.robots[0].hardware[0].components[1].command_interfaces.push_back(interface("effort"));
  ASSERT_EQ(pushed.on_init(context), hardware::CallbackReturn::success);
  EXPECT_NE(pushed.summary().find("efforts move nothing here"), std::string::npos) << pushed.summary();
  EXPECT_NE(pushed.summary().find("elbow"), std::string::npos) << pushed.summary();
  EXPECT_NE(pushed.summary().find("--hardware mujoco"), std::string::npos) << pushed.summary();
}

TEST(Mock, SaysThatVelocitiesAloneMoveNothing) {
  const Stage stage = arm();
  hardware::ComponentContext context = stage.context();
  context.robots[0].hardware = {declared()};
  context.robots[0].hardware[0].components[1].command_interfaces = {interface("velocity")};
  drivers::MockComponent still, moving;
  ASSERT_EQ(still.on_init(context), hardware::CallbackReturn::success);
  EXPECT_NE(still.summary().find("velocities move nothing here"), std::string::npos) << still.summary();
  EXPECT_NE(still.summary().find("elbow"), std::string::npos) << still.summary();
  EXPECT_EQ(still.summary().find("shoulder"), std::string::npos) << still.summary();
  context.parameters = kDynamics;
  ASSERT_EQ(moving.on_init(context), hardware::CallbackReturn::success);
  EXPECT_EQ(moving.summary().find("velocities"), std::string::npos) << moving.summary();
}

TEST(Mock, StartsWhereItIsToldTo) {
  const Stage stage = arm();
  const Rig rig = mock(stage);
  EXPECT_EQ(rig.state("arm/shoulder/position"), 0.1);
  EXPECT_EQ(rig.state("arm/elbow/position"), 0.2);
  EXPECT_EQ(rig.state("arm/elbow/velocity"), 0);
}

TEST(Mock, PositionFollowsTheCommandAndVelocityIsItsDifferenceQuotient) {
  const Stage stage = arm();
  Rig rig = mock(stage);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> draw(-1, 1);
  double before = rig.state("arm/shoulder/position");
  for (int k = 0; k < 100; ++k) {
    const double wanted = rig.command("arm/shoulder/position") = draw(random);
    rig.cycle();
    EXPECT_EQ(rig.state("arm/shoulder/position"), wanted);
    EXPECT_NEAR(rig.state("arm/shoulder/velocity"), (wanted - before) / 1e-3, 1e-9);
    before = wanted;
  }
  EXPECT_EQ(rig.state("arm/elbow/position"), 0.2) << "was never commanded";
}

TEST(Mock, NotANumberIsNoCommand) {
  const Stage stage = arm();
  Rig rig = mock(stage);
  rig.command("arm/shoulder/position") = 0.5;
  rig.cycle();
  rig.command("arm/shoulder/position") = kNothing;
  EXPECT_EQ(rig.cycle(), hardware::ReturnType::ok);
  EXPECT_EQ(rig.state("arm/shoulder/position"), 0.5);
}

TEST(Mock, AnInfiniteCommandIsAnError) {
  const Stage stage = arm();
  Rig rig = mock(stage);
  rig.command("arm/shoulder/position") = -kInfinity;
  EXPECT_EQ(rig.cycle(), hardware::ReturnType::error);
}

TEST(Mock, DeclaredInterfacesAreAllThereIsAndTakeTheirInitialValues) {
  const Stage stage = arm();
  const Rig rig = mock(stage, {}, true);
  EXPECT_EQ(rig.state("arm/elbow/position"), 0.7);
  EXPECT_FALSE(rig.has_state("arm/elbow/velocity"));
  EXPECT_EQ(rig.state("arm/wrist_force/fy"), 2.5);
  EXPECT_FALSE(rig.has_command("arm/wrist_force/fy"));
  EXPECT_TRUE(rig.has_command("arm/lamp/light"));
}

TEST(Mock, WithoutDynamicsAVelocityCommandMovesNothing) {
  const Stage stage = arm();
  Rig rig = mock(stage, {}, true);
  rig.command("arm/shoulder/velocity") = 2;
  rig.run(0.01);
  EXPECT_EQ(rig.state("arm/shoulder/velocity"), 2);
  EXPECT_EQ(rig.state("arm/shoulder/position"), 0.1);
}

TEST(Mock, DynamicsIntegrateAVelocity) {
  const Stage stage = arm();
  Rig rig = mock(stage, kDynamics, true);
  rig.command("arm/shoulder/velocity") = 2;
  rig.cycle();
  EXPECT_NEAR(rig.state("arm/shoulder/position"), 0.1 + 2e-3, 1e-12);
  EXPECT_NEAR(rig.state("arm/shoulder/acceleration"), 2000, 1e-6);
  rig.cycle();
  EXPECT_NEAR(rig.state("arm/shoulder/position"), 0.1 + 4e-3, 1e-12);
  EXPECT_EQ(rig.state("arm/shoulder/acceleration"), 0);
}

TEST(Mock, DynamicsIntegrateAnAccelerationWithTheNewVelocity) {
  const Stage stage = arm();
  Rig rig = mock(stage, kDynamics, true);
  rig.command("arm/shoulder/acceleration") = 10;
  double x = 0.1, v = 0;
  for (int k = 0; k < 50; ++k) {
    rig.cycle();
    v += 10 * 1e-3;
    x += v * 1e-3;
    EXPECT_NEAR(rig.state("arm/shoulder/velocity"), v, 1e-12);
    EXPECT_NEAR(rig.state("arm/shoulder/position"), x, 1e-12);
  }
}

TEST(Mock, AStateWithoutACommandKeepsItsInitialValue) {
  const Stage stage = arm();
  hardware::ComponentContext context = stage.context();
  context.robots[0].hardware = {declared()};
  context.robots[0].hardware[0].components[1].state_interfaces.push_back(interface("effort", 3.5));
  Rig rig(std::make_unique<drivers::MockComponent>(), context);
  rig.run(0.01);
  EXPECT_EQ(rig.state("arm/elbow/effort"), 3.5);
  EXPECT_EQ(rig.state("arm/elbow/position"), 0.7);
  EXPECT_EQ(rig.state("arm/wrist_force/fy"), 2.5);
}

TEST(Mock, AMimicJointFollowsWithItsFactorAndOffset) {
  Stage stage = arm();
  stage.model.joints[static_cast<std::size_t>(stage.model.find_joint("elbow"))].mimic =
      description::Mimic{stage.model.find_joint("shoulder"), -2, 0.1};
  hardware::ComponentContext context = stage.context();
  context.parameters = kDynamics;
  context.robots[0].hardware = {declared()};
  auto& elbow = context.robots[0].hardware[0].components[1];
  elbow.command_interfaces.clear();
  elbow.state_interfaces = {interface("position"), interface("velocity")};
  Rig rig(std::make_unique<drivers::MockComponent>(), context);
  rig.command("arm/shoulder/velocity") = 0.5;
  for (int k = 0; k < 50; ++k) {
    rig.cycle();
    EXPECT_DOUBLE_EQ(rig.state("arm/elbow/position"), -2 * rig.state("arm/shoulder/position") + 0.1);
    EXPECT_DOUBLE_EQ(rig.state("arm/elbow/velocity"), -1);
  }
  EXPECT_FALSE(rig.has_command("arm/elbow/position"));
}

TEST(Mock, AnInterfaceThatStopsNoLongerLeads) {
  const Stage stage = arm();
  Rig rig = mock(stage, kDynamics, true);
  rig.command("arm/shoulder/position") = 0.3;
  rig.cycle();
  rig.switch_mode({"arm/shoulder/velocity"}, {"arm/shoulder/position"});
  rig.command("arm/shoulder/velocity") = 1;  // and the old position command still stands there
  rig.run(0.1);
  EXPECT_NEAR(rig.state("arm/shoulder/position"), 0.4, 1e-9);
}

TEST(Mock, OneJointTakesOneModeAtATime) {
  const Stage stage = arm();
  Rig rig = mock(stage, kDynamics, true);
  const std::vector<std::string> both = {"arm/shoulder/position", "arm/shoulder/velocity"};
  EXPECT_EQ(rig.component().prepare_command_mode_switch(both, {}), hardware::ReturnType::error);
  const std::vector<std::string> apart = {"arm/shoulder/velocity", "arm/elbow/position"};
  EXPECT_EQ(rig.component().prepare_command_mode_switch(apart, {}), hardware::ReturnType::ok);
}

TEST(Mock, TheFollowingOffsetIsAddedToThePosition) {
  const Stage stage = arm();
  Rig rig = mock(stage, {{"position_state_following_offset", "-0.25"}}, true);
  rig.command("arm/shoulder/position") = 1;
  rig.cycle();
  EXPECT_EQ(rig.state("arm/shoulder/position"), 0.75);
}

TEST(Mock, TheOffsetGoesToACustomInterfaceWhereOneIsNamed) {
  const Stage stage = arm();
  hardware::ComponentContext context = stage.context();
  context.parameters = {{"position_state_following_offset", "0.5"},
                        {"custom_interface_with_following_offset", "actual_position"}};
  context.robots[0].hardware = {declared()};
  context.robots[0].hardware[0].components[0].state_interfaces.push_back(interface("actual_position"));
  Rig rig(std::make_unique<drivers::MockComponent>(), context);
  rig.command("arm/shoulder/position") = 1;
  rig.cycle();
  EXPECT_EQ(rig.state("arm/shoulder/position"), 1);
  EXPECT_EQ(rig.state("arm/shoulder/actual_position"), 1.5);
}

TEST(Mock, DisabledCommandsMoveNothing) {
  const Stage stage = arm();
  Rig rig = mock(stage, {{"disable_commands", "True"}}, true);
  rig.command("arm/shoulder/position") = 1;
  rig.command("arm/lamp/light") = 1;
  rig.cycle();
  EXPECT_EQ(rig.state("arm/shoulder/position"), 0.1);
  EXPECT_TRUE(std::isnan(rig.state("arm/lamp/light")));
}

TEST(Mock, SensorsAndLampsAreMirroredWhereAskedFor) {
  const Stage stage = arm();
  Rig rig = mock(stage, {{"mock_sensor_commands", "true"}, {"mock_gpio_commands", "true"}}, true);
  rig.command("arm/wrist_force/fy") = 9;
  rig.command("arm/lamp/light") = 1;
  rig.command("arm/lamp/current") = 0.2;
  rig.cycle();
  EXPECT_EQ(rig.state("arm/wrist_force/fy"), 9);
  EXPECT_EQ(rig.state("arm/lamp/light"), 1);
  EXPECT_EQ(rig.state("arm/lamp/current"), 0.2);
}

TEST(Mock, WhatHasNoJointsSaysNothingOfMotion) {
  const Stage stage = arm();
  hardware::ComponentContext context = stage.context();
  context.robots[0].hardware = {declared()};
  drivers::MockComponent whole, rest;
  ASSERT_EQ(whole.on_init(context), hardware::CallbackReturn::success);
  std::erase_if(context.robots[0].hardware[0].components, [](const auto& c) { return c.kind == "joint"; });
  ASSERT_EQ(rest.on_init(context), hardware::CallbackReturn::success);
  EXPECT_NE(whole.summary().find("states follow commands at once"), std::string::npos);
  EXPECT_NE(rest.summary().find("inputs, outputs and sensors"), std::string::npos);
}

TEST(Mock, AParameterThatIsNoNumberIsRefusedByName) {
  const Stage stage = arm();
  hardware::ComponentContext context = stage.context();
  context.parameters = {{"position_state_following_offset", "far"}};
  drivers::MockComponent component;
  try {
    component.on_init(context);
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("position_state_following_offset"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("far"), std::string::npos);
  }
}

TEST(Mock, ThePartFollowsTheToolAndStaysWhereItIsLetGo) {
  Stage stage;
  stage.model = gantry();
  stage.tool = description::find_tool("suction_cup", "");
  stage.scene = table();
  stage.scene.parts = {cube("cube", {0, 0, 0.02})};
  Rig rig = mock(stage);
  rig.move({{"arm/z/position", -0.36}}, 0.2);
  EXPECT_EQ(rig.state("arm/tool/part_present"), 0);
  rig.command("arm/tool/vacuum") = 1;
  rig.run(0.05);
  EXPECT_EQ(rig.state("arm/tool/part_present"), 0) << "a vacuum takes its time";
  rig.run(0.1);
  EXPECT_EQ(rig.state("arm/tool/part_present"), 1);
  EXPECT_EQ(rig.part(0).held_by, 0);
  rig.move({{"arm/x/position", 0.3}, {"arm/z/position", -0.2}}, 0.2);
  EXPECT_NEAR(rig.part(0).pose.position.x, 0.3, 1e-9);
  EXPECT_NEAR(rig.part(0).pose.position.z, 0.18, 1e-9);
  rig.command("arm/tool/vacuum") = 0;
  rig.run(0.01);
  EXPECT_EQ(rig.state("arm/tool/part_present"), 0);
  EXPECT_EQ(rig.part(0).held_by, -1);
  rig.move({{"arm/x/position", -0.3}}, 0.2);
  EXPECT_NEAR(rig.part(0).pose.position.x, 0.3, 1e-9);
}

TEST(Mock, APartIsHeldByTheRobotThatHoldsItAmongOthersWithoutAGripper) {
  Stage stage;
  stage.model = gantry();
  stage.tool = description::find_tool("suction_cup", "");
  stage.scene = table();
  stage.scene.parts = {cube("cube", {0, 0, 0.02})};
  hardware::ComponentContext context = stage.context();
  hardware::RobotInstance bare = context.robots.front();
  bare.name = "bare";
  bare.tool = nullptr;
  // A robot with two hardware blocks has two instances of one name, and hardware of others has robots, too.
  context.robots.insert(context.robots.begin(), 2, bare);
  context.robots.back().number = 4;
  Rig rig(std::make_unique<drivers::MockComponent>(), context);
  rig.move({{"arm/z/position", -0.36}}, 0.2);
  rig.command("arm/tool/vacuum") = 1;
  rig.run(0.15);
  EXPECT_EQ(rig.part(0).held_by, 4) << "the robot's number in the cell, not in the component";
}

TEST(Mock, ACupTakesAPartOverFromTheCupThatLetsGo) {
  Stage stage;
  stage.model = gantry();
  stage.tool = description::find_tool("suction_cup", "");
  stage.scene = table();
  stage.scene.parts = {cube("plate", {0, 0, 0.01})};
  stage.scene.parts[0].shape.size = {0.2, 0.06, 0.02};
  hardware::ComponentContext context = stage.context();
  hardware::RobotInstance other = context.robots.front();
  other.name = "other";
  other.base.position.x = 0.5;
  other.number = 1;
  context.robots.push_back(other);
  Rig rig(std::make_unique<drivers::MockComponent>(), context);
  constexpr double kOnPlate = -0.38;
  rig.move({{"arm/z/position", kOnPlate}}, 0.5);
  rig.command("arm/tool/vacuum") = 1;
  rig.run(0.3);
  ASSERT_EQ(rig.part(0).held_by, 0);
  rig.move({{"arm/z/position", kOnPlate + 0.1}}, 0.5);
  rig.move({{"other/x/position", -0.44}, {"other/z/position", kOnPlate + 0.101}}, 0.5);
  EXPECT_EQ(rig.state("other/tool/part_present"), 0) << "its vacuum is off";
  rig.move({{"other/z/position", kOnPlate + 0.1}}, 0.1);
  rig.command("other/tool/vacuum") = 1;
  rig.run(0.3);
  EXPECT_EQ(rig.state("other/tool/part_present"), 1);
  EXPECT_EQ(rig.part(0).held_by, 0);
  const double height = rig.part(0).pose.position.z;
  rig.command("arm/tool/vacuum") = 0;
  rig.run(0.3);
  EXPECT_EQ(rig.part(0).held_by, 1);
  EXPECT_EQ(rig.state("arm/tool/part_present"), 0);
  EXPECT_NEAR(rig.part(0).pose.position.z, height, 5e-4) << "it does not fall between them";
  rig.move({{"arm/z/position", kOnPlate + 0.2}}, 0.5);
  rig.move({{"other/z/position", kOnPlate + 0.15}}, 0.5);
  EXPECT_NEAR(rig.part(0).pose.position.z, height + 0.05, 1e-3);
  rig.command("other/tool/vacuum") = 0;
  rig.run(0.5);
  EXPECT_EQ(rig.part(0).held_by, -1);
  EXPECT_LT(rig.part(0).pose.position.z, 0.05);
}

TEST(Mock, AFeederWaitsUntilThePlaceOfTheNextPartIsFree) {
  Stage stage;
  stage.model = gantry();
  stage.tool = description::find_tool("suction_cup", "");
  stage.scene = table();
  stage.scene.feeders = {{"magazine", {{0, 0, 0.02}, {}}}};
  stage.scene.parts = {cube("one", {}), cube("two", {})};
  for (description::Part& part : stage.scene.parts) part.feeder = "magazine";
  Rig rig = mock(stage);
  rig.command("scene/magazine/feed") = 2;
  rig.run(0.1);
  EXPECT_EQ(rig.state("scene/magazine/presented"), 1);
  rig.move({{"arm/z/position", -0.36}}, 0.2);
  rig.command("arm/tool/vacuum") = 1;
  rig.run(0.2);
  rig.move({{"arm/z/position", -0.325}}, 0.2);
  EXPECT_EQ(rig.state("scene/magazine/presented"), 1) << "the first one is 35 mm above, and 40 mm high";
  rig.move({{"arm/z/position", -0.31}}, 0.2);
  EXPECT_EQ(rig.state("scene/magazine/presented"), 2);
}

TEST(Mock, AReleasedPartLiesOnWhatIsBelowItAndRidesOnIt) {
  Stage stage;
  stage.model = gantry();
  stage.tool = description::find_tool("suction_cup", "");
  stage.scene = table();
  stage.scene.parts = {cube("lower", {0, 0, 0.02}), cube("upper", {0.2, 0, 0.02})};
  stage.scene.movers = {{.name = "shuttle", .axis = {0, 1, 0}, .upper = 0.1, .speed = 1}};
  description::Fixture plate;
  plate.name = "plate";
  plate.mover = "shuttle";
  plate.pose.position = {-0.2, 0, 0.005};
  description::Shape box;
  box.kind = description::ShapeKind::box;
  box.size = {0.1, 0.1, 0.01};
  plate.shapes = {box};
  stage.scene.fixtures.push_back(plate);
  Rig rig = mock(stage);
  const auto take_to = [&](double from, double x) {
    rig.move({{"arm/x/position", from}, {"arm/z/position", -0.3}}, 0.1);
    rig.move({{"arm/z/position", -0.36}}, 0.1);
    rig.command("arm/tool/vacuum") = 1;
    rig.run(0.2);
    rig.move({{"arm/z/position", -0.2}}, 0.1);
    rig.move({{"arm/x/position", x}}, 0.1);
    rig.command("arm/tool/vacuum") = 0;
    rig.run(0.01);
  };
  take_to(0.2, 0);
  EXPECT_NEAR(rig.part(1).pose.position.z, 0.06, 1e-9) << "on the other cube";
  rig.move({{"arm/z/position", -0.32}}, 0.1);
  rig.command("arm/tool/vacuum") = 1;
  rig.run(0.2);
  rig.move({{"arm/z/position", -0.2}}, 0.1);
  rig.move({{"arm/x/position", -0.2}}, 0.1);
  rig.command("arm/tool/vacuum") = 0;
  rig.run(0.01);
  EXPECT_NEAR(rig.part(1).pose.position.z, 0.03, 1e-9) << "on the plate";
  rig.command("scene/shuttle/position") = 0.1;
  rig.run(0.2);
  EXPECT_NEAR(rig.part(1).pose.position.y, 0.1, 1e-9) << "the shuttle carries it";
  EXPECT_NEAR(rig.part(0).pose.position.y, 0, 1e-9);
}

TEST(Mock, AReleasedPartLiesAcrossAGapBetweenTwoOthers) {
  Stage stage;
  stage.model = gantry();
  stage.tool = description::find_tool("suction_cup", "");
  stage.scene = table();
  description::Part sheet = cube("sheet", {0.2, 0, 0.002});
  sheet.shape.size = {0.1, 0.1, 0.004};
  stage.scene.parts = {cube("left", {0, -0.03, 0.02}), cube("right", {0, 0.03, 0.02}), sheet};
  Rig rig = mock(stage);
  const auto take_to = [&](double x) {
    rig.command("arm/tool/vacuum") = 1;
    rig.run(0.2);
    rig.move({{"arm/z/position", -0.2}}, 0.1);
    rig.move({{"arm/x/position", x}}, 0.1);
    rig.command("arm/tool/vacuum") = 0;
    rig.run(0.01);
  };
  rig.move({{"arm/x/position", 0.2}, {"arm/z/position", -0.3}}, 0.1);
  rig.move({{"arm/z/position", -0.396}}, 0.1);
  take_to(0);
  EXPECT_NEAR(rig.part(2).pose.position.z, 0.042, 1e-9) << "on both cubes, with nothing below its middle";
  rig.move({{"arm/z/position", -0.356}}, 0.1);
  take_to(0.045);
  EXPECT_NEAR(rig.part(2).pose.position.z, 0.002, 1e-9) << "with a cube below one side only it would tip";
}

TEST(Mock, FeederMoverAndOutfeedCountAsTheyAreAsked) {
  Stage stage;
  stage.model = gantry();
  stage.scene = table();
  stage.scene.kinds = {"ball", "cube"};
  stage.scene.feeders = {{"magazine", {{0.3, 0, 0.02}, {}}}};
  stage.scene.outfeeds = {{"chute", {0.2, -0.1, 0}, {0.4, 0.1, 0.1}}};
  stage.scene.movers = {{"door", {1, 0, 0}, 0, 0.1, 0.2, 1}};
  stage.scene.parts = {cube("one", {}), cube("two", {})};
  for (description::Part& part : stage.scene.parts) part.feeder = "magazine";
  Rig rig = mock(stage);
  EXPECT_EQ(rig.state("scene/magazine/remaining"), 2);
  EXPECT_FALSE(rig.part(0).entered);
  rig.command("scene/magazine/feed") = 1;
  rig.command("scene/door/position") = 5;
  rig.run(0.01);
  EXPECT_EQ(rig.state("scene/magazine/presented"), 1);
  EXPECT_EQ(rig.state("scene/magazine/remaining"), 1);
  EXPECT_EQ(rig.state("scene/magazine/present"), 1);
  EXPECT_EQ(rig.state("scene/magazine/kind"), 2);
  EXPECT_EQ(rig.state("scene/chute/present"), 1);
  EXPECT_NEAR(rig.state("scene/door/position"), 0.002, 1e-9);
  rig.command("scene/chute/take") = 1;
  rig.run(1);
  EXPECT_EQ(rig.state("scene/chute/taken"), 1);
  EXPECT_FALSE(rig.part(0).in_world);
  EXPECT_EQ(rig.state("scene/magazine/present"), 0);
  EXPECT_NEAR(rig.state("scene/door/position"), 0.1, 1e-9) << "not past its end";
}

TEST(Mock, CyclesAllocateNothing) {
  if (!RealtimeGuard::watches()) GTEST_SKIP() << "a sanitizer watches the allocations";
  Stage stage;
  stage.model = gantry();
  stage.tool = description::find_tool("suction_cup", "");
  stage.scene = table();
  stage.scene.parts = {cube("cube", {0, 0, 0.02})};
  Rig rig = mock(stage);
  rig.move({{"arm/z/position", -0.36}}, 0.1);
  double& vacuum = rig.command("arm/tool/vacuum");
  bool held = false;
  std::string violations;
  {
    const RealtimeGuard guard;
    for (int k = 0; k < 500; ++k) {
      vacuum = k < 300 ? 1 : 0;
      rig.cycle();
      held |= rig.part(0).held_by == 0;
    }
    violations = guard.violations();
  }
  EXPECT_EQ(violations, "");
  EXPECT_TRUE(held) << "the guard saw no grasp";
}

}  // namespace
}  // namespace polyarm::test::mock_test
