/// `polyarm doctor` as a person has it.
#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/support/command.hpp"

namespace polyarm {
namespace {

using test::run_command;

TEST(DoctorCommand, SaysThatCellsCanBeSimulatedHere) {
  const auto said = run_command({"doctor", "--json"});
  EXPECT_EQ(said.exit_code, 0) << said.output;
  const nlohmann::json result = said.result();
  EXPECT_EQ(result["may_simulate"], true);
  bool catalogue = false, clock = false;
  for (const auto& finding : result["findings"]) {
    EXPECT_TRUE(finding["grade"] != "problem" || finding["mend"] != "") << finding;
    catalogue = catalogue || (finding["topic"] == "catalogue" && finding["grade"] == "ok");
    clock = clock || finding["topic"] == "clock";
  }
  EXPECT_TRUE(catalogue && clock) << said.output;
}

TEST(DoctorCommand, ABrokenDriverIsReportedAndNotFatal) {
  const test::ExampleCopy folder("pick_and_place");
  std::FILE* file = std::fopen(folder.file("polyarm_driver_broken.so").c_str(), "w");
  ASSERT_NE(file, nullptr);
  std::fputs("no library\n", file);
  std::fclose(file);
  ::setenv("POLYARM_DRIVERS", folder.path().c_str(), 1);
  const auto said = run_command({"doctor"});
  ::unsetenv("POLYARM_DRIVERS");
  EXPECT_EQ(said.exit_code, 0) << said.output;
  EXPECT_NE(said.output.find("broken cannot be loaded"), std::string::npos) << said.output;
}

}  // namespace
}  // namespace polyarm
