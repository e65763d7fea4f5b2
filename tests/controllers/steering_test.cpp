/// The steering family, with the numbers that ros2_controllers' own tests use where they have some.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "polyarm/plugins/types.hpp"
#include "polyarm/wheels/steering_controllers.hpp"
#include "tests/controllers/wheels_rig.hpp"
#include "tests/support/realtime_guard.hpp"

namespace polyarm::controllers::steering_test {
namespace {

using Kind = SteeringGeometry::Kind;
constexpr double kPi = std::numbers::pi;

SteeringGeometry geometry(Kind kind, double wheelbase = 2, double track = 1, double radius = 1) {
  return {kind, wheelbase, track, track, radius};
}

TEST(SteeringKinematics, SteersByTheArcusTangent) {
  const SteeringGeometry g = geometry(Kind::bicycle, 3.24644);
  EXPECT_NEAR(steering_angle(g, 0.1, 0.2), 1.4179821977774734, 1e-12);
  EXPECT_NEAR(steering_angle(g, 1.5, 0.3), std::atan(0.3 * 3.24644 / 1.5), 1e-12);
  EXPECT_NEAR(steering_angle(g, -0.1, 0.2), -1.4179821977774734, 1e-12);  // backwards, still to the left
  EXPECT_EQ(steering_angle(g, 0, 0), 0);
  EXPECT_DOUBLE_EQ(steering_angle(g, 0, 1), kPi / 2);
  EXPECT_DOUBLE_EQ(steering_angle(g, 0, -1), -kPi / 2);
}

TEST(SteeringKinematics, TurnsInnerWheelsMoreAndSlower) {
  const SteeringGeometry g = geometry(Kind::ackermann);
  for (const double middle : {0.2, -0.2, 0.7, -0.7}) {
    const auto [right, left] = steering_joints(g, middle);
    const auto [fast, slow] = traction_wheels(g, 1, middle);
    EXPECT_EQ(std::abs(right) < std::abs(left), middle > 0);
    EXPECT_EQ(fast > slow, middle > 0);
    EXPECT_GT(std::min(fast, slow), 0);
    // All axes meet in one point on the line of the traction axle.
    const double turn = 2 / std::tan(middle);
    EXPECT_NEAR(std::tan(right), 2 / (turn + 0.5), 1e-12);
    EXPECT_NEAR(std::tan(left), 2 / (turn - 0.5), 1e-12);
    EXPECT_NEAR(middle_angle(g, {right, left}), middle, 1e-12);
    EXPECT_NEAR(traction_speed(g, {fast, slow}, middle), 1, 1e-12);
  }
  EXPECT_EQ(steering_joints(g, 0), (RightLeft{0, 0}));
  EXPECT_EQ(traction_wheels(g, 1, 0), (RightLeft{1, 1}));
}

TEST(SteeringKinematics, AtItsSharpestNoJointIsBeyondItsLimit) {
  for (const Kind kind : {Kind::bicycle, Kind::tricycle, Kind::ackermann})
    for (const double limit : {0.3, 0.7, 1.0}) {
      const SteeringGeometry g = geometry(kind);
      const double middle = std::atan(sharpest_curvature(g, limit) * g.wheelbase);
      const auto [right, left] = steering_joints(g, middle);
      EXPECT_NEAR(std::max(right, left), limit, 1e-9);
    }
  const SteeringGeometry g = geometry(Kind::bicycle);
  EXPECT_EQ(sharpest_curvature(g, INFINITY), sharpest_curvature(g, kMostSteering));
  EXPECT_GT(sharpest_curvature(g, 0), 0) << "of a joint that does not turn to one side";
}

TEST(SteeringKinematics, DrivesSlowerWhileItSteers) {
  EXPECT_EQ(share_while_steering(0.5), 1);
  EXPECT_NEAR(share_while_steering(-kPi / 4), std::cos(kPi / 4) / std::cos(kPi / 6), 1e-12);
  EXPECT_GT(share_while_steering(kPi), 0);
  EXPECT_LT(share_while_steering(kPi), 0.02);
}

// ---- bicycle

struct Bicycle : WheelsRig<BicycleSteeringController> {
  explicit Bicycle(const Rig::Values& more = {})
      : WheelsRig({"wheel", "steering"},
                  {{"traction_joints_names", {"wheel"}},
                   {"steering_joints_names", {"steering"}},
                   {"wheelbase", {"3.24644"}},
                   {"traction_wheel_radius", {"0.45"}},
                   {"reference_timeout", {"2.0"}}},
                  more) {}
};

TEST(Bicycle, ClaimsWhatItsOriginalClaims) {
  Bicycle base;
  base.rig.start();
  EXPECT_EQ(base.base.command_interfaces(),
            (std::vector<std::string>{"base/wheel/velocity", "base/steering/position"}));
  EXPECT_EQ(base.base.state_interfaces(),
            (std::vector<std::string>{"base/wheel/velocity", "base/steering/position"}));
  EXPECT_EQ(base.base.reference_interfaces(),
            (std::vector<std::string>{"drive/linear/velocity", "drive/angular/velocity"}));
  EXPECT_EQ(base.base.inputs().front().name, "reference");
}

TEST(Bicycle, CommandsWheelAndSteering) {
  for (const bool chained : {false, true}) {
    Bicycle base;
    base.rig.start(chained);
    if (chained) {
      base.rig.command("drive/linear/velocity") = 0.1;
      base.rig.command("drive/angular/velocity") = 0.2;
    } else {
      base.send(0.1, 0, 0.2);
    }
    base.rig.step();
    EXPECT_NEAR(base.velocity("wheel"), 0.1 / 0.45, 1e-12);
    EXPECT_NEAR(base.angle("steering"), 1.4179821977774734, 1e-12);
  }
}

TEST(Bicycle, StopsItsWheelAndKeepsItsSteeringWithoutAReference) {
  Bicycle base;
  base.rig.start(true);
  base.rig.command("drive/linear/velocity") = 0.1;
  base.rig.command("drive/angular/velocity") = 0.01;
  base.rig.step();
  const double angle = base.angle("steering");
  EXPECT_GT(angle, 0.1);
  base.rig.command("drive/angular/velocity") = std::nan("");
  base.rig.step();
  EXPECT_EQ(base.velocity("wheel"), 0);
  EXPECT_EQ(base.angle("steering"), angle);
}

TEST(Bicycle, HeedsItsTimeout) {
  Bicycle base;
  base.rig.start();
  base.send(0.1, 0, 0.2, base.rig.cycle.time - nanoseconds(2.1));  // too old on arrival
  base.rig.step();
  EXPECT_EQ(base.velocity("wheel"), 0);
  base.send(0.1, 0, 0.2);
  base.rig.steps(201);
  EXPECT_GT(base.velocity("wheel"), 0);
  base.rig.step();
  EXPECT_EQ(base.velocity("wheel"), 0);
  EXPECT_NEAR(base.angle("steering"), 1.4179821977774734, 1e-12);
}

TEST(Bicycle, UsesAReferenceOnceWithATimeoutOfZero) {
  Bicycle base(Rig::Values{{"reference_timeout", {"0"}}});
  base.rig.start();
  base.send(0.1, 0, 0);
  base.rig.step();
  EXPECT_GT(base.velocity("wheel"), 0);
  base.rig.step();
  EXPECT_EQ(base.velocity("wheel"), 0);
  // A twist on cmd_vel, which a person's keys and programs send, counts for half a second.
  base.base.receive("cmd_vel", Twist{{0.1, 0, 0}, {}, {}}, false);
  base.rig.steps(51);
  EXPECT_GT(base.velocity("wheel"), 0);
  base.rig.step();
  EXPECT_EQ(base.velocity("wheel"), 0);
}

TEST(Bicycle, WaitsForItsSteeringWhereAsked) {
  Bicycle base(Rig::Values{{"reduce_wheel_speed_until_steering_reached", {"true"}}});
  base.rig.start();
  base.send(0.45, 0, 0.45);  // 1.27 rad to the left
  base.rig.step();
  const double off = base.angle("steering");
  EXPECT_NEAR(base.velocity("wheel"), std::cos(off) / std::cos(kPi / 6), 1e-12);
  base.steer("steering", off);
  base.rig.step();
  EXPECT_DOUBLE_EQ(base.velocity("wheel"), 1);
}

TEST(Bicycle, TellsItsOdometryByVelocity) {
  Bicycle base(Rig::Values{{"wheelbase", {"1"}}, {"traction_wheel_radius", {"1"}}});
  base.rig.start();
  base.measure("wheel", 1);
  base.steer("steering", 0.1);
  base.rig.steps(10);
  EXPECT_NEAR(base.rig.told("odometry", "twist.twist.linear.x"), 1, 1e-12);
  EXPECT_NEAR(base.rig.told("odometry", "twist.twist.angular.z"), std::tan(0.1), 1e-12);
  const double turn = 0.1 * std::tan(0.1);
  EXPECT_NEAR(base.base.odometry().heading(), turn, 1e-12);
  EXPECT_NEAR(base.base.odometry().x(), std::sin(turn) / std::tan(0.1), 1e-12);
  EXPECT_EQ(base.rig.told("odometry", "pose.covariance[35]"), 35);
  EXPECT_NEAR(base.rig.told("tf_odometry", "transform.rotation.z"), std::sin(turn / 2), 1e-12);
}

TEST(Bicycle, CountsPositionsFromWhereTheWheelStands) {
  Bicycle base(Rig::Values{{"position_feedback", {"true"}}});
  base.rig.configure();
  base.rig.state("wheel/position") = 70;
  base.rig.activate();
  base.rig.step();
  EXPECT_EQ(base.base.odometry().x(), 0);
  base.rig.state("wheel/position") = 71;
  base.rig.step();
  EXPECT_NEAR(base.base.odometry().x(), 0.45, 1e-12);
}

TEST(Bicycle, DrivesOnWithoutAMeasurement) {
  Bicycle base;
  base.rig.start();
  base.measure("wheel", std::nan(""));
  base.send(0.1, 0, 0);
  EXPECT_EQ(base.rig.step(), ReturnType::ok);
  EXPECT_GT(base.velocity("wheel"), 0);
  EXPECT_EQ(base.base.odometry().x(), 0);
}

TEST(Bicycle, TellsItsState) {
  Bicycle base;
  base.rig.start();
  base.measure("wheel", 3);
  base.steer("steering", 0.2);
  base.send(0.45, 0, 0);
  base.rig.step();
  EXPECT_EQ(base.base.find_output("controller_state")->type(), "control_msgs/SteeringControllerStatus");
  EXPECT_EQ(base.rig.told("controller_state", "traction_wheels_velocity[0]"), 3);
  EXPECT_EQ(base.rig.told("controller_state", "steer_positions[0]"), 0.2);
  EXPECT_DOUBLE_EQ(base.rig.told("controller_state", "traction_command[0]"), 1);
  EXPECT_EQ(base.rig.told("controller_state", "steering_angle_command[0]"), 0);
}

TEST(Bicycle, HoldsItsSteeringWhereItIsWhenTheCellStops) {
  Bicycle base(Rig::Values{{"linear.x.max_acceleration", {"1"}}});
  base.rig.start();
  base.send(0.02, 0, 0.01);
  base.rig.steps(2);
  EXPECT_GT(base.angle("steering"), 0.5);
  base.steer("steering", 0.3);  // on its way
  base.rig.verdict.speed = 0;
  base.rig.step();
  EXPECT_EQ(base.angle("steering"), 0.3);
  EXPECT_FALSE(base.base.standing());
  base.steer("steering", 0.31);
  base.rig.step();
  EXPECT_EQ(base.angle("steering"), 0.3);
  EXPECT_EQ(base.velocity("wheel"), 0);
  EXPECT_TRUE(base.base.standing());
  base.rig.verdict.speed = 1;
  base.rig.step();
  EXPECT_EQ(base.velocity("wheel"), 0);  // not by itself
}

TEST(Bicycle, KeepsItsCurveUnderAnOverride) {
  Bicycle base;
  base.rig.start();
  base.rig.verdict.speed = 0.5;
  base.send(0.1, 0, 0.2);
  base.rig.step();
  EXPECT_NEAR(base.velocity("wheel"), 0.05 / 0.45, 1e-12);
  EXPECT_NEAR(base.angle("steering"), 1.4179821977774734, 1e-12);
}

TEST(Bicycle, BeginsWithItsSteeringWhereItIs) {
  Bicycle base;
  base.rig.configure();
  base.steer("steering", 0.4);
  base.rig.activate();
  base.rig.step();
  EXPECT_EQ(base.angle("steering"), 0.4);
}

// ---- tricycle and Ackermann

TEST(Tricycle, SharesASpeedBetweenItsWheels) {
  for (const char* open_loop : {"false", "true"}) {
    WheelsRig<TricycleSteeringController> base({"right", "left", "steering"},
                                               {{"traction_joints_names", {"right", "left"}},
                                                {"steering_joints_names", {"steering"}},
                                                {"wheelbase", {"3.24644"}},
                                                {"traction_track_width", {"1.212121"}},
                                                {"traction_wheels_radius", {"0.45"}},
                                                {"open_loop", {open_loop}}});
    base.rig.start();
    base.send(0.1, 0, 0.02);
    base.rig.step();
    const double angle = std::atan(0.2 * 3.24644), half = 1.212121 / 2;
    EXPECT_NEAR(base.angle("steering"), angle, 1e-12);
    if (open_loop[0] == 'f') {  // it looks at the measured angle, which is straight
      EXPECT_NEAR(base.velocity("right"), 0.22222222222222224, 1e-12);
      EXPECT_NEAR(base.velocity("left"), 0.22222222222222224, 1e-12);
      base.steer("steering", angle);
      base.rig.step();
    }
    EXPECT_NEAR(base.velocity("right"), (0.1 + 0.02 * half) / 0.45, 1e-12);
    EXPECT_NEAR(base.velocity("left"), (0.1 - 0.02 * half) / 0.45, 1e-12);
  }
}

struct Car : WheelsRig<AckermannSteeringController> {
  explicit Car(const Rig::Values& more = {})
      : WheelsRig({"rear_right", "rear_left", "front_right", "front_left"},
                  {{"traction_joints_names", {"rear_right", "rear_left"}},
                   {"steering_joints_names", {"front_right", "front_left"}},
                   {"wheelbase", {"3.24644"}},
                   {"traction_track_width", {"1.76868"}},
                   {"traction_wheels_radius", {"0.45"}}},
                  more) {}
};

TEST(Ackermann, SteersEachJointByTheSameTurn) {
  Car car;
  car.rig.start();
  car.send(1, 0, 0.1);
  car.rig.step();
  const double turn = 10, half = 1.76868 / 2;  // m
  EXPECT_NEAR(car.angle("front_right"), std::atan(3.24644 / (turn + half)), 1e-12);
  EXPECT_NEAR(car.angle("front_left"), std::atan(3.24644 / (turn - half)), 1e-12);
  EXPECT_NEAR(car.velocity("rear_right"), 1 / 0.45, 1e-12);  // still straight
  EXPECT_EQ(car.base.geometry().steering_track, 1.76868);
  Car narrow(Rig::Values{{"steering_track_width", {"1.2"}}});
  narrow.rig.start();
  EXPECT_EQ(narrow.base.geometry().steering_track, 1.2);
  EXPECT_EQ(narrow.base.geometry().traction_track, 1.76868);
}

TEST(Ackermann, TellsItsOdometryFromAllFourJoints) {
  Car car(
      Rig::Values{{"wheelbase", {"1"}}, {"traction_track_width", {"1"}}, {"traction_wheels_radius", {"1"}}});
  car.rig.start();
  for (const char* wheel : {"rear_right", "rear_left"}) car.measure(wheel, 1);
  for (const char* joint : {"front_right", "front_left"}) car.steer(joint, 0.1);
  car.rig.steps(10);
  EXPECT_NEAR(car.rig.told("odometry", "twist.twist.linear.x"), 1.002, 1e-3);
  EXPECT_NEAR(car.rig.told("odometry", "twist.twist.angular.z"), 0.1, 1e-3);
  EXPECT_NEAR(car.base.odometry().x(), 0.1, 1e-3);
  EXPECT_NEAR(car.base.odometry().heading(), 0.01, 1e-3);
}

/// A car on the ground: its steering moves at 1 rad/s, its wheels roll without slip around one point.
struct Ground {
  double x = 0, y = 0, heading = 0, angle = 0;
  void step(Car& car, double dt) {
    const SteeringGeometry& g = car.base.geometry();
    const double wanted = middle_angle(g, {car.angle("front_right"), car.angle("front_left")});
    angle += std::clamp(wanted - angle, -dt, dt);
    const double v = (car.velocity("rear_right") + car.velocity("rear_left")) / 2 * g.radius;
    const double w = v * std::tan(angle) / g.wheelbase;
    for (int k = 0; k < 20; ++k) {  // in small steps, by another integration than the odometry's
      x += v * std::cos(heading + w * dt / 40) * dt / 20;
      y += v * std::sin(heading + w * dt / 40) * dt / 20;
      heading += w * dt / 20;
    }
    // The speed of each wheel's centre along the wheel, from the motion of the body.
    const double half = g.traction_track / 2, front = g.steering_track / 2;
    car.measure("rear_right", (v + w * half) / g.radius);
    car.measure("rear_left", (v - w * half) / g.radius);
    car.steer("front_right", std::atan2(w * g.wheelbase * (v < 0 ? -1 : 1), std::abs(v + w * front)));
    car.steer("front_left", std::atan2(w * g.wheelbase * (v < 0 ? -1 : 1), std::abs(v - w * front)));
    if (v == 0)
      for (const auto& [joint, at] : {std::pair{"front_right", 0}, {"front_left", 1}})
        car.steer(joint, steering_joints(g, angle)[static_cast<std::size_t>(at)]);
  }
};

TEST(Ackermann, KnowsWhereItIsAfterARandomDrive) {
  Car car;
  car.rig.start();
  Ground ground;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> speed(-2, 2), turn(-0.5, 0.5);
  double v = 1, w = 0;
  for (int k = 0; k < 20000; ++k) {
    if (k % 100 == 0) v = speed(random), w = turn(random) * std::abs(v) / 2;
    car.send(v, 0, w);
    car.rig.step();
    ground.step(car, 0.01);
  }
  car.rig.verdict.speed = 0;
  car.rig.step();  // the last measurements count
  EXPECT_NEAR(car.base.odometry().x(), ground.x, 1e-3);
  EXPECT_NEAR(car.base.odometry().y(), ground.y, 1e-3);
  EXPECT_NEAR(car.base.odometry().heading(), ground.heading, 1e-6);
}

TEST(Ackermann, ComesBackAroundARoundedSquare) {
  Car car(Rig::Values{{"open_loop", {"true"}}});
  car.rig.start();
  for (int side = 0; side < 4; ++side) {  // 10 m ahead, then a quarter of a circle of 5 m
    for (int k = 0; k < 1000; ++k) car.send(1, 0, 0), car.rig.step();
    for (int k = 0; k < 1000; ++k) car.send(kPi / 2 * 5 / 10, 0, kPi / 2 / 10), car.rig.step();
  }
  EXPECT_NEAR(car.base.odometry().x(), 0, 1e-9);
  EXPECT_NEAR(car.base.odometry().y(), 0, 1e-9);
  EXPECT_NEAR(car.base.odometry().heading(), 2 * kPi, 1e-9);
}

TEST(Ackermann, RefusesWrongJointsAndSizes) {
  const std::pair<Rig::Values, const char*> kWrong[] = {
      {{{"traction_joints_names", {"rear_right"}}}, "'traction_joints_names' has 1 joints, it needs 2"},
      {{{"steering_joints_names", {"front_right", "rear_left", "front_left"}}}, "has 3 joints, it needs 2"},
      {{{"steering_joints_names", {"front_left", "front_left"}}}, "is named twice"},
      {{{"traction_joints_names", {"rear_right", "raer_left"}}}, "did you mean 'rear_left'"},
      {{{"wheelbase", {"0"}}}, "wheelbase must be a number above 0"},
      {{{"traction_wheels_radius", {"-1"}}}, "traction_wheels_radius must be a number above 0"},
      {{{"traction_track_width", {".inf"}}}, "traction_track_width"},
      {{{"pose_covariance_diagonal", {"1"}}}, "has 1 numbers, it needs 6"},
      {{{"reference_timeout", {"-1"}}}, "reference_timeout: -1"},
  };
  for (const auto& [values, sentence] : kWrong) {
    Car car(values);
    const std::string why = car.rig.refusal();
    EXPECT_NE(why.find(sentence), std::string::npos) << sentence << "\n" << why;
  }
}

TEST(Ackermann, UnderstandsTheNamesOfOlderReleases) {
  Car car(Rig::Values{{"front_steering", {"true"}},
                      {"rear_wheels_names", {"rear_right", "rear_left"}},
                      {"front_wheels_names", {"front_right", "front_left"}},
                      {"front_wheel_track", {"1.2"}},
                      {"rear_wheel_track", {"1.7"}},
                      {"rear_wheels_radius", {"0.4"}},
                      {"front_wheels_radius", {"0.3"}}});
  for (const char* key :
       {"traction_joints_names", "steering_joints_names", "traction_track_width", "traction_wheels_radius"})
    car.rig.context.parameters.entries.erase(key);
  car.rig.start();
  EXPECT_EQ(car.base.geometry().radius, 0.4);
  EXPECT_EQ(car.base.geometry().traction_track, 1.7);
  EXPECT_EQ(car.base.geometry().steering_track, 1.2);
  EXPECT_NE(car.rig.findings().find("write steering_joints_names"), std::string::npos);
  EXPECT_EQ(car.rig.findings().find("has no parameter"), std::string::npos) << car.rig.findings();
}

TEST(Ackermann, DoesNothingThatWaits) {
  if (!test::RealtimeGuard::watches()) GTEST_SKIP() << "sanitizers bring their own allocator";
  for (const char* feedback : {"true", "false"}) {
    Car car(Rig::Values{{"position_feedback", {feedback}}, {"publish_limited_velocity", {"true"}}});
    car.rig.start();
    for (int k = 0; k < 100; ++k) {
      car.send(0.01 * k, 0, 0.1);
      car.base.receive("reset_odometry", Numbers{}, false);
      car.rig.verdict.speed = k % 10 == 0 ? 0 : 1;
      test::RealtimeGuard guard;
      for (int i = 0; i < 20; ++i) {
        car.base.update(car.rig.cycle, car.rig.verdict);
        car.rig.cycle.time += car.rig.cycle.period;
      }
      car.base.on_deactivate(car.rig.cycle);
      car.base.on_activate(car.rig.cycle);
      ASSERT_EQ(guard.violations(), "");
    }
  }
}

TEST(Steering, IsFoundUnderItsNames) {
  for (const char* name :
       {"bicycle_steering_controller/BicycleSteeringController",
        "tricycle_steering_controller/TricycleSteeringController",
        "ackermann_steering_controller/AckermannSteeringController", "tricycle_controller/TricycleController",
        "mecanum_drive_controller/MecanumDriveController",
        "omni_wheel_drive_controller/OmniWheelDriveController"}) {
    Parameters parameters;
    EXPECT_NE(dynamic_cast<BaseController*>(make_controller(name, parameters).get()), nullptr) << name;
  }
}

}  // namespace
}  // namespace polyarm::controllers::steering_test
