#ifdef POLYARM_MUJOCO

#include <algorithm>

#include "drivers/mujoco/component.hpp"
#include "tests/drivers/rig.hpp"

namespace polyarm::test::mujoco_laws_test {
namespace {

constexpr double kGravity = 9.81;

Rig physics(const Stage& stage, Nanoseconds period = 1'000'000) {
  return Rig(std::make_unique<drivers::MujocoComponent>(), stage.context(period));
}

Stage arm() {
  Stage out;
  out.model = two_links();
  return out;
}

/// The gantry over the table; its TCP is 0.4 m + z above it.
Stage cell(const std::string& tool = "suction_cup") {
  Stage out;
  out.model = gantry();
  out.tool = description::find_tool(tool, "");
  out.scene = table();
  return out;
}

Stage only(description::Scene scene) {
  Stage out;
  out.robot = false;
  out.scene = std::move(scene);
  return out;
}

double fastest(Rig& rig, const std::string& joint, int cycles) {
  double out = 0;
  for (int k = 0; k < cycles; ++k) {
    rig.cycle();
    out = std::max(out, std::abs(rig.state(joint + "/velocity")));
  }
  return out;
}

/// A rig that holds part 0, which stood on the table and is 40 mm high, 0.1 m above the table.
Rig holding_the_first(const Stage& stage) {
  Rig rig = physics(stage);
  rig.move({{"arm/z/position", -0.3597}}, 0.5);
  rig.command("arm/tool/vacuum") = 1;
  rig.run(0.3);
  EXPECT_EQ(rig.state("arm/tool/part_present"), 1);
  rig.move({{"arm/z/position", -0.26}}, 0.5);
  return rig;
}

/// The same with a cube of this mass.
Rig holding(Stage& stage, double mass = 0.08) {
  stage.scene.parts.insert(stage.scene.parts.begin(), cube("cube", {0, 0, 0.02}, 0.04, mass));
  return holding_the_first(stage);
}

/// A rig whose fingers hold a cube of 0.2 kg above the table.
Rig gripping(Stage& stage) {
  stage.scene.parts = {cube("cube", {0, 0, 0.02}, 0.04, 0.2)};
  Rig rig = physics(stage);
  rig.command("arm/tool/grip") = 0;
  rig.move({{"arm/z/position", -0.39}}, 0.8);
  rig.command("arm/tool/grip") = 1;
  rig.run(0.5);
  EXPECT_EQ(rig.state("arm/tool/part_present"), 1);
  rig.move({{"arm/z/position", -0.2}}, 0.5);
  return rig;
}

// --- modes
// ------------------------------------------------------------------------------------------------------

TEST(MujocoModes, GoingBackToPositionDoesNotJump) {
  const Stage stage = arm();
  Rig rig = physics(stage);
  rig.switch_mode({"arm/shoulder/velocity"}, {"arm/shoulder/position"});
  rig.command("arm/shoulder/velocity") = 1;
  rig.run(0.5);
  rig.command("arm/shoulder/velocity") = 0;
  rig.run(0.2);
  rig.switch_mode({"arm/shoulder/position"}, {"arm/shoulder/velocity"});
  const double here = rig.command("arm/shoulder/position") = rig.state("arm/shoulder/position");
  EXPECT_LT(fastest(rig, "arm/shoulder", 200), 0.02);
  EXPECT_NEAR(rig.state("arm/shoulder/position"), here, 1e-3);
}

TEST(MujocoModes, AJointWhoseControllerStopsIsHeldWhereItIs) {
  for (const char* mode : {"velocity", "effort"}) {
    const Stage stage = arm();
    Rig rig = physics(stage);
    rig.command("arm/shoulder/position") = 0;  // an old command, left behind
    rig.run(0.01);
    const std::string name = std::string("arm/shoulder/") + mode;
    rig.switch_mode({name}, {"arm/shoulder/position"});
    rig.command(name) = mode[0] == 'v' ? 0.5 : -5;
    rig.run(0.3);
    rig.switch_mode({}, {name});
    const double there = rig.state("arm/shoulder/position");
    ASSERT_GT(std::abs(there), 0.1) << mode;
    rig.run(0.5);
    EXPECT_NEAR(rig.state("arm/shoulder/velocity"), 0, 1e-3) << mode;
    EXPECT_NEAR(rig.state("arm/shoulder/position"), there, 0.12) << mode << ": braking from its speed";
  }
}

TEST(MujocoModes, AJumpOfTheSetPointSettlesThere) {
  const Stage stage = arm();
  Rig rig = physics(stage);
  rig.command("arm/shoulder/position") = 0.5;
  rig.run(3);
  EXPECT_NEAR(rig.state("arm/shoulder/position"), 0.5, 1e-4);
  EXPECT_NEAR(rig.state("arm/shoulder/velocity"), 0, 1e-3);
}

TEST(MujocoModes, AJumpOfTheSetPointIsNotOvershot) {
  for (const double effort : {30.0, 150.0})
    for (const bool ramp : {false, true}) {  // all at once, or at 2 rad/s, with a sudden beginning and end
      Stage stage;
      stage.model = two_links(effort);
      stage.scene.gravity = {};
      Rig rig = physics(stage);
      double farthest = 0, command = 0;
      for (int k = 0; k < 3000; ++k) {
        command = ramp ? std::min(1.0, command + 2e-3) : 1.0;
        rig.command("arm/shoulder/position") = command;
        rig.cycle();
        farthest = std::max(farthest, rig.state("arm/shoulder/position"));
      }
      EXPECT_LT(farthest, 1.002) << effort << (ramp ? " ramp" : "");
      EXPECT_NEAR(rig.state("arm/shoulder/position"), 1, 1e-4) << effort << (ramp ? " ramp" : "");
    }
}

TEST(MujocoModes, TheBrakeOfAJointThatNobodyCommandsSlipsAndDoesNotPullBack) {
  for (const double effort : {2.0, 50.0}) {
    Stage stage;
    stage.model = two_links(20);
    stage.model.joints[0].limits.effort = effort;
    stage.scene.gravity = {};
    Rig rig = physics(stage);
    rig.command("arm/elbow/position") = 1;  // its jerk turns the shoulder the other way
    rig.run(3);
    EXPECT_NEAR(rig.state("arm/elbow/position"), 1, 1e-3);
    EXPECT_NEAR(rig.state("arm/shoulder/velocity"), 0, 1e-3);
    if (effort > 10)
      EXPECT_NEAR(rig.state("arm/shoulder/position"), 0, 1e-3) << "the brake holds";
    else
      EXPECT_GT(std::abs(rig.state("arm/shoulder/position")), 0.02) << "it stays where it slipped to";
  }
}

// --- joints
// -----------------------------------------------------------------------------------------------------

TEST(MujocoJoints, TheLimitsOfAJointAreStopsALittleBeyond) {
  Stage stage;
  stage.model = gantry();
  stage.model.joints[0].limits.upper = 0.2;
  Rig rig = physics(stage);
  rig.move({{"arm/x/position", 0.2}}, 0.5);
  rig.run(0.1);
  EXPECT_NEAR(rig.state("arm/x/position"), 0.2, 1e-5) << "the limit itself is free";
  rig.switch_mode({"arm/x/effort"}, {"arm/x/position"});
  rig.command("arm/x/effort") = 50;
  rig.run(1);
  EXPECT_GT(rig.state("arm/x/position"), 0.205);
  EXPECT_LT(rig.state("arm/x/position"), 0.215);
}

TEST(MujocoJoints, WhoStartsBeyondALimitIsNotThrown) {
  Stage stage;
  stage.model = gantry();
  stage.model.joints[0].limits.upper = 0.2;
  stage.start = {0.5, 0, 0};
  Rig rig = physics(stage);
  rig.run(0.2);
  EXPECT_NEAR(rig.state("arm/x/position"), 0.5, 1e-5);
}

/// Two arms of 0.2 m side by side about upright axes; the right one turns as the left one's mirror image,
/// plus 0.1.
description::RobotModel mirrored(const Vec3& axis) {
  using description::JointType;
  description::RobotModel model;
  model.links = {link("base_link"), link("left", 1, {0.1, 0, 0}), link("right", 1, {0.1, 0, 0})};
  model.links[2].collisions = {box({0.02, 0.02, 0.02}, {0.2, 0, 0})};
  auto left = joint("left", JointType::revolute, "base_link", "left", {{0, 0.3, 1}, {}}, axis, 50);
  auto right = joint("right", JointType::revolute, "base_link", "right", {{0, -0.3, 1}, {}}, axis, 50);
  right.mimics = "left";
  right.joint.mimic = description::Mimic{-1, -1.0, 0.1};
  return tie(std::move(model), {left, right});
}

TEST(MujocoJoints, AMimicJointFollowsItsSource) {
  Stage stage;
  stage.model = mirrored({0, 0, 1});
  const double at = 0.1 - 1.0;  // of the right arm when the left one is at 1
  stage.scene.floor = false;
  stage.scene.gravity = {0, 0, 0};
  stage.scene.parts = {cube("cube", {0.2 * std::cos(at), -0.3 + 0.2 * std::sin(at), 1}, 0.03)};
  Rig rig = physics(stage);
  rig.run(0.2);
  ASSERT_EQ(rig.world().finding_count, 0) << rig.findings();
  rig.move({{"arm/left/position", 0.95}}, 0.5);
  EXPECT_NE(rig.findings().find("arm/right touches part cube"), std::string::npos) << rig.findings();
}

TEST(MujocoLinks, OfHardlyAnyInertiaAreTaken) {
  Stage stage;
  stage.model = mirrored({0, 0, 1});
  for (const double small : {1e-9, 1e-15, 1e-20}) {  // kg m²; a rod as thin as a sheet's drawing makes it
    stage.model.links[1].inertial->inertia = {small, 0, 0, 1e-7 + small, 0, 1e-7 + small};
    ASSERT_TRUE(description::plausible(*stage.model.links[1].inertial));
    Rig rig = physics(stage);
    rig.run(0.1);
    EXPECT_NEAR(rig.state("arm/left/position"), 0, 1e-3) << small;
  }
}

TEST(MujocoJoints, AMimicJointCarriesItsOwnWeight) {
  Stage stage;
  stage.model = mirrored({0, 1, 0});
  Rig rig = physics(stage);
  rig.run(1);
  EXPECT_NEAR(rig.state("arm/left/position"), 0, 5e-5);
  EXPECT_NEAR(std::abs(rig.state("arm/left/effort")), kGravity * 0.1, 0.02);
}

// --- what <gazebo> says of links

/// The right arm's box meets the left arm's where both turn inwards.
description::RobotModel crossing() {
  description::RobotModel model = mirrored({0, 0, 1});
  model.links[1].collisions = {box({0.02, 0.02, 0.02}, {0.2, 0, 0})};
  model.joints[0].origin.position.y = 0.1;
  model.joints[1].origin.position.y = -0.1;
  return model;
}

TEST(MujocoLinks, MeetUnlessTheDescriptionSaysThatTheirRobotSparesItself) {
  for (const bool spared : {false, true}) {
    Stage stage;
    stage.model = crossing();
    if (spared) stage.model.links[1].contact.self_collide = false;
    stage.scene.floor = false;
    Rig rig = physics(stage);
    rig.move({{"arm/left/position", -0.5}}, 0.5);
    EXPECT_EQ(rig.findings().find("arm/left touches arm/right") == std::string::npos &&
                  rig.findings().find("arm/right touches arm/left") == std::string::npos,
              spared)
        << rig.findings();
  }
}

/// The corners of a cube of this half edge.
std::vector<Vec3> corners_about(const Vec3& at, double half) {
  std::vector<Vec3> out;
  for (int i = 0; i < 8; ++i)
    out.push_back({at.x + (i & 1 ? half : -half), at.y + (i & 2 ? half : -half), at.z + (i & 4 ? half : -half)});
  return out;
}

/// A mesh of two cubes with a gap between them, in the frame of its link or fixture.
description::Shape two_cubes(const Vec3& at, double apart, double half) {
  description::Shape out;
  out.kind = description::ShapeKind::mesh;
  out.pieces = {corners_about(at - Vec3{0, 0, apart / 2}, half), corners_about(at + Vec3{0, 0, apart / 2}, half)};
  return out;
}

TEST(MujocoMeshes, OfALinkTouchWithEachOfTheirConvexPieces) {
  for (const double apart : {0.0, 0.3}) {  // the other arm's box passes through a gap of 0.28 m
    Stage stage;
    stage.model = crossing();
    const Vec3 at = stage.model.links[1].collisions[0].pose.position;
    stage.model.links[1].collisions = {two_cubes(at, apart, 0.01)};
    stage.scene.floor = false;
    Rig rig = physics(stage);
    rig.move({{"arm/left/position", -0.5}}, 0.5);
    const bool touches = rig.findings().find("arm/left touches arm/right") != std::string::npos ||
                         rig.findings().find("arm/right touches arm/left") != std::string::npos;
    EXPECT_EQ(touches, apart == 0) << rig.findings();
  }
}

TEST(MujocoMeshes, OfAFixtureCarryPartsOnTheirPiecesOnly) {
  for (const double x : {0.0, 0.5}) {
    Stage stage = only(table());
    description::Fixture fixture;
    fixture.name = "stand";
    fixture.pose.position = {0, 0, 0.3};
    description::Shape mesh;
    mesh.kind = description::ShapeKind::mesh;
    mesh.pieces = {corners_about({0, 0, 0}, 0.05)};
    fixture.shapes = {mesh};
    stage.scene.fixtures.push_back(fixture);
    stage.scene.parts = {cube("cube", {x, 0, 0.5}, 0.04, 0.1)};
    Rig rig = physics(stage);
    rig.run(1.0);
    const double z = rig.part(0).pose.position.z;
    if (x == 0)
      EXPECT_NEAR(z, 0.3 + 0.05 + 0.02, 1e-3);
    else
      EXPECT_LT(z, 0.3);
  }
}

TEST(MujocoLinks, HoldOnASlopeAsMuchAsTheyRub) {
  for (const double mu : {0.1, 0.8}) {  // the slope has 0.3 rad, whose tangent is 0.31
    Stage stage;
    stage.model = gantry();
    stage.model.links[0].collisions = {box({0.6, 0.6, 0.02}, {1, 0, 0.5})};
    stage.model.links[0].collisions[0].pose.rotation = pose_xyz_rpy({}, {0, 0.3, 0}).rotation;
    stage.model.links[0].contact.mu1 = mu;
    stage.scene.parts = {cube("cube", {1, 0, 0.5 + 0.03 / std::cos(0.3)})};
    stage.scene.parts[0].friction = 0.01;
    stage.scene.parts[0].start.rotation = stage.model.links[0].collisions[0].pose.rotation;
    Rig rig = physics(stage);
    rig.run(0.5);
    const double slid = rig.part(0).pose.position.x - 1;
    if (mu > 0.31)
      EXPECT_LT(slid, 2e-3);
    else
      EXPECT_GT(slid, 0.05);
  }
}

// --- parts
// ------------------------------------------------------------------------------------------------------

description::Part plank() {
  description::Part out = cube("plank", {});
  out.shape = box({0.12, 0.03, 0.01});
  return out;
}

description::Part can() {
  description::Part out = cube("can", {});
  out.shape.kind = description::ShapeKind::cylinder;
  out.shape.radius = 0.02;
  out.shape.length = 0.1;
  return out;
}

TEST(MujocoParts, APartTumblesTheSameWhoeverElseIsThere) {
  for (description::Part part : {plank(), can()}) {
    description::Scene alone = table();
    alone.feeders = {{"magazine", pose_xyz_rpy({0, 0, 0.4}, {0.4, 0.7, 0.2})}};
    alone.fixtures[0].shapes.push_back(box({0.02, 0.02, 0.2}, {0.03, 0.02, 0.12}));  // sets it spinning
    part.feeder = "magazine";
    alone.parts = {part};
    description::Scene among = alone;
    among.parts = {cube("one", {0.5, 0, 0.02}), cube("two", {0.6, 0, 0.02}), part};
    const Stage first = only(alone), second = only(among);
    Rig a = physics(first), b = physics(second);
    a.run(1);
    b.run(1);
    ASSERT_TRUE(b.part(0).asleep);
    a.command("scene/magazine/feed") = b.command("scene/magazine/feed") = 1;
    double turned = 0;
    for (int k = 0; k < 40; ++k) {
      a.run(0.01);
      b.run(0.01);
      ASSERT_LT(norm(a.part(0).pose.position - b.part(2).pose.position), 1e-7) << part.name << " " << k;
      ASSERT_LT(angle_between(a.part(0).pose.rotation, b.part(2).pose.rotation), 1e-6)
          << part.name << " " << k;
      turned = std::max(turned, angle_between(a.part(0).pose.rotation, alone.feeders[0].pose.rotation));
    }
    EXPECT_GT(turned, 0.5) << part.name << " did not tumble";
  }
}

TEST(MujocoParts, ATowerComesToRestAndSleeps) {
  description::Scene scene = table();
  for (int k = 0; k < 3; ++k)
    scene.parts.push_back(cube("cube_" + std::to_string(k), {0.001 * k, 0, 0.02 + 0.0405 * k}));
  const Stage stage = only(scene);
  Rig rig = physics(stage);
  rig.run(3);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_TRUE(rig.part(k).asleep) << k;
    EXPECT_NEAR(rig.part(k).pose.position.z, 0.02 + 0.04 * static_cast<double>(k), 5e-4);
  }
}

TEST(MujocoParts, AMovingWallPushesWhatIsInItsWay) {
  description::Scene scene = table();
  description::Fixture plate;
  plate.name = "plate";
  plate.shapes = {box({0.1, 0.1, 0.02})};
  plate.pose.position = {0, 0, 0.011};
  plate.mover = "shuttle";
  scene.fixtures.push_back(plate);
  scene.movers = {{"shuttle", {1, 0, 0}, 0, 0.3, 0.2, 1}};
  scene.parts = {cube("cube", {0.15, 0, 0.02})};
  const Stage stage = only(scene);
  Rig rig = physics(stage);
  rig.run(1);
  ASSERT_TRUE(rig.part(0).asleep);
  rig.command("scene/shuttle/position") = 0.2;
  rig.run(2);
  EXPECT_NEAR(rig.part(0).pose.position.x, 0.27, 5e-3);
}

TEST(MujocoParts, APartWhoseMeshHasNoBodyIsRefusedByName) {
  description::Scene scene = table();
  scene.parts = {cube("casting", {})};
  scene.parts[0].shape.kind = description::ShapeKind::mesh;
  const Stage stage = only(scene);
  drivers::MujocoComponent component;
  try {
    component.on_init(stage.context());
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("casting"), std::string::npos) << error.what();
  }
}

/// An angle of two plates, whose origin is in its inner corner: one lies on the table, the other one stands.
description::Part angle(const std::string& name, const Vec3& at) {
  const auto plate = [](const Vec3& low, const Vec3& high) {
    std::vector<Vec3> out;
    for (int i = 0; i < 8; ++i)
      out.push_back({i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z});
    return out;
  };
  description::Part out = cube(name, at);
  out.shape.kind = description::ShapeKind::mesh;
  out.shape.pieces = {plate({0, -0.03, -0.01}, {0.1, 0.03, 0}),
                      plate({-0.01, -0.03, -0.01}, {0, 0.03, 0.06})};
  out.mass = 0.2;
  return out;
}

TEST(MujocoParts, OfAMeshRestOnTheirPiecesAndStayThere) {
  description::Scene scene = table();
  scene.parts = {angle("angle", {0, 0, 0.012}), cube("cube", {0.05, 0, 0.08}, 0.04, 0.1)};
  const Stage stage = only(scene);
  Rig rig = physics(stage);
  rig.run(1.5);
  EXPECT_NEAR(rig.part(0).pose.position.z, 0.01, 1e-3) << "its origin is on top of the lower plate";
  EXPECT_NEAR(rig.part(1).pose.position.z, 0.01 + 0.02, 1e-3)
      << "between the plates, not on a hull around both";
  EXPECT_TRUE(rig.part(0).asleep);
  rig.run(0.5);
  EXPECT_NEAR(rig.part(0).pose.position.z, 0.01, 1e-3) << "asleep it carries, too";
  EXPECT_NEAR(rig.part(1).pose.position.z, 0.03, 1e-3);
}

/// A ramp whose origin is at the foot of its back. The middle of the box around it is not its centre of mass.
TEST(MujocoParts, OfOnePieceStandWhereThePieceIs) {
  description::Scene scene = table();
  scene.parts = {cube("ramp", {0, 0, 0.002})};
  description::Shape ramp;
  ramp.kind = description::ShapeKind::mesh;
  const std::vector<Vec3> corners = {{0, -0.03, 0},  {0, 0.03, 0},     {0.1, -0.03, 0},
                                     {0.1, 0.03, 0}, {0, -0.03, 0.06}, {0, 0.03, 0.06}};
  ramp.pieces = {corners};
  scene.parts[0].shape = ramp;
  const Stage stage = only(scene);
  Rig rig = physics(stage);
  rig.run(0.3);
  EXPECT_FALSE(rig.part(0).asleep);
  EXPECT_NEAR(rig.part(0).pose.position.z, 0, 1e-3);
  EXPECT_NEAR(rig.part(0).pose.position.x, 0, 1e-3);
  EXPECT_LT(norm(to_rotation_vector(rig.part(0).pose.rotation)), 1e-2);
  rig.run(1);
  EXPECT_TRUE(rig.part(0).asleep);
  EXPECT_NEAR(rig.part(0).pose.position.z, 0, 1e-3);
}

TEST(MujocoParts, OfManyPiecesHaveRoomForTheirContacts) {
  description::Scene scene = table();
  for (int i = 0; i < 12; ++i) {
    description::Part row = cube("row_" + std::to_string(i), {0, -0.6 + 0.1 * i, 0.012});
    row.shape.kind = description::ShapeKind::mesh;
    for (int k = 0; k < 8; ++k) row.shape.pieces.push_back(corners_about({0.03 * k, 0, 0}, 0.01));
    row.mass = 0.2;
    scene.parts.push_back(row);
  }
  const Stage stage = only(scene);
  Rig rig = physics(stage);
  rig.run(0.3);
  for (std::size_t i = 0; i < scene.parts.size(); ++i)
    EXPECT_NEAR(rig.part(i).pose.position.z, 0.01, 1e-3) << i;
}

TEST(MujocoParts, KeepTheirShapesWhicheverOfThemMove) {
  // Four parts take four slots or fewer in turn: those that fall later must not get the shape of another one.
  description::Scene scene = table();
  scene.parts = {cube("small", {0, 0.3, 0.02}), angle("angle", {0, 0, 0.012}), cube("large", {0.4, 0, 0.6}),
                 cube("third", {-0.4, 0, 1.2})};
  scene.parts[2].shape.size = {0.1, 0.1, 0.1};
  const Stage stage = only(scene);
  Rig rig = physics(stage);
  rig.run(3);
  EXPECT_NEAR(rig.part(0).pose.position.z, scene.parts[0].shape.size.z / 2, 1e-3);
  EXPECT_NEAR(rig.part(1).pose.position.z, 0.01, 1e-3);
  EXPECT_NEAR(rig.part(2).pose.position.z, 0.05, 1e-3);
  EXPECT_NEAR(rig.part(3).pose.position.z, scene.parts[3].shape.size.z / 2, 1e-3);
}

// --- tools
// ------------------------------------------------------------------------------------------------------

TEST(MujocoCup, PressingIsNotPulling) {
  Stage stage = cell();
  Rig rig = holding(stage);
  rig.move({{"arm/z/position", -0.3637}}, 0.5);  // four millimetres into the table
  rig.run(0.5);
  EXPECT_LT(rig.state("arm/z/effort"), -80) << "presses with more than the cup could pull";
  EXPECT_EQ(rig.state("arm/tool/part_present"), 1);
  rig.move({{"arm/z/position", -0.26}}, 0.5);
  EXPECT_EQ(rig.state("arm/tool/part_present"), 1);
}

TEST(MujocoCup, HoldsAMeshOnAFaceOfItsPieces) {
  Stage stage = cell();
  stage.scene.parts = {cube("cube", {0, 0, 0.02})};
  description::Shape& shape = stage.scene.parts[0].shape;
  shape = {};
  shape.kind = description::ShapeKind::mesh;
  shape.pieces = {corners_about({0, 0, 0}, 0.02), corners_about({0.05, 0, -0.01}, 0.01)};
  Rig rig = holding_the_first(stage);
  EXPECT_EQ(rig.state("arm/tool/part_present"), 1);
  EXPECT_GT(rig.part(0).pose.position.z, 0.05);
  rig.command("arm/tool/vacuum") = 0;
  rig.run(1.5);
  EXPECT_EQ(rig.state("arm/tool/part_present"), 0);
  EXPECT_NEAR(rig.part(0).pose.position.z, 0.02, 2e-3) << "back on the table";
}

TEST(MujocoCup, TheArmCarriesTheWeightOfWhatItHolds) {
  Stage stage = cell();
  Rig rig = holding(stage, 2);
  rig.run(0.5);
  EXPECT_NEAR(rig.state("arm/z/position"), -0.26, 1e-4);
  EXPECT_NEAR(rig.state("arm/z/effort"), (2 + 0.15 + 2) * kGravity, 0.05) << "link, tool and part";
}

TEST(MujocoCup, APartTakenFromAmongOthersMayTouchThemUntilItIsFree) {
  Stage stage = cell();
  stage.scene.parts = {cube("left", {-0.04, 0, 0.02}), cube("right", {0.04, 0, 0.02})};
  Rig rig = holding(stage);
  EXPECT_EQ(rig.world().finding_count, 0) << rig.findings();
  rig.move({{"arm/x/position", 0.04}, {"arm/y/position", 0.1}}, 0.5);
  rig.move({{"arm/z/position", -0.355}}, 0.5);
  EXPECT_EQ(rig.world().finding_count, 0) << rig.findings();
  rig.move({{"arm/y/position", 0.02}}, 0.5);  // sideways into one that it has left
  EXPECT_NE(rig.findings().find("part right"), std::string::npos) << rig.findings();
}

TEST(MujocoFingers, WhatTheyHoldFollowsAlongAndAcrossTheirStroke) {
  for (const char* axis : {"x", "y"}) {
    Stage stage = cell("parallel_gripper");
    Rig rig = gripping(stage);
    const auto in_hand = [&] {
      return rig.part(0).pose.position -
             Vec3{rig.state("arm/x/position"), rig.state("arm/y/position"), rig.state("arm/z/position")};
    };
    const Vec3 before = in_hand();
    const std::string name = std::string("arm/") + axis + "/position";
    double worst = 0;
    for (int k = 0; k < 1000; ++k) {
      rig.command(name) = 0.1 * (1 - std::cos(8e-3 * k));  // up to 6.4 m/s²
      rig.cycle();
      worst = std::max(worst, norm(in_hand() - before));
    }
    EXPECT_LT(worst, 1e-3) << axis;
    EXPECT_EQ(rig.state("arm/tool/part_present"), 1) << axis;
  }
}

TEST(MujocoFingers, TheyDoNotSagToTheSide) {
  Stage stage = cell("parallel_gripper");
  stage.scene.gravity = {0, -5, -8};  // as on a robot that holds its gripper aslant
  Rig rig = gripping(stage);
  const Vec3 before = rig.part(0).pose.position;
  rig.run(3);
  EXPECT_LT(norm(rig.part(0).pose.position - before), 1e-3);
}

TEST(MujocoFingers, TheyCentreWhatTheyGrip) {
  Stage stage = cell("parallel_gripper");
  stage.scene.parts = {cube("cube", {0, 0.003, 0.02}, 0.04, 0.2)};
  Rig rig = physics(stage);
  rig.move({{"arm/z/position", -0.39}}, 0.8);
  rig.command("arm/tool/grip") = 1;
  rig.run(1);
  EXPECT_EQ(rig.state("arm/tool/part_present"), 1);
  EXPECT_NEAR(rig.part(0).pose.position.y, 0, 1e-3) << "one drive moves both";
}

}  // namespace
}  // namespace polyarm::test::mujoco_laws_test
#endif
