/// Faults on purpose over the wire of an arm that is not there, as a user writes them into a cell.
#include <gtest/gtest.h>

#include <string>

#include "polyarm/base/file.hpp"
#include "tests/support/command.hpp"

namespace polyarm {
namespace {

using test::ExampleCopy;
using test::Finished;
using test::run_command;

/// The example on its fake servos, with this on their wire.
Finished run_with(const std::string& faults) {
  const ExampleCopy copy("so101");
  std::string text = read_file(copy.file("cell.yaml"));
  const auto change = [&text](const std::string& from, const std::string& to) {
    ASSERT_NE(text.find(from), std::string::npos);
    text.replace(text.find(from), from.size(), to);
  };
  change("hardware: mock", "hardware: feetech_fake");
  change("port: /dev/ttyACM0", "wire_faults: \"" + faults + "\"");
  write_file_atomically(copy.file("cell.yaml"), text);
  return run_command({"run", copy.path(), "--fast", "--json", "--no-socket"});
}

struct Row {
  const char *name, *faults, *told;
};
class FakeFaults : public testing::TestWithParam<Row> {};

TEST_P(FakeFaults, EndsTheRunWithASentenceThatNamesTheJoint) {
  const Finished ran = run_with(GetParam().faults);
  EXPECT_EQ(ran.exit_code, 1) << ran.output;
  EXPECT_NE(ran.output.find(GetParam().told), std::string::npos) << ran.output;
}

INSTANTIATE_TEST_SUITE_P(All, FakeFaults,
                         testing::Values(Row{"silent", "silent@200:elbow_flex", "elbow_flex (servo 3"},
                                         Row{"cut", "cut@200", "no answer in 5 cycles"},
                                         Row{"unplug", "unplug@200", "is gone and with it"},
                                         Row{"block", "block@100:wrist_roll", "wrist_roll"}),
                         [](const testing::TestParamInfo<Row>& row) { return row.param.name; });

TEST(FakeFaultsOnTheWire, BytesThatAreLostLateOrWrongCostTheirCycleAndNothingElse) {
  const Finished ran = run_with(
      "lose@50=2; extra@100=2; wrong_sum@150=2; late@200; garbage@250=20; silent@300:gripper=3; cut@350=3");
  EXPECT_EQ(ran.exit_code, 0) << ran.output;
}

TEST(FakeFaultsOnTheWire, WhatCannotBeIsRefusedWithWhatCan) {
  for (const auto& [faults, told] :
       {std::pair{"silnt@3", "silent"}, {"silent@x", "'x'"}, {"jump@3:elbow", "elbow_flex"}}) {
    const Finished ran = run_with(faults);
    EXPECT_NE(ran.exit_code, 0);
    EXPECT_NE(ran.output.find(told), std::string::npos) << ran.output;
  }
}

}  // namespace
}  // namespace polyarm
