#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <set>

#include "polyarm/broadcasters/force_torque_sensor_broadcaster.hpp"
#include "polyarm/broadcasters/gps_sensor_broadcaster.hpp"
#include "polyarm/broadcasters/imu_sensor_broadcaster.hpp"
#include "polyarm/broadcasters/pose_broadcaster.hpp"
#include "polyarm/broadcasters/sensor_interfaces.hpp"
#include "polyarm/broadcasters/state_interfaces_broadcaster.hpp"
#include "polyarm/controllers/filters.hpp"
#include "polyarm/plugins/types.hpp"
#include "tests/controllers/rig.hpp"
#include "tests/support/realtime_guard.hpp"

namespace polyarm::controllers {
namespace {

std::vector<std::string> states_of(const std::string& sensor, std::span<const char* const> interfaces) {
  std::vector<std::string> out;
  for (const char* interface : interfaces) out.push_back(sensor + "/" + interface);
  return out;
}

std::vector<std::string> together(std::vector<std::string> a, const std::vector<std::string>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

template <typename Broadcaster>
struct Sensor {
  Broadcaster broadcaster;
  Rig rig;
  Sensor(std::vector<std::string> states, const Rig::Values& values)
      : rig(broadcaster, "arm", {"elbow"}, std::move(states), {}, values, "teller") {}
};

struct Imu : Sensor<ImuSensorBroadcaster> {
  explicit Imu(const Rig::Values& values) : Sensor(states_of("imu", kImuInterfaces), values) {}
  void measure() {
    const double s = std::sqrt(0.5);
    const double values[] = {0, 0, s, s, 1, 2, 3, 4, 5, 6};
    for (std::size_t i = 0; i < 10; ++i) rig.state(std::string("imu/") + kImuInterfaces[i]) = values[i];
  }
};

TEST(SensorTypes, AreFoundUnderTheNamesOfBothGenerations) {
  for (const char* name :
       {"imu_sensor_broadcaster/IMUSensorBroadcaster", "imu_sensor_controller/ImuSensorController",
        "force_torque_sensor_broadcaster/ForceTorqueSensorBroadcaster",
        "force_torque_sensor_controller/ForceTorqueSensorController",
        "gps_sensor_broadcaster/GPSSensorBroadcaster", "pose_broadcaster/PoseBroadcaster",
        "state_interfaces_broadcaster/StateInterfacesBroadcaster"}) {
    Parameters parameters;
    EXPECT_TRUE(make_controller(name, parameters)) << name;
    EXPECT_TRUE(is_publisher(name)) << name;
  }
}

TEST(ImuBroadcaster, TellsItsTenValuesWithCovariances) {
  Imu imu(Rig::Values{{"sensor_name", {"imu"}},
                      {"frame_id", {"imu_frame"}},
                      {"static_covariance_orientation", {"1", "2", "3", "4", "5", "6", "7", "8", "9"}}});
  imu.rig.start();
  imu.measure();
  imu.rig.step();
  EXPECT_DOUBLE_EQ(imu.rig.told("imu", "orientation.z"), std::sqrt(0.5));
  EXPECT_DOUBLE_EQ(imu.rig.told("imu", "angular_velocity.y"), 2);
  EXPECT_DOUBLE_EQ(imu.rig.told("imu", "linear_acceleration.z"), 6);
  EXPECT_DOUBLE_EQ(imu.rig.told("imu", "orientation_covariance[5]"), 6);
  EXPECT_DOUBLE_EQ(imu.rig.told("imu", "angular_velocity_covariance[0]"), 0);
  EXPECT_EQ(imu.broadcaster.find_output("imu")->type(), "sensor_msgs/Imu");
  EXPECT_EQ(imu.broadcaster.find_output("imu")->texts.at("frame_id"), "imu_frame");
  EXPECT_EQ(imu.broadcaster.find_output("imu")->fields().size(), 10u + 27u);
}

TEST(ImuBroadcaster, GivesItsValuesToOtherControllers) {
  Imu imu(Rig::Values{{"sensor_name", {"imu"}}});
  imu.rig.start();
  imu.measure();
  imu.rig.step();
  EXPECT_EQ(imu.broadcaster.exported_states().size(), 10u);
  EXPECT_DOUBLE_EQ(imu.rig.state("teller/imu/linear_acceleration.x"), 4);
  EXPECT_DOUBLE_EQ(imu.rig.state("teller/imu/orientation.w"), std::sqrt(0.5));
}

TEST(ImuBroadcaster, TurnsIntoTheFrameOfTheOffset) {
  Imu imu(Rig::Values{{"sensor_name", {"imu"}},
                      {"rotation_offset.yaw", {std::to_string(std::numbers::pi / 2)}},
                      {"static_covariance_angular_velocity", {"1", "0", "0", "0", "2", "0", "0", "0", "3"}}});
  imu.rig.start();
  imu.measure();
  imu.rig.step();
  EXPECT_NEAR(imu.rig.told("imu", "angular_velocity.x"), -2, 1e-5);  // x goes to y, y to -x
  EXPECT_NEAR(imu.rig.told("imu", "angular_velocity.y"), 1, 1e-5);
  EXPECT_NEAR(imu.rig.told("imu", "linear_acceleration.x"), -5, 1e-5);
  EXPECT_NEAR(imu.rig.told("imu", "angular_velocity_covariance[0]"), 2, 1e-5);
  EXPECT_NEAR(imu.rig.told("imu", "angular_velocity_covariance[4]"), 1, 1e-5);
  EXPECT_NEAR(imu.rig.told("imu", "orientation.z"), 0, 1e-5);  // the quarter turn is taken back
  EXPECT_NEAR(imu.rig.told("imu", "orientation.w"), 1, 1e-5);
}

TEST(ImuBroadcaster, FindsTheOnlyImuWithoutAName) {
  Imu imu(Rig::Values{});
  imu.rig.start();
  EXPECT_EQ(imu.broadcaster.find_output("imu")->texts.at("frame_id"), "imu");
}

TEST(ImuBroadcaster, SaysWhatIsNotMeasuredAtAll) {
  Sensor<ImuSensorBroadcaster> gyro(
      states_of("gyro", std::span<const char* const>(kImuInterfaces).subspan(4)), {});
  gyro.rig.start();
  gyro.rig.state("gyro/angular_velocity.x") = 7;
  gyro.rig.step();
  EXPECT_TRUE(std::isnan(gyro.rig.told("imu", "orientation.w")));
  EXPECT_EQ(gyro.rig.told("imu", "orientation_covariance[0]"), -1);
  EXPECT_EQ(gyro.rig.told("imu", "angular_velocity.x"), 7);
}

TEST(ImuBroadcaster, RefusesWithAPlace) {
  const std::pair<Rig::Values, const char*> kWrong[] = {
      {{{"sensor_name", {"imo"}}}, "did you mean 'imu'"},
      {{{"static_covariance_orientation", {"1"}}}, "has 1 numbers, it needs 9"},
      {{{"rotation_offset.yaw", {".inf"}}}, "'rotation_offset.yaw: .inf' is not a finite number"},
  };
  for (const auto& [values, sentence] : kWrong) {
    Imu imu(values);
    const std::string why = imu.rig.refusal();
    EXPECT_NE(why.find(sentence), std::string::npos) << why;
    EXPECT_NE(why.find("controllers.yaml:10"), std::string::npos) << why;
  }
}

TEST(SensorSearch, NamesTheSensorsWhereSeveralCouldBeMeant) {
  Sensor<ImuSensorBroadcaster> two(
      together(states_of("front", kImuInterfaces), states_of("back", kImuInterfaces)), {});
  const std::string why = two.rig.refusal();
  EXPECT_NE(why.find("front, back"), std::string::npos) << why;
  Sensor<ImuSensorBroadcaster> none({"elbow/position"}, {});
  EXPECT_NE(none.rig.refusal().find("nothing has the states of an IMU"), std::string::npos);
}

TEST(SensorSearch, TakesThatOfItsOwnRobot) {
  Sensor<ForceTorqueSensorBroadcaster> own(states_of("fts", kForceTorqueInterfaces), {});
  for (const char* interface : kForceTorqueInterfaces)
    own.rig.context.state_names.push_back(std::string("other/fts/") + interface);
  own.rig.start();
  EXPECT_EQ(own.broadcaster.state_interfaces().front(), "arm/fts/force.x");
}

struct ForceTorque : Sensor<ForceTorqueSensorBroadcaster> {
  explicit ForceTorque(const Rig::Values& values)
      : Sensor(together(states_of("fts", kForceTorqueInterfaces), {"cell/pull"}), values) {}
};

TEST(ForceTorqueBroadcaster, TellsWhatIsMeasuredPlusOffsetTimesMultiplier) {
  ForceTorque fts(Rig::Values{{"sensor_name", {"fts"}},
                              {"frame_id", {"tool0"}},
                              {"offset.force.x", {"1"}},
                              {"multiplier.force.x", {"2"}},
                              {"offset.torque.z", {"-10"}}});
  fts.rig.start();
  fts.rig.state("fts/force.x") = 3;
  fts.rig.state("fts/force.y") = 4;
  fts.rig.state("fts/torque.z") = 12;
  fts.rig.step();
  EXPECT_DOUBLE_EQ(fts.rig.told("wrench", "wrench.force.x"), 8);
  EXPECT_DOUBLE_EQ(fts.rig.told("wrench", "wrench.force.y"), 4);
  EXPECT_DOUBLE_EQ(fts.rig.told("wrench", "wrench.torque.z"), 2);
  EXPECT_DOUBLE_EQ(fts.rig.state("teller/fts/force.x"), 8);
  EXPECT_EQ(fts.broadcaster.find_output("wrench")->texts.at("frame_id"), "tool0");
  EXPECT_EQ(fts.broadcaster.find_output("wrench_filtered"), nullptr);
}

TEST(ForceTorqueBroadcaster, TakesANewOffsetWhileRunning) {
  ForceTorque fts(Rig::Values{{"sensor_name", {"fts"}}});
  fts.rig.start();
  fts.rig.state("fts/force.z") = 5;
  EXPECT_EQ(fts.rig.change("offset.force.z", "-5"), "");
  fts.rig.step();
  EXPECT_EQ(fts.rig.told("wrench", "wrench.force.z"), 0);
}

TEST(ForceTorqueBroadcaster, TakesItsAxesOneByOne) {
  ForceTorque fts(Rig::Values{{"interface_names.force.z", {"cell/pull"}}, {"frame_id", {"pull"}}});
  fts.rig.start();
  fts.rig.state("cell/pull") = 9;
  fts.rig.step();
  EXPECT_EQ(fts.rig.told("wrench", "wrench.force.z"), 9);
  EXPECT_TRUE(std::isnan(fts.rig.told("wrench", "wrench.force.x")));
  EXPECT_EQ(fts.broadcaster.exported_states(), std::vector<std::string>{"teller/cell/pull"});
  EXPECT_EQ(fts.rig.state("teller/cell/pull"), 9);
}

TEST(ForceTorqueBroadcaster, RefusesTwoSourcesAndUnknownOnes) {
  const std::pair<Rig::Values, const char*> kWrong[] = {
      {{{"sensor_name", {"fts"}}, {"interface_names.force.z", {"cell/pull"}}}, "leave one of them out"},
      {{{"interface_names.force.z", {"cell/pul"}}}, "did you mean 'arm/cell/pull'"},
      {{{"sensor_name", {"ftz"}}}, "did you mean 'fts'"},
      {{{"offset.force.x", {"much"}}}, "is not a number"},
      {{{"sensor_filter_chain.filter1.type", {"control_filters/LowPassFilterWrench"}},
        {"sensor_filter_chain.filter1.params.damping_frequency", {"0"}}},
       "must be a number above 0"},
      {{{"sensor_filter_chain.filter1.type", {"control_filters/ExponentialFilterWrench"}},
        {"sensor_filter_chain.filter1.params.alpha", {"1.5"}}},
       "alpha must not be above 1"},
  };
  for (const auto& [values, sentence] : kWrong) {
    ForceTorque fts(values);
    const std::string why = fts.rig.refusal();
    EXPECT_NE(why.find(sentence), std::string::npos) << why;
    EXPECT_NE(why.find("controllers.yaml:1"), std::string::npos) << why;
  }
}

TEST(ForceTorqueBroadcaster, FiltersInAChain) {
  ForceTorque fts(
      Rig::Values{{"sensor_name", {"fts"}},
                  {"sensor_filter_chain.filter1.type", {"control_filters/LowPassFilterWrench"}},
                  {"sensor_filter_chain.filter1.name", {"smooth"}},
                  {"sensor_filter_chain.filter1.params.sampling_frequency", {"100"}},
                  {"sensor_filter_chain.filter1.params.damping_frequency", {"20.5"}},
                  {"sensor_filter_chain.filter1.params.damping_intensity", {"1.25"}},
                  {"sensor_filter_chain.filter2.type", {"control_filters/ExponentialFilterWrench"}},
                  {"sensor_filter_chain.filter2.params.alpha", {"0.25"}}});
  fts.rig.start();
  EXPECT_EQ(fts.rig.findings(), "");
  fts.rig.step();  // begins at zero
  fts.rig.state("fts/force.x") = 1;
  fts.rig.step();
  EXPECT_EQ(fts.rig.told("wrench", "wrench.force.x"), 1);
  EXPECT_EQ(fts.rig.told("wrench_filtered", "wrench.force.x"), 0);  // one sample later
  fts.rig.step();
  const double a = std::exp(-2 * std::numbers::pi * 20.5 / 100 * std::pow(10, 0.125));
  EXPECT_NEAR(fts.rig.told("wrench_filtered", "wrench.force.x"), 0.25 * (1 - a), 1e-12);
  fts.broadcaster.on_activate(fts.rig.cycle);  // begins anew, without a jump
  fts.rig.step();
  EXPECT_EQ(fts.rig.told("wrench_filtered", "wrench.force.x"), 1);
}

TEST(ForceTorqueBroadcaster, TellsNothingFilteredWhereAFilterIsMissing) {
  ForceTorque fts(
      Rig::Values{{"sensor_name", {"fts"}},
                  {"sensor_filter_chain.filter1.type", {"control_filters/GravityCompensationWrench"}},
                  {"sensor_filter_chain.filter1.params.CoG.force", {"0", "0", "-9"}},
                  {"sensor_filter_chain.filter2.type", {"control_filters/ExponentialFilterWrench"}}});
  fts.rig.start();
  EXPECT_EQ(fts.broadcaster.find_output("wrench_filtered"), nullptr);
  EXPECT_NE(fts.rig.findings().find("GravityCompensationWrench is not available"), std::string::npos);
  EXPECT_EQ(fts.rig.findings().find("has no parameter"), std::string::npos) << fts.rig.findings();
}

TEST(FirstOrderFilter, SettlesWhereItsInputIsAndPassesOverWhatIsNotFinite) {
  std::mt19937 random(9);
  std::uniform_real_distribution<double> any(0.1, 20);
  for (int round = 0; round < 100; ++round) {
    const double rate = 1000, damping = any(random), target = any(random);
    for (FirstOrderFilter filter :
         {FirstOrderFilter::low_pass(rate, damping, 1), FirstOrderFilter::exponential(0.05)}) {
      EXPECT_TRUE(std::isnan(filter.update(std::nan(""))));
      EXPECT_EQ(filter.update(0), 0);
      double last = 0;
      for (int k = 0; k < 50000; ++k) {
        const double now = filter.update(k % 10 ? target : HUGE_VAL);
        ASSERT_GE(now, last - 1e-12);  // no overshoot
        ASSERT_LE(now, target + 1e-9);
        last = now;
      }
      EXPECT_NEAR(last, target, 1e-6);
    }
  }
}

struct Gps : Sensor<GpsSensorBroadcaster> {
  explicit Gps(const Rig::Values& values)
      : Sensor(together(states_of("gps", kGpsInterfaces), states_of("gps", kGpsCovarianceInterfaces)),
               values) {}
  void measure() {
    const double values[] = {-1, 3, 48.1, 11.6, 519};
    for (std::size_t i = 0; i < 5; ++i) rig.state(std::string("gps/") + kGpsInterfaces[i]) = values[i];
    for (std::size_t i = 0; i < 3; ++i)
      rig.state(std::string("gps/") + kGpsCovarianceInterfaces[i]) = 0.5 + static_cast<double>(i);
  }
};

struct TcpPose : Sensor<PoseBroadcaster> {
  explicit TcpPose(const Rig::Values& values)
      : Sensor(together(states_of("imu", kImuInterfaces), states_of("tcp_pose", kPoseInterfaces)), values) {}
  void measure(double x, double w = 0.8) {
    const double values[] = {x, 0.2, 0.3, 0, 0.6, 0, w};
    for (std::size_t i = 0; i < 7; ++i) rig.state(std::string("tcp_pose/") + kPoseInterfaces[i]) = values[i];
  }
};

TEST(PoseBroadcaster, TellsThePoseAndTheTransform) {
  TcpPose tcp(Rig::Values{
      {"pose_name", {"tcp_pose"}}, {"frame_id", {"base"}}, {"tf.child_frame_id", {"tool0_controller"}}});
  tcp.rig.start();
  tcp.measure(0.1);
  tcp.rig.step();
  EXPECT_EQ(tcp.rig.told("pose", "pose.position.x"), 0.1);
  EXPECT_EQ(tcp.rig.told("pose", "pose.position.z"), 0.3);
  EXPECT_EQ(tcp.rig.told("pose", "pose.orientation.y"), 0.6);
  EXPECT_EQ(tcp.rig.told("pose", "pose.orientation.w"), 0.8);
  EXPECT_EQ(tcp.rig.told("tf", "transform.translation.x"), 0.1);
  EXPECT_EQ(tcp.rig.told("tf", "transform.rotation.w"), 0.8);
  EXPECT_EQ(tcp.broadcaster.find_output("pose")->texts.at("frame_id"), "base");
  EXPECT_EQ(tcp.broadcaster.find_output("tf")->texts.at("frame_id"), "base");
  EXPECT_EQ(tcp.broadcaster.find_output("tf")->texts.at("child_frame_id"), "tool0_controller");
}

TEST(PoseBroadcaster, WhatIsNoPoseIsNotTold) {
  TcpPose tcp(Rig::Values{});  // the only sensor with a position; the IMU has none
  tcp.rig.start();
  tcp.measure(0.1);
  tcp.rig.step();
  for (const auto& [x, w] : {std::pair{0.5, 0.9}, {std::nan(""), 0.8}, {0.5, HUGE_VAL}}) {
    tcp.measure(x, w);
    tcp.rig.step();
    EXPECT_EQ(tcp.rig.told("pose", "pose.position.x"), 0.1);
    EXPECT_EQ(tcp.rig.told("tf", "transform.translation.x"), 0.1);
  }
}

TEST(PoseBroadcaster, TheTransformHasARateOfItsOwnOrIsNotTold) {
  TcpPose slow(Rig::Values{{"tf_publish_rate", {"10"}}});
  slow.rig.start();
  ASSERT_EQ(slow.rig.cycle.period, 10'000'000);
  std::set<double> told;
  for (int i = 0; i < 100; ++i) {
    slow.measure(0.001 * i);
    slow.rig.step();
    told.insert(slow.rig.told("tf", "transform.translation.x"));
  }
  EXPECT_EQ(told.size(), 10u);
  TcpPose none(Rig::Values{{"tf.enable", {"false"}}});
  none.rig.start();
  EXPECT_EQ(none.broadcaster.find_output("tf"), nullptr);
}

TEST(GpsBroadcaster, TellsTheFixWithTheStatedCovariance) {
  Gps gps(Rig::Values{{"sensor_name", {"gps"}},
                      {"frame_id", {"roof"}},
                      {"static_position_covariance", {"1", "2", "3", "4", "5", "6", "7", "8", "9"}}});
  gps.rig.start();
  gps.measure();
  gps.rig.step();
  EXPECT_EQ(gps.rig.told("gps/fix", "status.status"), -1);
  EXPECT_EQ(gps.rig.told("gps/fix", "status.service"), 3);
  EXPECT_EQ(gps.rig.told("gps/fix", "latitude"), 48.1);
  EXPECT_EQ(gps.rig.told("gps/fix", "longitude"), 11.6);
  EXPECT_EQ(gps.rig.told("gps/fix", "altitude"), 519);
  EXPECT_EQ(gps.rig.told("gps/fix", "position_covariance[8]"), 9);
  EXPECT_EQ(gps.rig.told("gps/fix", "position_covariance_type"), 3);
  EXPECT_EQ(gps.broadcaster.state_interfaces().size(), 5u);
  EXPECT_EQ(gps.broadcaster.find_output("gps/fix")->texts.at("frame_id"), "roof");
}

TEST(GpsBroadcaster, TellsTheCovarianceOfTheReceiver) {
  Gps gps(Rig::Values{{"sensor_name", {"gps"}}, {"read_covariance_from_interface", {"true"}}});
  gps.rig.start();
  gps.measure();
  gps.rig.step();
  EXPECT_EQ(gps.rig.told("gps/fix", "position_covariance[0]"), 0.5);
  EXPECT_EQ(gps.rig.told("gps/fix", "position_covariance[4]"), 1.5);
  EXPECT_EQ(gps.rig.told("gps/fix", "position_covariance[8]"), 2.5);
  EXPECT_EQ(gps.rig.told("gps/fix", "position_covariance[1]"), 0);
  EXPECT_EQ(gps.rig.told("gps/fix", "position_covariance_type"), 2);
}

TEST(StateInterfacesBroadcaster, TellsAnyStatesInTheOrderOfTheFile) {
  Sensor<StateInterfacesBroadcaster> any({"elbow/position", "elbow/temperature", "fan/speed"},
                                         {{"interfaces", {"fan/speed", "elbow/temperature", "fan/speed"}}});
  any.rig.start();
  any.rig.state("fan/speed") = 7;
  any.rig.state("elbow/temperature") = 40;
  any.rig.step();
  EXPECT_EQ(any.rig.told("values", "fan/speed"), 7);
  EXPECT_EQ(any.rig.told("values", "elbow/temperature"), 40);
  EXPECT_EQ(any.broadcaster.find_output("values")->fields(),
            (std::vector<std::string>{"fan/speed", "elbow/temperature", "fan/speed"}));
}

TEST(StateInterfacesBroadcaster, RefusesNoneAndUnknownOnes) {
  Sensor<StateInterfacesBroadcaster> none({"elbow/position"}, {{"interfaces", {}}});
  EXPECT_NE(none.rig.refusal().find("it names no interfaces"), std::string::npos);
  Sensor<StateInterfacesBroadcaster> wrong({"elbow/position"}, {{"interfaces", {"elbow/positon"}}});
  const std::string why = wrong.rig.refusal();
  EXPECT_NE(why.find("did you mean 'arm/elbow/position'"), std::string::npos) << why;
  EXPECT_NE(why.find("controllers.yaml:10"), std::string::npos) << why;
}

template <typename Tested>
void expect_quiet(Tested& tested) {
  tested.rig.start();
  test::RealtimeGuard guard;
  for (int k = 0; k < 1000; ++k) {
    tested.broadcaster.update(tested.rig.cycle, tested.rig.verdict);
    if (k % 100 == 0) tested.broadcaster.on_activate(tested.rig.cycle);
  }
  EXPECT_EQ(guard.violations(), "");
}

TEST(SensorBroadcasters, DoNothingThatWaits) {
  if (!test::RealtimeGuard::watches()) GTEST_SKIP() << "sanitizers bring their own allocator";
  Imu imu(Rig::Values{});
  expect_quiet(imu);
  ForceTorque fts(Rig::Values{{"sensor_filter_chain.filter1.type", {"control_filters/LowPassFilterWrench"}}});
  expect_quiet(fts);
  Gps gps(Rig::Values{{"read_covariance_from_interface", {"true"}}});
  expect_quiet(gps);
  Sensor<StateInterfacesBroadcaster> any({"elbow/position"}, {{"interfaces", {"elbow/position"}}});
  expect_quiet(any);
}

TEST(SensorBroadcasters, SurviveWhateverTheirFileSays) {
  const char* kKeys[] = {"sensor_name",
                         "frame_id",
                         "interface_names.force.x",
                         "offset.torque.z",
                         "sensor_filter_chain.filter1.type",
                         "sensor_filter_chain.filter2.type",
                         "sensor_filter_chain.filter1.params.alpha",
                         "sensor_filter_chain.filter1.params.sampling_frequency",
                         "static_covariance_orientation",
                         "rotation_offset.roll",
                         "interfaces",
                         "read_covariance_from_interface"};
  const std::vector<std::string> kValues[] = {{},
                                              {""},
                                              {"/"},
                                              {"fts"},
                                              {"fts/force.x"},
                                              {"LowPassFilter"},
                                              {"ExponentialFilter"},
                                              {"1e400"},
                                              {"-1e308"},
                                              {".inf"},
                                              {".nan"},
                                              {"true"},
                                              {"0"},
                                              {"\x01\xff"},
                                              {"1", "2"}};
  std::mt19937 random(6);
  int configured = 0;
  const auto round = [&](auto&& tested) {
    for (int n = 0; n < 3; ++n)
      tested.rig.set(kKeys[random() % std::size(kKeys)], kValues[random() % std::size(kValues)]);
    if (!tested.rig.refusal().empty()) return;
    ++configured;
    tested.rig.activate();
    tested.rig.step();
  };
  for (int k = 0; k < 2000; ++k) {
    round(Imu(Rig::Values{}));
    round(ForceTorque(Rig::Values{}));
    round(Gps(Rig::Values{}));
  }
  EXPECT_GT(configured, 1000);
}

}  // namespace
}  // namespace polyarm::controllers
