/// `drive` to a pose, in lock-step on the mock.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>

#include "polyarm/cell/check.hpp"
#include "polyarm/setup/cell_file.hpp"
#include "polyarm/wheels/base_controller.hpp"
#include "tests/support/folder.hpp"
#include "tests/support/lock_step_cell.hpp"

namespace polyarm::cell {
namespace {

using test::Folder;
using test::LockStepCell;
constexpr double kPi = std::numbers::pi;

constexpr const char* kBaseUrdf = R"(<robot name="base">
<link name="base_link"><collision><origin xyz="0.05 0 0.25"/><geometry><box size="0.5 0.3 0.3"/></geometry></collision></link>
<link name="left_link"/><joint name="left" type="continuous"><origin xyz="0 0.15 0.1"/><parent link="base_link"/>
<child link="left_link"/><axis xyz="0 1 0"/><limit velocity="50" effort="30"/></joint>
<link name="right_link"/><joint name="right" type="continuous"><origin xyz="0 -0.15 0.1"/><parent link="base_link"/>
<child link="right_link"/><axis xyz="0 1 0"/><limit velocity="50" effort="30"/></joint>
<ros2_control name="Base" type="system"><hardware><plugin>mock_components/GenericSystem</plugin>
<param name="calculate_dynamics">true</param></hardware>
<joint name="left"><command_interface name="velocity"/><state_interface name="position"/><state_interface name="velocity"/></joint>
<joint name="right"><command_interface name="velocity"/><state_interface name="position"/><state_interface name="velocity"/></joint>
</ros2_control></robot>
)";

constexpr const char* kBaseControllers = R"(
controller_manager:
  ros__parameters: {update_rate: 100, base: {type: diff_drive_controller/DiffDriveController}}
base:
  ros__parameters:
    left_wheel_names: [left]
    right_wheel_names: [right]
    wheel_separation: 0.3
    wheel_radius: 0.1
    linear.x: {max_velocity: 0.5, max_acceleration: 1.0}
    angular.z: {max_velocity: 1.5, max_acceleration: 4.0}
)";

constexpr const char* kWallAhead = "  wall: {box: [0.1, 1.4, 1], at: [1.2, 0, 0.5]}\n";

class BaseWaysOfPrograms : public ::testing::Test {
 protected:
  BaseWaysOfPrograms() {
    hardware::register_driver(
        "mock", [] { return std::unique_ptr<hardware::Component>(new drivers::MockComponent); });
  }
  CellFile file(const std::string& program, const std::string& fixtures, const std::string& more = {}) {
    folder.write("base.urdf", kBaseUrdf);
    folder.write("controllers.yaml", kBaseControllers);
    folder.write("go.script", program);
    folder.write("scene.yaml", "polyarm: scene/1\nfloor: {height: 0}\n" +
                                   (fixtures.empty() ? "" : "fixtures:\n" + fixtures));
    folder.write("cell.yaml", "polyarm: cell/1\nrobots:\n  base: {model: base.urdf, hardware: mock" + more +
                                  "}\nscene: scene.yaml\ncontrollers: controllers.yaml\nprogram: go\n");
    return read_cell_file(folder.path());
  }
  void start(const std::string& program, const std::string& fixtures = "", const std::string& more = {}) {
    cell = std::make_unique<LockStepCell>(file(program, fixtures, more));
  }
  const controllers::PlanarOdometry& place() {
    return dynamic_cast<controllers::BaseController&>(*cell->cell().loop().controllers().find("base"))
        .odometry();
  }
  bool ended() { return cell->cell().program()->ended(); }
  double now() { return seconds(cell->cell().loop().cycle().time); }
  Problem failure() { return cell->cell().program()->status().problem.value_or(Problem{}); }
  void finish(double most = 60) {
    while (!ended() && now() < most) {
      cell->tick();
      aside = std::max(aside, std::abs(place().y()));
    }
    ASSERT_TRUE(ended());
  }
  void expect_at(double x, double y, double heading) {
    EXPECT_FALSE(cell->cell().program()->failed()) << failure().text();
    EXPECT_NEAR(place().x(), x, 0.003);
    EXPECT_NEAR(place().y(), y, 0.003);
    EXPECT_NEAR(std::remainder(place().heading() - heading, 2 * kPi), 0, 0.006);
  }
  std::string checked(const std::string& program, const std::string& fixtures) {
    file(program, fixtures);
    std::string out;
    for (const Problem& problem : check(folder.path(), {}, description::Catalogue({}), {}).problems)
      if (problem.severity == Severity::error) out += problem.text() + "\n";
    return out;
  }

  Folder folder;
  std::unique_ptr<LockStepCell> cell;
  double aside = 0;  ///< how far it went to the side
};

TEST_F(BaseWaysOfPrograms, ItGoesAroundAWallToItsPose) {
  start("drive pose(2.4m, 0, 0, 0, 0, 90deg)\nlog(here().x)\n", kWallAhead);
  finish();
  expect_at(2.4, 0, kPi / 2);
  EXPECT_GT(aside, 0.8) << "the wall ends at 0.7 m";
  EXPECT_LT(aside, 1.3);
}

TEST_F(BaseWaysOfPrograms, PosesAreInTheWorldOrInAFrameWhereverTheBaseBegins) {
  start("drive pose(0.5m), frame pose(2m, 1m, 0, 0, 0, 90deg)\n", "", ", at: [1, 1, 0], rpy: [0, 0, 90deg]");
  finish();
  // World: (2, 1.5) with heading 90°. The odometry begins at (1, 1) with the same heading.
  expect_at(0.5, -1, 0);
}

TEST_F(BaseWaysOfPrograms, HereIsWhereTheBaseIs) {
  start("drive pose(1m, 0.5m, 0, 0, 0, 90deg)\nlet p = here()\ndrive pose()\ndrive p\n");
  finish();
  expect_at(1, 0.5, kPi / 2);
}

TEST_F(BaseWaysOfPrograms, HeldOnItsWayItGoesOnAfterwards) {
  start("drive pose(2.4m, 0, 0, 0, 0, 90deg)\n", kWallAhead);
  while (place().x() < 0.4 && now() < 30) cell->tick();
  cell->result({{"request", "control.hold"}});
  cell->run(2);
  const double x = place().x();
  cell->run(1);
  EXPECT_EQ(place().x(), x);
  cell->result({{"request", "control.resume"}});
  finish();
  expect_at(2.4, 0, kPi / 2);
}

TEST_F(BaseWaysOfPrograms, MovedDuringAHoldItLooksForAnotherWay) {
  start("drive pose(2.4m, 0, 0, 0, 0, 90deg)\n", kWallAhead);
  while (place().x() < 0.4 && now() < 30) cell->tick();
  cell->result({{"request", "control.hold"}});
  cell->run(2);
  auto& base = dynamic_cast<controllers::BaseController&>(*cell->cell().loop().controllers().find("base"));
  base.receive("set_odometry", controllers::Numbers{{0, -1, 0}}, false);
  cell->run(0.1);
  EXPECT_NEAR(place().y(), -1, 1e-6);
  cell->result({{"request", "control.resume"}});
  finish();
  expect_at(2.4, 0, kPi / 2);
}

TEST_F(BaseWaysOfPrograms, ASpeedLimitsLinesOrTurns) {
  start("drive pose(1m, 1m), speed 0.2m/s\ndrive pose(), speed 20deg/s\n");
  double linear = 0, angular = 0;
  const auto watch = [&](int line) {
    linear = angular = 0;
    while (!ended() && cell->cell().program()->status().where.line == line && now() < 60) {
      const double x = place().x(), y = place().y(), heading = place().heading();
      cell->run(0.01);
      linear = std::max(linear, std::hypot(place().x() - x, place().y() - y) / 0.01);
      angular = std::max(angular, std::abs(place().heading() - heading) / 0.01);
    }
  };
  cell->run(0.1);
  watch(1);
  EXPECT_LT(linear, 0.21);
  EXPECT_GT(angular, 0.8);
  watch(2);
  EXPECT_GT(linear, 0.4);
  EXPECT_LT(angular, 25 * kPi / 180);
  expect_at(0, 0, 0);
}

TEST_F(BaseWaysOfPrograms, WithoutAWayTheLineFailsAndCheckSaysSoBefore) {
  const std::string inside = "drive 100mm\ndrive pose(1.2m, 0)\n";
  start(inside, kWallAhead);
  finish();
  EXPECT_EQ(failure().code, "goal-in-contact");
  EXPECT_NE(failure().text().find("base/base_link touches fixture wall there"), std::string::npos)
      << failure().text();
  EXPECT_NE(checked(inside, kWallAhead).find("go.script:2:1: error: no way to (1.200, 0.000) m"),
            std::string::npos)
      << checked(inside, kWallAhead);
  EXPECT_EQ(checked("drive pose(2.4m)\ndrive pose()\n", kWallAhead), "");
}

TEST_F(BaseWaysOfPrograms, CheckKeepsOnlyTheHeadingOfAPose) {
  EXPECT_EQ(checked("drive pose(1m, 0, 0, 180deg, 0, 0)\nturn 90deg\ndrive 1m\ndrive pose()\n",
                    "  post: {box: [0.2, 0.2, 1], at: [1, -1, 0.5]}\n"),
            "");
}

TEST_F(BaseWaysOfPrograms, CheckEndsAtItsLimitOfMoves) {
  file("for i in 1 .. 100000\n  drive pose(0.2m)\n  drive pose()\nend\n", "");
  const auto found = check(folder.path(), {}, description::Catalogue({}), {});
  EXPECT_GT(found.moves, 400u);
  EXPECT_LT(found.moves, 1000u);
}

TEST_F(BaseWaysOfPrograms, AfterAnErrorThatTheProgramCatchesTheBaseStandsWhereItWas) {
  const std::string program =
      "try\n  drive pose(1.2m, 0)\non error e\n  log(e.text)\nend\ndrive pose(0.2m)\n";
  EXPECT_EQ(checked(program, kWallAhead), "");
}

TEST_F(BaseWaysOfPrograms, ItDocksAheadOfTwoPlaces) {
  start("include \"polyarm:base\"\ndock_at(pose(2m, 0.4m), pose(2m, 0.2m), away = 600mm, gap = 320mm)\n",
        "  dock: {box: [0.2, 0.6, 0.5], at: [2.11, 0.3, 0.25]}\n");
  finish();
  expect_at(2 - 0.32, 0.3, 0);
}

TEST_F(BaseWaysOfPrograms, ItUndocksBackToWhereItBeganToDock) {
  start("include \"polyarm:base\"\nundock_to(pose(), away = 600mm, gap = 320mm)\n");
  double back = 0;
  while (!ended() && now() < 60) {
    cell->tick();
    back = std::min(back, place().x());
  }
  EXPECT_NEAR(back, -0.28, 0.003) << "from 320 mm to 600 mm";
  expect_at(0, 0, 0);
}

TEST_F(BaseWaysOfPrograms, UndockingNeverDrivesIntoTheDock) {
  start("include \"polyarm:base\"\nundock_to(pose(), away = 50mm, gap = 100mm)\n");
  double ahead = 0;
  while (!ended() && now() < 60) {
    cell->tick();
    ahead = std::max(ahead, place().x());
  }
  EXPECT_LT(ahead, 0.001);
}

/// An arm beside the base; `check` plans its moves around the base.
TEST_F(BaseWaysOfPrograms, CheckPlansMovesOfArmsAroundABaseWhereItHasDriven) {
  std::string both = kBaseControllers;
  both.replace(both.find("base: {type"), 0,
               "arm: {type: joint_trajectory_controller/JointTrajectoryController}, ");
  both +=
      "arm:\n  ros__parameters:\n    joints: [shoulder_pan_joint, shoulder_lift_joint, elbow_joint, "
      "wrist_1_joint, wrist_2_joint, wrist_3_joint]\n    command_interfaces: [position]\n"
      "    state_interfaces: [position, velocity]\n";
  const auto found = [&](const std::string& program) {
    file(program, "");
    folder.write("cell.yaml",
                 "polyarm: cell/1\nrobots:\n  base: {model: base.urdf, hardware: mock}\n"
                 "  arm: {model: universal_robots/ur3, hardware: mock, at: [0, 0.6, 0]}\n"
                 "scene: scene.yaml\ncontrollers: both.yaml\nprogram: go\n");
    folder.write("both.yaml", both);
    std::string out;
    for (const Problem& problem :
         check(folder.path(), {}, description::Catalogue({std::string(POLYARM_SOURCE_DIR) + "/robots"}), {})
             .problems)
      if (problem.severity == Severity::error) out += problem.text() + "\n";
    return out;
  };
  // 0.45 m in front of the arm: over the middle of the base where it starts.
  const std::string low =
      "movej pose(0, -0.45m, 0.25m, 180deg, 0, 0), frame \"arm/base\", robot arm, around true\n";
  EXPECT_NE(found(low).find("inside base/base_link"), std::string::npos) << found(low);
  EXPECT_EQ(found("drive -1m, robot base\n" + low), "");
  const std::string back = found("drive -1m, robot base\ndrive 1m, robot base\n" + low);
  EXPECT_NE(back.find("inside base/base_link"), std::string::npos) << back;
}

}  // namespace
}  // namespace polyarm::cell
