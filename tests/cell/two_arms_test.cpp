/// The two arms of one description as two robots of a cell.
#include "tests/support/two_arms.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "polyarm/setup/cell_file.hpp"
#include "tests/support/lock_step_cell.hpp"

namespace polyarm::cell {
namespace {

using test::Folder;
using test::LockStepCell;

class TwoArmsTest : public ::testing::Test {
 protected:
  TwoArmsTest() {
    folder.write("pair.urdf", test::two_arms());
    folder.write("pair.srdf", test::two_arms_srdf());
    folder.write("scene.yaml", R"(polyarm: scene/1
floor: {height: -1}
fixtures:
  table: {box: [0.4, 0.8, 0.04], at: [0.5, 0, 0.08]}
parts:
  one: {kind: cube, box: [0.04, 0.04, 0.04], at: [0.37, 0.2, 0.12], mass: 0.1}
  two: {kind: cube, box: [0.04, 0.04, 0.04], at: [0.37, -0.2, 0.12], mass: 0.1}
)");
    folder.write("signals.yaml", R"(polyarm: signals/1
tags:
  LeftCup: {command: left/tool/vacuum}
  RightCup: {command: right/tool/vacuum}
)");
  }

  void build(const std::string& program, const std::string& left = "branch: left_hand",
             const std::string& right = "branch: right_tool0") {
    folder.write("go.script", program);
    folder.write("cell.yaml", "polyarm: cell/1\nrobots:\n  left: {model: pair.urdf, tool: suction_cup, " +
                                  left + "}\n  right: {model: pair.urdf, tool: suction_cup, " + right +
                                  "}\nscene: scene.yaml\nsignals: signals.yaml\nprogram: go\n");
    hardware::register_driver(
        "mock", [] { return std::unique_ptr<hardware::Component>(new drivers::MockComponent); });
    cell = std::make_unique<LockStepCell>(read_cell_file(folder.path()), CellOptions{});
  }
  void run() {
    for (int i = 0; i < 20'000 && !cell->cell().finished() && failure().empty(); ++i) cell->tick();
  }
  std::string failure() { return cell->cell().failure() ? cell->cell().failure()->problem.text() : ""; }
  Vec3 tcp(std::size_t robot) { return cell->cell().tcp(robot).position; }
  Problem refused(const std::string& left, const std::string& right) {
    try {
      build("wait 1ms\n", left, right);
    } catch (const Error& e) {
      return e.problems().front();
    }
    ADD_FAILURE() << "no error";
    return {};
  }

  Folder folder;
  std::unique_ptr<LockStepCell> cell;
};

TEST_F(TwoArmsTest, PickBesideEachOther) {
  build(
      "together\n"
      "  movej joints(0m, 0m, -0.26m, 0, 0m), robot left\n"
      "  movej joints(0m, 0m, -0.26m, 0, 0m), robot right\n"
      "end\n"
      "set LeftCup = true\nset RightCup = true\nwait 300ms\n"
      "together\n"
      "  movej joints(0.1m, 0.1m, 0m, 0, 0m), robot left\n"
      "  movej joints(0.1m, -0.1m, 0m, 0, 0m), robot right\n"
      "end\nwait 100ms\n");
  EXPECT_NEAR(tcp(0).x, 0.47, 1e-9) << "left begins at its home, x = 0.1";
  EXPECT_NEAR(tcp(1).x, 0.57, 1e-9) << "right begins at its home, x = 0.2";
  run();
  EXPECT_EQ(failure(), "");
  EXPECT_NEAR(tcp(0).y, 0.3, 1e-6);
  EXPECT_NEAR(tcp(1).y, -0.3, 1e-6);
  EXPECT_EQ(cell->value_of("states", "left/tool/part_present"), 1);
  EXPECT_EQ(cell->value_of("states", "right/tool/part_present"), 1);
  EXPECT_EQ(cell->value_of("states", "left/left_z/position"), 0);
  EXPECT_TRUE(std::isnan(cell->value_of("states", "left/right_z/position"))) << "it is of the other robot";
}

TEST_F(TwoArmsTest, DrivenIntoEachOtherTheyStopBeforeTheContact) {
  build("movej joints(0.1m, -0.5m, 0m, 0, 0m), robot left\n");
  run();
  EXPECT_NE(failure().find("left/tool would come within"), std::string::npos) << failure();
  EXPECT_NE(failure().find("right/right_"), std::string::npos) << failure();
  EXPECT_LT(tcp(0).y - tcp(1).y, 0.2);
  EXPECT_GT(tcp(0).y - tcp(1).y, 0.04);
}

TEST_F(TwoArmsTest, AnArmStopsBeforeTheTorso) {
  build("movej joints(-0.3m, 0m, 0m, 0, 0m), robot right\n");
  run();
  EXPECT_NE(failure().find("right/right_arm"), std::string::npos) << failure();
  EXPECT_NE(failure().find("right/torso"), std::string::npos) << failure();
}

TEST_F(TwoArmsTest, TwoRobotsWithOneJointAreRefused) {
  const Problem same = refused("branch: left_hand", "branch: left_arm");
  EXPECT_EQ(same.code, "shared-joint");
  EXPECT_EQ(same.where.line, 4);
  EXPECT_NE(same.what.find("'left' and 'right' are at the same place and both have the joints left_x"),
            std::string::npos)
      << same.what;
  const Problem whole = refused("branch: left_hand", "at: [0, 0, 0]");
  EXPECT_EQ(whole.code, "shared-joint");
  EXPECT_NE(whole.advice.find("give each of them a 'branch'"), std::string::npos) << whole.advice;
  EXPECT_EQ(refused("branch: left_hand", "branch: torso").code, "bad-branch");
  EXPECT_EQ(refused("branch: left_hand", "branch: nothing").where.line, 4);
}

TEST_F(TwoArmsTest, TheSameArmsAtAnotherPlaceAreOtherRobots) {
  build("movej joints(0.1m, 0.1m, 0m, 0, 0m), robot right\n", "branch: left_hand",
        "branch: left_hand, at: [3, 0, 0]");
  run();
  EXPECT_EQ(failure(), "");
}

TEST_F(TwoArmsTest, AWholeDescriptionSaysThatItHasTwoArms) {
  build("wait 1ms\n", "at: [0, 0, 0]", "branch: right_hand, at: [2, 0, 0]");
  EXPECT_EQ(cell->told("left: the description has 2 arms, with left_tool0 and right_tool0"), 1);
  EXPECT_EQ(cell->told("right: the description has 2 arms"), 0);
}

}  // namespace
}  // namespace polyarm::cell
