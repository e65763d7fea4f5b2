#ifdef POLYARM_MUJOCO

#include <algorithm>
#include <functional>
#include <limits>
#include <sstream>

#include "tests/drivers/mujoco_stage.hpp"
#include "tests/support/realtime_guard.hpp"

namespace polyarm::test::mujoco_test {
namespace {

/// Runs a path for every joint in step with the clock; returns the largest |state - command|.
double follow(Rig& rig, const std::vector<std::string>& joints, double duration, double period,
              const std::function<double(std::size_t, double)>& path) {
  double worst = 0;
  const auto cycles = std::lround(duration / period);
  for (long k = 1; k <= cycles; ++k) {
    const double t = static_cast<double>(k) * period;
    for (std::size_t j = 0; j < joints.size(); ++j)
      rig.command("arm/" + joints[j] + "/position") = path(j, t);
    EXPECT_EQ(rig.cycle(), hardware::ReturnType::ok);
    worst = std::max(worst, rig.world().tracking_error);
    for (std::size_t j = 0; j < joints.size(); ++j)
      worst = std::max(worst, std::abs(rig.state("arm/" + joints[j] + "/position") - path(j, t)));
  }
  return worst;
}

Stage ur3() {
  Stage out;
  out.model = description::Catalogue({POLYARM_SOURCE_DIR "/robots"}).load("universal_robots/ur3");
  out.start = out.model.named_states.at("home");
  out.scene.floor = false;
  return out;
}

/// From rest along a cosine whose fastest speed is 1 rad/s; stands after four periods.
constexpr double kAmplitude = 0.2, kWave = 8 * M_PI * kAmplitude;
double wave(double start, double t) {
  return start + kAmplitude * (1 - std::cos(std::min(t, kWave) / kAmplitude));
}

// --- the servo
// ----------------------------------------------------------------------------------------------

TEST(Mujoco, PositionServoTracksAMovingTarget) {
  const Stage stage = ur3();
  Rig rig = simulate(stage);
  const auto joints = stage.model.joint_names();
  const double peak = follow(rig, joints, kWave + 0.5, 1e-3,
                             [&](std::size_t j, double t) { return wave(stage.start[j], t); });
  EXPECT_LT(peak, 1e-3);
  const double rest =
      follow(rig, joints, 1, 1e-3, [&](std::size_t j, double) { return wave(stage.start[j], kWave); });
  EXPECT_LT(rest, 5e-5);
  RecordProperty("peak_mrad", (std::ostringstream() << peak * 1e3).str());
  RecordProperty("rest_mrad", (std::ostringstream() << rest * 1e3).str());
  EXPECT_EQ(rig.world().finding_count, 0) << rig.findings();
}

TEST(Mujoco, HoldsAgainstGravity) {
  Stage stage;
  stage.model = two_links();
  stage.start = {0, 0};
  stage.scene.floor = false;
  Rig rig = simulate(stage);
  rig.run(5);
  EXPECT_NEAR(rig.state("arm/shoulder/position"), 0, 5e-5);
  EXPECT_NEAR(rig.state("arm/elbow/position"), 0, 5e-5);
  EXPECT_NEAR(rig.state("arm/shoulder/effort"), -9.81 * (4 * 0.2 + 2 * 0.6), 0.02);
  EXPECT_NEAR(rig.state("arm/elbow/effort"), -9.81 * 2 * 0.2, 0.02);
}

TEST(Mujoco, AServoTooWeakForItsLoadSinks) {
  Stage stage;
  stage.model = two_links(10);
  stage.start = {0, 0};
  stage.scene.floor = false;
  Rig rig = simulate(stage);
  rig.run(0.3);
  EXPECT_GT(rig.state("arm/shoulder/position"), 0.05);
  EXPECT_LE(std::abs(rig.state("arm/shoulder/effort")), 10);
}

TEST(Mujoco, PushingALoadItDoesNotKnowCostsTheServoAccuracy) {
  const Stage stage = cell("suction_cup", 2);
  Rig rig = simulate(stage);
  rig.move({{"arm/x/position", -0.2}}, 0.5);
  rig.move({{"arm/z/position", 0.01 - kTcpAtZero}}, 0.5);
  EXPECT_LT(rig.worst_tracking(), 1e-6) << "nothing in the way";
  rig.move({{"arm/x/position", 0.1}}, 1);
  EXPECT_GT(rig.worst_tracking(), 1e-5);
  EXPECT_LT(rig.worst_tracking(), 5e-3);
}

TEST(Mujoco, AJointWithoutACommandHasNoTrackingError) {
  Stage stage;
  stage.model = two_links(10);
  stage.start = {0, 0};
  stage.scene.floor = false;
  Rig rig = simulate(stage);
  rig.run(0.3);
  EXPECT_GT(rig.state("arm/shoulder/position"), 0.05) << "it sinks";
  EXPECT_EQ(rig.world().tracking_error, 0) << "and nobody asked it to stay";
  rig.command("arm/shoulder/position") = 0;
  rig.run(0.01);
  EXPECT_GT(rig.world().tracking_error, 0.05);
  rig.switch_mode({}, {"arm/shoulder/position"});
  rig.run(0.01);
  EXPECT_EQ(rig.world().tracking_error, 0);
}

TEST(Mujoco, NotANumberIsNoCommand) {
  Stage stage;
  stage.model = gantry();
  stage.scene.floor = false;
  Rig rig = simulate(stage);
  rig.move({{"arm/x/position", 0.2}}, 0.5);
  rig.command("arm/x/position") = kNothing;
  rig.run(1);
  EXPECT_NEAR(rig.state("arm/x/position"), 0.2, 5e-5);
  EXPECT_NEAR(rig.state("arm/y/position"), 0, 5e-5) << "was never commanded";
}

TEST(Mujoco, EffortModeAppliesWhatIsCommanded) {
  Stage stage;
  stage.model = gantry(500);
  stage.scene.floor = false;
  Rig rig = simulate(stage);
  rig.switch_mode({"arm/x/effort"}, {"arm/x/position"});
  rig.command("arm/x/effort") = 10;
  rig.run(0.5);
  constexpr double kMass = 4 + 3 + 2 + 1;  // of the links, and what the drive adds
  EXPECT_EQ(rig.state("arm/x/effort"), 10);
  EXPECT_NEAR(rig.state("arm/x/velocity"), 10 / kMass * 0.5, 1e-3);
  EXPECT_NEAR(rig.state("arm/x/position"), 10 / kMass * 0.5 * 0.5 / 2, 2e-3);
  EXPECT_NEAR(rig.state("arm/z/position"), 0, 5e-5) << "still holds its position";
  rig.command("arm/x/effort") = -1e5;
  rig.cycle();
  EXPECT_EQ(rig.state("arm/x/effort"), -500) << "the limit of the drive";
}

TEST(Mujoco, VelocityModeRunsAtTheSpeedCommanded) {
  Stage stage;
  stage.model = gantry();
  stage.scene.floor = false;
  Rig rig = simulate(stage);
  rig.switch_mode({"arm/y/velocity"}, {"arm/y/position"});
  rig.command("arm/y/velocity") = 0.2;
  rig.run(0.5);
  const double from = rig.state("arm/y/position");
  rig.run(1);
  EXPECT_NEAR(rig.state("arm/y/velocity"), 0.2, 1e-4);
  EXPECT_NEAR(rig.state("arm/y/position") - from, 0.2, 1e-4);
}

TEST(Mujoco, FourMillisecondPeriodRunsFourSteps) {
  Stage falling = parts_only();
  falling.scene.parts = {cube("cube", {0, 0, 2})};
  Rig fine = simulate(falling), coarse = simulate(falling, 4'000'000);
  fine.run(0.4);
  coarse.run(0.4);
  EXPECT_EQ(fine.part(0).pose, coarse.part(0).pose);
  const Stage stage = ur3();
  Rig rig = simulate(stage, 4'000'000);
  const double peak = follow(rig, stage.model.joint_names(), 4, 4e-3,
                             [&](std::size_t j, double t) { return wave(stage.start[j], t); });
  EXPECT_LT(peak, 1e-3);
}

// --- parts
// --------------------------------------------------------------------------------------------------

TEST(Mujoco, FreeFallMatchesTheFormula) {
  constexpr double kHeight = 0.3;
  Stage stage = parts_only();
  stage.scene.parts = {cube("cube", {0, 0, 0.02 + kHeight})};
  Rig rig = simulate(stage);
  while (rig.world().contacts == 0 && rig.now() < 1) ASSERT_EQ(rig.cycle(), hardware::ReturnType::ok);
  EXPECT_NEAR(rig.now(), std::sqrt(2 * kHeight / 9.81), 2.001e-3);
}

TEST(Mujoco, AStandingCylinderComesToRest) {
  for (const double height : {0.04, 0.06}) {
    Stage stage = parts_only();
    description::Part part = cube("can", {0.1, 0.2, height / 2});
    part.shape = {};
    part.shape.kind = description::ShapeKind::cylinder;
    part.shape.radius = 0.02;
    part.shape.length = height;
    stage.scene.parts = {part};
    Rig rig = simulate(stage);
    rig.run(2);
    EXPECT_TRUE(rig.part(0).asleep) << height << " m high, moves at " << rig.part(0).speed << " m/s";
  }
}

TEST(Mujoco, PartStaysWhereItWasPut) {
  Stage stage = parts_only();
  stage.scene.parts = {cube("cube", {0.1, 0.2, 0.02})};
  Rig rig = simulate(stage);
  rig.run(2);
  const Pose settled = rig.part(0).pose;
  EXPECT_LT(norm(settled.position - stage.scene.parts[0].start.position), 1e-4);
  EXPECT_TRUE(rig.part(0).asleep);
  EXPECT_TRUE(rig.world().at_rest);
  rig.run(10);
  EXPECT_LT(norm(rig.part(0).pose.position - settled.position), 1e-5);
  EXPECT_TRUE(rig.part(0).asleep);
}

TEST(Mujoco, SleepingPartWakesWhenTouched) {
  const Stage stage = cell();
  Rig rig = simulate(stage);
  rig.move({{"arm/x/position", -0.2}}, 0.5);
  rig.move({{"arm/z/position", 0.01 - kTcpAtZero}}, 0.5);
  rig.run(1);
  ASSERT_TRUE(rig.part(0).asleep);
  rig.move({{"arm/x/position", 0.0}}, 1);
  EXPECT_NEAR(rig.part(0).pose.position.x, 0.02 + 0.012, 0.005) << "pushed along by the body of the cup";
  rig.move({{"arm/x/position", -0.1}}, 0.5);
  rig.run(1);
  EXPECT_TRUE(rig.part(0).asleep) << "and asleep again";
}

TEST(Mujoco, APartAsleepOnAnotherFallsWhenThatIsTaken) {
  Stage stage = parts_only();
  stage.scene.parts = {cube("lower", {0, 0, 0.02}), cube("upper", {0, 0, 0.06})};
  stage.scene.outfeeds = {{"chute", {-0.1, -0.1, 0}, {0.1, 0.1, 0.04}}};
  Rig rig = simulate(stage);
  rig.run(2);
  ASSERT_TRUE(rig.part(0).asleep && rig.part(1).asleep);
  rig.command("scene/chute/take") = 1;
  rig.run(2);
  EXPECT_FALSE(rig.part(0).in_world);
  EXPECT_NEAR(rig.part(1).pose.position.z, 0.02, 5e-4);
}

// --- the suction cup
// ----------------------------------------------------------------------------------------

TEST(Mujoco, CupHoldsOnlyWhatItTouches) {
  Stage stage = cell();
  stage.number = 3;
  Rig rig = simulate(stage);
  rig.move({{"arm/z/position", kOnCube + 0.005}}, 0.5);
  rig.command("arm/tool/vacuum") = 1;
  rig.run(0.5);
  EXPECT_EQ(rig.state("arm/tool/part_present"), 0);
  EXPECT_EQ(rig.part(0).held_by, -1);
  rig.move({{"arm/z/position", kOnCube + 0.0005}}, 0.2);
  rig.run(0.1);
  EXPECT_EQ(rig.state("arm/tool/part_present"), 1);
  EXPECT_EQ(rig.part(0).held_by, 3) << "the robot's number in the cell, not in physics";
}

TEST(Mujoco, ACupTakesAPartOverFromTheCupThatLetsGo) {
  Stage stage = cell();
  stage.scene.parts = {cube("plate", {0, 0, 0.01})};
  stage.scene.parts[0].shape.size = {0.2, 0.06, 0.02};
  hardware::ComponentContext context = stage.context();
  hardware::RobotInstance other = context.robots.front();
  other.name = "other";
  other.base.position.x = 0.5;
  other.number = 1;
  context.robots.push_back(other);
  Rig rig(std::make_unique<drivers::MujocoComponent>(), context);
  constexpr double kOnPlate = kOnCube - 0.02;
  rig.move({{"arm/x/position", -0.06}, {"arm/z/position", kOnPlate + 0.0005}}, 0.5);
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

TEST(Mujoco, WithoutVacuumNothingIsHeld) {
  const Stage stage = cell();
  Rig rig = simulate(stage);
  rig.move({{"arm/z/position", kOnCube + 0.0005}}, 0.5);
  rig.run(0.5);
  EXPECT_EQ(rig.state("arm/tool/part_present"), 0);
  rig.move({{"arm/z/position", -0.2}}, 0.5);
  EXPECT_NEAR(rig.part(0).pose.position.z, 0.02, 1e-4);
}

TEST(Mujoco, HeldPartFollowsTheTool) {
  const Stage stage = cell();
  Rig rig = simulate(stage);
  grasp(rig);
  const auto offset = [&] {
    return rig.part(0).pose.position -
           Vec3{rig.state("arm/x/position"), rig.state("arm/y/position"), rig.state("arm/z/position")};
  };
  const Vec3 gripped = offset();
  rig.move({{"arm/z/position", -0.1}}, 0.5);
  double lag = 0;
  for (int k = 1; k <= 2000; ++k) {
    const double t = k * 1e-3;
    rig.command("arm/x/position") = 0.2 * (1 - std::cos(4 * t));
    rig.command("arm/y/position") = 0.1 * (1 - std::cos(6 * t));
    ASSERT_EQ(rig.cycle(), hardware::ReturnType::ok);
    lag = std::max(lag, norm(offset() - gripped));
  }
  EXPECT_LT(lag, 5e-4);
  EXPECT_EQ(rig.state("arm/tool/part_present"), 1);
  EXPECT_EQ(rig.world().finding_count, 0) << rig.findings();
}

TEST(Mujoco, VacuumOffDropsIt) {
  const Stage stage = cell();
  Rig rig = simulate(stage);
  grasp(rig);
  rig.move({{"arm/x/position", 0.2}, {"arm/z/position", -0.2}}, 1);
  ASSERT_GT(rig.part(0).pose.position.z, 0.15);
  rig.command("arm/tool/vacuum") = 0;
  rig.run(0.1);
  EXPECT_EQ(rig.state("arm/tool/part_present"), 0);
  rig.run(2);
  EXPECT_EQ(rig.part(0).held_by, -1);
  EXPECT_LT(rig.part(0).pose.position.z, 0.03);
  EXPECT_NEAR(rig.part(0).pose.position.x, 0.2, 0.05);
  EXPECT_TRUE(rig.part(0).asleep);
}

TEST(Mujoco, TooHeavyOrTooFastPullsOff) {
  const Stage heavy = cell("suction_cup", 7);  // 69 N, the cup holds 60 N
  Rig rig = simulate(heavy);
  grasp(rig);
  rig.move({{"arm/z/position", -0.1}}, 1);
  EXPECT_EQ(rig.state("arm/tool/part_present"), 0);
  EXPECT_LT(rig.part(0).pose.position.z, 0.03);

  const Stage lighter = cell("suction_cup", 3);
  for (const double duration : {1.5, 0.2}) {  // peak accelerations 0.8 and 43 m/s²
    Rig other = simulate(lighter);
    grasp(other);
    other.move({{"arm/z/position", -0.1}}, 1.5);
    ASSERT_EQ(other.state("arm/tool/part_present"), 1);
    other.move({{"arm/x/position", 0.3}}, duration);
    EXPECT_EQ(other.state("arm/tool/part_present"), duration > 1 ? 1 : 0) << duration << " s";
  }
}

// --- the gripper
// --------------------------------------------------------------------------------------------

TEST(Mujoco, GripperHoldsByFriction) {
  const Stage stage = cell("parallel_gripper");
  Rig rig = simulate(stage);
  rig.command("arm/tool/grip") = 0;
  rig.move({{"arm/z/position", 0.01 - kTcpAtZero}}, 0.8);
  EXPECT_NEAR(rig.state("arm/tool/width"), 0.05, 1e-3);
  EXPECT_EQ(rig.state("arm/tool/part_present"), 0);
  rig.command("arm/tool/grip") = 1;
  rig.run(0.5);
  EXPECT_EQ(rig.state("arm/tool/part_present"), 1);
  EXPECT_NEAR(rig.state("arm/tool/width"), 0.04, 1e-3);
  rig.move({{"arm/z/position", 0.21 - kTcpAtZero}}, 1);
  const double lifted = rig.part(0).pose.position.z;
  EXPECT_NEAR(lifted, 0.22, 2e-3);
  rig.run(2);
  EXPECT_NEAR(rig.part(0).pose.position.z, lifted, 1e-3) << "slips";
  EXPECT_EQ(rig.world().finding_count, 0) << rig.findings();
  rig.command("arm/tool/grip") = 0;
  rig.run(1.5);
  EXPECT_EQ(rig.state("arm/tool/part_present"), 0);
  EXPECT_LT(rig.part(0).pose.position.z, 0.04);
}

TEST(Mujoco, AGripperThatClosesOnNothingHoldsNothing) {
  Stage stage = cell("parallel_gripper");
  stage.scene.parts.clear();
  Rig rig = simulate(stage);
  rig.command("arm/tool/grip") = 1;
  rig.run(1);
  EXPECT_EQ(rig.state("arm/tool/part_present"), 0);
  EXPECT_NEAR(rig.state("arm/tool/width"), 0, 1e-3);
}

TEST(Mujoco, FingersRunSmoothlyAtTheirSpeed) {
  Stage stage = cell("parallel_gripper");
  stage.scene.parts.clear();
  Rig rig = simulate(stage);
  rig.command("arm/tool/grip") = 1;
  rig.run(0.05);
  double width = rig.state("arm/tool/width");
  for (int k = 0; k < 100; ++k) {  // of 250 ms for the whole stroke
    rig.cycle();
    EXPECT_NEAR((width - rig.state("arm/tool/width")) / 1e-3, 2 * stage.tool.closing_speed, 0.01);
    width = rig.state("arm/tool/width");
  }
}

// --- findings
// -----------------------------------------------------------------------------------------------

TEST(Mujoco, ArmIntoTableIsAFinding) {
  Stage stage = cell("none");
  stage.scene.parts.clear();
  Rig rig = simulate(stage);
  rig.move({{"arm/z/position", -0.495}}, 0.5);
  EXPECT_EQ(rig.world().finding_count, 0) << rig.findings();
  rig.move({{"arm/z/position", -0.503}}, 0.5);
  ASSERT_EQ(rig.world().finding_count, 1) << rig.findings();
  const hardware::Contact& found = rig.world().findings[0];
  const auto names = rig.component().world_names();
  EXPECT_EQ(names.at(static_cast<std::size_t>(found.a)), "arm/z_link");
  EXPECT_EQ(names.at(static_cast<std::size_t>(found.b)), "fixture table");
  EXPECT_GT(found.depth, 0);
  EXPECT_GT(found.time, nanoseconds(0.5));
  EXPECT_TRUE(found.now);
  EXPECT_NEAR(found.position.z, 0, 0.005) << "at the top of the table";
}

TEST(Mujoco, APairIsToldAgainOnlyAfterItHasBeenClear) {
  Stage stage = cell("none");
  stage.scene.parts.clear();
  Rig rig = simulate(stage);
  rig.move({{"arm/z/position", -0.503}}, 0.5);
  rig.run(1);
  ASSERT_EQ(rig.world().finding_count, 1) << "resting is nothing new";
  EXPECT_TRUE(rig.world().findings[0].now);
  rig.move({{"arm/z/position", -0.4}}, 0.5);
  EXPECT_FALSE(rig.world().findings[0].now) << "clear again";
  rig.move({{"arm/z/position", -0.503}}, 0.5);
  ASSERT_EQ(rig.world().finding_count, 2) << "touched anew";
  EXPECT_TRUE(rig.world().findings[1].now);
}

TEST(Mujoco, HeldPartSweptIntoAnObstacleIsAFinding) {
  Stage stage = cell();
  stage.scene.fixtures.push_back(block("wall", {0.02, 0.2, 0.1}, {0.2, 0, 0.05}));
  Rig rig = simulate(stage);
  grasp(rig);
  rig.move({{"arm/z/position", kOnCube + 0.03}}, 0.5);
  EXPECT_EQ(rig.world().finding_count, 0) << rig.findings();
  rig.move({{"arm/x/position", 0.175}}, 1);
  ASSERT_GE(rig.world().finding_count, 1);
  EXPECT_NE(rig.findings().find("part cube"), std::string::npos) << rig.findings();
  EXPECT_NE(rig.findings().find("fixture wall"), std::string::npos) << rig.findings();
}

TEST(Mujoco, PlacingOnATableIsNoFinding) {
  const Stage stage = cell();
  Rig rig = simulate(stage);
  grasp(rig);
  rig.move({{"arm/z/position", -0.2}}, 0.5);
  rig.move({{"arm/x/position", 0.2}}, 0.8);
  rig.move({{"arm/z/position", kOnCube}}, 0.8);
  rig.command("arm/tool/vacuum") = 0;
  rig.run(0.3);
  rig.move({{"arm/z/position", -0.2}}, 0.5);
  rig.run(1);
  EXPECT_EQ(rig.world().finding_count, 0) << rig.findings();
  EXPECT_LT(norm(rig.part(0).pose.position - Vec3{0.2, 0, 0.02}), 5e-4);
  EXPECT_TRUE(rig.part(0).asleep);
}

// --- repeatable and real-time
// -------------------------------------------------------------------------------

/// Grasps, carries and drops a part onto others, and feeds nothing else in: many models are switched.
void act(Rig& rig) {
  grasp(rig);
  rig.move({{"arm/x/position", 0.2}, {"arm/z/position", -0.2}}, 0.4);
  rig.command("arm/tool/vacuum") = 0;
  rig.run(0.8);
  rig.move({{"arm/x/position", 0}}, 0.4);
}

Stage crowded() {
  Stage out = cell();
  for (int i = 0; i < 5; ++i)
    out.scene.parts.push_back(
        cube("other_" + std::to_string(i), {0.185 + 0.005 * i, 0.003 * i, 0.02 + 0.041 * i}));
  out.scene.parts.resize(4);
  return out;
}

TEST(Mujoco, TwoRunsAreBitEqual) {
  const Stage stage = crowded();
  Rig one = simulate(stage);
  act(one);
  const Stage other = cell("parallel_gripper");
  Rig noise = simulate(other);
  noise.run(0.1);
  Rig two = simulate(stage);
  act(two);
  ASSERT_EQ(one.states().size(), two.states().size());
  for (std::size_t i = 0; i < one.states().size(); ++i) EXPECT_EQ(one.states()[i], two.states()[i]) << i;
  for (std::size_t i = 0; i < one.world().parts.size(); ++i) {
    EXPECT_EQ(one.part(i).pose, two.part(i).pose) << i;
    EXPECT_EQ(one.part(i).speed, two.part(i).speed) << i;
  }
  EXPECT_EQ(one.world().finding_count, two.world().finding_count);
  EXPECT_GT(norm(one.part(0).pose.position - stage.scene.parts[0].start.position), 0.1) << "nothing happened";
}

TEST(Mujoco, StepAllocatesNothing) {
  if (!RealtimeGuard::watches()) GTEST_SKIP() << "a sanitizer watches the allocations";
  const Stage stage = crowded();
  Rig rig = simulate(stage);
  rig.move({{"arm/z/position", kOnCube + 0.0005}}, 0.5);
  double& vacuum = rig.command("arm/tool/vacuum");
  double& z = rig.command("arm/z/position");
  double& x = rig.command("arm/x/position");
  x = 0;
  rig.run(0.02);
  std::string violations;
  bool held = false, awake = false;
  {
    const RealtimeGuard guard;
    for (int k = 1; k <= 3000; ++k) {
      vacuum = k < 1200 ? 1 : 0;
      if (k > 300 && k <= 600) z += 0.2 / 300;
      if (k > 600 && k <= 1000) x += 0.2 / 400;
      rig.cycle();
      held |= rig.part(0).held_by == 0;
      awake |= held && rig.part(0).held_by < 0 && !rig.part(1).asleep;
    }
    violations = guard.violations();
  }
  EXPECT_EQ(violations, "");
  EXPECT_TRUE(held) << "the guard saw no grasp";
  EXPECT_TRUE(awake) << "the guard saw no part woken";
}

}  // namespace
}  // namespace polyarm::test::mujoco_test

#endif
