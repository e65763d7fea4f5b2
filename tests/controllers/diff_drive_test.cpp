#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "polyarm/controllers/diff_drive_controller.hpp"
#include "polyarm/controllers/types.hpp"
#include "tests/controllers/rig.hpp"
#include "tests/support/realtime_guard.hpp"

namespace polyarm::controllers {
namespace {

const std::vector<std::string> kWheels = {"left", "right", "left_rear", "right_rear"};

std::vector<std::string> interfaces(std::initializer_list<const char*> kinds) {
  std::vector<std::string> out;
  for (const std::string& wheel : kWheels)
    for (const char* kind : kinds) out.push_back(wheel + "/" + kind);
  return out;
}

Rig::Values plus(Rig::Values values, const Rig::Values& more) {
  for (const auto& [key, value] : more) values[key] = value;
  return values;
}

/// A base with a separation of 0.4 m and wheels of 1 m radius, which knows the wheels' feedback.
struct Base {
  DiffDriveController drive;
  Rig rig;
  explicit Base(const Rig::Values& more = {})
      : rig(drive, "base", kWheels, interfaces({"position", "velocity"}), interfaces({"velocity"}),
            plus({{"left_wheel_names", {"left"}},
                  {"right_wheel_names", {"right"}},
                  {"wheel_separation", {"0.4"}},
                  {"wheel_radius", {"1"}}},
                 more),
            "drive") {}
  void command(double linear, double angular, std::optional<Nanoseconds> stamp = {}) {
    drive.receive("cmd_vel", Twist{{linear, 0, 0}, {0, 0, angular}, stamp}, false);
  }
  double left() { return rig.command("left/velocity"); }
  double right() { return rig.command("right/velocity"); }
};

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
  EXPECT_NE(base.rig.change("cmd_vel_timeout", ".nan"), "");
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
  two.rig.context.joints.back().name = "other/left";
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

TEST(DiffDrive, RefusesUnequalSidesWithASentence) {
  Base base(Rig::Values{{"left_wheel_names", {"left", "left_rear"}}});
  const std::string why = base.rig.refusal();
  EXPECT_NE(why.find("2 wheels on the left and 1 on the right"), std::string::npos) << why;
  EXPECT_NE(why.find("controllers.yaml:10"), std::string::npos) << why;
}

TEST(DiffDrive, RefusesWhatCannotBeADrive) {
  const std::pair<Rig::Values, const char*> kWrong[] = {
      {{{"left_wheel_names", {}}, {"right_wheel_names", {}}}, "no wheels"},
      {{{"left_wheel_names", {"lefd"}}}, "did you mean 'left'"},
      {{{"left_wheel_names", {"right"}}}, "'right' is named twice"},
      {{{"wheel_separation", {"0"}}}, "wheel_separation must be a number above 0"},
      {{{"wheel_radius", {".nan"}}}, "wheel_radius must be a number above 0"},
      {{{"wheel_radius", {"wide"}}}, "'wheel_radius: wide' is not a number"},
      {{{"left_wheel_radius_multiplier", {"0"}}}, "left_wheel_radius_multiplier must not be 0"},
      {{{"pose_covariance_diagonal", {"1", "2"}}}, "has 2 numbers, it needs 6"},
      {{{"linear.x.max_velocity", {"-1"}}}, "'linear.x.max_velocity: -1' is not a number of at least 0"},
      {{{"angular.z.min_velocity", {"1"}}}, "'angular.z.min_velocity: 1' is not a number of at most 0"},
      {{{"linear.x.has_velocity_limits", {"perhaps"}}}, "is not true or false"},
      {{{"cmd_vel_timeout", {"-1"}}}, "cmd_vel_timeout: -1"},
      {{{"cmd_vel_timeout", {".nan"}}}, "cmd_vel_timeout is not a number"},
      {{{"velocity_rolling_window_size", {"0"}}}, "velocity_rolling_window_size: 0"},
      {{{"velocity_rolling_window_size", {"2000000000"}}}, "velocity_rolling_window_size: 2000000000"},
  };
  for (const auto& [values, sentence] : kWrong) {
    Base base(values);
    const std::string why = base.rig.refusal();
    EXPECT_NE(why.find(sentence), std::string::npos) << why;
    EXPECT_NE(why.find("controllers.yaml:"), std::string::npos) << why;
  }
}

TEST(DiffDrive, HasALimitOfZeroOnlyWhereItIsMeant) {
  Base off(Rig::Values{{"linear.x.has_velocity_limits", {"false"}}, {"linear.x.max_velocity", {"0"}}});
  off.rig.start();
  off.command(1, 0);
  off.rig.step();
  EXPECT_DOUBLE_EQ(off.left(), 1);
  EXPECT_NE(off.rig.findings().find("older release's way"), std::string::npos);
  Base on(Rig::Values{{"linear.x.has_velocity_limits", {"true"}}, {"linear.x.max_velocity", {"0"}}});
  on.rig.start();
  on.command(1, 0);
  on.rig.step();
  EXPECT_EQ(on.left(), 0);
}

TEST(DiffDrive, TakesABrakeOfZeroAsNotStated) {
  Base base(Rig::Values{{"linear.x.max_acceleration", {"2"}}, {"linear.x.max_deceleration", {"0"}}});
  base.rig.start();
  EXPECT_NE(base.rig.findings().find("would never let it stop"), std::string::npos);
  base.command(0.02, 0);
  base.rig.step();
  base.command(0, 0);
  base.rig.step();
  EXPECT_EQ(base.left(), 0);
}

TEST(DiffDrive, TellsWhichLimitsHaveNoEffect) {
  Base base(Rig::Values{{"linear.x.max_deceleration", {"-1"}}, {"angular.z.min_velocity", {"-1"}}});
  base.rig.start();
  EXPECT_NE(base.rig.findings().find("'linear.x.max_deceleration' has no effect without max_acceleration"),
            std::string::npos);
  EXPECT_NE(base.rig.findings().find("'angular.z.min_velocity' has no effect without max_velocity"),
            std::string::npos);
}

TEST(DiffDrive, UnderstandsTheNamesOfRos1) {
  Base base(Rig::Values{{"left_wheel", {"left_rear"}},
                        {"right_wheel", {"right_rear"}},
                        {"wheel_radius_multiplier", {"2"}},
                        {"linear.x.has_acceleration_limits", {"true"}},
                        {"linear.x.max_acceleration", {"1"}},
                        {"linear.x.min_acceleration", {"-3"}},
                        {"publish_cmd", {"true"}}});
  base.rig.context.parameters.entries.erase("left_wheel_names");
  base.rig.context.parameters.entries.erase("right_wheel_names");
  base.rig.start();
  base.command(1, 0);
  base.rig.steps(10);
  EXPECT_NEAR(base.rig.command("left_rear/velocity"), 0.05, 1e-12);
  EXPECT_NEAR(base.rig.told("cmd_vel_out", "twist.linear.x"), 0.1, 1e-12);
  base.command(0, 0);
  base.rig.step();
  EXPECT_NEAR(base.rig.told("cmd_vel_out", "twist.linear.x"), 0.07, 1e-12);
  EXPECT_NE(base.rig.findings().find("write left_wheel_names"), std::string::npos);
}

/// The JetBot's lines, as they stand in its file.
Rig::Values jetbot() {
  return {{"left_wheel_names", {"left"}},
          {"right_wheel_names", {"right"}},
          {"wheel_separation", {"0.104"}},
          {"wheel_radius", {"0.032"}},
          {"wheel_separation_multiplier", {"1.0"}},
          {"left_wheel_radius_multiplier", {"1.0"}},
          {"right_wheel_radius_multiplier", {"1.0"}},
          {"publish_rate", {"50.0"}},
          {"odom_frame_id", {"odom"}},
          {"base_frame_id", {"base_link"}},
          {"pose_covariance_diagonal", {"0.001", "0.001", "0.001", "0.001", "0.001", "0.01"}},
          {"twist_covariance_diagonal", {"0.001", "0.001", "0.001", "0.001", "0.001", "0.01"}},
          {"open_loop", {"true"}},
          {"enable_odom_tf", {"true"}},
          {"position_feedback", {"false"}},
          {"cmd_vel_timeout", {"0.5"}},
          {"use_stamped_vel", {"false"}},
          {"linear.x.has_velocity_limits", {"true"}},
          {"linear.x.has_acceleration_limits", {"true"}},
          {"linear.x.has_jerk_limits", {"false"}},
          {"linear.x.max_velocity", {"0.016"}},
          {"linear.x.min_velocity", {"-0.016"}},
          {"linear.x.max_acceleration", {"0.07"}},
          {"linear.x.max_jerk", {"0.0"}},
          {"linear.x.min_jerk", {"0.0"}},
          {"angular.z.has_velocity_limits", {"true"}},
          {"angular.z.max_velocity", {"0.25"}},
          {"angular.z.min_velocity", {"-0.25"}},
          {"angular.z.max_acceleration", {"1.0"}},
          {"angular.z.min_acceleration", {"-1.0"}}};
}

TEST(DiffDrive, RunsTheJetBotAsItsFileStands) {
  Base base(jetbot());
  base.rig.cycle.period = 100'000'000;  // its update_rate is 10
  base.rig.start();
  for (int k = 0; k < 30; ++k) {
    base.command(1, 1);
    base.rig.step();
  }
  EXPECT_NEAR(base.right(), 0.016 / 0.032 + 0.25 * 0.104 / 2 / 0.032, 1e-12);  // 0.5 + 0.406
  EXPECT_NEAR(base.right(), 0.906, 5e-4);
  const std::string findings = base.rig.findings();
  for (const char* key : {"publish_rate", "use_stamped_vel", "linear.x.has_velocity_limits",
                          "linear.x.has_jerk_limits", "angular.z.has_velocity_limits"})
    EXPECT_NE(findings.find(std::string("'") + key), std::string::npos) << key << "\n" << findings;
  EXPECT_EQ(findings.find("has no parameter"), std::string::npos) << findings;
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

TEST(DiffDrive, SurvivesWhateverItsFileSays) {
  const char* kKeys[] = {"left_wheel_names",
                         "right_wheel_names",
                         "wheel_separation",
                         "wheel_radius",
                         "linear.x.max_velocity",
                         "linear.x.min_acceleration",
                         "angular.z.has_jerk_limits",
                         "cmd_vel_timeout",
                         "pose_covariance_diagonal",
                         "tf_frame_prefix",
                         "left_wheel",
                         "velocity_rolling_window_size",
                         "wheel_radius_multiplier"};
  const std::vector<std::string> kValues[] = {
      {},       {""},     {"~~//"},          {"1e400"}, {"-1e308"},   {".inf"},
      {"true"}, {"left"}, {"right", "left"}, {"0"},     {"\x01\xff"}, {"1", "2"}};
  std::mt19937 random(5);
  int configured = 0;
  for (int round = 0; round < 3000; ++round) {
    Base base;
    for (int n = 0; n < 2; ++n)
      base.rig.set(kKeys[random() % std::size(kKeys)], kValues[random() % std::size(kValues)]);
    if (!base.rig.refusal().empty()) continue;
    ++configured;
    base.rig.activate();
    base.command(1, 1);
    base.rig.step();
  }
  EXPECT_GT(configured, 100);
}

}  // namespace
}  // namespace polyarm::controllers
