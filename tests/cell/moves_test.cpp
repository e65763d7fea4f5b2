// What programs draw: moves of every kind in a cell, looked at in every cycle.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "polyarm/cell/cell_file.hpp"
#include "tests/support/lock_step_cell.hpp"

namespace polyarm {
namespace {

using test::LockStepCell;

cell::CellFile drawing(const std::string& program) {
  cell::Overrides overrides;
  overrides.program = program;
  overrides.hardware = "mock";
  return cell::read_cell_file(std::string(POLYARM_SOURCE_DIR) + "/examples/r6bot/drawing.yaml", overrides);
}

/// Runs to the end of the program and gives the TCP's place in every tick.
std::vector<Vec3> drawn(LockStepCell& run, double most_s) {
  std::vector<Vec3> out;
  while (!run.cell().finished() && run.cell().loop().cycle().time < nanoseconds(most_s)) {
    run.tick();
    out.push_back(run.cell().tcp(0).position);
  }
  EXPECT_TRUE(run.cell().finished());
  return out;
}

TEST(Moves, TheCircleIsACircle) {
  LockStepCell run(drawing("circle"));
  const std::vector<Vec3> way = drawn(run, 20);
  ASSERT_FALSE(way.empty());
  const Vec3 start = way.back(), center = start - Vec3{0, 0, 0.1};
  double length = 0;
  std::size_t on_it = 0;
  for (std::size_t i = 1; i < way.size(); ++i) {
    const double radius = norm(way[i] - center);
    if (std::abs(radius - 0.1) > 1e-3) continue;  // on the way there
    ++on_it;
    EXPECT_NEAR(radius, 0.1, 1e-6);
    EXPECT_NEAR(way[i].y, start.y, 1e-6);
    length += norm(way[i] - way[i - 1]);
  }
  EXPECT_GT(on_it, 1000u);
  EXPECT_NEAR(length, 2 * M_PI * 0.1, 2e-3);
}

TEST(Moves, TheEllipseIsThatOfItsReference) {
  LockStepCell run(drawing("ellipse"));
  const std::vector<Vec3> way = drawn(run, 20);
  ASSERT_GT(way.size(), 1000u);
  const Vec3 start = way.back();
  const double a = 0.3 * 2 * 3 / (2 * M_PI), b = 0.3 * 3 / (2 * M_PI);  // of the generator's velocities over 3 s
  double most = 0;
  for (const Vec3& p : way) {
    const double x = (p.x - start.x) / a, y = (p.y - start.y) / b + 1;
    most = std::max(most, std::abs(std::hypot(x, y) - 1) * b);
  }
  printf("most %g end %g %g %g\n", most, start.x, start.y, start.z);
  EXPECT_LT(most, 5e-5);
}

}  // namespace
}  // namespace polyarm
