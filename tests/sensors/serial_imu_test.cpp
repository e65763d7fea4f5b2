#include "drivers/sensors/serial_imu.hpp"

#include "tests/sensors/far_sides.hpp"
#include "tests/sensors/rig.hpp"
#include "tests/support/waiting_component.hpp"

namespace polyarm::test::serial_imu_test {
namespace {

using sensors::SerialImu;
using Rig = SensorRig<SerialImu>;
using Parameters = std::map<std::string, std::string>;
using hardware::CallbackReturn;
using hardware::ReturnType;

constexpr double kPi = 3.14159265358979323846;

/// A sensor that has been configured; from then on bytes come from the test alone.
struct Imu {
  explicit Imu(Parameters more = {}) {
    more["port"] = far.path();
    rig = std::make_unique<Rig>(std::move(more));
    far.start();
    EXPECT_TRUE(rig->configure()) << rig->sensor.reason();
    far.stop();
    far.pty.write(wit(0x51, 0, 0, 2048, 7777));  // behind all that was sent before
    EXPECT_TRUE(rig->until([&] { return state("temperature") == 77.77; }));
  }
  double state(const std::string& name) const { return rig->state("cart/imu/" + name); }
  /// Sends, and reads until `count` more frames have come.
  bool send(const Bytes& bytes, int count) {
    rig->read();
    const double wanted = state("frames") + count;
    far.pty.write(bytes);
    return rig->until([&] { return state("frames") >= wanted; });
  }

  FakeImu far;
  std::unique_ptr<Rig> rig;
};

TEST(SerialImu, MeasuresInSiUnitsUnderTheNamesOfTheBroadcaster) {
  Imu imu;
  ASSERT_TRUE(imu.send(wit_sample(), 3));
  EXPECT_NEAR(imu.state("orientation.z"), std::sqrt(0.5), 1e-9);
  EXPECT_NEAR(imu.state("orientation.w"), std::sqrt(0.5), 1e-9);
  EXPECT_EQ(imu.state("orientation.x"), 0);
  EXPECT_NEAR(imu.state("angular_velocity.x"), 62.5 * kPi / 180, 1e-9);
  EXPECT_NEAR(imu.state("linear_acceleration.z"), 9.80665, 1e-9);
  EXPECT_EQ(imu.state("temperature"), 25);
  EXPECT_FALSE(imu.rig->sensor.real());
  EXPECT_TRUE(imu.rig->sensor.blocks());
}

TEST(SerialImu, AQuaternionHasLengthOneWhateverTheRoundingAndNoneIsNoAttitude) {
  Imu imu;
  ASSERT_TRUE(imu.send(wit(0x59, 20000, -20000, 12000, 9000), 1));
  double norm = 0;
  for (const char* axis : {"x", "y", "z", "w"})
    norm += std::pow(imu.state(std::string("orientation.") + axis), 2);
  EXPECT_NEAR(norm, 1, 1e-12);
  const double before = imu.state("orientation.w");
  ASSERT_TRUE(imu.send(wit(0x59, 0, 0, 0, 0), 1));
  EXPECT_EQ(imu.state("orientation.w"), before);
}

TEST(SerialImu, AnglesTurnRollFirstAboutTheFixedAxes) {
  FakeImu far;
  far.silent = true;
  Rig rig({{"port", far.path()}, {"start_timeout", "5"}});
  std::atomic<bool> done{false};
  std::thread writer([&] {  // a sensor that sends angles in place of quaternions
    while (!done) {
      far.pty.write(wit(0x51, 0, 0, 2048, 0) + wit(0x52, 0, 0, 0, 0) + wit(0x53, 8192, 0, 16384, 0));
      far.pty.read(5);
    }
  });
  const bool configured = rig.configure();
  done = true;
  writer.join();
  ASSERT_TRUE(configured) << rig.sensor.reason();
  ASSERT_TRUE(rig.until([&] { return !std::isnan(rig.state("cart/imu/orientation.w")); }));
  // 45° about x, then 90° about the fixed z
  const double a = std::cos(kPi / 8), b = std::sin(kPi / 8), h = std::sqrt(0.5);
  EXPECT_NEAR(rig.state("cart/imu/orientation.w"), a * h, 1e-9);
  EXPECT_NEAR(rig.state("cart/imu/orientation.x"), b * h, 1e-9);
  EXPECT_NEAR(rig.state("cart/imu/orientation.y"), b * h, 1e-9);
  EXPECT_NEAR(rig.state("cart/imu/orientation.z"), a * h, 1e-9);
  EXPECT_NE(rig.sensor.summary().find("from its angles"), std::string::npos);
}

TEST(SerialImu, SplitFramesGarbageAndBadSumsDoNoHarm) {
  Imu imu;
  Bytes bad = wit(0x52, 30000, 30000, 30000, 0);
  bad[3] ^= 1;
  const double lost = imu.state("lost_bytes");
  const Bytes stream = Bytes{0x00, 0x55, 0x55, 0x51, 0xFF} + bad + wit_sample();
  imu.rig->read();
  const double wanted = imu.state("frames") + 3;
  for (const std::uint8_t byte : stream) {
    imu.far.pty.write({byte});
    EXPECT_EQ(imu.rig->read(), ReturnType::ok);
    EXPECT_NEAR(imu.state("angular_velocity.x"), 62.5 * kPi / 180, 1e-9);
  }
  ASSERT_TRUE(imu.rig->until([&] { return imu.state("frames") >= wanted; }));
  EXPECT_EQ(imu.state("frames"), wanted);
  EXPECT_EQ(imu.state("lost_bytes") - lost, 5 + 11);
  EXPECT_GE(imu.state("bad_frames"), 1);
}

TEST(SerialImu, SilenceMakesEachQuantityUnknownAndSpeechBringsItBack) {
  test_now = 1'000'000'000;
  Imu imu(Parameters{{"timeout", "0.5"}});
  ASSERT_TRUE(imu.send(wit_sample(), 3));
  test_now += 400'000'000;
  ASSERT_TRUE(imu.send(wit(0x51, 0, 0, 2048, 2500), 1));
  EXPECT_TRUE(std::isfinite(imu.state("orientation.w")));
  EXPECT_EQ(imu.rig->sensor.reason(), "");
  test_now += 200'000'000;  // the others are 0.6 s old
  EXPECT_EQ(imu.rig->read(), ReturnType::ok);
  EXPECT_TRUE(std::isnan(imu.state("orientation.w")));
  EXPECT_TRUE(std::isnan(imu.state("angular_velocity.x")));
  EXPECT_TRUE(std::isfinite(imu.state("linear_acceleration.z")));
  EXPECT_NE(imu.rig->sensor.reason().find("'imu' on " + imu.far.path()), std::string::npos);
  ASSERT_TRUE(imu.send(wit_sample(), 3));
  EXPECT_TRUE(std::isfinite(imu.state("orientation.w")));
  EXPECT_EQ(imu.rig->sensor.reason(), "");
}

TEST(SerialImu, UnpluggingIsAnErrorAndActivationFindsThePluggedInAgain) {
  const std::string link = ::testing::TempDir() + "polyarm_imu_" + std::to_string(::getpid());
  FakeImu second;
  auto first = std::make_unique<FakeImu>();
  ASSERT_EQ(::symlink(first->path().c_str(), link.c_str()), 0);
  Rig rig({{"port", link}});
  first->start();
  ASSERT_TRUE(rig.configure()) << rig.sensor.reason();
  ASSERT_EQ(rig.sensor.on_activate(), CallbackReturn::success);
  first->stop();
  first->pty.close_connection();
  ASSERT_TRUE(rig.until([&] { return rig.last == ReturnType::error; }));
  EXPECT_TRUE(std::isnan(rig.state("cart/imu/orientation.w")));
  EXPECT_NE(rig.sensor.reason().find("unplugged"), std::string::npos) << rig.sensor.reason();
  EXPECT_EQ(rig.sensor.on_error(), CallbackReturn::success);
  EXPECT_EQ(rig.read(), ReturnType::error) << "a port that is closed measures nothing";
  EXPECT_EQ(::unlink(link.c_str()), 0);
  EXPECT_EQ(rig.sensor.on_activate(), CallbackReturn::failure) << "nothing is plugged in";
  EXPECT_NE(rig.sensor.reason().find("no serial port"), std::string::npos) << rig.sensor.reason();
  ASSERT_EQ(::symlink(second.path().c_str(), link.c_str()), 0);
  second.start();
  EXPECT_EQ(rig.sensor.on_activate(), CallbackReturn::success) << rig.sensor.reason();
  EXPECT_TRUE(rig.until([&] { return std::isfinite(rig.state("cart/imu/orientation.w")); }));
  EXPECT_EQ(rig.sensor.reason(), "");
  ::unlink(link.c_str());
}

TEST(SerialImu, SetsContentAndRateOnlyWhenAskedTo) {
  FakeImu far;
  far.quaternions = false;
  far.start();
  {
    Rig as_it_is({{"port", far.path()}, {"start_timeout", "0.2"}});
    EXPECT_FALSE(as_it_is.configure());
    EXPECT_NE(as_it_is.sensor.reason().find("sends no orientation"), std::string::npos)
        << as_it_is.sensor.reason();
    EXPECT_TRUE(far.commands().empty());
  }
  Rig set({{"port", far.path()}, {"configure", "true"}, {"rate", "20"}});
  ASSERT_TRUE(set.configure()) << set.sensor.reason();
  EXPECT_EQ(far.commands(), (Bytes{0xFF, 0xAA, 0x69, 0x88, 0xB5, 0xFF, 0xAA, 0x02, 0x06, 0x02, 0xFF, 0xAA,
                                   0x03, 0x07, 0x00}));
}

TEST(SerialImu, SaysWhatIsWrongWithASilentOrStrangeDevice) {
  Pty silent;
  Rig nothing({{"port", silent.path()}, {"start_timeout", "0.05"}});
  EXPECT_FALSE(nothing.configure());
  EXPECT_NE(nothing.sensor.reason().find("sends nothing"), std::string::npos) << nothing.sensor.reason();
  FakeReceiver other;
  other.start();
  Rig strange({{"port", other.path()}, {"start_timeout", "0.2"}});
  EXPECT_FALSE(strange.configure());
  EXPECT_NE(strange.sensor.reason().find("no WIT frames"), std::string::npos) << strange.sensor.reason();
  EXPECT_EQ(strange.sensor.on_configure(), CallbackReturn::failure)
      << "and the port is free to be tried again";
}

TEST(SerialImu, ASecondComponentIsToldWhoHasThePort) {
  Imu first;
  Rig second({{"port", first.far.path()}});
  EXPECT_FALSE(second.configure());
  EXPECT_NE(second.sensor.reason().find("component unit"), std::string::npos) << second.sensor.reason();
}

TEST(SerialImu, EveryBadParameterIsToldAtOnce) {
  Rig rig({{"bauds", "9600"},
           {"timeout", "soon"},
           {"rate", "33"},
           {"configure", "perhaps"},
           {"update_rate", "7"}},
          {sensor_block("imu", {"orientation.q", "orientation.x"})});
  const std::string said = rig.init();
  for (const char* part :
       {"'bauds'", "did you mean 'baud'", "needs the parameter 'port'", "timeout is 'soon'",
        "no rate of 33 Hz", "configure is 'perhaps'", "no state 'orientation.q'"})
    EXPECT_NE(said.find(part), std::string::npos) << part << " in\n" << said;
}

TEST(SerialImu, ARateThatThePortCannotCarryIsRefused) {
  Rig rig({{"port", "/dev/null"}, {"configure", "true"}, {"rate", "200"}, {"baud", "9600"}});
  EXPECT_NE(rig.init().find("need 66000 bit/s"), std::string::npos);
}

TEST(SerialImu, OffersWhatIsDeclaredInThatOrderAndNeedsNoMore) {
  FakeImu far;
  far.quaternions = false;
  far.start();
  Rig rig({{"port", far.path()}}, {sensor_block("level", {"linear_acceleration.z", "angular_velocity.x"})});
  ASSERT_TRUE(rig.configure()) << rig.sensor.reason();
  EXPECT_EQ(rig.names,
            (std::vector<std::string>{"cart/level/linear_acceleration.z", "cart/level/angular_velocity.x"}));
  ASSERT_TRUE(rig.until([&] { return std::isfinite(rig.states[0]) && std::isfinite(rig.states[1]); }));
  EXPECT_NEAR(rig.states[0], 9.80665, 1e-9);
  EXPECT_EQ(rig.sensor.reason(), "") << "an attitude that nobody asked for is not missed";
}

TEST(SerialImu, ReadingNeitherAllocatesNorThrows) {
  Imu imu;
  Bytes bytes;
  for (int i = 0; i < 20; ++i) bytes = bytes + wit_sample() + Bytes{0x55, 0x51, 0x00};
  imu.far.pty.write(bytes);
  const double before = imu.state("frames");
  EXPECT_TRUE(neither_allocates_nor_throws(imu.rig->sensor, 1000, imu.rig->states, {}));
  ASSERT_TRUE(imu.rig->until([&] { return imu.state("frames") >= before + 60; }));
  imu.far.pty.close_connection();
  EXPECT_TRUE(neither_allocates_nor_throws(imu.rig->sensor, 10, imu.rig->states, {})) << "nor unplugged";
}

}  // namespace
}  // namespace polyarm::test::serial_imu_test
