/// The example and `polyarm far-side ur`, as users start them.
#include "tests/support/command.hpp"

#include <gtest/gtest.h>

#include "polyarm/base/file.hpp"

namespace polyarm {
namespace {

using test::Command;
using test::ExampleCopy;
using test::Finished;
using test::run_command;

TEST(UrExample, PlacesOverTheControllersWiresAndRepeatsItself) {
  const ExampleCopy copy("ur_far_side");
  const std::vector<std::string> line{"run", copy.path(), "--fast", "--json", "--no-socket"};
  const Finished first = run_command(line);
  ASSERT_EQ(first.exit_code, 0) << first.output;
  EXPECT_EQ(first.result()["result"], "completed");
  EXPECT_NE(first.output.find("Universal Robots controller 5.15.0"), std::string::npos);
  EXPECT_EQ(run_command(line).result()["trace_hash"], first.result()["trace_hash"]);
}

TEST(UrExample, AFaultOfTheControllerEndsTheRunWithItsCause) {
  const ExampleCopy copy("ur_far_side");
  std::string text = read_file(copy.file("cell.yaml"));
  const std::string wires = "wires: 0=0 ";
  text.replace(text.find(wires), wires.size(), "faults: protective_stop@2\n      wires: 0=0 ");
  write_file_atomically(copy.file("cell.yaml"), text);
  const Finished ran = run_command({"run", copy.path(), "--fast", "--json", "--no-socket"});
  EXPECT_EQ(ran.exit_code, 1);
  EXPECT_NE(ran.output.find("made a protective stop"), std::string::npos) << ran.output;
  EXPECT_NE(ran.output.find("Enable robot"), std::string::npos) << "says what to do";
}

TEST(UrFarSide, WrongOptionsAreRefused) {
  EXPECT_EQ(run_command({"far-side", "fanuc"}).exit_code, 2);
  EXPECT_EQ(run_command({"far-side", "ur", "--software", "new"}).exit_code, 2);
  const Finished base = run_command({"far-side", "ur", "--robot", "agilex/ranger", "--port", "0"});
  EXPECT_NE(base.exit_code, 0) << base.output;
}

}  // namespace
}  // namespace polyarm
