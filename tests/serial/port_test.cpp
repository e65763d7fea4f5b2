#include "drivers/serial/port.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <filesystem>
#include <fstream>
#include <numeric>
#include <thread>

#include "drivers/serial/ports.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/realtime/periodic.hpp"
#include "tests/support/pty.hpp"

namespace polyarm::serial {
namespace {

using Bytes = std::vector<std::uint8_t>;
namespace fs = std::filesystem;

Nanoseconds soon() {
  return realtime::monotonic_now() + 5'000'000'000;
}

Port open_port(const test::Pty& pty, int baud = 1'000'000) {
  PortOptions options;
  options.path = pty.path();
  options.baud = baud;
  options.holder = "the test";
  return Port(options);
}

Error refusal(const std::string& path, int baud = 115200) {
  try {
    PortOptions options;
    options.path = path;
    options.baud = baud;
    const Port port(options);
  } catch (const Error& e) {
    return e;
  }
  return Error("none", "it opened");
}

TEST(SerialPort, PassesEveryByteBothWaysUnchanged) {
  test::Pty pty;
  Port port = open_port(pty);
  Bytes all(256);
  std::iota(all.begin(), all.end(), std::uint8_t{0});
  ASSERT_TRUE(port.write(all, soon()));
  EXPECT_EQ(pty.read_exactly(256), all);
  pty.write(all);
  Bytes got(256);
  EXPECT_TRUE(port.read_exactly(got, soon()));
  EXPECT_EQ(got, all);
}

TEST(SerialPort, NothingIsSentByOpening) {
  test::Pty pty;
  Port port = open_port(pty);
  EXPECT_TRUE(pty.read(0).empty());
}

TEST(SerialPort, ReadsEndAtTheirDeadlineWithWhatCame) {
  test::Pty pty;
  Port port = open_port(pty);
  Bytes got(4);
  EXPECT_EQ(port.read(got, realtime::monotonic_now() + 1'000'000).status, Status::timeout);
  EXPECT_EQ(port.read(got, 0).status, Status::timeout) << "a deadline in the past asks for what is there";
  pty.write({7, 8});
  const Transfer part = port.read_exactly(got, realtime::monotonic_now() + 300'000'000);
  EXPECT_EQ(part.status, Status::timeout);
  EXPECT_EQ(part.count, 2u);
}

TEST(SerialPort, WritesEndAtTheirDeadlineWhenNobodyReads) {
  test::Pty pty;
  Port port = open_port(pty);
  const Bytes much(1 << 20);
  const Transfer sent = port.write(much, realtime::monotonic_now() + 20'000'000);
  EXPECT_EQ(sent.status, Status::timeout);
  EXPECT_LT(sent.count, much.size());
}

TEST(SerialPort, FlushDropsWhatArrived) {
  test::Pty pty;
  Port port = open_port(pty);
  pty.write({1, 2, 3});
  Bytes got(1);
  ASSERT_TRUE(port.read_exactly(got, soon()));
  ASSERT_TRUE(port.flush());
  EXPECT_EQ(port.read(got, 0).status, Status::timeout);
  pty.write({9});
  ASSERT_TRUE(port.read_exactly(got, soon()));
  EXPECT_EQ(got[0], 9);
}

TEST(SerialPort, KnowsThatTheFarSideIsGone) {
  test::Pty pty;
  Port port = open_port(pty);
  pty.close_connection();
  Bytes got(1);
  EXPECT_EQ(port.read(got, soon()).status, Status::gone);
  const Bytes one{1};
  EXPECT_EQ(port.write(one, soon()).status, Status::gone);
  EXPECT_NE(explain(Status::gone, 5).find("unplugged"), std::string::npos);
}

TEST(SerialPort, WakesFromAReadWhenTheFarSideGoes) {
  test::Pty pty;
  Port port = open_port(pty);
  std::thread cable([&pty] { pty.close_connection(); });
  Bytes got(1);
  EXPECT_EQ(port.read(got, soon()).status, Status::gone);
  cable.join();
}

TEST(SerialPort, TakesRatesThatAreNotInTheOldTable) {
  test::Pty pty;
  Port port = open_port(pty, 1'000'000);
  for (const int baud : {57'600, 250'000, 3'000'000, 4'500'000, 123'456})
    EXPECT_NO_THROW(port.set_baud(baud));
  EXPECT_THROW(port.set_baud(0), Error);
  EXPECT_THROW(port.set_baud(-9600), Error);
}

TEST(SerialPort, IsForOneAtATime) {
  test::Pty pty;
  Port first = open_port(pty);
  const Error second = refusal(pty.path());
  EXPECT_EQ(second.problems().at(0).code, "device-in-use");
  EXPECT_NE(std::string(second.what()).find("the test"), std::string::npos) << second.what();
  first.close();
  EXPECT_NO_THROW(open_port(pty));
}

TEST(SerialPort, AMovedPortIsTheSamePort) {
  test::Pty pty;
  Port first = open_port(pty);
  Port second = std::move(first);
  EXPECT_FALSE(first.is_open());
  first = std::move(second);
  pty.write({5});
  Bytes got(1);
  EXPECT_TRUE(first.read_exactly(got, soon()));
}

TEST(SerialPort, HandedOverItIsSharedUntilBothHaveClosedIt) {
  test::Pty far;
  Port first = open_port(far);
  int copies[2];
  const auto descriptors = first.descriptors();
  for (int k = 0; k < 2; ++k) ASSERT_GE(copies[k] = ::dup(descriptors[k]), 0);
  Port second = Port::handed_over(copies[0], copies[1], far.path());
  first.close();
  EXPECT_EQ(refusal(far.path()).problems().at(0).code, "device-in-use");
  const std::uint8_t byte[] = {0x42};
  ASSERT_TRUE(second.write(byte, soon()));
  EXPECT_EQ(far.read_exactly(1), Bytes{0x42});
  second.close();
  EXPECT_NO_THROW(open_port(far));
}

TEST(SerialPort, SaysWhichPortsThereAreWhenTheNamedOneIsNot) {
  const Error e = refusal("/dev/ttyNone7");
  EXPECT_EQ(e.problems().at(0).code, "no-such-port");
  EXPECT_NE(e.problems().at(0).advice.find("port"), std::string::npos);
}

TEST(SerialPort, AFileIsNoPort) {
  EXPECT_EQ(refusal("/dev/null").problems().at(0).code, "not-a-serial-port");
}

TEST(SerialPort, WithoutPermissionTheGroupIsNamed) {
  if (::getuid() != 0) GTEST_SKIP() << "only root can give a pty away";
  test::Pty pty;
  ASSERT_EQ(::chmod(pty.path().c_str(), 0660), 0);
  ASSERT_EQ(::chown(pty.path().c_str(), 0, 20), 0);
  const pid_t child = ::fork();
  if (child == 0) {
    if (::setgid(65534) != 0 || ::setuid(65534) != 0) ::_exit(9);
    const Error e = refusal(pty.path());
    const bool good = e.problems().at(0).code == "port-not-permitted" &&
                      e.problems().at(0).advice.find("join the group dialout") != std::string::npos;
    ::_exit(good ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

TEST(SerialPorts, NamesThatStayComeFirstAndEachPortOnce) {
  std::string pattern = (fs::temp_directory_path() / "polyarm_dev_XXXXXX").string();
  const fs::path dev = ::mkdtemp(pattern.data());
  fs::create_directories(dev / "serial" / "by-id");
  for (const char* name : {"ttyUSB0", "ttyACM1", "ttyS0", "tty7", "null"}) std::ofstream(dev / name) << "";
  fs::create_symlink(dev / "ttyUSB0", dev / "serial" / "by-id" / "usb-servo-adapter");
  const std::vector<std::string> expected{(dev / "serial/by-id/usb-servo-adapter").string(),
                                          (dev / "ttyACM1").string()};
  EXPECT_EQ(list_ports(dev), expected);
  EXPECT_TRUE(list_ports(dev / "nothing").empty());
  fs::remove_all(dev);
}

}  // namespace
}  // namespace polyarm::serial
