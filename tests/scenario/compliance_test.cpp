/// Programs whose tools yield to forces: whole cells, in tests that the language itself describes.
#include <gtest/gtest.h>

#include <string>

#include "polyarm/base/error.hpp"
#include "tests/support/command.hpp"
#include "tests/support/folder.hpp"

namespace polyarm {
namespace {

using test::Finished;
using test::run_command;

/// A cell with one or two arms on the mock, whose sensors measure zero: a tool that presses goes on into the air.
class InTheAir : public ::testing::Test {
 protected:
  InTheAir() {
    folder.write("cell.yaml",
                 "polyarm: cell/1\nrobots:\n"
                 "  arm: {model: universal_robots/ur5e, hardware: mock, force_sensor: true}\n"
                 "  other: {model: universal_robots/ur5e, hardware: mock, force_sensor: true, at: [0, 2, 0]}\n"
                 "signals: signals.yaml\nprogram: job.script\n");
    folder.write("signals.yaml",
                 "polyarm: signals/1\ntags:\n  Z: {state: arm/tcp/z, type: number}\n  OtherZ: {state: other/tcp/z, type: "
                 "number}\n  Trip: {initial: false}\n  Stage: {initial: 0}\n");
  }
  void expect_passes(const std::string& program, const std::string& test) {
    folder.write("job.script",
                 "let ready = pose(400mm, 100mm, 400mm, 180deg, 0deg, 0deg)\nuse robot arm\nmoveto ready\n" + program);
    folder.write("tests.script", "test \"it\"\n  run\n  wait Stage == 1 timeout 20s\n" + test + "end\n");
    const Finished run = run_command({"test", folder.path()});
    EXPECT_EQ(run.exit_code, 0) << run.output;
  }
  test::Folder folder;
};

constexpr const char* kPress = "set Stage = 1\ncomply(\"z\", force = 20N, reach = 150mm)\n";

TEST_F(InTheAir, TheToolGoesOnWithForceOverDamping) {
  expect_passes(std::string(kPress) + "wait 1s\nlet deep = ready.z - here().z\nstiff()\n"
                                      "if abs(deep - 20mm) > 1mm or abs(ready.z - here().z - deep) > 1mm\n"
                                      "  raise \"{deep:.2mm} {here().z:.2mm}\"\nend\nmovel ready\n",
                "  expect program.state == \"finished\" timeout 20s\n  expect abs(Z - 0.4) < 0.0001\n");
}

TEST_F(InTheAir, AHoldFreezesTheToolAndAResumeLetsItGoOn) {
  expect_passes(std::string(kPress) + "wait 6s\nstiff()\n",
                "  wait 500ms\n  person(\"hold\")\n  wait 500ms\n  let z = Z\n  wait 500ms\n"
                "  expect abs(Z - z) < 0.00001\n  person(\"resume\")\n  wait 500ms\n  expect Z < z - 0.005\n"
                "  expect program.state == \"finished\" timeout 20s\n");
}

TEST_F(InTheAir, AHoldWithinAMoveGoesOnAlongTheShiftedPath) {
  expect_passes(std::string(kPress) + "movel offset(ready, x = 100mm), speed 50mm/s, touch\nlet there = here()\nstiff()\n"
                                      "if abs(there.x - ready.x - 100mm) > 1mm or there.z > ready.z - 30mm\n"
                                      "  raise \"{there.x:.2mm} {there.z:.2mm}\"\nend\n",
                "  wait 800ms\n  person(\"hold\")\n  wait 500ms\n  person(\"resume\")\n"
                "  expect program.state == \"finished\" timeout 20s\n");
}

TEST_F(InTheAir, ATrapRunsBetweenAndTheToolGoesOn) {
  expect_passes("let n = 0\ntrap when Trip\n  set n = n + 1\n  wait 200ms\nend\n" + std::string(kPress) +
                    "movel offset(ready, x = 100mm), speed 50mm/s, touch\nstiff()\nif n != 1\n  raise \"{n}\"\nend\n",
                "  wait 500ms\n  set Trip = true\n  expect program.state == \"finished\" timeout 20s\n");
}

TEST_F(InTheAir, TwoRobotsYieldEachByItself) {
  expect_passes("task a\n  use robot arm\n  set Stage = 1\n  comply(\"z\", force = 20N, reach = 150mm)\n  wait 1s\n"
                "  stiff()\nend\n"
                "task b\n  use robot other\n  moveto pose(400mm, 2100mm, 400mm, 180deg, 0deg, 0deg)\n"
                "  comply(\"z\", force = -10N, reach = 150mm)\n  wait 1s\n  stiff()\nend\n",
                "  expect program.state == \"finished\" timeout 20s\n  expect abs(Z - 0.38) < 0.001\n"
                "  expect abs(OtherZ - 0.41) < 0.001\n");
}

TEST_F(InTheAir, TheEndOfAProgramMakesTheToolStiff) {
  expect_passes(std::string(kPress) + "wait 200ms\n",
                "  expect program.state == \"finished\" timeout 20s\n  wait 100ms\n  let z = Z\n  wait 500ms\n"
                "  expect abs(Z - z) < 0.00001\n");
}

TEST_F(InTheAir, ADiscardMakesTheToolStiffWhereItIs) {
  expect_passes(std::string(kPress) + "wait 6s\nstiff()\n",
                "  wait 500ms\n  person(\"hold\")\n  wait 300ms\n  person(\"discard\")\n  wait 300ms\n  let z = Z\n"
                "  person(\"resume\")\n  wait 500ms\n  expect abs(Z - z) < 0.00001\n");
}

TEST_F(InTheAir, AStopEndsItWhereTheToolIs) {
  expect_passes(std::string(kPress) + "wait 6s\nstiff()\n",
                "  wait 500ms\n  person(\"stop\")\n  wait 300ms\n  let z = Z\n  wait 500ms\n"
                "  expect program.state == \"stopped\"\n  expect abs(Z - z) < 0.00001\n");
}

TEST_F(InTheAir, ASecondComplyIsAnError) {
  expect_passes(std::string(kPress) + "try\n  comply(\"x\")\n  raise \"taken\"\non error e\n  stiff()\n"
                                      "  if not (find(e.text, \"already\") > 0)\n    raise\n  end\nend\n",
                "  expect program.state == \"finished\" timeout 20s\n");
}

}  // namespace
}  // namespace polyarm
