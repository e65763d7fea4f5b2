#include "drivers/sensors/ublox_gnss.hpp"

#include "tests/sensors/far_sides.hpp"
#include "tests/sensors/rig.hpp"
#include "tests/support/waiting_component.hpp"

namespace polyarm::test::ublox_gnss_test {
namespace {

using sensors::UbloxGnss;
using Rig = SensorRig<UbloxGnss>;
using Parameters = std::map<std::string, std::string>;
using hardware::CallbackReturn;
using hardware::ReturnType;

/// A receiver that has been configured; from then on bytes come from the test alone.
struct Gnss {
  explicit Gnss(Parameters more = {}, const std::string& protocol = "27.31") : far(protocol) {
    far.sends_fixes = false;
    more["port"] = far.path();
    rig = std::make_unique<Rig>(std::move(more));
    far.start();
    EXPECT_TRUE(rig->configure()) << rig->sensor.reason();
    far.stop();
    Fix none;
    none.type = 0, none.satellites = 77;
    far.pty.write(nav_pvt(none));  // behind all that was sent before
    EXPECT_TRUE(rig->until([&] { return state("satellites") == 77; }));
  }
  double state(const std::string& name) const { return rig->state("cart/gps/" + name); }
  bool send(const Bytes& bytes, int count = 1) {
    rig->read();
    const double wanted = state("frames") + count;
    far.pty.write(bytes);
    return rig->until([&] { return state("frames") >= wanted; });
  }

  FakeReceiver far;
  std::unique_ptr<Rig> rig;
};

TEST(UbloxGnss, TellsFixAndVelocityUnderTheNamesOfTheBroadcaster) {
  Gnss gnss(Parameters{{"service", "9"}});
  EXPECT_EQ(gnss.state("status"), -1);
  EXPECT_TRUE(std::isnan(gnss.state("latitude")));
  ASSERT_TRUE(gnss.send(nav_pvt()));
  EXPECT_EQ(gnss.state("status"), 0);
  EXPECT_EQ(gnss.state("service"), 9);
  EXPECT_NEAR(gnss.state("latitude"), 47.37, 1e-9);
  EXPECT_NEAR(gnss.state("longitude"), 8.52, 1e-9);
  EXPECT_NEAR(gnss.state("altitude"), 456.789, 1e-9) << "above the ellipsoid, not the sea";
  EXPECT_NEAR(gnss.state("latitude_covariance"), 2.25, 1e-9);
  EXPECT_NEAR(gnss.state("longitude_covariance"), 2.25, 1e-9);
  EXPECT_NEAR(gnss.state("altitude_covariance"), 6.25, 1e-9);
  EXPECT_NEAR(gnss.state("velocity.east"), -2, 1e-9);
  EXPECT_NEAR(gnss.state("velocity.north"), 1, 1e-9);
  EXPECT_NEAR(gnss.state("velocity.up"), -0.3, 1e-9);
  EXPECT_EQ(gnss.state("satellites"), 12);
  EXPECT_FALSE(gnss.rig->sensor.real());
  EXPECT_TRUE(gnss.rig->sensor.blocks());
  EXPECT_NE(gnss.rig->sensor.summary().find("HPG 1.32, protocol 27.31"), std::string::npos);
}

TEST(UbloxGnss, StatusSaysWhatKindOfFixItIs) {
  struct Case {
    std::uint8_t type, flags, flags3;
    double status;
    bool position, altitude;
  };
  Gnss gnss;
  for (const Case& c : std::vector<Case>{{0, 0x00, 0, -1, false, false},
                                         {3, 0x00, 0, -1, false, false},  // outside the limits of accuracy
                                         {3, 0x01, 1, -1, false, false},  // position marked invalid
                                         {1, 0x01, 0, 0, true, true},     // dead reckoning within limits
                                         {2, 0x01, 0, 0, true, false},    // height assumed
                                         {3, 0x01, 0, 0, true, true},
                                         {3, 0x03, 0, 1, true, true},  // corrections
                                         {3, 0x43, 0, 2, true, true},  // carrier, floating
                                         {3, 0x83, 0, 2, true, true},  // carrier, fixed
                                         {4, 0x01, 0, 0, true, true},
                                         {5, 0x01, 0, -1, false, false},  // time alone
                                         {200, 0x01, 0, -1, false, false}}) {
    Fix fix;
    fix.type = c.type, fix.flags = c.flags, fix.flags3 = c.flags3;
    ASSERT_TRUE(gnss.send(nav_pvt(fix)));
    EXPECT_EQ(gnss.state("status"), c.status) << int{c.type} << " " << int{c.flags};
    EXPECT_EQ(std::isfinite(gnss.state("latitude")), c.position) << int{c.type} << " " << int{c.flags};
    EXPECT_EQ(std::isfinite(gnss.state("velocity.north")), c.position);
    EXPECT_EQ(std::isfinite(gnss.state("altitude")), c.altitude) << int{c.type} << " " << int{c.flags};
    EXPECT_EQ(gnss.state("fix_type"), c.type);
  }
}

TEST(UbloxGnss, NewReceiversAreSetByKeysAndOldOnesByMessages) {
  Gnss fresh(Parameters{{"rate", "10"}});
  auto commands = fresh.far.commands();
  ASSERT_EQ(commands.size(), 2u);
  EXPECT_EQ(commands[0], ubx(0x0A, 0x04, {}));
  EXPECT_EQ(commands[1],
            ubx(0x06, 0x8A, {0,    1,    0,    0,    0x01, 0x00, 0x21, 0x30, 100,  0,    0x02, 0x00, 0x21,
                             0x30, 0x01, 0x00, 0x07, 0x00, 0x91, 0x20, 0x01, 0x02, 0x00, 0x74, 0x10, 0x00}));
  Gnss old(Parameters{{"rate", "10"}}, "18.00");
  commands = old.far.commands();
  ASSERT_EQ(commands.size(), 3u);
  EXPECT_EQ(commands[1], ubx(0x06, 0x08, {100, 0, 1, 0, 1, 0}));
  EXPECT_EQ(commands[2], ubx(0x06, 0x01, {0x01, 0x07, 1}));
  Gnss untouched(Parameters{{"configure", "none"}});
  EXPECT_EQ(untouched.far.commands().size(), 1u) << "only asked who it is";
}

TEST(UbloxGnss, ARefusedSettingIsToldWithWhatToDo) {
  FakeReceiver far;
  far.refuses = true;
  far.start();
  Rig rig({{"port", far.path()}, {"rate", "20"}});
  EXPECT_FALSE(rig.configure());
  EXPECT_NE(rig.sensor.reason().find("refused 20 fixes a second"), std::string::npos) << rig.sensor.reason();
  EXPECT_NE(rig.sensor.reason().find("receiver_port"), std::string::npos);
  EXPECT_EQ(far.commands().size(), 2u) << "what was refused is not asked for again";
}

TEST(UbloxGnss, ASettingThatIsNotAnsweredIsSentOnceMore) {
  FakeReceiver far;
  far.ignores_settings = true;
  far.start();
  Rig rig({{"port", far.path()}, {"start_timeout", "0.3"}});
  EXPECT_FALSE(rig.configure());
  EXPECT_NE(rig.sensor.reason().find("does not answer when its rate is set"), std::string::npos)
      << rig.sensor.reason();
  const auto commands = far.commands();
  ASSERT_GE(commands.size(), 3u);
  EXPECT_EQ(commands[commands.size() - 1], commands[commands.size() - 2]);
}

TEST(UbloxGnss, SaysWhetherNothingGarbageOrOnlyOneDirectionComes) {
  FakeReceiver far;
  far.deaf = true;
  far.start();
  Rig nothing({{"port", far.path()}, {"start_timeout", "0.05"}});
  EXPECT_FALSE(nothing.configure());
  EXPECT_NE(nothing.sensor.reason().find("sends nothing"), std::string::npos) << nothing.sensor.reason();
  FakeImu other;
  other.start();
  Rig garbage({{"port", other.path()}, {"start_timeout", "0.2"}});
  EXPECT_FALSE(garbage.configure());
  EXPECT_NE(garbage.sensor.reason().find("does not answer in UBX"), std::string::npos)
      << garbage.sensor.reason();
}

TEST(UbloxGnss, GarbageBadSumsAndNmeaBetweenMessagesDoNoHarm) {
  Gnss gnss;
  Bytes bad = nav_pvt();
  bad[30] ^= 0x40;
  const std::string nmea = "$GNGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*47\r\n";
  const Bytes stream = Bytes{0xB5, 0xB5, 0x62, 0x01} + bad + Bytes(nmea.begin(), nmea.end()) + nav_pvt();
  gnss.rig->read();
  const double wanted = gnss.state("frames") + 1, lost = gnss.state("lost_bytes");
  for (const std::uint8_t byte : stream) {
    gnss.far.pty.write({byte});
    EXPECT_EQ(gnss.rig->read(), ReturnType::ok);
  }
  ASSERT_TRUE(gnss.rig->until([&] { return gnss.state("frames") >= wanted; }));
  EXPECT_EQ(gnss.state("frames"), wanted);
  EXPECT_NEAR(gnss.state("latitude"), 47.37, 1e-9);
  EXPECT_EQ(gnss.state("lost_bytes") - lost, static_cast<double>(stream.size() - nav_pvt().size()));
}

TEST(UbloxGnss, SilenceIsNoFixWithAReasonUntilItSpeaksAgain) {
  test_now = 5'000'000'000;
  Gnss gnss(Parameters{{"timeout", "2"}});
  ASSERT_TRUE(gnss.send(nav_pvt()));
  test_now += 2'000'000'000;
  gnss.rig->read();
  EXPECT_EQ(gnss.state("status"), 0);
  test_now += 1;
  EXPECT_EQ(gnss.rig->read(), ReturnType::ok);
  EXPECT_EQ(gnss.state("status"), -1);
  EXPECT_TRUE(std::isnan(gnss.state("latitude")));
  EXPECT_TRUE(std::isnan(gnss.state("velocity.east")));
  EXPECT_NE(gnss.rig->sensor.reason().find("silent for 2 s"), std::string::npos) << gnss.rig->sensor.reason();
  ASSERT_TRUE(gnss.send(nav_pvt()));
  EXPECT_EQ(gnss.state("status"), 0);
  EXPECT_EQ(gnss.rig->sensor.reason(), "");
}

TEST(UbloxGnss, UnpluggingIsAnErrorAndActivationConfiguresAnew) {
  const std::string link = ::testing::TempDir() + "polyarm_gnss_" + std::to_string(::getpid());
  auto first = std::make_unique<FakeReceiver>();
  FakeReceiver second;
  ASSERT_EQ(::symlink(first->path().c_str(), link.c_str()), 0);
  Rig rig({{"port", link}});
  first->start();
  ASSERT_TRUE(rig.configure()) << rig.sensor.reason();
  first->stop();
  first->pty.close_connection();
  ASSERT_TRUE(rig.until([&] { return rig.last == ReturnType::error; }));
  EXPECT_EQ(rig.state("cart/gps/status"), -1);
  EXPECT_NE(rig.sensor.reason().find("unplugged"), std::string::npos) << rig.sensor.reason();
  rig.sensor.on_error();
  ::unlink(link.c_str());
  ASSERT_EQ(::symlink(second.path().c_str(), link.c_str()), 0);
  second.start();
  EXPECT_EQ(rig.sensor.on_activate(), CallbackReturn::success) << rig.sensor.reason();
  EXPECT_EQ(second.commands().size(), 2u);
  EXPECT_TRUE(rig.until([&] { return rig.state("cart/gps/status") == 0; }));
  ::unlink(link.c_str());
}

TEST(UbloxGnss, EveryBadParameterIsToldAtOnce) {
  Rig rig(
      {{"rat", "5"}, {"configure", "valsett"}, {"receiver_port", "spi"}, {"service", "99"}, {"baud", "fast"}},
      {sensor_block("gps", {"latitud"})});
  const std::string said = rig.init();
  for (const char* part :
       {"did you mean 'rate'", "did you mean 'valset'", "receiver_port is 'spi'", "a number from 0 to 15",
        "baud is 'fast'", "did you mean 'latitude'", "needs the parameter 'port'"})
    EXPECT_NE(said.find(part), std::string::npos) << part << " in\n" << said;
}

TEST(UbloxGnss, ARateThatThePortOrTheTimeoutDoesNotCarryIsRefused) {
  Rig narrow({{"port", "/dev/ttyS0"}, {"rate", "20"}, {"baud", "9600"}});
  EXPECT_NE(narrow.init().find("need 20000 bit/s"), std::string::npos);
  Rig usb({{"port", "/dev/ttyACM0"}, {"rate", "20"}, {"baud", "9600"}});
  EXPECT_EQ(usb.init(), "");
  Rig slow({{"port", "/dev/ttyS0"}, {"rate", "0.1"}, {"timeout", "2"}});
  EXPECT_NE(slow.init().find("before the next fix"), std::string::npos);
}

TEST(UbloxGnss, ReadingNeitherAllocatesNorThrows) {
  Gnss gnss;
  Bytes bytes = mon_ver("27.31");
  for (int i = 0; i < 20; ++i) bytes = bytes + nav_pvt() + Bytes{0xB5, 0x62, 0x01};
  gnss.far.pty.write(bytes);
  const double before = gnss.state("frames");
  EXPECT_TRUE(neither_allocates_nor_throws(gnss.rig->sensor, 1000, gnss.rig->states, {}));
  ASSERT_TRUE(gnss.rig->until([&] { return gnss.state("frames") >= before + 20; }));
  gnss.far.pty.close_connection();
  EXPECT_TRUE(neither_allocates_nor_throws(gnss.rig->sensor, 10, gnss.rig->states, {})) << "nor unplugged";
}

}  // namespace
}  // namespace polyarm::test::ublox_gnss_test
