// Runs on the wall clock, one after the other: stop, suspend, kill, and a writer outside.
#include <gtest/gtest.h>

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

TEST(Suspend, TheRobotHoldsAfterwardsAndDoesNotCatchUp) {
  const ExampleCopy copy("pick_and_place");
  Command run({"run", copy.path(), "--json", "--hardware", "mock"});
  ASSERT_TRUE(run.wait_for("moveto PrePick"));
  run.signal(SIGSTOP);
  ::usleep(900'000);  // what is tested is the gap itself
  run.signal(SIGCONT);
  ASSERT_TRUE(run.wait_for("\"state\":\"held\""));
  run.signal(SIGINT);
  const test::Finished& ended = run.wait();
  EXPECT_NE(ended.output.find("wall time went missing"), std::string::npos);
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
