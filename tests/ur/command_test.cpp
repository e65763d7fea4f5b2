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

/// The number behind a word, in a line of the far side.
std::string port_behind(const std::string& line, const std::string& word) {
  const std::size_t at = line.find(word + " ");
  if (at == std::string::npos) return {};
  const std::size_t begin = at + word.size() + 1;
  return line.substr(begin, line.find_first_not_of("0123456789", begin) - begin);
}

TEST(UrExample, ACellInAnotherProcessIsArmedAndPlaces) {
  Command far({"far-side", "ur", "--port", "0", "--dashboard-port", "0", "--primary-port", "0",
               "--secondary-port", "0", "--wire", "0=0"});
  const std::string line = far.line_with("RTDE ");
  ASSERT_FALSE(port_behind(line, "RTDE").empty()) << line;
  const ExampleCopy copy("ur_far_side");
  std::string text = read_file(copy.file("cell.yaml"));
  const auto replace = [&](const std::string& from, const std::string& to) {
    ASSERT_NE(text.find(from), std::string::npos) << from;
    text.replace(text.find(from), from.size(), to);
  };
  replace("hardware: ur_fake", "hardware: ur\n    accept_unverified: true");
  replace("      wires: 0=0 ", "      rtde_port: " + port_behind(line, "RTDE") +
                                   "\n      primary_port: " + port_behind(line, "primary") +
                                   "\n      dashboard_port: " + port_behind(line, "dashboard") +
                                   "\n      watchdog_ms: 5000\n      silence_ms: 10000\n      # ");
  write_file_atomically(copy.file("cell.yaml"), text);
  Command cell({"run", copy.path(), "--real", "--full-speed", "--json", "--no-socket"},
               test::Input::terminal);
  if (cell.wait_for("nothing moves before a person types")) cell.type("arm\n");
  const Finished ran = cell.wait();
  EXPECT_EQ(ran.exit_code, 0) << ran.output;
  EXPECT_EQ(ran.result()["result"], "completed");
  far.signal(SIGTERM);
  const Finished ended = far.wait();
  EXPECT_EQ(ended.exit_code, 0) << ended.output;
  EXPECT_NE(ended.output.find("a program started"), std::string::npos) << ended.output;
}

TEST(UrFarSide, WrongOptionsAreRefused) {
  EXPECT_EQ(run_command({"far-side", "nachi"}).exit_code, 2);
  EXPECT_EQ(run_command({"far-side", "ur", "--software", "new"}).exit_code, 2);
  const Finished base = run_command({"far-side", "ur", "--robot", "agilex/ranger", "--port", "0"});
  EXPECT_NE(base.exit_code, 0) << base.output;
}

}  // namespace
}  // namespace polyarm
