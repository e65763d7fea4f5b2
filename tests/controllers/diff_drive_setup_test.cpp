#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/controllers/diff_drive_rig.hpp"

namespace polyarm::controllers {
namespace {

TEST(DiffDriveSetup, RefusesUnequalSidesWithASentence) {
  Base base(Rig::Values{{"left_wheel_names", {"left", "left_rear"}}});
  const std::string why = base.rig.refusal();
  EXPECT_NE(why.find("2 wheels on the left and 1 on the right"), std::string::npos) << why;
  EXPECT_NE(why.find("controllers.yaml:10"), std::string::npos) << why;
}

TEST(DiffDriveSetup, RefusesWhatCannotBeADrive) {
  const std::pair<Rig::Values, const char*> kWrong[] = {
      {{{"left_wheel_names", {}}, {"right_wheel_names", {}}}, "no wheels"},
      {{{"left_wheel_names", {"lefd"}}}, "did you mean 'left'"},
      {{{"left_wheel_names", {"right"}}}, "'right' is named twice"},
      {{{"wheel_separation", {"0"}}}, "wheel_separation must be a number above 0"},
      {{{"wheel_radius", {".nan"}}}, "'wheel_radius: .nan' is not a finite number"},
      {{{"wheel_radius", {"wide"}}}, "'wheel_radius: wide' is not a number"},
      {{{"left_wheel_radius_multiplier", {"0"}}}, "left_wheel_radius_multiplier must not be 0"},
      {{{"pose_covariance_diagonal", {"1", "2"}}}, "has 2 numbers, it needs 6"},
      {{{"linear.x.max_velocity", {"-1"}}}, "'linear.x.max_velocity: -1' is not a number of at least 0"},
      {{{"angular.z.min_velocity", {"1"}}}, "'angular.z.min_velocity: 1' is not a number of at most 0"},
      {{{"linear.x.has_velocity_limits", {"perhaps"}}}, "is not true or false"},
      {{{"cmd_vel_timeout", {"-1"}}}, "cmd_vel_timeout: -1"},
      {{{"cmd_vel_timeout", {".nan"}}}, "'cmd_vel_timeout: .nan' is not a number of at least 0"},
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

TEST(DiffDriveSetup, HasALimitOfZeroOnlyWhereItIsMeant) {
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

TEST(DiffDriveSetup, TakesABrakeOfZeroAsNotStated) {
  Base base(Rig::Values{{"linear.x.max_acceleration", {"2"}}, {"linear.x.max_deceleration", {"0"}}});
  base.rig.start();
  EXPECT_NE(base.rig.findings().find("would never let it stop"), std::string::npos);
  base.command(0.02, 0);
  base.rig.step();
  base.command(0, 0);
  base.rig.step();
  EXPECT_EQ(base.left(), 0);
}

TEST(DiffDriveSetup, TellsWhichLimitsHaveNoEffect) {
  Base base(Rig::Values{{"linear.x.max_deceleration", {"-1"}}, {"angular.z.min_velocity", {"-1"}}});
  base.rig.start();
  EXPECT_NE(base.rig.findings().find("'linear.x.max_deceleration' has no effect without max_acceleration"),
            std::string::npos);
  EXPECT_NE(base.rig.findings().find("'angular.z.min_velocity' has no effect without max_velocity"),
            std::string::npos);
}

TEST(DiffDriveSetup, UnderstandsTheNamesOfRos1) {
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

TEST(DiffDriveSetup, RunsTheJetBotAsItsFileStands) {
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

TEST(DiffDriveSetup, SurvivesWhateverItsFileSays) {
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
