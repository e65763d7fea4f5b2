/// The cell thread of a running program allocates for what happens, not for the time that passes.
#include <gtest/gtest.h>

#include <string>

#include "polyarm/setup/cell_file.hpp"
#include "tests/support/lock_step_cell.hpp"
#include "tests/support/realtime_guard.hpp"

namespace polyarm::cell {
namespace {

constexpr const char* kCell = "polyarm: cell/1\nrobots:\n  arm: {model: " POLYARM_SOURCE_DIR
                              "/examples/r6bot/r6bot.urdf, hardware: mock}\nsignals: signals.yaml\nprogram: "
                              "job.script\nplc: plc.script\n";
constexpr const char* kPoints =
    "JS: joint_1 joint_2 joint_3 joint_4 joint_5 joint_6\n"
    "Name: First\nPoint: 0.9, 0, 0, 0, 0, 0\nName: Second\nPoint: -0.9, 0.2, 0, 0, 0, 0\n";
/// Moves, waits for time and a handshake with the PLC, as a cell that picks and places does.
constexpr const char* kProgram =
    "load job_data\nwhile true\n  movej First\n  wait time 0.5\n  set GripperRequested = true\n  wait "
    "GripperActive\n"
    "  set GripperRequested = false\n  wait not GripperActive\n  movej Second\n  wait time 0.5\nend\n";
constexpr const char* kPlc =
    "while true\n  wait GripperRequested\n  set GripperActive = true\n  wait not GripperRequested\n"
    "  set GripperActive = false\nend\n";

TEST(CellThread, AllocatesAtMostAHundredTimesASecond) {
  if (!test::RealtimeGuard::watches()) GTEST_SKIP() << "sanitizers replace malloc";
  hardware::register_driver("mock",
                            [] { return std::unique_ptr<hardware::Component>(new drivers::MockComponent); });
  const test::Folder folder;
  folder.write("places.points", kPoints);
  folder.write("job_data.data", "Name: PointFile\nText: places\nName: ScriptFile\nText: job\n");
  folder.write(
      "signals.yaml",
      "polyarm: signals/1\ntags:\n  GripperRequested: {initial: false}\n  GripperActive: {initial: false}\n");
  folder.write("job.script", kProgram);
  folder.write("plc.script", kPlc);
  folder.write("cell.yaml", kCell);
  Observer nobody;
  CellOptions options;  // as with the wall clock: moves are planned on a thread of their own
  test::OpenCell cell(read_cell_file(folder.path()), description::Catalogue({}), options, nobody);
  cell.loop().begin();

  constexpr std::uint64_t kPasses = 6;
  constexpr int kTicks = 1'000'000;  // far more than the passes need
  Nanoseconds begun = 0;
  std::uint64_t counted = 0;
  for (int tick = 0; tick < kTicks && cell.program()->status().passes < kPasses; ++tick) {
    const bool warm = cell.program()->status().passes > 0;
    const Nanoseconds now = cell.loop().cycle().time;
    if (!warm) begun = now;
    {
      const test::RealtimeGuard guard;
      cell.tick(now);
      if (warm) counted += guard.allocations();
    }
    while (cell.loop().cycle().time < now + Cell::kTick) cell.loop().step_next();
  }
  ASSERT_FALSE(cell.failure()) << cell.failure()->problem.text();
  ASSERT_EQ(cell.program()->status().passes, kPasses);
  const double duration = seconds(cell.loop().cycle().time - begun);
  EXPECT_GT(duration, 5);
  EXPECT_LE(static_cast<double>(counted) / duration, 100) << counted << " in " << duration << " s";
  RecordProperty("allocations", std::to_string(counted));
  RecordProperty("seconds", std::to_string(duration));
  cell.loop().end();
}

}  // namespace
}  // namespace polyarm::cell
