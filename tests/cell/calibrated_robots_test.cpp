/// The key `calibration` of a robot: the measured geometry of its arm in place of the nominal one.
#include <gtest/gtest.h>

#include "polyarm/base/text.hpp"
#include "polyarm/description/arm_calibration.hpp"
#include "polyarm/setup/robots.hpp"
#include "tests/support/folder.hpp"

namespace polyarm {
namespace {

const char* const kCell =
    "polyarm: cell/1\nrobots:\n  arm: {model: universal_robots/ur5e, calibration: arm.yaml}\n";

struct Resolved {
  Problems problems;
  std::vector<std::string> notes;
  cell::CellRobots robots;
};
Resolved resolved(const test::Folder& folder, const std::string& calibration) {
  folder.write("arm.yaml", calibration);
  Resolved out;
  out.robots = cell::resolve_robots(cell::read_cell_file(folder.write("cell.yaml", kCell)),
                                    description::Catalogue({POLYARM_SOURCE_DIR "/robots"}), false,
                                    out.problems, out.notes);
  return out;
}

std::string file(const std::string& joints) {
  return "polyarm: arm_calibration/1\nrobot: universal_robots/ur5e\njoints:\n" + joints;
}

TEST(CalibratedRobots, MoveAsMeasuredAndTheNotesSayHowMuch) {
  const test::Folder folder;
  const description::RobotModel described =
      description::Catalogue({POLYARM_SOURCE_DIR "/robots"}).load("universal_robots/ur5e");
  description::ArmCalibration longer;
  const description::Joint& elbow =
      described.joints[static_cast<std::size_t>(described.find_joint("elbow_joint"))];
  longer.origins["elbow_joint"] = elbow.origin;
  longer.origins["elbow_joint"].position.x -= 2e-3;  // the upper arm is 2 mm longer
  const Resolved found = resolved(folder, description::arm_calibration_text(longer));
  ASSERT_FALSE(found.problems.has_errors());
  const std::vector<double> q{0, -1.5707963267948966, 0, 0, 0, 0};
  const kinematics::Chain nominal(described, described.tool_link());
  const Vec3 moved = found.robots.front()->facts->chain.forward(q).position - nominal.forward(q).position;
  EXPECT_NEAR(norm(moved), 2e-3, 1e-9);
  EXPECT_NE(join(found.notes, "\n").find("with the calibration arm.yaml the tool is up to 2.00 mm"),
            std::string::npos)
      << join(found.notes, "\n");
}

TEST(CalibratedRobots, OfAnotherRobotOrWithFaultsAreRefused) {
  const test::Folder folder;
  for (const auto& [joints, what] :
       {std::pair<std::string, std::string>{"  elbow_joint: [-0.6, 0, 0, 0, 0, 0]\n",
                                            "away from the description"},
        {"  elbow: [-0.425, 0, 0, 0, 0, 0]\n", "did you mean 'elbow_joint'"},
        {"  elbow_joint: [1, 2]\n", "arm.yaml"},
        {"", "no joints"}}) {
    Problems problems = resolved(folder, file(joints)).problems;
    ASSERT_TRUE(problems.has_errors()) << joints;
    EXPECT_NE(problems.list().front().text().find(what), std::string::npos) << problems.list().front().text();
  }
}

TEST(CalibratedRobots, AreReadBackAsWritten) {
  const test::Folder folder;
  description::ArmCalibration one{"a/b", "a test", {{"x", {{0.1, 0.2, 1.0 / 3}, from_rpy(0.1, 0.2, 0.3)}}}};
  const auto path = folder.write("arm.yaml", description::arm_calibration_text(one));
  const description::ArmCalibration again = description::read_arm_calibration(path);
  EXPECT_EQ(again.robot, one.robot);
  EXPECT_EQ(again.source, one.source);
  EXPECT_EQ(again.origins.at("x").position, one.origins.at("x").position);
  EXPECT_LT(angle_between(again.origins.at("x").rotation, one.origins.at("x").rotation), 1e-7);
}

}  // namespace
}  // namespace polyarm
