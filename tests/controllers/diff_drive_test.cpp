#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "polyarm/plugins/types.hpp"
#include "tests/controllers/diff_drive_rig.hpp"
#include "tests/support/realtime_guard.hpp"

namespace polyarm::controllers {
namespace {

Rig::Values four_limits(const std::string& radius) {
  return {{"wheel_radius", {radius}},
          {"linear.x.max_acceleration", {"2"}},
          {"linear.x.max_deceleration", {"-4"}},
          {"linear.x.max_acceleration_reverse", {"-8"}},
          {"linear.x.max_deceleration_reverse", {"10"}}};
}

TEST(DiffDrive, IsFoundUnderItsName) {
  Parameters parameters;
  const auto made = make_controller("diff_drive_controller/DiffDriveController", parameters);
  EXPECT_NE(dynamic_cast<DiffDriveController*>(made.get()), nullptr);
}

TEST(DiffDrive, TurnsBothWheelsAlikeToGoStraight) {
  Base base;
  base.rig.start();
  base.command(1, 0);
  base.rig.step();
  EXPECT_DOUBLE_EQ(base.left(), 1);
  EXPECT_DOUBLE_EQ(base.right(), 1);
}

TEST(DiffDrive, SharesATurnBetweenTheSides) {
  Base base(Rig::Values{{"wheel_radius", {"0.1"}}});
  base.rig.start();
  base.command(0.5, 1);
  base.rig.step();
  EXPECT_DOUBLE_EQ(base.left(), (0.5 - 1 * 0.4 / 2) / 0.1);
  EXPECT_DOUBLE_EQ(base.right(), (0.5 + 1 * 0.4 / 2) / 0.1);
}

TEST(DiffDrive, CorrectsItsSizeByTheMultipliers) {
  Base base(Rig::Values{{"wheel_separation_multiplier", {"2"}},
                        {"left_wheel_radius_multiplier", {"0.5"}},
                        {"right_wheel_radius_multiplier", {"4"}}});
  base.rig.start();
  base.command(1, 1);
  base.rig.step();
  EXPECT_DOUBLE_EQ(base.left(), (1 - 0.4) / 0.5);
  EXPECT_DOUBLE_EQ(base.right(), (1 + 0.4) / 4);
}

TEST(DiffDrive, DrivesEveryWheelOfASide) {
  Base base(Rig::Values{{"left_wheel_names", {"left", "left_rear"}},
                        {"right_wheel_names", {"right", "right_rear"}}});
  base.rig.start();
  base.command(1, 1);
  base.rig.state("left/position") = 3;  // the mean of a side counts
  base.rig.state("left_rear/position") = 1;
  base.rig.state("right/position") = 0;
  base.rig.state("right_rear/position") = 4;
  base.rig.step();
  EXPECT_DOUBLE_EQ(base.rig.command("left_rear/velocity"), base.left());
  EXPECT_DOUBLE_EQ(base.rig.command("right_rear/velocity"), base.right());
  EXPECT_NEAR(base.rig.told("odom", "pose.pose.position.x"), 2, 1e-12);
}

TEST(DiffDrive, ReachesItsSpeedExactlyWhenTheAccelerationSays) {
  struct Way {
    double from, to, acceleration;
  };
  for (const Way way : {Way{0, 1, 2}, {1, 0, -4}, {0, -1, -8}, {-1, 0, 10}}) {
    Base base(four_limits("0.1"));
    base.rig.start();
    base.command(way.from, 0);
    for (int k = 0; k < 200; ++k) {  // long enough to have reached it
      base.command(way.from, 0);
      base.rig.step();
    }
    ASSERT_NEAR(base.left(), way.from / 0.1, 1e-9);
    const int cycles = static_cast<int>(std::ceil((way.to - way.from) / way.acceleration / 0.01 - 1e-9));
    base.command(way.to, 0);
    for (int k = 1; k < cycles; ++k) {
      base.rig.step();
      EXPECT_GT(std::abs(base.left() - way.to / 0.1), 1e-6) << way.to << " after " << k;
      EXPECT_NEAR(base.left(), (way.from + way.acceleration * 0.01 * k) / 0.1, 1e-9);
    }
    base.rig.step();
    EXPECT_NEAR(base.left(), way.to / 0.1, 1e-9);
    EXPECT_DOUBLE_EQ(base.left(), base.right());
  }
}

TEST(DiffDrive, TakesANewAccelerationWhileRunning) {
  Base base(four_limits("1"));
  base.rig.start();
  base.command(1, 0);
  base.rig.step();
  EXPECT_DOUBLE_EQ(base.left(), 0.02);
  EXPECT_EQ(base.rig.change("linear.x.max_acceleration", "5"), "");
  base.rig.step();
  EXPECT_DOUBLE_EQ(base.left(), 0.07);
}

TEST(DiffDrive, RefusesAChangeThatCouldNeverStop) {
  Base base(four_limits("1"));
  base.rig.start();
  EXPECT_NE(base.rig.change("linear.x.max_deceleration", "0").find("max_deceleration"), std::string::npos);
  EXPECT_THROW(base.rig.change("cmd_vel_timeout", ".nan"), Error);
  EXPECT_THROW(base.rig.change("linear.x.max_velocity", "-1"), Error);
  EXPECT_THROW(base.rig.change("wheel_radius", "2"), Error);
  EXPECT_EQ(base.rig.change("angular.z.max_velocity", "1"), "");
  base.command(0, 9);
  base.rig.step();
  EXPECT_DOUBLE_EQ(base.right(), 0.2);
}

TEST(DiffDrive, LimitsTurningApartFromGoing) {
  Base base(Rig::Values{{"angular.z.max_velocity", {"0.5"}}, {"linear.x.max_velocity", {"2"}}});
  base.rig.start();
  base.command(-7, -7);
  base.rig.step();
  EXPECT_DOUBLE_EQ((base.left() + base.right()) / 2, -2);
  EXPECT_DOUBLE_EQ((base.right() - base.left()) / 0.4, -0.5);
}

TEST(DiffDrive, RampsToRestWhenNoCommandComesAnyMore) {
  Base base(Rig::Values{{"linear.x.max_acceleration", {"2"}}});
  base.rig.start();
  base.command(0.1, 0);
  base.rig.steps(50);  // half a second: still young enough
  EXPECT_DOUBLE_EQ(base.left(), 0.1);
  base.rig.step();
  EXPECT_DOUBLE_EQ(base.left(), 0.1);
  base.rig.step();
  EXPECT_DOUBLE_EQ(base.left(), 0.08);  // through the limiter
  EXPECT_FALSE(base.drive.standing());
  base.rig.steps(4);
  EXPECT_EQ(base.left(), 0);
  EXPECT_TRUE(base.drive.standing());
}

TEST(DiffDrive, KeepsACommandForEverWithATimeoutOfZero) {
  Base base(Rig::Values{{"cmd_vel_timeout", {"0"}}});
  base.rig.start();
  base.command(0.1, 0, 1);  // a stamp from long ago is as good as any
  base.rig.steps(1000);
  EXPECT_DOUBLE_EQ(base.left(), 0.1);
}

TEST(DiffDrive, TakesTwistsWithAndWithoutStamp) {
  Base base;
  base.rig.start();
  base.command(0.1, 0, base.rig.cycle.time);
  base.rig.step();
  EXPECT_DOUBLE_EQ(base.left(), 0.1);
  base.command(0.2, 0);
  base.rig.step();
  EXPECT_DOUBLE_EQ(base.left(), 0.2);
  base.command(0.3, 0, 0);  // a stamp of zero means: now
  base.rig.step();
  EXPECT_DOUBLE_EQ(base.left(), 0.3);
  base.drive.receive("cmd_vel_unstamped", Twist{{0.4, 0, 0}, {}, {}}, false);
  base.rig.step();
  EXPECT_DOUBLE_EQ(base.left(), 0.4);
  EXPECT_EQ(base.drive.inputs().front().types.size(), 2u);
}

TEST(DiffDrive, IgnoresACommandThatWasTooLongOnItsWay) {
  Base base;
  base.rig.start();
  base.command(0.3, 0);
  base.rig.step();
  base.command(0.7, 0, base.rig.cycle.time - nanoseconds(0.5));
  base.rig.step();
  EXPECT_DOUBLE_EQ(base.left(), 0.3);
  base.command(0.7, 0, base.rig.cycle.time - nanoseconds(0.49));
  base.rig.step();
  EXPECT_DOUBLE_EQ(base.left(), 0.7);
  base.rig.steps(2);  // it ages by its stamp
  EXPECT_EQ(base.left(), 0);
}

TEST(DiffDrive, DoesNotTrustAStampFromTheFuture) {
  Base base;
  base.rig.start();
  base.command(0.3, 0, base.rig.cycle.time + nanoseconds(3600));
  base.rig.steps(52);
  EXPECT_EQ(base.left(), 0);
}

TEST(DiffDrive, IgnoresWhatIsNoSpeedAndSaysSo) {
  Base base;
  base.rig.start();
  base.command(0.3, 0);
  base.rig.step();
  for (const double wrong : {std::nan(""), HUGE_VAL, -HUGE_VAL, 1e300}) {
    EXPECT_THROW(base.command(wrong, 0), Error);
    EXPECT_THROW(base.command(0, wrong), Error);
  }
  base.rig.step();
  EXPECT_DOUBLE_EQ(base.left(), 0.3);
  EXPECT_THROW(base.drive.receive("cmd_vel", Numbers{{1}}, false), Error);
  EXPECT_THROW(base.drive.receive("cmd_veil", Twist{}, false), Error);
}

TEST(DiffDrive, ForgetsWhatWasSentBeforeItBecameActive) {
  Base base;
  base.rig.configure();
  base.command(1, 0);
  base.rig.activate();
  base.rig.step();
  EXPECT_EQ(base.left(), 0);
  EXPECT_TRUE(base.drive.standing());
}

TEST(DiffDrive, StopsItsWheelsWhenItBecomesInactive) {
  Base base(four_limits("1"));
  base.rig.start();
  base.command(1, 1);
  base.rig.steps(20);
  EXPECT_NE(base.left(), 0);
  base.drive.on_deactivate(base.rig.cycle);
  EXPECT_EQ(base.left(), 0);
  EXPECT_EQ(base.right(), 0);
  EXPECT_TRUE(base.drive.standing());
  base.rig.activate();
  base.rig.step();
  EXPECT_EQ(base.left(), 0);
}

TEST(DiffDrive, RampsDownOnAStopAndMovesNoMoreByItself) {
  Base base(Rig::Values{{"linear.x.max_acceleration", {"2"}}, {"cmd_vel_timeout", {"0"}}});
  base.rig.start();
  base.command(0.1, 0);
  base.rig.steps(10);
  base.rig.verdict.speed = 0;
  base.rig.step();
  EXPECT_DOUBLE_EQ(base.left(), 0.08);
  EXPECT_FALSE(base.drive.standing());
  base.command(0.1, 0);  // nor what is sent while it is held
  base.rig.steps(4);
  EXPECT_EQ(base.left(), 0);
  EXPECT_TRUE(base.drive.standing());
  base.rig.verdict.speed = 1;
  base.rig.steps(10);
  EXPECT_EQ(base.left(), 0);
  base.command(0.1, 0);
  base.rig.step();
  EXPECT_DOUBLE_EQ(base.left(), 0.02);
}

TEST(DiffDrive, StopsAtOnceWhenItMust) {
  Base base(Rig::Values{{"linear.x.max_acceleration", {"2"}}});
  base.rig.start();
  base.command(0.1, 0);
  base.rig.steps(10);
  base.rig.verdict = {0, true, false};
  base.rig.step();
  EXPECT_EQ(base.left(), 0);
  EXPECT_TRUE(base.drive.standing());
}

TEST(DiffDrive, GoesSlowerOnTheSameCurveUnderAnOverride) {
  Base base;
  base.rig.start();
  base.rig.verdict.speed = 0.5;
  base.command(1, 1);
  base.rig.step();
  EXPECT_DOUBLE_EQ(base.left(), 0.5 * (1 - 0.2));
  EXPECT_DOUBLE_EQ(base.right(), 0.5 * (1 + 0.2));
}

TEST(DiffDrive, FollowsItsReferencesWhenAnotherControllerWritesThem) {
  Base base;
  base.rig.start(true);
  EXPECT_EQ(base.drive.reference_interfaces(),
            (std::vector<std::string>{"drive/linear/velocity", "drive/angular/velocity"}));
  base.command(0.7, 0);  // not used now
  base.rig.step();
  EXPECT_EQ(base.left(), 0);
  base.rig.command("drive/linear/velocity") = 0.5;
  base.rig.command("drive/angular/velocity") = 1;
  base.rig.steps(200);  // no time-out here
  EXPECT_DOUBLE_EQ(base.left(), 0.3);
  EXPECT_DOUBLE_EQ(base.right(), 0.7);
  base.rig.command("drive/linear/velocity") = std::nan("");
  base.rig.step();
  EXPECT_DOUBLE_EQ(base.left(), 0.3);
  base.drive.set_chained(false);
  base.rig.step();
  EXPECT_EQ(base.left(), 0);
}

TEST(DiffDrive, TakesAReferenceAgainAfterAStopOnlyWhenItChanges) {
  Base base;
  base.rig.start(true);
  base.rig.command("drive/linear/velocity") = 0.5;
  base.rig.step();
  base.rig.verdict.speed = 0;
  base.rig.step();
  EXPECT_EQ(base.left(), 0);
  base.rig.verdict.speed = 1;
  base.rig.steps(10);
  EXPECT_EQ(base.left(), 0);
  base.rig.command("drive/linear/velocity") = 0.6;
  base.rig.step();
  EXPECT_DOUBLE_EQ(base.left(), 0.6);
}

TEST(DiffDrive, ShowsInItsReferencesWhatItFollows) {
  Base base;
  base.rig.start();
  base.command(0.3, 0.2);
  base.rig.step();
  EXPECT_DOUBLE_EQ(base.rig.command("drive/linear/velocity"), 0.3);
  EXPECT_DOUBLE_EQ(base.rig.command("drive/angular/velocity"), 0.2);
}

TEST(DiffDrive, ReadsNoWheelsInAnOpenLoop) {
  Base base(Rig::Values{{"open_loop", {"true"}}});
  base.rig.start();
  EXPECT_TRUE(base.drive.state_interfaces().empty());
  base.command(0.5, 0);
  base.rig.steps(10);
  EXPECT_NEAR(base.rig.told("odom", "pose.pose.position.x"), 0.05, 1e-12);
  EXPECT_DOUBLE_EQ(base.rig.told("odom", "twist.twist.linear.x"), 0.5);
}

TEST(DiffDrive, ReadsVelocitiesWhereThereAreNoPositions) {
  Base base(Rig::Values{{"position_feedback", {"false"}}});
  base.rig.start();
  EXPECT_EQ(base.drive.state_interfaces().front(), "base/left/velocity");
  base.rig.state("left/velocity") = 2;
  base.rig.state("right/velocity") = 2;
  base.rig.steps(100);
  EXPECT_NEAR(base.rig.told("odom", "pose.pose.position.x"), 2, 1e-12);
}

TEST(DiffDrive, CountsFromWhereItsWheelsStandWhenItStarts) {
  Base base;
  base.rig.configure();
  base.rig.state("left/position") = 50;
  base.rig.state("right/position") = -20;
  base.rig.activate();
  base.rig.step();
  EXPECT_EQ(base.rig.told("odom", "pose.pose.position.x"), 0);
  base.rig.state("left/position") = 50.1;
  base.rig.state("right/position") = -19.9;
  base.rig.step();
  EXPECT_NEAR(base.rig.told("odom", "pose.pose.position.x"), 0.1, 1e-12);
}

TEST(DiffDrive, FailsWhenAWheelIsNoLongerMeasured) {
  Base base;
  base.rig.start();
  base.rig.state("right/position") = std::nan("");
  EXPECT_EQ(base.rig.step(), ReturnType::error);
}

TEST(DiffDrive, TellsPlaceSpeedAndCovariances) {
  Base base(Rig::Values{{"position_feedback", {"false"}},
                        {"pose_covariance_diagonal", {"0.001", "0.001", "0.001", "0.001", "0.001", "0.01"}},
                        {"twist_covariance_diagonal", {"1", "2", "3", "4", "5", "6"}},
                        {"odom_frame_id", {"map"}},
                        {"velocity_rolling_window_size", {"1"}}});
  base.rig.start();
  base.rig.state("left/velocity") = -1;
  base.rig.state("right/velocity") = 1;
  base.rig.step();
  const double heading = 2 / 0.4 * 0.01;
  EXPECT_NEAR(base.rig.told("odom", "pose.pose.orientation.z"), std::sin(heading / 2), 1e-12);
  EXPECT_NEAR(base.rig.told("odom", "pose.pose.orientation.w"), std::cos(heading / 2), 1e-12);
  EXPECT_NEAR(base.rig.told("odom", "twist.twist.angular.z"), 5, 1e-12);
  EXPECT_EQ(base.rig.told("odom", "pose.covariance[0]"), 0.001);
  EXPECT_EQ(base.rig.told("odom", "pose.covariance[35]"), 0.01);
  EXPECT_EQ(base.rig.told("odom", "twist.covariance[7]"), 2);
  EXPECT_EQ(base.drive.find_output("odom")->type(), "nav_msgs/Odometry");
  EXPECT_EQ(base.drive.find_output("odom")->texts.at("frame_id"), "map");
  EXPECT_EQ(base.drive.find_output("odom")->texts.at("child_frame_id"), "base_link");
  EXPECT_NEAR(base.rig.told("tf", "transform.rotation.z"), std::sin(heading / 2), 1e-12);
}

TEST(DiffDrive, TellsTransformAndLimitedSpeedsWhereAsked) {
  Base base(Rig::Values{{"enable_odom_tf", {"false"}}, {"linear.x.max_velocity", {"0.25"}}});
  base.rig.start();
  base.command(1, 0);
  base.rig.step();
  EXPECT_TRUE(std::isnan(base.rig.told("tf", "transform.rotation.w")));
  EXPECT_TRUE(std::isnan(base.rig.told("cmd_vel_out", "twist.linear.x")));
  EXPECT_EQ(base.rig.change("publish_limited_velocity", "true"), "");
  EXPECT_EQ(base.rig.change("enable_odom_tf", "true"), "");
  base.rig.step();
  EXPECT_DOUBLE_EQ(base.rig.told("cmd_vel_out", "twist.linear.x"), 0.25);
  EXPECT_DOUBLE_EQ(base.rig.told("tf", "transform.rotation.w"), 1);
}

TEST(DiffDrive, PutsAPrefixBeforeItsFrames) {
  Base plain(Rig::Values{{"tf_frame_prefix", {"~"}}});
  plain.rig.start();
  EXPECT_EQ(plain.drive.find_output("odom")->texts.at("frame_id"), "odom");
  Base named(Rig::Values{{"tf_frame_prefix", {"/warehouse"}}});
  named.rig.start();
  EXPECT_EQ(named.drive.find_output("odom")->texts.at("frame_id"), "warehouse/odom");
  Base two(Rig::Values{{"tf_frame_prefix", {"~"}}});
  two.rig.context.joints.push_back(two.rig.context.joints.front());
  two.rig.context.joints.edit().back().name = "other/left";
  two.rig.start();
  EXPECT_EQ(two.drive.find_output("tf")->texts.at("child_frame_id"), "base/base_link");
}

TEST(DiffDrive, IsPutElsewhereByARequest) {
  Base base(Rig::Values{{"open_loop", {"true"}}});
  base.rig.start();
  base.drive.receive("set_odometry", Numbers{{3, 4, 1}}, false);
  base.rig.step();
  EXPECT_EQ(base.rig.told("odom", "pose.pose.position.x"), 3);
  EXPECT_EQ(base.rig.told("odom", "pose.pose.position.y"), 4);
  EXPECT_DOUBLE_EQ(base.rig.told("odom", "pose.pose.orientation.z"), std::sin(0.5));
  base.drive.receive("set_odometry", NamedValues{{"yaw"}, {0}}, false);
  base.rig.step();
  EXPECT_EQ(base.rig.told("odom", "pose.pose.position.x"), 0);
  EXPECT_THROW(base.drive.receive("set_odometry", Numbers{{3, 4}}, false), Error);
  EXPECT_THROW(base.drive.receive("set_odometry", Numbers{{3, 4, std::nan("")}}, false), Error);
  EXPECT_THROW(base.drive.receive("set_odometry", NamedValues{{"yow"}, {0}}, false), Error);
}

TEST(DiffDrive, NeverPassesItsLimitsWhateverIsAsked) {
  Base base(Rig::Values{{"wheel_radius", {"0.1"}},
                        {"linear.x.max_velocity", {"0.5"}},
                        {"linear.x.max_acceleration", {"1"}},
                        {"angular.z.max_velocity", {"1"}},
                        {"angular.z.max_acceleration", {"4"}},
                        {"angular.z.max_jerk", {"50"}}});
  base.rig.start();
  std::mt19937 random(3);
  std::uniform_real_distribution<double> wish(-5, 5);
  double linear = 0, angular = 0;
  for (int k = 0; k < 20000; ++k) {
    if (random() % 5 == 0) base.command(wish(random), wish(random));
    base.rig.verdict.speed = random() % 50 == 0 ? 0 : 1;
    base.rig.step();
    const double now = (base.left() + base.right()) * 0.1 / 2;
    const double turning = (base.right() - base.left()) * 0.1 / 0.4;
    ASSERT_LE(std::abs(now), 0.5 + 1e-12);
    ASSERT_LE(std::abs(turning), 1 + 1e-12);
    ASSERT_LE(std::abs(now - linear), 0.01 + 1e-12);
    ASSERT_LE(std::abs(turning - angular), 0.04 + 1e-12);
    linear = now, angular = turning;
  }
}

TEST(DiffDrive, DoesNothingThatWaits) {
  if (!test::RealtimeGuard::watches()) GTEST_SKIP() << "sanitizers bring their own allocator";
  for (const char* open_loop : {"true", "false"}) {
    Base base(plus(four_limits("0.1"), {{"open_loop", {open_loop}}, {"publish_limited_velocity", {"true"}}}));
    base.rig.start();
    base.rig.steps(10);
    for (int k = 0; k < 100; ++k) {
      base.command(0.01 * k, 1);
      base.drive.receive("set_odometry", Numbers{{1, 2, 3}}, false);
      base.rig.verdict.speed = k % 10 == 0 ? 0 : 1;
      test::RealtimeGuard guard;
      for (int i = 0; i < 100; ++i) {
        base.drive.update(base.rig.cycle, base.rig.verdict);
        base.rig.cycle.time += base.rig.cycle.period;
      }
      base.drive.on_deactivate(base.rig.cycle);
      base.drive.on_activate(base.rig.cycle);
      base.drive.on_parameters_changed();
      ASSERT_EQ(guard.violations(), "");
    }
  }
}

}  // namespace
}  // namespace polyarm::controllers
