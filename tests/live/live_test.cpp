// Runs on the wall clock, one after the other: stop, suspend, kill, and a writer outside.
#include <gtest/gtest.h>

#include <chrono>
#include <fstream>
#include <thread>

#include "polyarm/base/file.hpp"
#include "polyarm/data/import_format.hpp"
#include "tests/support/command.hpp"

namespace polyarm {
namespace {

using test::Command;
using test::ExampleCopy;

TEST(CtrlC, StopsOnThePathAndSaysStopped) {
  const ExampleCopy copy("pick_and_place");
  Command run({"run", copy.path(), "--json", "--hardware", "mock"});
  ASSERT_TRUE(run.wait_for("moveto PrePick"));
  run.signal(SIGINT);
  const test::Finished& ended = run.wait();
  EXPECT_EQ(ended.exit_code, 3) << ended.output;
  EXPECT_EQ(ended.result()["result"], "stopped");
  EXPECT_NE(ended.output.find("\"state\":\"held\""), std::string::npos) << "it came to rest before it ended";
}

TEST(CtrlC, TwiceStopsAtOnce) {
  const ExampleCopy copy("pick_and_place");
  Command run({"run", copy.path(), "--json", "--hardware", "mock"});
  ASSERT_TRUE(run.wait_for("moveto p0"));
  run.signal(SIGINT);
  run.signal(SIGINT);
  EXPECT_EQ(run.wait().exit_code, 3);
}

TEST(Signals, EachThatCanBeCaughtStopsOnThePath) {
  for (const int number : {SIGTERM, SIGQUIT, SIGHUP, SIGUSR1, SIGALRM, SIGSTKFLT, SIGTRAP, SIGRTMIN, SIGRTMAX, SIGABRT, SIGSYS,
                           SIGSEGV, SIGBUS, SIGFPE, SIGILL}) {
    const ExampleCopy copy("pick_and_place");
    Command run({"run", copy.path(), "--json", "--hardware", "mock"});
    ASSERT_TRUE(run.wait_for("moveto PrePick"));
    run.signal(number);
    const test::Finished& ended = run.wait();
    EXPECT_EQ(ended.exit_code, 3) << "signal " << number << "\n" << ended.output;
    EXPECT_EQ(ended.result()["result"], "stopped") << number;
    EXPECT_NE(ended.output.find("\"state\":\"held\""), std::string::npos) << number;
  }
}

TEST(Signals, AClosedTerminalIsOneStopHoweverOftenItIsSaid) {
  const ExampleCopy copy("pick_and_place");
  Command run({"run", copy.path(), "--json", "--hardware", "mock"});
  ASSERT_TRUE(run.wait_for("moveto PrePick"));
  for (int i = 0; i < 5; ++i) run.signal(SIGHUP);
  const test::Finished& ended = run.wait();
  EXPECT_EQ(ended.exit_code, 3);
  EXPECT_EQ(ended.result()["result"], "stopped") << "it came to its end";
}

TEST(Signals, OutputThatNobodyReadsEndsInAStopOnThePath) {
  for (const bool json : {true, false}) {
    const ExampleCopy copy("pick_and_place");
    std::vector<std::string> arguments{"run", copy.path(), "--hardware", "mock"};
    if (json) arguments.emplace_back("--json");
    Command run(arguments);
    ASSERT_TRUE(run.wait_for("moveto PrePick"));
    run.stop_reading();
    EXPECT_EQ(run.wait().exit_code, 3) << "no signal ended it";
  }
}

TEST(Signals, CtrlZHoldsInsteadOfSuspending) {
  const ExampleCopy copy("pick_and_place");
  Command run({"run", copy.path(), "--json", "--hardware", "mock"});
  ASSERT_TRUE(run.wait_for("moveto PrePick"));
  run.signal(SIGTSTP);
  ASSERT_TRUE(run.wait_for("\"state\":\"held\"")) << "it goes on running, and stands";
  run.signal(SIGTERM);
  EXPECT_EQ(run.wait().exit_code, 3);
}

TEST(Signals, SigtermEndsASimulatedCellInTimeWhateverItDoes) {
  const ExampleCopy copy("bin_picking");
  for (const int tenths : {0, 2, 6, 15}) {  // while it reads, builds, compiles, runs
    Command run({"run", copy.path(), "--fast", "--seconds", "100000"});
    ::usleep(static_cast<useconds_t>(100'000 * tenths));
    const auto asked = std::chrono::steady_clock::now();
    run.signal(SIGTERM);
    const int code = run.wait().exit_code;
    EXPECT_TRUE(code == 3 || code == 128 + SIGTERM) << code;
    EXPECT_LT(std::chrono::steady_clock::now() - asked, std::chrono::seconds(4));
  }
}

TEST(Stall, ASimulatedCellGoesOnAndSaysSo) {
  const ExampleCopy copy("pick_and_place");
  Command run({"run", copy.path(), "--json", "--hardware", "mock"});
  ASSERT_TRUE(run.wait_for("moveto PrePick"));
  run.signal(SIGSTOP);
  ::usleep(900'000);  // what is tested is the gap itself
  run.signal(SIGCONT);
  ASSERT_TRUE(run.wait_for("wall time was lost; a simulated cell continues"));
  ASSERT_TRUE(run.wait_for("moveto Pass1")) << "the program goes on";
  run.signal(SIGINT);
  EXPECT_EQ(run.wait().exit_code, 3);
}

TEST(Stall, HoldsWhereTheCellSaysSo) {
  const ExampleCopy copy("pick_and_place");
  std::ofstream(copy.file("cell.yaml"), std::ios::app) << "loop: {stall: hold}\n";
  Command run({"run", copy.path(), "--json", "--hardware", "mock"});
  ASSERT_TRUE(run.wait_for("moveto PrePick"));
  run.signal(SIGSTOP);
  ::usleep(900'000);  // what is tested is the gap itself
  run.signal(SIGCONT);
  ASSERT_TRUE(run.wait_for("\"state\":\"held\""));
  run.signal(SIGINT);
  const test::Finished& ended = run.wait();
  EXPECT_NE(ended.output.find("wall time was lost"), std::string::npos);
  EXPECT_EQ(ended.output.find("moveto Pass1"), std::string::npos) << "it did not go on by itself";
}

TEST(Kill, LeavesEveryDataFileEitherOldOrNew) {
  const ExampleCopy copy("pick_and_place");
  // A PLC that writes as often as it can.
  write_file_atomically(
      copy.file("plc.script"),
      "while true\n  set ActivateGripper = not ActivateGripper\n  set GripperActive = not GripperActive\n"
      "  wait 2ms\nend\n");
  write_file_atomically(copy.file("PAPscript.script"),
                        "load cycledata\nwait GripperActive and not GripperActive\n");
  std::string text = read_file(copy.file("signals.yaml"));
  write_file_atomically(copy.file("signals.yaml"), text + "live: [cycledata]\n");
  for (int i = 0; i < 100; ++i) {
    Command run({"run", copy.path(), "--json", "--hardware", "mock"});
    ASSERT_TRUE(run.wait_for("\"event\":\"line\""));
    ::usleep(static_cast<useconds_t>(1000 + 700 * (i % 37)));
    run.signal(SIGKILL);
    run.wait();
    Problems problems;
    const data::ImportFile file =
        data::ImportFile::parse(read_file(copy.file("cycledata.data")), "cycledata.data", problems);
    ASSERT_TRUE(problems.list().empty()) << "after kill " << i << ": " << problems.list().front().text();
    ASSERT_EQ(file.values().size(), 7u);
  }
}

TEST(LiveData, WhatAnOutsideProgramWritesReachesTheRunningProgram) {
  const ExampleCopy copy("pick_and_place");
  write_file_atomically(copy.file("signals.yaml"),
                        read_file(copy.file("signals.yaml")) + "live: [cycledata]\n");
  write_file_atomically(copy.file("plc.script"),
                        "wait ActivateGripper\nlog \"seen\"\nset GripperActive = true\n");
  write_file_atomically(copy.file("PAPscript.script"),
                        "load cycledata\nwait GripperActive\nlog \"through\"\n");
  Command run({"run", copy.path(), "--json", "--hardware", "mock"});
  ASSERT_TRUE(run.wait_for("wait GripperActive"));
  std::string text = read_file(copy.file("cycledata.data"));
  const std::string from = "Name: ActivateGripper\nBool: False";
  ASSERT_NE(text.find(from), std::string::npos);
  text.replace(text.find(from), from.size(), "Name: ActivateGripper\nBool: True");
  std::ofstream(copy.file("cycledata.data")) << text;  // as an outsider would: in place
  const test::Finished& ended = run.wait();
  EXPECT_EQ(ended.exit_code, 0) << ended.output;
  EXPECT_NE(ended.output.find("through"), std::string::npos);
  EXPECT_NE(read_file(copy.file("cycledata.data")).find("Name: GripperActive\nBool: True"), std::string::npos)
      << "written through";
}

}  // namespace
}  // namespace polyarm
