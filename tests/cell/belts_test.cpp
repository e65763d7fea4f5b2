/// Programs that follow a belt whose encoder is that of the mock.
#include "polyarm/tasks/belts.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "polyarm/setup/cell_file.hpp"
#include "tests/support/lock_step_cell.hpp"

namespace polyarm::cell {
namespace {

class OnABelt : public ::testing::Test {
 protected:
  OnABelt() {
    folder.write("scene.yaml",
                 "polyarm: scene/1\nfloor: false\nbelts:\n  line: {size: [1.7, 0.2, 0.04], at: [0.5, 0, "
                 "0.1], rpy: [0, 0, 90deg]}\n");
    folder.write("signals.yaml",
                 "polyarm: signals/1\ntags:\n  LineSpeed: {command: scene/line/speed, type: number}\n"
                 "  Travel: {state: scene/line/position, type: number}\n  Counts: {state: "
                 "scene/line/position, type: number}\n"
                 "  Seen: {initial: false}\n  TcpX: {state: arm/tcp/x, type: number}\n"
                 "  TcpY: {state: arm/tcp/y, type: number}\n");
    write_cell("");
  }
  void write_cell(const std::string& more) {
    folder.write(
        "cell.yaml",
        "polyarm: cell/1\nrobots:\n  arm: {model: universal_robots/ur5e, hardware: mock}\nscene: scene.yaml\n"
        "signals: signals.yaml\nprogram: job.script\nbelts:\n  line: {at: [0.5, 0, 0.1], rpy: [0, 0, 90deg], "
        "encoder: Travel, sensor: Seen, sensor_at: -350mm, from: -300mm, start_by: 200mm, to: 300mm" +
            more + "}\n");
  }
  /// What the run fails with; empty: nothing.
  std::string failure(const std::string& program, double seconds = 12) {
    folder.write("job.script",
                 "let ready = pose(500mm, -300mm, 300mm, 180deg, 0, 0)\nlet over = pose(0, 0, 100mm, 180deg, "
                 "0, -90deg)\n"
                 "func check_place(start)\n  let x = TcpX\n  let off = TcpY - (Travel - start - 0.35)\n"
                 "  if abs(off) > 0.001 or abs(x - 0.5) > 0.001\n    raise \"off by {off} {x}\"\n  end\nend\n"
                 "moveto ready\nset LineSpeed = 0.3\nwait 500ms\n" +
                     program);
    test::LockStepCell cell(read_cell_file(folder.path()), {std::string(POLYARM_SOURCE_DIR) + "/robots"});
    cell.run(seconds);
    return cell.cell().failure() ? cell.cell().failure()->problem.what : std::string{};
  }
  test::Folder folder;
};

TEST_F(OnABelt, TheToolStaysBesideThePart) {
  EXPECT_EQ(
      failure(
          "let began = Travel\nadd_part(\"line\", pose(-350mm, 0, 0))\nwait next_part(\"line\") timeout 5s\n"
          "movel over, frame \"line\"\ncheck_place(began)\nwait 300ms\ncheck_place(began)\n"
          "movel offset(over, z = -50mm), frame \"line\"\nwait 1ms\ncheck_place(began)\n"
          "set LineSpeed = 0.1\nwait 400ms\ncheck_place(began)\n"
          "moveto ready\nif abs(TcpY + 0.3) > 1e-5\n  raise \"not back\"\nend\n"),
      "");
}

TEST_F(OnABelt, ASensorQueuesPartsOnce) {
  EXPECT_EQ(failure("if waiting_parts(\"line\") > 0\n  raise \"none has come\"\nend\n"
                    "set Seen = true\nwait 100ms\nset Seen = false\nwait 100ms\n"
                    "if waiting_parts(\"line\") != 1\n  raise \"one has come\"\nend\n"
                    "wait 2s\nif waiting_parts(\"line\") != 0 or missed_parts(\"line\") != 1\n  raise \"it "
                    "has gone\"\nend\n"
                    "if next_part(\"line\")\n  raise \"too late\"\nend\n"),
            "");
}

TEST_F(OnABelt, APartThatLeavesTheWindowIsMissed) {
  EXPECT_EQ(failure("add_part(\"line\", pose(-350mm, 0, 0))\nwait next_part(\"line\") timeout 5s\n"
                    "try\n  movel over, frame \"line\"\n  wait 3s\n  movel over, frame \"line\"\n  raise "
                    "\"not missed\"\n"
                    "on error e\n  if e.kind != \"missed\"\n    raise\n  end\nend\n"
                    "moveto ready\nif missed_parts(\"line\") != 1\n  raise \"not counted\"\nend\n"),
            "");
}

TEST_F(OnABelt, AMoveThatIsUnderWayFailsWithThePart) {
  EXPECT_EQ(failure("add_part(\"line\", pose(-350mm, 0, 0))\nwait next_part(\"line\") timeout 5s\n"
                    "movel over, frame \"line\", speed 10mm/s\nwait 1ms\n"),
            "the part on the belt 'line' has left the window, which ends at 0.3 m");
}

TEST_F(OnABelt, MistakesAreSaid) {
  EXPECT_EQ(failure("wait next_part(\"lin\")\n"), "the cell has no belt 'lin'; did you mean 'line'?");
  EXPECT_EQ(failure("movel over, frame \"line\"\n"), "'arm' has no part on the belt 'line' yet");
}

TEST_F(OnABelt, ATagOfALinkIsItsEncoder) {
  folder.write("signals.yaml",
               "polyarm: signals/1\nlinks:\n  plc:\n    modbus: client\n    host: 127.0.0.1\n    port: 5020\n"
               "    tags:\n      Travel: {input: 0, type: number, direction: in}\n      Seen: {discrete: 0, "
               "direction: in}\n");
  folder.write("job.script", "log(waiting_parts(\"line\"))\n");
  const test::LockStepCell cell(read_cell_file(folder.path()), {std::string(POLYARM_SOURCE_DIR) + "/robots"});
  folder.write("signals.yaml", "polyarm: signals/1\n");
  try {
    const test::LockStepCell without(read_cell_file(folder.path()),
                                     {std::string(POLYARM_SOURCE_DIR) + "/robots"});
    FAIL() << "an encoder that is not there";
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("`Travel: {initial: 0}`, below `tags:` of signals.yaml"),
              std::string::npos)
        << e.what();
  }
}

TEST(TravelFilter, FollowsAConstantSpeedExactly) {
  TravelFilter filter;
  for (int i = 0; i < 500; ++i) filter.add(0.3 * 0.002 * i, 2'000'000LL * i);
  EXPECT_NEAR(filter.value().velocity, 0.3, 1e-9);
  EXPECT_NEAR(filter.value().travel, 0.3 * 0.002 * 499, 1e-9);
  EXPECT_NEAR(filter.value().acceleration, 0, 1e-6);
}

}  // namespace
}  // namespace polyarm::cell
