#ifdef POLYARM_MUJOCO

#include <array>

#include "drivers/mujoco/component.hpp"
#include "tests/drivers/rig.hpp"

namespace polyarm::test::riding_test {
namespace {

constexpr double kHalfLength = 4;  // m
constexpr double kNoJump = 0.005;  // m/s: a contact point more or less changes a part's velocity by less

description::Scene belt() {
  description::Scene out;
  out.floor_height = -0.75;
  out.kinds = {"cube"};
  description::Belt line;
  line.name = "line";
  line.half_width = 0.2;
  line.pose.rotation = from_axis_angle({0, 0, 1}, M_PI / 2);  // as in a cell: the numbers are not exact
  description::Fixture body;
  body.name = body.belt = "line";
  body.shapes = {box({2 * kHalfLength, 0.4, 0.04}, {0, 0, -0.02})};
  body.pose = line.pose;
  out.belts = {line};
  out.fixtures = {body};
  return out;
}

description::Shape upright(description::ShapeKind kind, double radius, double length) {
  description::Shape out;
  out.kind = kind;
  out.radius = radius;
  out.length = length;
  return out;
}

/// Boxes and cylinders of several sizes, 0.15 m apart, flat on the belt and turned about the vertical.
void put_parts(description::Scene& scene, double turn) {
  const std::array shapes = {box({0.03, 0.03, 0.03}), box({0.06, 0.03, 0.02}), box({0.04, 0.05, 0.06}),
                             upright(description::ShapeKind::cylinder, 0.02, 0.03), box({0.12, 0.05, 0.01})};
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    description::Part part;
    part.name = "part_" + std::to_string(i);
    part.kind = "cube";
    part.shape = shapes[i];
    part.mass = 0.05;
    const double height = shapes[i].kind == description::ShapeKind::box ? shapes[i].size.z : shapes[i].length;
    part.start = {
        {0.01 * static_cast<double>(i), -kHalfLength + 0.3 + 0.15 * static_cast<double>(i), height / 2},
        from_axis_angle({0, 0, 1}, turn + 0.4 * static_cast<double>(i))};
    scene.parts.push_back(part);
  }
}

struct Ride {
  double speed, turn;
};
class Riding : public testing::TestWithParam<Ride> {};

TEST_P(Riding, PartsStayInTheirPlacesOnTheBelt) {
  Stage stage;
  stage.robot = false;
  stage.scene = belt();
  put_parts(stage.scene, GetParam().turn);
  Rig rig(std::make_unique<drivers::MujocoComponent>(), stage.context());
  rig.command("scene/line/speed") = GetParam().speed;
  rig.run(1);  // the belt has its speed, and so have the parts
  const std::size_t parts = stage.scene.parts.size();
  std::vector<Pose> from;
  for (std::size_t i = 0; i < parts; ++i) from.push_back(rig.part(i).pose);
  const double begin = rig.state("scene/line/position");
  for (int k = 0; k < 10'000; ++k) {
    rig.cycle();
    const double travel = rig.state("scene/line/position") - begin;
    for (std::size_t i = 0; i < parts; ++i) {
      const Pose at = rig.part(i).pose;
      const Vec3 off = at.position - from[i].position;
      ASSERT_NEAR(rig.part(i).linear_velocity.y, GetParam().speed, kNoJump + 0.02 * GetParam().speed)
          << "part " << i << " at " << rig.now() << " s";
      ASSERT_NEAR(off.x, 0, 1e-4) << "sideways, part " << i << " at " << rig.now() << " s";
      ASSERT_NEAR(off.z, 0, 1e-4) << "upwards, part " << i << " at " << rig.now() << " s";
      ASSERT_NEAR(off.y, travel, 1e-3) << "along the belt, part " << i << " at " << rig.now() << " s";
      ASSERT_LT(norm(to_rotation_vector(inverse(from[i].rotation) * at.rotation)), 1e-3) << "part " << i;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Speeds, Riding,
                         testing::Values(Ride{0.05, 0}, Ride{0.1, 0.2}, Ride{0.2, 0.7}, Ride{0.3, 1.5},
                                         Ride{0.3, 2.9}, Ride{0.5, -0.3}, Ride{0.5, M_PI / 4}));

/// The wall of a bin in a belt, the next belt at its end, and a stop on a mover do not stop its surface.
TEST(Riding, WhatReachesIntoABeltDoesNotStopIt) {
  Stage stage;
  stage.robot = false;
  stage.scene = belt();
  description::Fixture wall;
  wall.name = "wall";
  wall.shapes = {box({0.05, 0.05, 0.3})};
  wall.pose.position = {0.18, 1, 0};
  description::Mover mover;
  mover.name = "stop";
  mover.axis = {0, 0, 1};
  description::Fixture stop = wall;
  stop.name = "stop", stop.mover = "stop";
  stop.pose.position = {-0.18, 1, 0};
  description::Belt next = stage.scene.belts.front();
  next.name = "next";
  next.pose.position = {0, 2 * kHalfLength - 0.01, 0};
  description::Fixture body = stage.scene.fixtures.front();
  body.name = body.belt = "next";
  body.pose = next.pose;
  stage.scene.belts.push_back(next);
  stage.scene.movers = {mover};
  stage.scene.fixtures.insert(stage.scene.fixtures.end(), {wall, stop, body});
  put_parts(stage.scene, 0.3);
  Rig rig(std::make_unique<drivers::MujocoComponent>(), stage.context());
  rig.command("scene/line/speed") = 0.3;
  rig.run(1);
  const double from = rig.part(0).pose.position.y, begin = rig.state("scene/line/position");
  rig.run(3);
  EXPECT_NEAR(rig.part(0).pose.position.y - from, rig.state("scene/line/position") - begin, 2e-3);
}

/// MuJoCo 2.2 throws such cubes away without the check of its contacts between boxes.
TEST(Riding, TurnedCubesLieStillOnATable) {
  Stage stage;
  stage.robot = false;
  stage.scene = table();
  for (int i = 0; i < 60; ++i) {
    description::Part part =
        cube("cube_" + std::to_string(i), {-0.8 + 0.15 * (i % 10), -0.8 + 0.15 * (i / 10), 0.02});
    part.start.rotation = from_axis_angle({0, 0, 1}, 0.1 * i);
    stage.scene.parts.push_back(part);
  }
  Rig rig(std::make_unique<drivers::MujocoComponent>(), stage.context());
  double fastest = 0;
  for (int k = 0; k < 1000; ++k) {
    rig.cycle();
    for (std::size_t i = 0; i < stage.scene.parts.size(); ++i)
      fastest = std::max(fastest, norm(rig.part(i).linear_velocity));
  }
  EXPECT_LT(fastest, 0.02);
}

/// Contacts of a thin part are true although their points are above the part.
TEST(Riding, ASheetComesOutOfTheTableThatItIsDeepIn) {
  Stage stage;
  stage.robot = false;
  stage.scene = table();
  description::Part sheet = cube("sheet", {0, 0, -0.005});
  sheet.shape = box({0.1, 0.1, 0.001});
  stage.scene.parts = {sheet};
  Rig rig(std::make_unique<drivers::MujocoComponent>(), stage.context());
  rig.run(3);
  EXPECT_NEAR(rig.part(0).pose.position.z, 0.0005, 1e-3);
}

}  // namespace
}  // namespace polyarm::test::riding_test

#endif
