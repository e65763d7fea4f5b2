/// The example, `polyarm far-side cia402` and `polyarm setup cia402`, as users start them.
#include "tests/support/driver_examples.hpp"
#include "tests/support/wire_rig.hpp"

namespace polyarm {
namespace {

using namespace test;

std::vector<std::string> far_side(std::vector<std::string> more = {}) {
  std::vector<std::string> out{"far-side", "cia402"};
  out.insert(out.end(), more.begin(), more.end());
  return out;
}

/// The port in the line "… behind the serial port /dev/pts/3".
std::string port_of(Command& far) {
  const std::string line = far.line_with("behind the serial port");
  const std::size_t at = line.find("/dev/");
  return at == std::string::npos ? std::string() : line.substr(at, line.find_last_not_of(" \r\n") + 1 - at);
}

TEST(Cia402Example, MovesFourDrivesAndRepeatsItself) {
  const ExampleCopy copy("cia402");
  expect_same_run_twice(copy, "4 CiA 402 drives on");
}

TEST(Cia402Example, AFaultOfADriveEndsTheRunWithItsCause) {
  expect_fault_ends_the_run("cia402", {"max_step: 0.05", "faults: over_current=2@2\n      max_step: 0.05"},
                            {"shoulder (node 2)", "continuous over-current (0x2310)", "remove the cause"});
}

TEST(Cia402Example, RunsAgainstDrivesInAnotherProcess) {
  Command far(far_side({"--drives", "4"}));
  const std::string port = port_of(far);
  ASSERT_NE(port, "");
  const ExampleCopy copy("cia402");
  // The clocks of a busy machine say nothing about drives.
  edit(copy, "cell.yaml",
       {{"hardware: cia402_fake", "hardware: cia402"},
        {"bus: /tmp/can", "bus: " + port +
                              "\n      heartbeat_ms: 5000\n      lost_cycles: 500\n"
                              "      loop_silence_ms: 10000\n      watchdog: \"off\""}});
  expect_armed_run_completes(copy);
  far.signal(SIGTERM);
  EXPECT_EQ(far.wait().exit_code, 0);
}

TEST(Cia402Setup, ListsTheDrivesAndTheirStates) {
  Command far(far_side({"--drives", "2", "--start", "10 -20", "--order", "encoder=2"}));
  const Finished done = run_command({"setup", "cia402", "--bus", port_of(far), "--last", "4"});
  EXPECT_EQ(done.exit_code, 0) << done.output;
  expect_words(done.output, {"node 1: Polyarm simulated drive", "state \"switch on disabled\"", "node 2",
                             "state \"fault\"", "encoder 1 failed (0x7305)"});
  EXPECT_EQ(done.output.find("node 3"), std::string::npos) << done.output;
  far.signal(SIGTERM);
  EXPECT_EQ(far.wait().exit_code, 0);
}

TEST(Cia402Setup, SaysWhatCannotBeUsed) {
  Command far(far_side({"--drives", "2", "--order", "wrong_device=1", "--order", "no_position_mode=2"}));
  const Finished done = run_command({"setup", "cia402", "--bus", port_of(far), "--last", "2"});
  EXPECT_EQ(done.exit_code, 1) << done.output;
  expect_words(done.output, {"profile 401", "without cyclic synchronous position"});
  far.signal(SIGTERM);
  far.wait();
}

TEST(Cia402Setup, ABusWithoutAnswersIsExplained) {
  Command far(far_side({"--drives", "1", "--order", "bus_off"}));
  const Finished off = run_command({"setup", "cia402", "--bus", port_of(far), "--last", "2"});
  EXPECT_EQ(off.exit_code, 1) << off.output;
  expect_words(off.output, {"no node answers", "the adapter could not send"});
  far.signal(SIGTERM);
  far.wait();
  const Finished nobody = run_command({"setup", "cia402", "--bus", "can7"});
  EXPECT_NE(nobody.exit_code, 0);
  expect_words(nobody.output, {"there is no CAN interface can7"});
  EXPECT_EQ(run_command({"setup", "cia402"}).exit_code, 2) << "the bus is the user's";
}

TEST(Cia402FarSide, TakesFaultsAndShowsItsState) {
  Command far(far_side({"--drives", "2", "--order", "over_current=2"}), Input::terminal);
  EXPECT_NE(port_of(far), "");
  ASSERT_TRUE(far.wait_for("type `state`"));
  far.type("state\n");
  EXPECT_NE(far.line_with("node 2").find("node 2: fault"), std::string::npos);
  far.type("storm\n");
  EXPECT_NE(far.line_with("storm").find("storm"), std::string::npos) << "a wrong kind does not end it";
  far.type("silent=9\n");
  EXPECT_NE(far.line_with("node number 9").find("no drive"), std::string::npos);
  far.signal(SIGTERM);
  EXPECT_EQ(far.wait().exit_code, 0);
}

TEST(Cia402FarSide, WrongOptionsAreRefused) {
  EXPECT_EQ(run_command(far_side({"--drives", "0"})).exit_code, 2);
  EXPECT_EQ(run_command(far_side({"--start", "1 2"})).exit_code, 2);
  EXPECT_NE(run_command(far_side({"--order", "storm"})).exit_code, 0);
  EXPECT_NE(run_command(far_side({"--link", "/"})).exit_code, 0);
  const Finished help = run_command({"far-side", "cia402", "--help"});
  EXPECT_EQ(help.exit_code, 0);
  EXPECT_NE(help.output.find("over_current"), std::string::npos) << "lists the faults: " << help.output;
}

}  // namespace
}  // namespace polyarm
