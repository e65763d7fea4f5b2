/// The process that reads a sensor is killed or stands still.
#include <gtest/gtest.h>

#include "tests/sensors/far_sides.hpp"
#include "tests/support/driving_process.hpp"

namespace polyarm::test::process_test {
namespace {

/// The process tells what it measures; true when it becomes that, within a minute.
bool becomes(DrivingProcess& process, const std::string& value) {
  for (const Nanoseconds end = realtime::monotonic_now() + 60'000'000'000; realtime::monotonic_now() < end;) {
    process.tell("value");
    if (process.line() == value + "\n") return true;
  }
  return false;
}

/// `meanwhile`: what the device sends while the process stands still. `last`: what it sends at the end, and
/// what the state is then.
template <typename Device>
void expect_to_survive(const std::string& driver, const std::string& state, const std::string& usual,
                       const std::vector<Bytes>& meanwhile, const Bytes& last, const std::string& then) {
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
  far.stop();  // between two messages: the line holds some 4 kB, and what does not fit would be lost
  next.signal(SIGSTOP);
  for (const Bytes& one : meanwhile) far.pty.write(one);
  far.pty.write(last);
  next.signal(SIGCONT);
  EXPECT_TRUE(becomes(next, then)) << "what came last is what is measured, without an error";
}

TEST(SensorProcess, KilledAnInertialSensorIsFreeAndAfterAStandstillTheLastFrameCounts) {
  expect_to_survive<FakeImu>("serial_imu", "temperature", "25.000000", std::vector<Bytes>(10, wit_sample()),
                             wit(0x51, 0, 0, 2048, 7700), "77.000000");
}

TEST(SensorProcess, KilledAReceiverIsFreeAndAfterAStandstillTheLastFixCounts) {
  Fix last;
  last.latitude = 100'000'000;
  expect_to_survive<FakeReceiver>("ublox_gnss", "latitude", "47.370000", std::vector<Bytes>(10, nav_pvt()),
                                  nav_pvt(last), "10.000000");
}

}  // namespace
}  // namespace polyarm::test::process_test
