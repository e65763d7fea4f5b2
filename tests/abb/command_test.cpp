/// The example, `polyarm far-side abb` and `polyarm setup abb`, as users start them.
#include "tests/support/command.hpp"

#include <gtest/gtest.h>

#include "polyarm/base/file.hpp"
#include "tests/support/wire_rig.hpp"

namespace polyarm {
namespace {

using test::Command;
using test::ExampleCopy;
using test::Finished;
using test::run_command;

void replace(std::string& text, const std::string& from, const std::string& to) {
  ASSERT_NE(text.find(from), std::string::npos) << from;
  text.replace(text.find(from), from.size(), to);
}

TEST(AbbExample, PlacesOverTheControllersWiresAndRepeatsItself) {
  const ExampleCopy copy("abb_far_side");
  const std::vector<std::string> line{"run", copy.path(), "--fast", "--json", "--no-socket"};
  const Finished first = run_command(line);
  ASSERT_EQ(first.exit_code, 0) << first.output;
  EXPECT_EQ(first.result()["result"], "completed");
  EXPECT_NE(first.output.find("EGM at 250 Hz"), std::string::npos) << first.output;
  EXPECT_EQ(run_command(line).result()["trace_hash"], first.result()["trace_hash"]);
}

TEST(AbbExample, AFaultOfTheControllerEndsTheRunWithItsCause) {
  const ExampleCopy copy("abb_far_side");
  std::string text = read_file(copy.file("cell.yaml"));
  replace(text, "wires: doVacuum=diHolds", "faults: guard_open@2\n      wires: doVacuum=diHolds");
  write_file_atomically(copy.file("cell.yaml"), text);
  const Finished ran = run_command({"run", copy.path(), "--fast", "--json", "--no-socket"});
  EXPECT_EQ(ran.exit_code, 1);
  EXPECT_NE(ran.output.find("a guard of the controller"), std::string::npos) << ran.output;
  EXPECT_NE(ran.output.find("close it"), std::string::npos) << "says what to do";
}

TEST(AbbSetup, FindsTheControllerAndInstallsTheModule) {
  Command far({"far-side", "abb", "--port", "0", "--order", "no_module"});
  const std::string port = test::number_behind(far.line_with("Robot Web Services "), "at port");
  ASSERT_FALSE(port.empty());
  const std::vector<std::string> line{"setup", "abb", "--host",     "127.0.0.1",
                                      "--rws", "2",   "--rws-port", port};
  const Finished missing = run_command(line);
  EXPECT_EQ(missing.exit_code, 1) << missing.output;
  EXPECT_NE(missing.output.find("does not have the module PolyarmEGM"), std::string::npos) << missing.output;
  EXPECT_NE(missing.output.find("Externally Guided Motion is installed"), std::string::npos)
      << missing.output;
  std::vector<std::string> install = line;
  install.insert(install.end(), {"--install", "--yes"});
  const Finished done = run_command(install);
  EXPECT_EQ(done.exit_code, 0) << done.output;
  EXPECT_NE(done.output.find("loaded"), std::string::npos) << done.output;
  EXPECT_EQ(run_command(line).exit_code, 0);
  far.signal(SIGTERM);
  EXPECT_EQ(far.wait().exit_code, 0);
}

TEST(AbbFarSide, WrongOptionsAreRefused) {
  EXPECT_EQ(run_command({"far-side", "abb", "--rws", "3"}).exit_code, 2);
  EXPECT_EQ(run_command({"far-side", "abb", "--egm", "nowhere", "--port", "0"}).exit_code, 2);
  EXPECT_EQ(run_command({"far-side", "abb", "--start", "1 2 3", "--port", "0"}).exit_code, 2);
  EXPECT_EQ(run_command({"far-side", "abb", "--wire", "a", "--port", "0"}).exit_code, 2);
  const Finished base = run_command({"far-side", "abb", "--robot", "agilex/ranger", "--port", "0"});
  EXPECT_NE(base.exit_code, 0) << base.output;
}

}  // namespace
}  // namespace polyarm
