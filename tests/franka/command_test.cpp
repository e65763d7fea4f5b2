/// The example, as users start it.
#include "tests/support/command.hpp"

#include <gtest/gtest.h>

#include "polyarm/base/file.hpp"
#include "tests/support/wire_rig.hpp"

namespace polyarm {
namespace {

using test::ExampleCopy;
using test::Finished;
using test::run_command;

void replace(std::string& text, const std::string& old, const std::string& with) {
  const std::size_t at = text.find(old);
  ASSERT_NE(at, std::string::npos) << old;
  text.replace(at, old.size(), with);
}

TEST(FrankaExample, PlacesWithTheHandAndRepeatsItself) {
  const ExampleCopy copy("franka");
  const std::vector<std::string> line{"run", copy.path(), "--fast", "--json", "--no-socket"};
  const Finished first = run_command(line);
  ASSERT_EQ(first.exit_code, 0) << first.output;
  EXPECT_EQ(first.result()["result"], "completed");
  EXPECT_NE(first.output.find("joint positions at 1000 Hz, with its hand"), std::string::npos)
      << first.output;
  EXPECT_EQ(run_command(line).result()["trace_hash"], first.result()["trace_hash"]);
}

TEST(FrankaExample, AFaultOfTheRobotEndsTheRunWithItsCause) {
  const ExampleCopy copy("franka");
  std::string text = read_file(copy.file("cell.yaml"));
  replace(text, "faults: part=30@0", "faults: part=30@0 collision@2");
  write_file_atomically(copy.file("cell.yaml"), text);
  const Finished ran = run_command({"run", copy.path(), "--fast", "--json", "--no-socket"});
  EXPECT_EQ(ran.exit_code, 1);
  EXPECT_NE(ran.output.find("stopped for a collision (joint_reflex)"), std::string::npos) << ran.output;
  EXPECT_NE(ran.output.find("clear the space"), std::string::npos) << "says what to do";
}

}  // namespace
}  // namespace polyarm
