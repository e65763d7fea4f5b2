/// Two arms of one description, as a user sees them.
#include "tests/support/two_arms.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/support/command.hpp"
#include "tests/support/folder.hpp"

namespace polyarm {
namespace {

using test::Finished;
using test::run_command;

class TwoArms : public testing::Test {
 protected:
  TwoArms() {
    urdf = folder.write("pair.urdf", test::two_arms());
    folder.write("pair.srdf", test::two_arms_srdf());
    folder.write("cell.yaml", R"(polyarm: cell/1
robots:
  left: {model: pair.urdf, branch: left_hand, hardware: mujoco}
  right: {model: pair.urdf, branch: right_hand, hardware: mujoco}
program: go
)");
  }
  Finished check(const std::string& program) {
    folder.write("go.script", program);
    return run_command({"check", "--dry", folder.path().string()});
  }
  test::Folder folder;
  std::string urdf;
};

TEST_F(TwoArms, AreNamedByDescribeAndTakenByBranch) {
  const Finished whole = run_command({"describe", urdf});
  EXPECT_NE(whole.output.find("'branch: left_tool0', 'branch: right_tool0'"), std::string::npos)
      << whole.output;
  const Finished left = run_command({"describe", urdf, "--branch", "left_hand", "--json"});
  ASSERT_EQ(left.exit_code, 0) << left.output;
  const auto json = nlohmann::json::parse(left.output);
  EXPECT_EQ(json["tool_link"], "left_tool0");
  EXPECT_TRUE(json["arms"].empty());
  EXPECT_EQ(json["named_states"]["home"].size(), 5u);
  const Finished fk =
      run_command({"fk", urdf, "--branch", "right_hand", "--joints", "0.1", "0", "0", "0", "0", "--json"});
  ASSERT_EQ(fk.exit_code, 0) << fk.output;
  EXPECT_NEAR(nlohmann::json::parse(fk.output)["xyz"][1].get<double>(), -0.2, 1e-9);
}

TEST_F(TwoArms, EachRunsAlone) {
  const Finished run =
      run_command({"run", urdf, "--branch", "right_hand", "--fast", "--seconds", "0.1", "--json"});
  EXPECT_EQ(run.exit_code, 0) << run.output;
  EXPECT_EQ(run.output.find("has 2 arms"), std::string::npos) << run.output;
  const Finished cell = run_command({"run", folder.path().string(), "--branch", "right_hand"});
  EXPECT_EQ(cell.exit_code, 2);
  EXPECT_NE(cell.output.find("in a cell, write 'branch: right_hand' to a robot"), std::string::npos)
      << cell.output;
}

TEST_F(TwoArms, ADryRunFindsContactsBetweenThemAndNoneWithTheTorso) {
  const Finished clear = check(
      "together\n  movej joints(0.2m, 0.1m, 0m, 0, 0m), robot left\n"
      "  movej joints(0.1m, -0.1m, 0m, 0, 0m), robot right\nend\n");
  EXPECT_EQ(clear.exit_code, 0) << clear.output;
  EXPECT_NE(clear.output.find("0 errors, 0 warnings"), std::string::npos) << clear.output;
  const Finished hit = check("movej joints(0.1m, -0.5m, 0m, 0, 0m), robot left\n");
  EXPECT_EQ(hit.exit_code, 1) << hit.output;
  EXPECT_NE(hit.output.find("left/left_arm touched right/right_arm"), std::string::npos) << hit.output;
  EXPECT_EQ(hit.output.find("torso touched"), std::string::npos) << hit.output;
}

}  // namespace
}  // namespace polyarm
