/// Distance sensors, magnetometers, batteries, and states that are filtered.
#include <gtest/gtest.h>

#include <cmath>

#include "polyarm/broadcasters/battery_state_broadcaster.hpp"
#include "polyarm/broadcasters/chained_filter.hpp"
#include "polyarm/broadcasters/magnetometer_broadcaster.hpp"
#include "polyarm/broadcasters/range_sensor_broadcaster.hpp"
#include "tests/controllers/rig.hpp"
#include "tests/support/realtime_guard.hpp"

namespace polyarm::controllers::small_broadcasters_test {
namespace {

TEST(RangeSensor, TellsItsDistanceAndItsLimits) {
  RangeSensorBroadcaster range;
  Rig rig(range, "arm", {}, {"sonar/range"}, {},
          {{"sensor_name", {"sonar"}},
           {"frame_id", {"bumper"}},
           {"radiation_type", {"1"}},
           {"max_range", {"7"}},
           {"variance", {"0.1"}}});
  rig.start();
  rig.state("sonar/range") = 3.1;
  rig.step();
  EXPECT_EQ(rig.told("range", "range"), 3.1);
  EXPECT_EQ(rig.told("range", "radiation_type"), 1);
  EXPECT_EQ(rig.told("range", "field_of_view"), 0.52);
  EXPECT_EQ(rig.told("range", "min_range"), 0.52);
  EXPECT_EQ(rig.told("range", "max_range"), 7);
  EXPECT_EQ(rig.told("range", "variance"), 0.1);
  EXPECT_EQ(range.find_output("range")->texts.at("frame_id"), "bumper");
  rig.set("sensor_name", {"sonor"});
  EXPECT_NE(rig.refusal().find("did you mean 'sonar'"), std::string::npos);
}

TEST(Magnetometer, TellsTheFieldAndItsCovariance) {
  MagnetometerBroadcaster magnetometer;
  Rig rig(magnetometer, "arm", {},
          {"compass/magnetic_field.x", "compass/magnetic_field.y", "compass/magnetic_field.z"}, {},
          {{"static_covariance", {"1", "2", "3", "4", "5", "6", "7", "8", "9"}}});
  rig.start();
  rig.state("compass/magnetic_field.y") = 4e-5;
  rig.step();
  EXPECT_EQ(rig.told("magnetic_field", "magnetic_field.y"), 4e-5);
  EXPECT_EQ(rig.told("magnetic_field", "magnetic_field_covariance[5]"), 6);
  EXPECT_EQ(magnetometer.find_output("magnetic_field")->texts.at("frame_id"), "compass");
}

const std::vector<std::string> kBatteryStates = {
    "left/battery_voltage",    "left/battery_temperature",
    "left/battery_percentage", "left/battery_power_supply_health",
    "right/battery_voltage",   "right/battery_charge",
    "right/battery_present",   "old/voltage"};

TEST(Batteries, AreToldEachAndTogether) {
  BatteryStateBroadcaster batteries;
  Rig rig(batteries, "base", {}, kBatteryStates, {},
          {{"batteries", {"left", "right"}},
           {"interfaces.left.battery_temperature", {"true"}},
           {"interfaces.left.battery_percentage", {"true"}},
           {"interfaces.left.battery_power_supply_health", {"true"}},
           {"interfaces.right.battery_charge", {"true"}},
           {"interfaces.right.battery_present", {"true"}},
           {"right.minimum_voltage", {"20"}},
           {"right.maximum_voltage", {"30"}},
           {"left.capacity", {"8"}},
           {"right.capacity", {"10"}},
           {"left.power_supply_technology", {"2"}},
           {"right.power_supply_technology", {"3"}},
           {"left.location", {"slot 1"}}});
  rig.start();
  rig.state("left/battery_voltage") = 24;
  rig.state("left/battery_temperature") = 31;
  rig.state("left/battery_percentage") = 60;
  rig.state("left/battery_power_supply_health") = 2;
  rig.state("right/battery_voltage") = 28;
  rig.state("right/battery_charge") = 5;
  rig.state("right/battery_present") = 1;
  rig.step();
  EXPECT_EQ(rig.told("raw_battery_states", "battery_states[0].voltage"), 24);
  EXPECT_EQ(rig.told("raw_battery_states", "battery_states[1].percentage"), 80);
  EXPECT_TRUE(std::isnan(rig.told("raw_battery_states", "battery_states[1].temperature")));
  EXPECT_EQ(rig.told("battery_state", "voltage"), 26);
  EXPECT_EQ(rig.told("battery_state", "temperature"), 31);
  EXPECT_EQ(rig.told("battery_state", "percentage"), 70);
  EXPECT_EQ(rig.told("battery_state", "charge"), 5);
  EXPECT_EQ(rig.told("battery_state", "capacity"), 18);
  EXPECT_TRUE(std::isnan(rig.told("battery_state", "current")));
  EXPECT_EQ(rig.told("battery_state", "power_supply_health"), 2);
  EXPECT_EQ(rig.told("battery_state", "power_supply_technology"), 0);  // they differ
  EXPECT_EQ(rig.told("battery_state", "present"), 1);
  EXPECT_EQ(batteries.find_output("battery_state")->texts.at("location"), "slot 1, ");
}

TEST(Batteries, UnderstandTheOlderNameOfOne) {
  BatteryStateBroadcaster batteries;
  Rig rig(batteries, "base", {}, kBatteryStates, {}, {{"sensor_name", {"old"}}, {"design_capacity", {"4"}}});
  rig.start();
  rig.state("old/voltage") = 12.5;
  rig.step();
  EXPECT_EQ(rig.told("battery_state", "voltage"), 12.5);
  EXPECT_EQ(rig.told("battery_state", "design_capacity"), 4);
  EXPECT_EQ(rig.told("battery_state", "present"), 1);
  rig.state("old/voltage") = 0;
  rig.step();
  EXPECT_EQ(rig.told("battery_state", "present"), 0);
}

TEST(Batteries, SayWhatIsWrong) {
  const std::pair<Rig::Values, const char*> kWrong[] = {
      {{}, "it names no batteries"},
      {{{"batteries", {"left"}}, {"sensor_name", {"old"}}}, "are both there"},
      {{{"batteries", {"middle"}}}, "there is no state 'middle/battery_voltage'"},
      {{{"batteries", {"left"}}, {"interfaces.left.battery_charge", {"true"}}}, "'left/battery_charge'"},
      {{{"batteries", {"left"}}, {"left.minimum_voltage", {"30"}}, {"left.maximum_voltage", {"20"}}},
       "is not above"},
  };
  for (const auto& [values, sentence] : kWrong) {
    BatteryStateBroadcaster batteries;
    Rig rig(batteries, "base", {}, kBatteryStates, {}, values);
    const std::string why = rig.refusal();
    EXPECT_NE(why.find(sentence), std::string::npos) << sentence << "\n" << why;
  }
}

const std::vector<std::string> kWheelStates = {"left/position", "right/position"};

TEST(FilterChain, ExportsTheMeanOfTheLastValues) {
  ChainedFilter filter;
  Rig rig(filter, "base", {}, kWheelStates, {},
          {{"input_interfaces", {"left/position"}},
           {"output_interfaces", {"left/filtered_position"}},
           {"filter_chain.filter1.name", {"filter1"}},
           {"filter_chain.filter1.type", {"filters/MeanFilterDouble"}},
           {"filter_chain.filter1.params.number_of_observations", {"2"}}},
          "smooth");
  rig.start();
  double& out = rig.state("smooth/left/filtered_position");
  EXPECT_TRUE(std::isnan(out));
  const std::pair<double, double> kSteps[] = {{1.1, 1.1}, {2.1, 1.6}, {NAN, 1.6}, {3.1, 2.6}};
  for (const auto& [in, expected] : kSteps) {
    rig.state("left/position") = in;
    rig.step();
    EXPECT_NEAR(out, expected, 1e-12);
  }
}

TEST(FilterChain, FiltersEachInputByItsOwnChain) {
  ChainedFilter filter;
  Rig rig(filter, "base", {}, kWheelStates, {},
          {{"input_interfaces", {"left/position", "right/position"}},
           {"output_interfaces", {"left/smooth", "right/smooth"}},
           {"left/position.filter_chain.filter1.type", {"filters/MedianFilterDouble"}},
           {"left/position.filter_chain.filter1.params.number_of_observations", {"3"}},
           {"right/position.filter_chain.filter1.type", {"control_filters/ExponentialFilterDouble"}},
           {"right/position.filter_chain.filter1.params.alpha", {"0.5"}},
           {"right/position.filter_chain.filter2.type", {"control_filters/ExponentialFilterDouble"}},
           {"right/position.filter_chain.filter2.params.alpha", {"0.5"}}},
          "smooth");
  rig.start();
  for (const double value : {0.0, 100.0, 1.0}) {
    rig.state("left/position") = value;
    rig.state("right/position") = 8;
    rig.step();
  }
  EXPECT_EQ(rig.state("smooth/left/smooth"), 1);
  EXPECT_EQ(rig.state("smooth/right/smooth"), 8);
  rig.state("right/position") = 0;
  rig.step();
  EXPECT_EQ(rig.state("smooth/right/smooth"), 6);
}

TEST(FilterChain, ReportsTheProblem) {
  const std::pair<Rig::Values, const char*> kWrong[] = {
      {{{"input_interfaces", {"left/position"}}, {"output_interfaces", {"a", "b"}}},
       "1 input_interfaces and 2 output_interfaces"},
      {{{"input_interfaces", {"left/positron"}},
        {"output_interfaces", {"a"}},
        {"filter_chain.filter1.type", {"filters/MeanFilterDouble"}}},
       "there is no state 'left/positron'"},
      {{{"input_interfaces", {"left/position"}}, {"output_interfaces", {"a"}}}, "filter1.type' is missing"},
      {{{"input_interfaces", {"left/position"}},
        {"output_interfaces", {"a"}},
        {"filter_chain.filter1.type", {"filters/Magic"}}},
       "there is no filter 'filters/Magic'"},
  };
  for (const auto& [values, sentence] : kWrong) {
    ChainedFilter filter;
    Rig rig(filter, "base", {}, kWheelStates, {}, values);
    EXPECT_NE(rig.refusal().find(sentence), std::string::npos) << sentence << "\n" << rig.refusal();
  }
}

TEST(FilterChain, DoesNothingThatWaits) {
  if (!test::RealtimeGuard::watches()) GTEST_SKIP() << "sanitizers bring their own allocator";
  ChainedFilter filter;
  Rig rig(filter, "base", {}, kWheelStates, {},
          {{"input_interfaces", {"left/position"}},
           {"output_interfaces", {"smooth"}},
           {"filter_chain.filter1.type", {"filters/MedianFilterDouble"}},
           {"filter_chain.filter1.params.number_of_observations", {"5"}}});
  rig.start();
  test::RealtimeGuard guard;
  for (int k = 0; k < 100; ++k) filter.update(rig.cycle, rig.verdict);
  filter.on_activate(rig.cycle);
  ASSERT_EQ(guard.violations(), "");
}

}  // namespace
}  // namespace polyarm::controllers::small_broadcasters_test
