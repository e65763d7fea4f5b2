/// `drive` to a pose of bases that steer, in lock-step on the mock.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "polyarm/setup/cell_file.hpp"
#include "polyarm/wheels/base_controller.hpp"
#include "tests/support/folder.hpp"
#include "tests/support/lock_step_cell.hpp"

namespace polyarm::cell::steered {
namespace {

using test::Folder;
using test::LockStepCell;
constexpr double kDegree = std::numbers::pi / 180;

/// A car, 1 m long and 0.5 m wide, on two more wheels that nothing drives; its rear axle is 0.15 m before its
/// back. Joints steer by ±1 rad.
std::string car_urdf(const std::vector<std::string>& wheels, const std::vector<std::string>& steering) {
  std::string links =
      "<link name=\"base_link\"><collision><origin xyz=\"0.35 0 0.3\"/><geometry><box size=\"1 0.5 0.3\"/>"
      "</geometry></collision></link>";
  for (const char* side : {"0.2", "-0.2"})
    links += fmt::format(
        "<link name=\"free{0}_link\"><collision><geometry><sphere "
        "radius=\"0.1\"/></geometry></collision></link>"
        "<joint name=\"free{0}\" type=\"continuous\"><origin xyz=\"0 {0} 0.1\"/><parent link=\"base_link\"/>"
        "<child link=\"free{0}_link\"/><axis xyz=\"0 1 0\"/><limit velocity=\"50\" effort=\"30\"/></joint>",
        side);
  std::string hardware;
  const auto add = [&](const std::string& name, const char* type, const char* axis, const char* limit,
                       const char* command) {
    links += "<link name=\"" + name + "_link\"/><joint name=\"" + name + "\" type=\"" + type +
             "\"><parent link=\"base_link\"/><child link=\"" + name + "_link\"/><axis xyz=\"" + axis +
             "\"/><limit " + limit + "/></joint>";
    hardware += "<joint name=\"" + name + "\"><command_interface name=\"" + command +
                "\"/><state_interface name=\"position\"/><state_interface name=\"velocity\"/></joint>";
  };
  for (const std::string& name : wheels)
    add(name, "continuous", "0 1 0", "velocity=\"50\" effort=\"30\"", "velocity");
  for (const std::string& name : steering)
    add(name, "revolute", "0 0 1", "lower=\"-1\" upper=\"1\" velocity=\"3\" effort=\"30\"", "position");
  return "<robot name=\"car\">" + links +
         "<ros2_control name=\"Car\" "
         "type=\"system\"><hardware><plugin>mock_components/GenericSystem</plugin>"
         "<param name=\"calculate_dynamics\">true</param></hardware>" +
         hardware + "</ros2_control></robot>\n";
}

struct Kind {
  const char* name;
  std::vector<std::string> wheels, steering;
  std::string controller;
};

std::string manager_of(const std::string& type) {
  return "controller_manager:\n  ros__parameters: {update_rate: 100, car: {type: " + type +
         "}}\ncar:\n  ros__parameters:\n";
}

std::vector<Kind> kinds() {
  const std::string limits = "    linear.x: {max_velocity: 0.6, max_acceleration: 0.6}\n";
  return {{"Tricycle",
           {"right", "left"},
           {"front"},
           manager_of("tricycle_steering_controller/TricycleSteeringController") +
               "    traction_joints_names: [right, left]\n    steering_joints_names: [front]\n"
               "    wheelbase: 0.6\n    traction_track_width: 0.4\n    traction_wheels_radius: 0.1\n" +
               limits},
          {"TricycleOpenLoop",
           {"right", "left"},
           {"front"},
           manager_of("tricycle_steering_controller/TricycleSteeringController") +
               "    traction_joints_names: [right, left]\n    steering_joints_names: [front]\n"
               "    open_loop: true\n"
               "    wheelbase: 0.6\n    traction_track_width: 0.4\n    traction_wheels_radius: 0.1\n" +
               limits},
          {"Ackermann",
           {"right", "left"},
           {"front_right", "front_left"},
           manager_of("ackermann_steering_controller/AckermannSteeringController") +
               "    traction_joints_names: [right, left]\n"
               "    steering_joints_names: [front_right, front_left]\n"
               "    wheelbase: 0.6\n    traction_track_width: 0.4\n    steering_track_width: 0.4\n"
               "    traction_wheels_radius: 0.1\n" +
               limits},
          {"FrontWheelDrive",
           {"front_wheel"},
           {"front"},
           manager_of("tricycle_controller/TricycleController") +
               "    traction_joint_name: front_wheel\n    steering_joint_name: front\n"
               "    wheelbase: 0.6\n    wheel_radius: 0.1\n"
               "    traction: {max_velocity: 6.0, max_acceleration: 6.0}\n"}};
}

struct Box {
  double x, y, half_x, half_y;
};

class SteeredBases : public ::testing::TestWithParam<Kind> {
 protected:
  SteeredBases() {
    hardware::register_driver(
        "mock", [] { return std::unique_ptr<hardware::Component>(new drivers::MockComponent); });
  }
  void start(const std::string& program, std::vector<Box> obstacles = {}) {
    boxes = std::move(obstacles);
    std::string scene = "polyarm: scene/1\nfloor: {height: 0}\n";
    if (!boxes.empty()) scene += "fixtures:\n";
    for (std::size_t k = 0; k < boxes.size(); ++k)
      scene += fmt::format("  box{}: {{box: [{}, {}, 1], at: [{}, {}, 0.5]}}\n", k, 2 * boxes[k].half_x,
                           2 * boxes[k].half_y, boxes[k].x, boxes[k].y);
    folder.write("car.urdf", car_urdf(GetParam().wheels, GetParam().steering));
    folder.write("controllers.yaml", GetParam().controller);
    folder.write("go.script", program);
    folder.write("scene.yaml", scene);
    folder.write("cell.yaml",
                 "polyarm: cell/1\nrobots:\n  car: {model: car.urdf, hardware: mock}\nscene: scene.yaml\n"
                 "controllers: controllers.yaml\nprogram: go\n");
    cell = std::make_unique<LockStepCell>(read_cell_file(folder.path()));
  }
  controllers::BaseController& base() {
    return dynamic_cast<controllers::BaseController&>(*cell->cell().loop().controllers().find("car"));
  }
  const controllers::PlanarOdometry& place() { return base().odometry(); }
  bool ended() { return cell->cell().program()->ended(); }
  double now() { return seconds(cell->cell().loop().cycle().time); }
  std::string state() { return cell->result({{"request", "health"}})["state"]; }
  Problem failure() { return cell->cell().program()->status().problem.value_or(Problem{}); }
  /// How far the car is from the nearest box: points along its outline.
  double gap() {
    double out = 1e9;
    const double c = std::cos(place().heading()), s = std::sin(place().heading());
    for (double u = 0; u < 4; u += 0.02) {  // around, a side each
      const double t = u - std::floor(u);
      const double x = u < 1   ? t
                       : u < 2 ? 1
                       : u < 3 ? 1 - t
                               : 0,
                   y = u < 1   ? 0
                       : u < 2 ? t
                       : u < 3 ? 1
                               : 1 - t;
      const double ahead = -0.15 + x, left = -0.25 + 0.5 * y;
      const double at_x = place().x() + c * ahead - s * left, at_y = place().y() + s * ahead + c * left;
      for (const Box& box : boxes)
        out = std::min(out, std::hypot(std::max(0.0, std::abs(at_x - box.x) - box.half_x),
                                       std::max(0.0, std::abs(at_y - box.y) - box.half_y)));
    }
    return out;
  }
  void finish(double most = 120) {
    nearest = 1e9;
    while (!ended() && now() < most && state() == "running")
      for (int k = 0; k < 10 && !ended(); ++k) {
        cell->tick();
        if (k == 0) nearest = std::min(nearest, gap());
      }
    ASSERT_TRUE(ended()) << state() << ": " << cell->cell().stop_cause().what;
  }
  void expect_at(double x, double y, double heading) {
    EXPECT_FALSE(cell->cell().program()->failed()) << failure().text();
    EXPECT_LT(std::hypot(place().x() - x, place().y() - y), 0.011);
    EXPECT_NEAR(std::remainder(place().heading() - heading, 2 * std::numbers::pi), 0, 1.1 * kDegree);
  }

  Folder folder;
  std::unique_ptr<LockStepCell> cell;
  std::vector<Box> boxes;
  double nearest = 0;  ///< of finish()
};

TEST_P(SteeredBases, GoAroundAWallToTheirPose) {
  start("drive pose(4m, 0, 0, 0, 0, 90deg)\n", {{2, 0, 0.05, 1}});
  finish();
  expect_at(4, 0, 90 * kDegree);
  EXPECT_GT(nearest, 0.003);
}

TEST_P(SteeredBases, BackIntoABayAndComeOutAgain) {
  // 0.2 m more than the car at both sides, and a wall at its end.
  start("drive pose(0, -2m, 0, 0, 0, 90deg)\ndrive pose()\n",
        {{0.5, -1.9, 0.05, 0.6}, {-0.5, -1.9, 0.05, 0.6}, {0, -2.4, 0.5, 0.05}});
  finish();
  expect_at(0, 0, 0);
  EXPECT_GT(nearest, 0.003);
}

TEST_P(SteeredBases, MovedBesideTheirWayTheyLookForAnotherOne) {
  start("drive pose(3m, 1m, 0, 0, 0, 90deg)\n");
  while (place().x() < 1 && now() < 30) cell->tick();
  base().receive("set_odometry", controllers::Numbers{{place().x(), place().y() - 0.5, place().heading()}},
                 false);
  finish();
  expect_at(3, 1, 90 * kDegree);
}

TEST_P(SteeredBases, StopBeforeWhatCameIntoTheirArc) {
  start("drive pose(2m, 2m, 0, 0, 0, 90deg)\n");
  while (place().x() < 0.6 && now() < 30) cell->tick();
  ASSERT_LT(now(), 30);
  boxes = {{2, 1.6, 0.3, 0.05}};
  description::Fixture box;
  box.name = "late";
  box.shapes.emplace_back().size = {0.6, 0.1, 1};
  box.pose.position = {2, 1.6, 0.5};
  cell->cell().in().guards->set_more({box});
  nearest = 1e9;
  for (int k = 0; k < 1500; ++k) {
    cell->tick();
    nearest = std::min(nearest, gap());
  }
  EXPECT_EQ(state(), "held");
  EXPECT_GT(nearest, 0.003);
  EXPECT_LT(nearest, 0.5) << "it comes near";
}

TEST_P(SteeredBases, AmongRandomPostsTheyAreThereOrSayThatThereIsNoWay) {
  std::mt19937_64 engine(7);
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine);
  };
  int there = 0;
  for (int round = 0; round < 5; ++round) {
    std::vector<Box> posts;
    while (posts.size() < 6) {
      const Box post{between(-3, 3), between(-3, 3), between(0.05, 0.4), between(0.05, 0.4)};
      if (std::hypot(post.x, post.y) > 1.6) posts.push_back(post);
    }
    const double x = between(-3, 3), y = between(-3, 3), heading = between(-180, 180);
    start(fmt::format("drive pose({}m, {}m, 0, 0, 0, {}deg)\n", x, y, heading), posts);
    finish();
    SCOPED_TRACE(round);
    EXPECT_GT(nearest, 0.003);
    if (cell->cell().program()->failed()) {
      EXPECT_TRUE(failure().code == "no-way" || failure().code == "goal-in-contact") << failure().text();
      continue;
    }
    expect_at(x, y, heading * kDegree);
    ++there;
  }
  EXPECT_GE(there, 2);
}

INSTANTIATE_TEST_SUITE_P(All, SteeredBases, ::testing::ValuesIn(kinds()),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace polyarm::cell::steered
