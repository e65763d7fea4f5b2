/// Programs on bases that steer or have mecanum wheels, in lock-step on the mock.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "polyarm/inside/inside.hpp"
#include "polyarm/protocol/session.hpp"
#include "polyarm/setup/cell_file.hpp"
#include "polyarm/wheels/base_controller.hpp"
#include "tests/support/folder.hpp"
#include "tests/support/lock_step_cell.hpp"

namespace polyarm::cell {
namespace {

using test::Folder;
using test::LockStepCell;

/// A base with these wheels, and steering joints of ±1.4 rad.
std::string urdf(const std::vector<std::string>& wheels, const std::vector<std::string>& steering) {
  std::string links = "<link name=\"base_link\"/>", hardware;
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
    add(name, "revolute", "0 0 1", "lower=\"-1.4\" upper=\"1.4\" velocity=\"3\" effort=\"30\"", "position");
  return "<robot name=\"base\">" + links +
         "<ros2_control name=\"Base\" "
         "type=\"system\"><hardware><plugin>mock_components/GenericSystem</plugin>"
         "<param name=\"calculate_dynamics\">true</param></hardware>" +
         hardware + "</ros2_control></robot>\n";
}

constexpr const char* kTricycle = R"(
controller_manager:
  ros__parameters: {update_rate: 100, base: {type: tricycle_steering_controller/TricycleSteeringController}}
base:
  ros__parameters:
    traction_joints_names: [right, left]
    steering_joints_names: [front]
    wheelbase: 0.8
    traction_track_width: 0.5
    traction_wheels_radius: 0.1
    linear.x: {max_velocity: 0.5, max_acceleration: 0.5}
)";

constexpr const char* kMecanum = R"(
controller_manager:
  ros__parameters: {update_rate: 100, base: {type: mecanum_drive_controller/MecanumDriveController}}
base:
  ros__parameters:
    front_left_wheel_command_joint_name: fl
    front_right_wheel_command_joint_name: fr
    rear_right_wheel_command_joint_name: rr
    rear_left_wheel_command_joint_name: rl
    kinematics: {wheels_radius: 0.08, sum_of_robot_center_projection_on_X_Y_axis: 0.5}
    linear.x: {max_velocity: 0.5, max_acceleration: 0.5}
    linear.y: {max_velocity: 0.5, max_acceleration: 0.5}
    angular.z: {max_velocity: 1.0, max_acceleration: 2.0}
)";

class WheeledBases : public ::testing::Test {
 protected:
  void start(const std::string& description, const std::string& controllers, const std::string& program) {
    folder.write("base.urdf", description);
    folder.write("controllers.yaml", controllers);
    folder.write("go.script", program);
    folder.write("cell.yaml",
                 "polyarm: cell/1\nrobots:\n  base: {model: base.urdf, hardware: mock}\n"
                 "controllers: controllers.yaml\nprogram: go\n");
    cell = std::make_unique<LockStepCell>(read_cell_file(folder.path()));
  }
  static constexpr const char* kSphere =
      "<collision><geometry><sphere radius=\"0.1\"/></geometry></collision>";
  /// A base with a body, 0.4 m long, before a wall at x = 1 m. `shape`: of its wheels.
  void start_before_a_wall(const std::string& program, const std::string& guards = "",
                           const std::string& shape = kSphere) {
    start_before_a_wall(urdf({"right", "left"}, {"front"}), kTricycle, program, guards, shape);
  }
  void start_before_a_wall(std::string description, const std::string& controllers,
                           const std::string& program, const std::string& guards, const std::string& shape,
                           const std::string& fixtures = "") {
    const std::string empty = "<link name=\"base_link\"/>";
    description.replace(description.find(empty), empty.size(),
                        "<link name=\"base_link\"><collision><origin xyz=\"0 0 0.3\"/><geometry><box "
                        "size=\"0.4 0.3 0.2\"/></geometry></collision></link>");
    for (const std::string wheel : {"right", "left", "front", "fl", "fr", "rr", "rl"}) {
      const std::string link = "<link name=\"" + wheel + "_link\"/>";
      if (const std::size_t at = description.find(link); at != std::string::npos)
        description.replace(at, link.size(), "<link name=\"" + wheel + "_link\">" + shape + "</link>");
    }
    folder.write("base.urdf", description);
    folder.write("controllers.yaml", controllers);
    folder.write("go.script", program);
    folder.write("scene.yaml",
                 "polyarm: scene/1\nfloor: {height: -0.1}\nfixtures:\n"
                 "  wall: {box: [0.2, 2, 1], at: [1.1, 0, 0.5]}\n" +
                     fixtures);
    folder.write("cell.yaml",
                 "polyarm: cell/1\nrobots:\n  base: {model: base.urdf, hardware: mock}\nscene: scene.yaml\n"
                 "controllers: controllers.yaml\nprogram: go\n" +
                     guards);
    hardware::register_driver(
        "mock", [] { return std::unique_ptr<hardware::Component>(new drivers::MockComponent); });
    CellOptions options;
    options.waits = true;
    cell = std::make_unique<LockStepCell>(read_cell_file(folder.path()), options);
    cell->run(0.1);
  }
  void start_tricycle(const std::string& program) {
    start(urdf({"right", "left"}, {"front"}), kTricycle, program);
  }
  controllers::BaseController& base() {
    return dynamic_cast<controllers::BaseController&>(*cell->cell().loop().controllers().find("base"));
  }
  bool ended() { return cell->cell().program()->ended(); }
  double now() { return seconds(cell->cell().loop().cycle().time); }
  void finish(double most = 60) {
    while (!ended() && now() < most) cell->tick();
    ASSERT_TRUE(ended());
  }
  std::string failure() { return cell->cell().program()->status().problem.value_or(Problem{}).text(); }
  const controllers::PlanarOdometry& place() { return base().odometry(); }

  Folder folder;
  std::unique_ptr<LockStepCell> cell;
};

TEST_F(WheeledBases, ABaseThatSteersDrivesStraightBothWays) {
  start_tricycle("drive 800mm\ndrive -300mm, speed 0.2m/s\n");
  finish();
  EXPECT_FALSE(cell->cell().program()->failed()) << failure();
  EXPECT_NEAR(place().x(), 0.5, 0.003);
  EXPECT_NEAR(place().y(), 0, 0.003);
  EXPECT_NEAR(place().heading(), 0, 0.01);
}

/// Wheels are what the controller drives: their shapes say nothing.
class WheelsOfAnyShape : public WheeledBases, public ::testing::WithParamInterface<const char*> {};

TEST_P(WheelsOfAnyShape, ABaseStopsBeforeAWall) {
  start_before_a_wall("drive 1500mm\n", "", GetParam());
  ASSERT_TRUE(cell->ask({{"request", "program.start"}})["ok"].get<bool>());
  double most = 0;
  for (int i = 0; i < 4000; ++i) {
    cell->tick();
    most = std::max(most, place().x());
  }
  EXPECT_EQ(cell->result({{"request", "health"}})["state"], "held");
  EXPECT_NE(cell->cell().stop_cause().what.find("fixture wall"), std::string::npos)
      << cell->cell().stop_cause().what;
  EXPECT_LT(most, 0.8) << "its front is 0.2 m before its middle";
  EXPECT_GT(most, 0.6);
}

constexpr const char* kBox = "<collision><geometry><box size=\"0.2 0.05 0.2\"/></geometry></collision>";
INSTANTIATE_TEST_SUITE_P(
    Shapes, WheelsOfAnyShape,
    testing::Values("<collision><geometry><sphere radius=\"0.1\"/></geometry></collision>", "", kBox));

struct BaseKind {
  std::string name;
  std::vector<std::string> wheels, steering;
  std::string controllers;
};
std::ostream& operator<<(std::ostream& out, const BaseKind& kind) {
  return out << kind.name;
}
class BasesThatGoNear : public WheeledBases, public ::testing::WithParamInterface<BaseKind> {
 protected:
  /// Until it has ended or is held; the most that it was ahead.
  double drive(const std::string& program) {
    start_before_a_wall(urdf(GetParam().wheels, GetParam().steering), GetParam().controllers, program,
                        "contacts: {clearance: 40mm}\nguards: {clearance: 40mm}\n", kSphere);
    EXPECT_TRUE(cell->ask({{"request", "program.start"}})["ok"].get<bool>());
    const auto wheels = [&]() -> moves::BaseMotion& { return *cell->cell().in().motions->wheels(0); };
    double most = 0;
    int idle_ticks = 0;
    bool was_busy = false;
    while (!ended() && now() < 60 && cell->cell().loop().supervisor().state() == control::RunState::running) {
      cell->tick();
      most = std::max(most, place().x());
      idle_ticks = wheels().idle() ? idle_ticks + 1 : 0;
      if (was_busy && idle_ticks > 0 && idle_ticks < 20) {
        EXPECT_TRUE(wheels().left()) << "the move that has just ended explains what odometry still says";
      }
      was_busy = was_busy || !wheels().idle();
    }
    return most;
  }
};

/// Its front is 0.2 m before its middle, the wall begins at 1 m: 15 mm are left, the clearance is 40 mm.
TEST_P(BasesThatGoNear, TheyReachAGoalThatIsNearerToAWallThanTheClearance) {
  const double most = drive("drive pose(0.785m)\n");
  EXPECT_TRUE(ended()) << cell->cell().stop_cause().what;
  EXPECT_FALSE(cell->cell().program()->failed()) << failure();
  EXPECT_NEAR(place().x(), 0.785, GetParam().steering.empty() ? 0.003 : 0.01);
  EXPECT_LT(most, 0.8) << "it does not touch the wall";
  EXPECT_EQ(cell->result({{"request", "health"}})["state"], "running");
}

/// At its end a corner is 12 mm from the wall.
TEST_P(BasesThatGoNear, TheyTurnNearAWallAsItWasPlanned) {
  if (!GetParam().steering.empty()) GTEST_SKIP() << "it does not turn on the spot";
  drive("drive pose(0.74m, 0, 0, 0, 0, 30deg)\n");
  EXPECT_TRUE(ended()) << cell->cell().stop_cause().what;
  EXPECT_FALSE(cell->cell().program()->failed()) << failure();
  EXPECT_NEAR(place().heading(), std::numbers::pi / 6, 0.01);
}

TEST_P(BasesThatGoNear, TheyLeaveAPlaceNearAWall) {
  drive("drive pose(0.785m)\ndrive pose(0.3m)\n");
  EXPECT_TRUE(ended()) << cell->cell().stop_cause().what;
  EXPECT_FALSE(cell->cell().program()->failed()) << failure();
  EXPECT_NEAR(place().x(), 0.3, 0.01);
}

TEST_P(BasesThatGoNear, WithoutAPlanTheyKeepTheClearance) {
  const double most = drive("drive 785mm\n");
  cell->run(2);
  EXPECT_FALSE(ended());
  EXPECT_EQ(cell->result({{"request", "health"}})["state"], "held");
  EXPECT_LT(most, 0.765);
}

constexpr const char* kTwoWheels = R"(
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
constexpr const char* kOmni = R"(
controller_manager:
  ros__parameters: {update_rate: 100, base: {type: omni_wheel_drive_controller/OmniWheelDriveController}}
base:
  ros__parameters:
    wheel_names: [fl, rl, fr]
    robot_radius: 0.2
    wheel_radius: 0.08
    linear.x: {max_velocity: 0.5, max_acceleration: 0.5}
    angular.z: {max_velocity: 1.0, max_acceleration: 2.0}
)";
INSTANTIATE_TEST_SUITE_P(Bases, BasesThatGoNear,
                         testing::Values(BaseKind{"diff", {"right", "left"}, {}, kTwoWheels},
                                         BaseKind{"tricycle", {"right", "left"}, {"front"}, kTricycle},
                                         BaseKind{"mecanum", {"fl", "fr", "rr", "rl"}, {}, kMecanum},
                                         BaseKind{"omni", {"fl", "rl", "fr"}, {}, kOmni}),
                         [](const auto& made) { return made.param.name; });

/// Twists of somebody else, against the moves of the program.
class BasesThatSomebodyElseDrives : public WheeledBases, public ::testing::WithParamInterface<double> {
 protected:
  moves::BaseMotion& wheels() { return *cell->cell().in().motions->wheels(0); }
  void start_fast(const std::string& program) {
    start_before_a_wall(urdf({"right", "left"}, {}), kFast, program, "", kSphere);
    ASSERT_TRUE(cell->ask({{"request", "program.start"}})["ok"].get<bool>());
  }
  /// The most that it was ahead while these twists came.
  double push(double ahead, double turn, int every, int ticks) {
    double most = 0;
    for (int i = 0; i < ticks; ++i) {
      control::ControlLoop& loop = cell->cell().loop();
      const Nanoseconds until = loop.cycle().time + Cell::kTick;
      cell->cell().tick(loop.cycle().time);  // the move gives its command; the twist comes after it
      if (i % every == 0)
        base().receive("cmd_vel", controllers::Twist{{ahead, 0, 0}, {0, 0, turn}, {}}, false);
      while (loop.cycle().time < until) loop.step_next();
      most = std::max(most, place().x());
    }
    return most;
  }
  static constexpr const char* kFast = R"(
controller_manager:
  ros__parameters: {update_rate: 100, base: {type: diff_drive_controller/DiffDriveController}}
base:
  ros__parameters:
    left_wheel_names: [left]
    right_wheel_names: [right]
    wheel_separation: 0.3
    wheel_radius: 0.1
    linear.x: {max_velocity: 1.5, max_acceleration: 6.0}
    angular.z: {max_velocity: 1.5, max_acceleration: 4.0}
)";
};

TEST_P(BasesThatSomebodyElseDrives, InTheTickAfterADriveTheCellHoldsBeforeAWall) {
  start_fast("drive 200mm\nwait 10s\n");
  for (bool busy = false; !(busy && wheels().idle()) && now() < 20; busy = busy || !wheels().idle())
    cell->tick();
  EXPECT_NEAR(place().x(), 0.2, 0.005);
  const double most = push(GetParam(), 0, 25, 1500);
  EXPECT_EQ(cell->result({{"request", "health"}})["state"], "held");
  EXPECT_LT(most, 0.8) << "its front is 0.2 m before its middle";
}

TEST_P(BasesThatSomebodyElseDrives, JustBeforeTheWallTheyAreHeldToo) {
  start_fast("drive 770mm\nwait 10s\n");
  for (bool busy = false; !(busy && wheels().idle()) && now() < 20; busy = busy || !wheels().idle())
    cell->tick();
  ASSERT_NEAR(place().x(), 0.77, 0.005);
  const double most = push(std::min(GetParam(), 0.1), 0, 25, 1500);
  EXPECT_EQ(cell->result({{"request", "health"}})["state"], "held");
  EXPECT_LT(most, 0.8);
}

/// They come in every tick: what the move commands is never followed.
TEST_P(BasesThatSomebodyElseDrives, DuringADriveTheCellHoldsBeforeAWall) {
  start_fast("drive 300mm\nwait 10s\n");
  while (wheels().idle() && now() < 20) cell->tick();
  const double most = push(GetParam(), 0, 1, 2000);
  EXPECT_EQ(cell->result({{"request", "health"}})["state"], "held");
  EXPECT_LT(most, 0.8);
}

TEST_P(BasesThatSomebodyElseDrives, DuringALegAndBetweenLegsTheCellHoldsBeforeAWall) {
  start_fast("drive pose(300mm)\ndrive pose(300mm, 500mm)\nwait 10s\n");
  while (!wheels().left() && now() < 20) cell->tick();
  const double most = push(GetParam(), 0, 1, 2000);
  EXPECT_EQ(cell->result({{"request", "health"}})["state"], "held");
  EXPECT_LT(most, 0.8);
}

TEST_P(BasesThatSomebodyElseDrives, DuringATurnTheCellHoldsBeforeAWall) {
  start_fast("turn 90deg\nwait 10s\n");
  while (wheels().idle() && now() < 20) cell->tick();
  const double most = push(GetParam(), 0, 1, 2000);
  EXPECT_EQ(cell->result({{"request", "health"}})["state"], "held");
  EXPECT_LT(most, 0.8);
}

INSTANTIATE_TEST_SUITE_P(Speeds, BasesThatSomebodyElseDrives, testing::Values(0.2, 0.5, 1.5));

/// Near walls a base is as slow as it could stop before them, from the beginning of its leg.
class BasesBetweenWalls : public WheeledBases, public ::testing::WithParamInterface<const char*> {};

TEST_P(BasesBetweenWalls, DriveSlowlyBothWays) {
  start_before_a_wall(urdf({"right", "left"}, {}), std::string(kTwoWheels) + GetParam(),
                      "drive pose(0.4m)\ndrive pose(0)\n",
                      "contacts: {clearance: 40mm}\nguards: {clearance: 40mm}\n", kSphere,
                      "  side: {box: [6, 0.2, 1], at: [0, 0.265, 0.5]}\n");
  ASSERT_TRUE(cell->ask({{"request", "program.start"}})["ok"].get<bool>());
  double fastest = 0, before = 0, quickest = 0, time = now(), most = 0, slowest = 0;
  for (double last = place().x(); !ended() && now() < 60; last = place().x()) {
    cell->run(0.01);
    const double speed = (place().x() - last) / (now() - time);
    quickest = std::max(quickest, std::abs(speed - before) / (now() - time));
    fastest = std::max(fastest, speed), slowest = std::min(slowest, speed);
    before = speed, time = now();
    most = std::max(most, place().x());
  }
  EXPECT_TRUE(ended()) << cell->cell().stop_cause().what;
  EXPECT_NEAR(most, 0.4, 0.003);
  EXPECT_LT(fastest, 0.12);
  EXPECT_GT(slowest, -0.12);
  EXPECT_LT(quickest, 1.1) << "as its limits allow";
}

INSTANTIATE_TEST_SUITE_P(Limits, BasesBetweenWalls, testing::Values("", "    linear.x.max_jerk: 200.0\n"));

/// Base `a` goes to a place 15 mm before a wall, so its way was planned with less than the clearance. Base
/// `b` came near its way later.
class BasesThatMeet : public WheeledBases {
 protected:
  void meet(const std::string& b) {
    std::string description = urdf({"right", "left"}, {});
    const std::string empty = "<link name=\"base_link\"/>";
    description.replace(description.find(empty), empty.size(),
                        "<link name=\"base_link\"><collision><origin xyz=\"0 0 0.3\"/><geometry><box "
                        "size=\"0.4 0.3 0.2\"/></geometry></collision></link>");
    folder.write("base.urdf", description);
    const auto one = [](const std::string& name) {
      return "/" + name + R"(:
  controller_manager:
    ros__parameters: {update_rate: 100, drive: {type: diff_drive_controller/DiffDriveController}}
  drive:
    ros__parameters:
      left_wheel_names: [left]
      right_wheel_names: [right]
      wheel_separation: 0.2
      wheel_radius: 0.1
      linear.x: {max_velocity: 0.5, max_acceleration: 1.0}
)";
    };
    folder.write("controllers.yaml", one("a") + one("b"));
    folder.write("go.script",
                 "task one\n  use robot a\n  drive pose(0.785m), speed 0.3m/s\nend\n"
                 "task other\n  use robot b\n" +
                     b + "end\n");
    folder.write("scene.yaml",
                 "polyarm: scene/1\nfloor: {height: -0.1}\nfixtures:\n"
                 "  wall: {box: [0.2, 8, 1], at: [1.1, 0, 0.5]}\n");
    folder.write("cell.yaml",
                 "polyarm: cell/1\nrobots:\n  a: {model: base.urdf, hardware: mock, at: [-1, 0, 0]}\n"
                 "  b: {model: base.urdf, hardware: mock, at: [0, 1, 0], rpy: [0, 0, -90deg]}\n"
                 "scene: scene.yaml\ncontrollers: controllers.yaml\nprogram: go\n"
                 "contacts: {clearance: 40mm}\nguards: {clearance: 40mm}\n");
    hardware::register_driver(
        "mock", [] { return std::unique_ptr<hardware::Component>(new drivers::MockComponent); });
    CellOptions options;
    options.waits = true;
    cell = std::make_unique<LockStepCell>(read_cell_file(folder.path()), options);
    cell->run(0.1);
    ASSERT_TRUE(cell->ask({{"request", "program.start"}})["ok"].get<bool>());
    while (!ended() && now() < 30 && cell->cell().loop().supervisor().state() == control::RunState::running)
      cell->tick();
    cell->run(1);
  }
};

TEST_F(BasesThatMeet, ABaseThatMovesIsNotPassedNearerThanTheClearance) {
  meet("  drive 630mm\n  drive -200mm, speed 5mm/s\n");
  EXPECT_EQ(cell->result({{"request", "health"}})["state"], "held");
  EXPECT_EQ(cell->cell().stop_cause().what.rfind("a stopped before a contact", 0), 0U)
      << cell->cell().stop_cause().what;
}

TEST_F(BasesThatMeet, ABaseThatHasMovedAndStandsAgainIsNotPassedNearerEither) {
  meet("  drive 630mm\n");
  EXPECT_EQ(cell->result({{"request", "health"}})["state"], "held");
  EXPECT_EQ(cell->cell().stop_cause().what.rfind("a stopped before a contact", 0), 0U)
      << cell->cell().stop_cause().what;
}

TEST_F(BasesThatMeet, ABaseThatIsFarEnoughHoldsNobody) {
  meet("  drive 590mm\n  drive -50mm, speed 5mm/s\n");
  EXPECT_TRUE(ended()) << cell->cell().stop_cause().what;
}

/// Its way to a standstill is shorter than a step in which guards look along its way.
TEST_F(WheeledBases, ABaseThatCreepsStopsBeforeAWallToo) {
  start_before_a_wall("drive 750mm\ndrive 300mm, speed 20mm/s\n");
  ASSERT_TRUE(cell->ask({{"request", "program.start"}})["ok"].get<bool>());
  double most = 0;
  for (int i = 0; i < 10000; ++i) {
    cell->tick();
    most = std::max(most, place().x());
  }
  EXPECT_EQ(cell->result({{"request", "health"}})["state"], "held");
  EXPECT_LT(most, 0.8) << "its front is 0.2 m before its middle";
  EXPECT_GT(most, 0.77);
}

TEST_F(WheeledBases, WithoutGuardsOfBasesItDrivesOn) {
  start_before_a_wall("drive 1500mm\n", "guards: {bases: false}\n");
  ASSERT_TRUE(cell->ask({{"request", "program.start"}})["ok"].get<bool>());
  cell->run(8);
  EXPECT_NEAR(place().x(), 1.5, 0.01);
}

/// Keys: the base slows down, stands before the wall, may turn away and drive back.
TEST_F(WheeledBases, ABaseThatIsDrivenByKeysStandsBeforeAWallAndSaysWhich) {
  start_before_a_wall("wait 1s\n");
  HeldMotions& held = *cell->cell().in().held_motions;
  std::string near;
  const auto drive = [&](double share, double seconds) {
    protocol::JogBegin request;
    request.mode = "drive";
    request.axis = protocol::Any(0);
    request.direction = share;
    const std::uint64_t motion = held.begin(request);
    for (double t = 0; t < seconds; t += 0.05) {
      held.renew(motion);
      cell->run(0.05);
      for (const HeldEvent& event : held.take_events())
        if (event.what == HeldEvent::What::held_back && !event.which.empty()) near = event.which;
    }
    held.end(motion, "released");
    cell->run(0.5);
  };
  drive(1, 8);
  EXPECT_EQ(near, "fixture wall");
  EXPECT_EQ(cell->result({{"request", "health"}})["state"], "running") << "it is not held";
  EXPECT_LT(place().x(), 0.8);
  EXPECT_GT(place().x(), 0.7);
  drive(-1, 2);
  EXPECT_LT(place().x(), 0.5) << "it drives back";
}

TEST_F(WheeledBases, ABaseThatSteersRefusesToTurnOnTheSpot) {
  start_tricycle("turn 90deg\n");
  finish();
  EXPECT_TRUE(cell->cell().program()->failed());
  EXPECT_NE(failure().find("cannot turn on the spot"), std::string::npos) << failure();
}

TEST_F(WheeledBases, ABaseThatSteersTakesATwistAlongItsArc) {
  start_tricycle("wait 60s\n");
  const double v = 0.3, w = 0.2;
  for (int k = 0; k < 1500; ++k) {
    if (k % 50 == 0) base().receive("reference", controllers::Twist{{v, 0, 0}, {0, 0, w}, {}}, false);
    cell->tick();
  }
  const double turn = place().heading();
  EXPECT_GT(turn, 0.3);
  EXPECT_NEAR(place().x(), v / w * std::sin(turn), 0.02);  // a little off: the steering takes its time
  EXPECT_NEAR(place().y(), v / w * (1 - std::cos(turn)), 0.02);
}

TEST_F(WheeledBases, AMecanumBaseDrivesAndTurns) {
  start(urdf({"fl", "fr", "rr", "rl"}, {}), kMecanum, "drive 500mm\nturn 90deg\ndrive 400mm\n");
  finish();
  EXPECT_FALSE(cell->cell().program()->failed()) << failure();
  EXPECT_NEAR(place().x(), 0.5, 0.005);
  EXPECT_NEAR(place().y(), 0.4, 0.005);
  EXPECT_NEAR(place().heading(), std::numbers::pi / 2, 0.01);
}

}  // namespace
}  // namespace polyarm::cell
