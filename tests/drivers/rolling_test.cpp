#ifdef POLYARM_MUJOCO

#include "drivers/mujoco/component.hpp"
#include "tests/drivers/rig.hpp"

namespace polyarm::test::rolling_test {
namespace {

constexpr double kRadius = 0.03, kTrack = 0.1;

description::Shape cylinder(double radius, double length) {
  description::Shape out;
  out.kind = description::ShapeKind::cylinder;
  out.radius = radius;
  out.length = length;
  out.pose = pose_xyz_rpy({}, {M_PI / 2, 0, 0});  // along y
  return out;
}

/// A box with two driven wheels and a ball that slides, on the floor; `steered`: and a wheel that is steered; `arm`:
/// and an arm that reaches below it.
description::RobotModel base(bool steered = false, bool arm = false) {
  using description::JointType;
  description::RobotModel model;
  model.name = "base";
  model.links = {link("chassis", 0.6), link("left", 0.05), link("right", 0.05)};
  description::Shape ball;
  ball.kind = description::ShapeKind::sphere;
  ball.radius = 0.01;
  ball.pose.position = {-0.06, 0, 0.01 - kRadius};
  model.links.push_back(link("caster", 0.02, ball.pose.position));
  model.links[0].inertial = description::Inertial{0.6, {-0.02, 0, 0.01}, {1e-3, 0, 0, 1e-3, 0, 1e-3}};
  for (const std::size_t k : {1u, 2u})
    model.links[k].inertial = description::Inertial{0.05, {}, {2e-5, 0, 0, 3e-5, 0, 2e-5}};
  model.links[3].inertial = description::Inertial{0.02, ball.pose.position, {1e-6, 0, 0, 1e-6, 0, 1e-6}};
  model.links[0].collisions = {box({0.12, 0.07, 0.03}, {-0.02, 0, 0.02})};
  model.links[1].collisions = model.links[2].collisions = {cylinder(kRadius, 0.015)};
  model.links[3].collisions = {ball};
  model.links[3].contact.mu1 = 0.02;
  std::vector<description::NamedJoint> joints = {
      joint("left", JointType::continuous, "chassis", "left", {{0, kTrack / 2, 0}, {}}, {0, 1, 0}, 2),
      joint("right", JointType::continuous, "chassis", "right", {{0, -kTrack / 2, 0}, {}}, {0, 1, 0}, 2),
      joint("fixed", JointType::fixed, "chassis", "caster", {})};
  if (steered) {
    model.links.push_back(link("knuckle", 0.1));
    model.links.push_back(link("front", 0.05));
    model.links.back().collisions = {cylinder(kRadius, 0.015)};
    joints.push_back(joint("steer", JointType::revolute, "chassis", "knuckle", {{0.1, 0, 0}, {}}, {0, 0, 1}, 2));
    joints.push_back(joint("roll", JointType::continuous, "knuckle", "front", {}, {0, 1, 0}, 2));
  }
  if (arm) {
    model.links.push_back(link("mast", 0.1));
    model.links.push_back(link("arm", 0.1));
    model.links.back().collisions = {box({0.02, 0.02, 0.2})};
    joints.push_back(joint("turn", JointType::revolute, "chassis", "mast", {{-0.3, 0, 0}, {}}, {0, 0, 1}, 2));
    joints.push_back(joint("shoulder", JointType::revolute, "mast", "arm", {}, {0, 1, 0}, 2));
  }
  return tie(std::move(model), std::move(joints));
}

class Rolling {
 public:
  explicit Rolling(description::Scene scene = {}) {
    stage.model = base();
    stage.scene = std::move(scene);
    stage.base.position = {0, 0, kRadius};
    hardware::ComponentContext context = stage.context();
    description::HardwareInfo block;
    block.parameters["base"] = "free";
    context.robots[0].hardware = {block};
    rig = std::make_unique<Rig>(std::make_unique<drivers::MujocoComponent>(), context);
    rig->switch_mode({"arm/left/velocity", "arm/right/velocity"}, {});
    drive(0, 0, 0.2);
  }
  void drive(double left, double right, double time) {
    rig->command("arm/left/velocity") = left;
    rig->command("arm/right/velocity") = right;
    rig->run(time);
  }
  double x() const { return rig->state("arm/base/position.x"); }
  double y() const { return rig->state("arm/base/position.y"); }
  double z() const { return rig->state("arm/base/position.z"); }
  double heading() const {
    return 2 * std::atan2(rig->state("arm/base/orientation.z"), rig->state("arm/base/orientation.w"));
  }
  Stage stage;
  std::unique_ptr<Rig> rig;
};

TEST(Rolling, AFreeBaseStandsOnItsWheels) {
  Rolling base;
  base.drive(0, 0, 1);
  EXPECT_NEAR(base.z(), kRadius, 1e-3);
  EXPECT_NEAR(base.x(), 0, 1e-3);
  EXPECT_NEAR(base.heading(), 0, 1e-2);
  EXPECT_EQ(base.rig->findings(), "") << "standing on the floor is not a collision";
}

TEST(Rolling, WheelsThatTurnCarryItAlong) {
  Rolling base;
  base.drive(5, 5, 2);
  const double rolled = kRadius * base.rig->state("arm/left/position");
  EXPECT_NEAR(base.rig->state("arm/left/velocity"), 5, 0.05);
  EXPECT_GT(rolled, kRadius * 9);
  EXPECT_NEAR(base.x(), rolled, 0.03 * rolled) << "without much slip";
  EXPECT_NEAR(base.y(), 0, 0.01);
  EXPECT_EQ(base.rig->findings(), "");
}

TEST(Rolling, WheelsAgainstEachOtherTurnIt) {
  Rolling base;
  base.drive(-2, 2, 1.5);
  EXPECT_NEAR(base.heading(), 2 * kRadius * 3 / kTrack, 0.1);
  EXPECT_NEAR(std::hypot(base.x(), base.y()), 0, 0.01);
}

/// The same base, bolted down: a steered wheel reaches into the floor, which is no contact; an arm does, too.
TEST(Rolling, WheelsOfABaseThatDoesNotStandFreeMayTouchTheFloor) {
  for (const bool low : {false, true}) {
    Stage stage;
    stage.model = base(true, low);
    stage.base.position = {0, 0, kRadius - 0.002};
    Rig rig(std::make_unique<drivers::MujocoComponent>(), stage.context());
    rig.run(0.2);
    EXPECT_EQ(rig.findings().find("floor") == std::string::npos, !low) << rig.findings();
  }
}

/// Wheels of boxes: only the controller says that they are wheels.
TEST(Rolling, WheelsThatAControllerNamesMayTouchTheFloorWhateverTheirShape) {
  for (const bool named : {false, true}) {
    Stage stage;
    stage.model = base(true);
    for (const char* wheel : {"left", "right", "front"})
      stage.model.links[static_cast<std::size_t>(stage.model.find_link(wheel))].collisions = {
          box({2 * kRadius, 0.015, 2 * kRadius})};
    stage.base.position = {0, 0, kRadius - 0.002};
    hardware::ComponentContext context = stage.context();
    description::HardwareInfo block;
    if (named)
      for (const char* joint : {"left", "right", "steer"})
        block.parameters["wheel_joints"] += std::to_string(stage.model.find_joint(joint)) + " ";
    context.robots[0].hardware = {block};
    Rig rig(std::make_unique<drivers::MujocoComponent>(), context);
    rig.run(0.2);
    EXPECT_EQ(rig.findings().find("floor") == std::string::npos, named) << rig.findings();
  }
}

TEST(Rolling, AWallStopsItAndIsTold) {
  description::Scene scene;
  description::Fixture wall;
  wall.name = "wall";
  wall.shapes = {box({0.02, 1, 0.3})};
  wall.pose.position = {0.25, 0, 0.15};
  scene.fixtures = {wall};
  Rolling base(scene);
  base.drive(5, 5, 3);
  EXPECT_LT(base.x(), 0.25);
  EXPECT_NE(base.rig->findings().find("wall"), std::string::npos);
}

}  // namespace
}  // namespace polyarm::test::rolling_test

#endif
