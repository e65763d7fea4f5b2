/// The process that reads a sensor is killed or stands still.
#include <gtest/gtest.h>

#include "tests/sensors/far_sides.hpp"
#include "tests/support/driving_process.hpp"

namespace polyarm::test::process_test {
namespace {

/// The process tells what it measures; true when it becomes that.
bool becomes(DrivingProcess& process, const std::string& value) {
  for (int tries = 0; tries < 3000; ++tries) {
    process.tell("value");
    if (process.line() == value + "\n") return true;
  }
  return false;
}

/// `last`: what the device sends at the end, and what the state is then.
template <typename Device>
void expect_to_survive(const std::string& driver, const std::string& state, const std::string& usual,
                       const Bytes& last, const std::string& then) {
  Device far;
  const std::vector<std::string> words{POLYARM_FAKE_PROCESS, driver, far.path(), state};
  far.start();
  {
    DrivingProcess first(words);
    ASSERT_EQ(first.line(), "measuring\n");
    const std::string refused = DrivingProcess(words).line();
    EXPECT_NE(refused.find("in use by component unit"), std::string::npos) << refused;
    first.signal(SIGKILL);
    first.wait();
  }
  DrivingProcess next(words);
  ASSERT_EQ(next.line(), "measuring\n") << "the port is free at once";
  ASSERT_TRUE(becomes(next, usual));
  next.signal(SIGSTOP);
  far.stop();
  far.pty.write(last);
  next.signal(SIGCONT);
  EXPECT_TRUE(becomes(next, then)) << "what came last is what is measured, without an error";
}

TEST(SensorProcess, KilledAnInertialSensorIsFreeAndAfterAStandstillTheLastFrameCounts) {
  expect_to_survive<FakeImu>("serial_imu", "temperature", "25.000000", wit(0x51, 0, 0, 2048, 7700),
                             "77.000000");
}

TEST(SensorProcess, KilledAReceiverIsFreeAndAfterAStandstillTheLastFixCounts) {
  Fix last;
  last.latitude = 100'000'000;
  expect_to_survive<FakeReceiver>("ublox_gnss", "latitude", "47.370000", nav_pvt(last), "10.000000");
}

}  // namespace
}  // namespace polyarm::test::process_test
