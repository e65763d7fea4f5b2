#include "drivers/pca9685/settings.hpp"

#include <gtest/gtest.h>

#include "polyarm/base/error.hpp"
#include "tests/pca9685/rig.hpp"

namespace polyarm::drivers {
namespace {

using test::jetbot;
using test::wheels_on;

std::vector<std::string> complaints(std::map<std::string, std::string> changes,
                                    Nanoseconds period = 20'000'000) {
  auto parameters = jetbot("/dev/i2c-1");
  for (auto& [key, value] : changes)
    if (value == "-")
      parameters.erase(key);
    else
      parameters[key] = value;
  std::vector<std::string> out;
  try {
    read_settings(wheels_on(parameters, period));
  } catch (const Error& e) {
    for (const Problem& problem : e.problems()) out.push_back(problem.what + " [" + problem.advice + "]");
  }
  return out;
}

TEST(Settings, TheJetBotNeedsItsPinsAlone) {
  auto parameters = jetbot("1");
  const BoardSettings s = read_settings(wheels_on(parameters, 100'000'000));
  EXPECT_EQ(s.bus, "/dev/i2c-1");
  EXPECT_EQ(s.address, 0x60);
  EXPECT_EQ(s.prescale, 3);
  EXPECT_EQ(s.watchdog_ms, 400) << "four writes at 10 Hz";
  ASSERT_EQ(s.wheels.size(), 2u);
  EXPECT_EQ(s.wheels[0].motor.enable, 8);
  EXPECT_EQ(s.wheels[1].motor.positive, 12);
  EXPECT_EQ(s.wheels[1].motor.negative, 11);
  EXPECT_EQ(s.wheels[1].joint, "right_wheel_joint");
  EXPECT_EQ(s.states.size(), 4u);
  EXPECT_EQ(s.commands[1].name, "base/right_wheel_joint/velocity");
}

TEST(Settings, MotorsDifferWhereTheySaySo) {
  auto parameters = jetbot("/dev/i2c-7");
  parameters.insert({{"address", "0x40"},
                     {"frequency", "50"},
                     {"trim", "0.9"},
                     {"trim_1", "1.1"},
                     {"direction_1", "-1"},
                     {"stop_0", "brake"},
                     {"max_duty", "0.5"},
                     {"least_duty_1", "0.2"},
                     {"watchdog_ms", "300"}});
  const BoardSettings s = read_settings(wheels_on(parameters));
  EXPECT_EQ(s.address, 0x40);
  EXPECT_EQ(s.prescale, 121);
  EXPECT_EQ(s.watchdog_ms, 300);
  EXPECT_EQ(s.wheels[0].motor.trim, 0.9);
  EXPECT_EQ(s.wheels[1].motor.trim, 1.1);
  EXPECT_EQ(s.wheels[0].motor.direction, 1);
  EXPECT_EQ(s.wheels[1].motor.direction, -1);
  EXPECT_TRUE(s.wheels[0].motor.brake);
  EXPECT_FALSE(s.wheels[1].motor.brake);
  EXPECT_EQ(s.wheels[1].motor.most_duty, 0.5);
  EXPECT_EQ(s.wheels[1].motor.least_duty, 0.2);
}

struct Wrong {
  const char* key;
  const char* value;
  const char* says;
};

class WrongSettings : public ::testing::TestWithParam<Wrong> {};

TEST_P(WrongSettings, AreNamed) {
  const auto said = complaints({{GetParam().key, GetParam().value}});
  ASSERT_EQ(said.size(), 1u) << (said.empty() ? "nothing" : said[0] + said.back());
  EXPECT_NE(said[0].find(GetParam().says), std::string::npos) << said[0];
  EXPECT_NE(said[0].find("JetBot"), std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(
    Table, WrongSettings,
    ::testing::Values(Wrong{"pin_enable_0", "-", "pin_enable_0 is not stated"},
                      Wrong{"pin_pos_1", "16", "pin_pos_1 = '16' is not a channel"},
                      Wrong{"pin_neg_1", "x", "pin_neg_1 = 'x' is not a channel"},
                      Wrong{"pin_neg_1", "-3", "pin_neg_1 = '-3' is not a channel"},
                      Wrong{"pin_pos_1", "8", "channel 8 is used twice, by motors 0 and 1"},
                      Wrong{"pin_enable_2", "3", "no parameter 'pin_enable_2'"},
                      Wrong{"address", "0x20", "0x40 to 0x7F"}, Wrong{"address", "0x", "0x40 to 0x7F"},
                      Wrong{"address", "abc", "0x40 to 0x7F"}, Wrong{"address", "99999999999", "0x40"},
                      Wrong{"frequency", "10", "24 to 1743 Hz"}, Wrong{"frequency", "nan", "24 to 1743 Hz"},
                      Wrong{"speed_scale", "0", "speed_scale"}, Wrong{"speed_scale_1", "-1", "speed_scale_1"},
                      Wrong{"trim", "100", "trim"}, Wrong{"dead_band", "-1", "dead_band"},
                      Wrong{"max_duty_0", "1.5", "max_duty_0"}, Wrong{"least_duty", "1", "least_duty"},
                      Wrong{"direction_0", "2", "not one of 1, -1"},
                      Wrong{"stop", "halt", "not one of coast, brake"}, Wrong{"watchdog_ms", "30", "two writes"},
                      Wrong{"watchdog_ms", "60000", "watchdog_ms"},
                      Wrong{"spede_scale", "1", "did you mean 'speed_scale'"},
                      Wrong{"bus", "", "bus is empty"}));

TEST(Settings, AllThatIsWrongIsToldAtOnce) {
  EXPECT_EQ(complaints({{"address", "1"}, {"frequency", "1"}, {"stop", "x"}, {"pin_pos_0", "-"}}).size(), 4u);
}

TEST(Settings, InterfacesThatABoardWithoutEncodersHasNotAreRefused) {
  auto context = wheels_on(jetbot("1"));
  auto& block = context.robots[0].hardware[0];
  block.components[0].command_interfaces[0].name = "position";
  block.components[1].state_interfaces[0].name = "effort";
  block.components.push_back({"imu", "sensor"});
  try {
    read_settings(context);
    FAIL();
  } catch (const Error& e) {
    ASSERT_EQ(e.problems().size(), 3u) << e.what();
  }
}

}  // namespace
}  // namespace polyarm::drivers
