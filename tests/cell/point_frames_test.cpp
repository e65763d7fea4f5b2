#include <gtest/gtest.h>

#include "tests/support/lock_step_cell.hpp"

namespace polyarm {
namespace {

/// A UR3 on the mock, with points and a program of the test's own.
class PointFrames : public testing::Test {
 protected:
  void run(const std::string& points, const std::string& program) {
    hardware::register_driver(
        "mock", [] { return std::unique_ptr<hardware::Component>(new drivers::MockComponent); });
    folder.write(
        "cell.yaml",
        "polyarm: cell/1\nrobots: {arm: {model: universal_robots/ur3, hardware: mock, tool: suction_cup}}\n"
        "program: main.script\n");
    folder.write("places.points", points);
    folder.write("main.script", "load places\n" + program);
    cell::CellOptions options;
    options.lock_step = true;
    cell = std::make_unique<cell::Cell>(cell::read_cell_file(folder.path() / "cell.yaml"),
                                        description::Catalogue({POLYARM_SOURCE_DIR "/robots"}), options,
                                        observer);
    cell->loop().begin();
    for (int k = 0; k < 20'000 && !cell->finished() && !cell->failure(); ++k) {
      const Nanoseconds until = cell->loop().cycle().time + cell::Cell::kTick;
      cell->tick(cell->loop().cycle().time);
      while (cell->loop().cycle().time < until) cell->loop().step_next();
    }
    cell->loop().end();
  }
  void expect_tcp(const Pose& wanted) {
    ASSERT_FALSE(cell->failure()) << cell->failure()->problem.text();
    EXPECT_LT(norm(cell->tcp(0).position - wanted.position), 1e-6);
    EXPECT_LT(angle_between(cell->tcp(0).rotation, wanted.rotation), 1e-6);
  }

  test::Folder folder;
  cell::Observer observer;
  std::unique_ptr<cell::Cell> cell;
};

const Pose kTable = pose_xyz_rpy({0.25, 0.1, 0.05}, {0, 0, 0.5});
const Pose kOnTable = pose_xyz_rpy({0.05, 0.02, 0.1}, {3, 0, 0});
constexpr const char* kPoints =
    "Pose: RPY\nName: table\nPoint: 0.25, 0.1, 0.05, 0, 0, 0.5\nName: corner\nPoint: 0.01, 0, 0, 0, 0, 0; "
    "frame = "
    "\"table\"\nName: p\nPoint: 0.05, 0.02, 0.1, 3, 0, 0; frame = \"table\"\nName: q\nPoint: 0.05, 0.02, "
    "0.1, 3, 0, 0; "
    "frame = \"corner\"\nName: up\nPoint: 0, 0, -0.03, 0, 0, 0; frame = \"arm/tcp\"\nName: lost\nPoint: 0, "
    "0, 0.1, 0, "
    "0, 0; frame = \"tabel\"\nName: a\nPoint: 0, 0, 0, 0, 0, 0; frame = \"b\"\nName: b\nPoint: 0, 0, 0, 0, "
    "0, 0; frame "
    "= \"a\"\n";

TEST_F(PointFrames, APoseIsMeantInTheFrameThatItNames) {
  run(kPoints, "movej p\n");
  expect_tcp(kTable * kOnTable);
}

TEST_F(PointFrames, AFrameMayBeInAnotherAndAMovesOwnFrameDoesNotCount) {
  run(kPoints, "use frame table\nmovej q\n");
  expect_tcp(kTable * Pose{{0.01, 0, 0}, {}} * kOnTable);
}

TEST_F(PointFrames, AFrameThatChangesTakesItsPointsAlong) {
  run(kPoints, "set table = pose(300mm, 0, 50mm, 0, 0, 0)\nmovej p\n");
  expect_tcp(pose_xyz_rpy({0.3, 0, 0.05}, {0, 0, 0}) * kOnTable);
}

TEST_F(PointFrames, AFrameThatHangsOnTheRobotIsWhereItStands) {
  run(kPoints, "moveto p\nmovel up\n");
  expect_tcp(kTable * kOnTable * Pose{{0, 0, -0.03}, {}});
}

TEST_F(PointFrames, AFrameOnARobotThatIsUnderWayIsRefused) {
  run(kPoints, "movej p\nmovel up\n");
  ASSERT_TRUE(cell->failure());
  EXPECT_EQ(cell->failure()->problem.code, "frame-moves") << cell->failure()->problem.text();
}

TEST_F(PointFrames, AFrameThatThereIsNotIsToldWithTheNearestName) {
  run(kPoints, "movej lost\n");
  ASSERT_TRUE(cell->failure());
  EXPECT_NE(cell->failure()->problem.text().find("did you mean 'table'"), std::string::npos)
      << cell->failure()->problem.text();
}

TEST_F(PointFrames, AFrameThatHangsOnItselfIsToldAndNothingHangs) {
  run(kPoints, "movej a\n");
  ASSERT_TRUE(cell->failure());
  EXPECT_NE(cell->failure()->problem.text().find("hangs on itself"), std::string::npos);
}

}  // namespace
}  // namespace polyarm
