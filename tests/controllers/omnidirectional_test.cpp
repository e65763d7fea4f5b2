/// Bases that drive sideways, and the older tricycle.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "polyarm/wheels/mecanum_drive_controller.hpp"
#include "polyarm/wheels/omni_wheel_drive_controller.hpp"
#include "polyarm/wheels/tricycle_controller.hpp"
#include "tests/controllers/wheels_rig.hpp"
#include "tests/support/realtime_guard.hpp"

namespace polyarm::controllers::omnidirectional_test {
namespace {

constexpr double kPi = std::numbers::pi;
const std::vector<std::string> kCorners = {"fl", "fr", "rr", "rl"};

struct Mecanum : WheelsRig<MecanumDriveController> {
  explicit Mecanum(const Rig::Values& more = {})
      : WheelsRig(kCorners,
                  {{"front_left_wheel_command_joint_name", {"fl"}},
                   {"front_right_wheel_command_joint_name", {"fr"}},
                   {"rear_right_wheel_command_joint_name", {"rr"}},
                   {"rear_left_wheel_command_joint_name", {"rl"}},
                   {"kinematics.wheels_radius", {"0.5"}},
                   {"kinematics.sum_of_robot_center_projection_on_X_Y_axis", {"1.0"}},
                   {"reference_timeout", {"0.9"}}},
                  more) {}
  std::vector<double> wheels() {
    std::vector<double> out;
    for (const std::string& corner : kCorners) out.push_back(velocity(corner));
    return out;
  }
  /// The wheels do what they are commanded.
  void follow() {
    for (const std::string& corner : kCorners) measure(corner, velocity(corner));
  }
};

TEST(Mecanum, ClaimsWhatItsOriginalClaims) {
  Mecanum base;
  base.rig.start();
  EXPECT_EQ(base.base.command_interfaces(),
            (std::vector<std::string>{"base/fl/velocity", "base/fr/velocity", "base/rr/velocity",
                                      "base/rl/velocity"}));
  EXPECT_EQ(base.base.state_interfaces(), base.base.command_interfaces());
  EXPECT_EQ(base.base.reference_interfaces(),
            (std::vector<std::string>{"drive/linear/x/velocity", "drive/linear/y/velocity",
                                      "drive/angular/z/velocity"}));
}

TEST(Mecanum, TurnsEachWheelByItsFormula) {
  Mecanum base;
  base.rig.start(true);
  base.rig.command("drive/linear/x/velocity") = 10;
  base.rig.command("drive/linear/y/velocity") = 5;
  base.rig.command("drive/angular/z/velocity") = 3;
  base.rig.step();
  EXPECT_EQ(base.wheels(), (std::vector<double>{4, 36, 16, 24}));
  EXPECT_EQ(base.rig.told("controller_state", "reference_velocity.linear.y"), 5);
  base.rig.command("drive/linear/x/velocity") = std::nan("");
  base.rig.step();
  EXPECT_EQ(base.wheels(), (std::vector<double>{0, 0, 0, 0}));
}

TEST(Mecanum, DrivesAheadSidewaysAndAround) {
  for (const auto& [twist, signs] : {std::pair{PlanarTwist{1, 0, 0}, std::vector<double>{2, 2, 2, 2}},
                                     {PlanarTwist{0, 1, 0}, std::vector<double>{-2, 2, -2, 2}},
                                     {PlanarTwist{0, 0, 1}, std::vector<double>{-2, 2, 2, -2}}}) {
    Mecanum base;
    base.rig.start();
    base.send(twist.x, twist.y, twist.angular);
    base.rig.step();
    EXPECT_EQ(base.wheels(), signs);
    base.follow();
    base.rig.step();
    EXPECT_DOUBLE_EQ(base.rig.told("odometry", "twist.twist.linear.x"), twist.x);
    EXPECT_DOUBLE_EQ(base.rig.told("odometry", "twist.twist.linear.y"), twist.y);
    EXPECT_DOUBLE_EQ(base.rig.told("odometry", "twist.twist.angular.z"), twist.angular);
  }
}

TEST(Mecanum, MovesTheTwistOfItsFrameToTheCentreAndBack) {
  Mecanum base(Rig::Values{{"kinematics.base_frame_offset.x", {"1"}},
                           {"kinematics.base_frame_offset.y", {"2"}},
                           {"kinematics.base_frame_offset.theta", {"3"}}});
  base.rig.start();
  base.send(0.3, -0.2, 0.4);
  base.rig.step();
  const double x = 0.3 * std::cos(3) + 0.2 * std::sin(3) + 2 * 0.4,
               y = 0.3 * std::sin(3) - 0.2 * std::cos(3) - 1 * 0.4;
  EXPECT_NEAR(base.velocity("fl"), (x - y - 0.4) / 0.5, 1e-12);
  EXPECT_NEAR(base.velocity("rr"), (x - y + 0.4) / 0.5, 1e-12);
  base.follow();
  base.rig.step();
  EXPECT_NEAR(base.rig.told("odometry", "twist.twist.linear.x"), 0.3, 1e-12);
  EXPECT_NEAR(base.rig.told("odometry", "twist.twist.linear.y"), -0.2, 1e-12);
  EXPECT_NEAR(base.rig.told("odometry", "twist.twist.angular.z"), 0.4, 1e-12);
}

TEST(Mecanum, ComesBackAroundASquareWithoutTurning) {
  Mecanum base;
  base.rig.start();
  for (const auto& [x, y] : {std::pair{1, 0}, {0, 1}, {-1, 0}, {0, -1}})
    for (int k = 0; k < 1000; ++k) {
      base.send(x, y, 0);
      base.rig.step();
      base.follow();
    }
  base.rig.step();  // measures the last update
  EXPECT_NEAR(base.base.odometry().x(), 0, 1e-9);
  EXPECT_NEAR(base.base.odometry().y(), 0, 1e-9);
  EXPECT_EQ(base.base.odometry().heading(), 0);
}

TEST(Mecanum, HeedsItsLimitsOnEachAxis) {
  Mecanum base(Rig::Values{{"linear.y.max_acceleration", {"2"}},
                           {"linear.y.max_deceleration", {"-4"}},
                           {"angular.z.max_velocity", {"0.5"}}});
  base.rig.start();
  base.send(1, 1, 9);
  base.rig.step();
  EXPECT_NEAR((base.velocity("fr") + base.velocity("rl")) / 4, 1 + 0.02, 1e-12);
  EXPECT_NEAR((base.velocity("fr") - base.velocity("rl")) / 4, 0.5, 1e-12);
  EXPECT_EQ(base.rig.change("linear.y.max_acceleration", "1"), "");
  base.rig.step();
  EXPECT_NEAR((base.velocity("fr") + base.velocity("rl")) / 4, 1 + 0.03, 1e-12);
  EXPECT_NE(base.rig.change("linear.y.max_deceleration", "0"), "");
}

TEST(Mecanum, UsesAReferenceOnceByDefault) {
  Mecanum base(Rig::Values{{"reference_timeout", {"0"}}});
  base.rig.start();
  base.send(1, 0, 0);
  base.rig.step();
  EXPECT_EQ(base.velocity("fl"), 2);
  base.rig.step();
  EXPECT_EQ(base.velocity("fl"), 0);
}

TEST(Mecanum, IsPutElsewhereAndBack) {
  Mecanum base;
  base.rig.start();
  base.base.receive("set_odometry", NamedValues{{"x", "y", "z", "yaw"}, {5, -2, 0, kPi / 2}}, false);
  base.rig.step();
  EXPECT_EQ(base.base.odometry().x(), 5);
  EXPECT_EQ(base.base.odometry().y(), -2);
  EXPECT_EQ(base.base.odometry().heading(), kPi / 2);
  base.send(1, 0, 0);
  base.rig.step();
  base.follow();
  base.rig.step();
  EXPECT_NEAR(base.base.odometry().y(), -1.99, 1e-12);
  base.base.receive("reset_odometry", Numbers{}, false);
  base.rig.step();
  EXPECT_EQ(base.base.odometry().x(), 0);
  EXPECT_EQ(base.base.odometry().heading(), 0);
}

TEST(Mecanum, ReadsWheelsElsewhereWhereAsked) {
  Mecanum base(Rig::Values{{"front_left_wheel_state_joint_name", {"rl"}}});
  base.rig.start();
  EXPECT_EQ(base.base.state_interfaces().front(), "base/rl/velocity");
  Mecanum none(Rig::Values{{"front_left_wheel_command_joint_name", {""}}});
  EXPECT_NE(none.rig.refusal().find("'front_left_wheel_command_joint_name' is missing"), std::string::npos);
}

// ---- omni wheels

struct Omni : WheelsRig<OmniWheelDriveController> {
  std::vector<std::string> names;
  explicit Omni(int count, const Rig::Values& more = {}) : Omni(named(count), more) {}
  Omni(const std::vector<std::string>& wheels, const Rig::Values& more)
      : WheelsRig(wheels,
                  {{"wheel_names", wheels},
                   {"robot_radius", {"0.5"}},
                   {"wheel_radius", {"0.1"}},
                   {"wheel_offset", {"0"}}},
                  more),
        names(wheels) {}
  static std::vector<std::string> named(int count) {
    std::vector<std::string> out;
    for (int i = 0; i < count; ++i) out.push_back("w" + std::to_string(i));
    return out;
  }
};

TEST(Omni, TurnsThreeWheelsAsItsOriginalDoes) {
  Omni base(3);
  base.rig.start();
  base.send(1, 1, 1);
  base.rig.step();
  EXPECT_NEAR(base.velocity("w0"), -15, 1e-12);
  EXPECT_NEAR(base.velocity("w1"), 8.66025, 1e-5);
  EXPECT_NEAR(base.velocity("w2"), -8.66025, 1e-5);
  base.base.on_deactivate(base.rig.cycle);
  EXPECT_EQ(base.velocity("w1"), 0);
}

TEST(Omni, MeasuresFourWheelsAsItsOriginalDoes) {
  const std::pair<std::vector<double>, PlanarTwist> kRows[] = {{{0, 10, 0, -10}, {1, 0, 0}},
                                                               {{-10, 0, 10, 0}, {0, 1, 0}},
                                                               {{-20, -20, -20, -20}, {0, 0, 2}},
                                                               {{-15, 5, -5, -25}, {1.5, 0.5, 1}}};
  for (const auto& [wheels, twist] : kRows) {
    Omni base(4, {{"robot_radius", {"1"}}, {"position_feedback", {"false"}}});
    base.rig.cycle.period = nanoseconds(1);
    base.rig.start();
    for (std::size_t i = 0; i < 4; ++i) base.measure(base.names[i], wheels[i]);
    base.rig.step();
    const PlanarOdometry& at = base.base.odometry();
    EXPECT_NEAR(at.linear(), twist.x, 1e-12);
    EXPECT_NEAR(at.lateral(), twist.y, 1e-12);
    EXPECT_NEAR(at.heading(), twist.angular, 1e-12);
    const double w = twist.angular;
    if (w == 0) {
      EXPECT_NEAR(at.x(), twist.x, 1e-12);
      EXPECT_NEAR(at.y(), twist.y, 1e-12);
    } else {
      EXPECT_NEAR(at.x(), (twist.x * std::sin(w) + twist.y * (std::cos(w) - 1)) / w, 1e-12);
      EXPECT_NEAR(at.y(), (twist.y * std::sin(w) - twist.x * (std::cos(w) - 1)) / w, 1e-12);
    }
  }
}

TEST(Omni, MeasuresWhatItCommandsWithAnyNumberOfWheels) {
  std::mt19937 random(8);
  std::uniform_real_distribution<double> any(-2, 2);
  for (int count = 3; count < 9; ++count) {
    Omni base(count, {{"wheel_offset", {std::to_string(any(random))}}});
    base.rig.start();
    const PlanarTwist twist{any(random), any(random), any(random)};
    for (int k = 0; k < 3; ++k) {
      base.send(twist.x, twist.y, twist.angular);
      base.rig.step();
      for (const std::string& wheel : base.names)
        base.rig.state(wheel + "/position") += base.velocity(wheel) * 0.01;
    }
    EXPECT_NEAR(base.base.odometry().linear(), twist.x, 1e-9);
    EXPECT_NEAR(base.base.odometry().lateral(), twist.y, 1e-9);
    EXPECT_NEAR(base.base.odometry().angular(), twist.angular, 1e-9);
  }
}

TEST(Omni, StopsWhenNoTwistComesAndFailsWithoutAMeasurement) {
  Omni base(4);
  base.rig.start();
  base.send(1, 0, 0);
  base.rig.steps(51);
  EXPECT_NE(base.velocity("w1"), 0);
  base.rig.step();
  EXPECT_EQ(base.velocity("w1"), 0);
  base.rig.state("w2/position") = std::nan("");
  EXPECT_EQ(base.rig.step(), ReturnType::error);
  Omni open(4, {{"open_loop", {"true"}}});
  open.rig.start();
  EXPECT_TRUE(open.base.state_interfaces().empty());
}

TEST(Omni, NeedsThreeWheels) {
  EXPECT_NE(Omni(2).rig.refusal().find("there are 2 wheels; it needs at least three"), std::string::npos);
  Omni old(3, {{"pose_covariance_diagonal", {"1", "2", "3", "4", "5", "6"}}});
  old.rig.start();
  old.rig.step();
  EXPECT_EQ(old.rig.told("odom", "pose.covariance[7]"), 2);
  EXPECT_NE(old.rig.findings().find("diagonal_covariance.pose"), std::string::npos);
}

// ---- the older tricycle

struct Trike : WheelsRig<TricycleController> {
  explicit Trike(const Rig::Values& more = {})
      : WheelsRig({"traction", "steering"},
                  {{"traction_joint_name", {"traction"}},
                   {"steering_joint_name", {"steering"}},
                   {"wheelbase", {"1.252"}},
                   {"wheel_radius", {"0.125"}}},
                  more) {}
};

TEST(OlderTricycle, DrivesTheWheelThatItSteers) {
  Trike base;
  base.rig.start();
  base.send(1, 0, 0);
  base.rig.step();
  EXPECT_DOUBLE_EQ(base.velocity("traction"), 8);
  EXPECT_EQ(base.angle("steering"), 0);
  base.send(1, 0, 0.2);
  base.rig.step();
  const double angle = std::atan(0.2 * 1.252);
  EXPECT_NEAR(base.angle("steering"), angle, 1e-12);
  EXPECT_NEAR(base.velocity("traction"), 8 / std::cos(angle), 1e-12);
}

TEST(OlderTricycle, CreepsWhileItsWheelTurnsAcross) {
  Trike base;
  base.rig.start();
  base.send(0, 0, -1);
  base.steer("steering", 0.1);
  base.rig.step();
  EXPECT_DOUBLE_EQ(base.angle("steering"), -kPi / 2);
  EXPECT_NEAR(base.velocity("traction"), 0.01 * 1.252 / 0.125, 1e-12);
  base.steer("steering", -kPi / 4);
  base.rig.step();
  EXPECT_NEAR(base.velocity("traction"), std::cos(kPi / 4) * 1.252 / 0.125, 1e-12);
  base.steer("steering", -kPi / 2);
  base.rig.step();
  EXPECT_NEAR(base.velocity("traction"), 1.252 / 0.125, 1e-12);
}

TEST(OlderTricycle, HeedsTheLimitsOfItsWheel) {
  Trike base(Rig::Values{{"traction.max_acceleration", {"5"}},
                         {"traction.max_deceleration", {"8"}},
                         {"traction.max_velocity", {"2"}},
                         {"cmd_vel_timeout", {"600"}}});
  base.rig.start();
  base.send(1, 0, 0);
  base.rig.step();
  EXPECT_NEAR(base.velocity("traction"), 0.05, 1e-12);
  base.rig.steps(50);
  EXPECT_NEAR(base.velocity("traction"), 2, 1e-12);
  base.rig.verdict.speed = 0;
  base.rig.step();
  EXPECT_NEAR(base.velocity("traction"), 1.92, 1e-12);
  EXPECT_FALSE(base.base.standing());
  base.rig.verdict.immediate = true;
  base.rig.step();
  EXPECT_EQ(base.velocity("traction"), 0);
  EXPECT_TRUE(base.base.standing());
}

TEST(OlderTricycle, SteersStraightAfterATimeout) {
  Trike base;
  base.rig.start();
  base.send(1, 0, 0.2);
  base.rig.steps(51);
  EXPECT_GT(base.angle("steering"), 0.2);
  base.rig.step();
  EXPECT_EQ(base.velocity("traction"), 0);
  EXPECT_EQ(base.angle("steering"), 0);
}

TEST(OlderTricycle, TellsVelocityPoseAndCommandAsAsked) {
  Trike base(Rig::Values{{"odom_only_twist", {"true"}}, {"publish_ackermann_command", {"true"}}});
  base.rig.start();
  base.measure("traction", 8);
  base.steer("steering", 0.3);
  base.rig.steps(10);
  EXPECT_NEAR(base.rig.told("odom", "twist.twist.linear.x"), std::cos(0.3), 1e-12);
  EXPECT_NEAR(base.rig.told("odom", "twist.twist.angular.z"), std::sin(0.3) / 1.252, 1e-12);
  EXPECT_EQ(base.rig.told("odom", "pose.pose.position.x"), 0);
  EXPECT_EQ(base.rig.told("odom", "pose.pose.orientation.w"), 1);
  EXPECT_NEAR(base.base.odometry().heading(), 0.1 * std::sin(0.3) / 1.252, 1e-12);
  EXPECT_EQ(base.rig.told("cmd_ackermann", "speed"), 0);
  EXPECT_TRUE(std::isnan(base.rig.told("tf", "transform.rotation.w")));
  EXPECT_TRUE(base.base.reference_interfaces().empty());
  base.base.receive("reset_odometry", Numbers{}, false);
  base.rig.step();
  EXPECT_EQ(base.base.odometry().x(), 0);
}

TEST(OlderTricycle, NeedsBothJoints) {
  EXPECT_NE(Trike(Rig::Values{{"steering_joint_name", {""}}})
                .rig.refusal()
                .find("'steering_joint_name' is missing"),
            std::string::npos);
}

TEST(AngleLimiter, NeverOvershootsNorPassesItsLimits) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> any(-3, 3);
  for (int trial = 0; trial < 200; ++trial) {
    AngleLimiter limiter;
    limiter.set({-1.5, 1.2, 0.7, 2});
    limiter.reset(0);
    double speed = 0;
    for (int move = 0; move < 3; ++move) {
      const double wanted = any(random), target = std::clamp(wanted, -1.5, 1.2);
      const double side = limiter.angle() <= target ? 1 : -1;
      const bool from_rest = std::abs(speed) < 1e-9;
      for (int k = 0; k < 800; ++k) {
        const double before = limiter.angle();
        const double now = (limiter.next(wanted, 0.01) - before) / 0.01;
        ASSERT_LE(std::abs(now), 0.7 + 1e-9);
        ASSERT_LE(std::abs(now - speed), 0.02 + 1e-9);
        if (from_rest) {
          ASSERT_GE(side * (target - limiter.angle()), -1e-3);
        }
        speed = now;
      }
      ASSERT_NEAR(limiter.angle(), target, 1e-3);
    }
  }
}

TEST(Omnidirectional, DoesNothingThatWaits) {
  if (!test::RealtimeGuard::watches()) GTEST_SKIP() << "sanitizers bring their own allocator";
  Mecanum mecanum;
  Omni omni(4);
  Trike trike(Rig::Values{{"steering.max_velocity", {"1"}}, {"steering.max_acceleration", {"2"}}});
  const auto run = [](auto& base) {
    base.rig.start();
    for (int k = 0; k < 20; ++k) {
      base.send(0.01 * k, 0.1, 0.1);
      base.rig.verdict.speed = k % 10 == 0 ? 0 : 1;
      test::RealtimeGuard guard;
      for (int i = 0; i < 60; ++i) {
        base.base.update(base.rig.cycle, base.rig.verdict);
        base.rig.cycle.time += base.rig.cycle.period;
      }
      base.base.on_deactivate(base.rig.cycle);
      base.base.on_activate(base.rig.cycle);
      ASSERT_EQ(guard.violations(), "");
    }
  };
  run(mecanum);
  run(omni);
  run(trike);
}

}  // namespace
}  // namespace polyarm::controllers::omnidirectional_test
