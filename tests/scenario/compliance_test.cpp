/// Programs whose tools yield to forces, and sensors with errors: whole cells, in tests that the language
/// itself describes.
#include <gtest/gtest.h>

#include <string>

#include "polyarm/base/error.hpp"
#include "tests/support/command.hpp"
#include "tests/support/folder.hpp"

namespace polyarm {
namespace {

using test::Finished;
using test::run_command;

/// A cell with one or two arms on the mock, whose sensors measure zero: a tool that presses goes on into the
/// air.
class InTheAir : public ::testing::Test {
 protected:
  InTheAir() {
    folder.write(
        "cell.yaml",
        "polyarm: cell/1\nrobots:\n"
        "  arm: {model: universal_robots/ur5e, hardware: mock, force_sensor: true}\n"
        "  other: {model: universal_robots/ur5e, hardware: mock, force_sensor: true, at: [0, 2, 0]}\n"
        "signals: signals.yaml\nprogram: job.script\n");
    folder.write("signals.yaml",
                 "polyarm: signals/1\ntags:\n  Z: {state: arm/tcp/z, type: number}\n  OtherZ: {state: "
                 "other/tcp/z, type: "
                 "number}\n  Trip: {initial: false}\n  Stage: {initial: 0}\n");
  }
  void expect_passes(const std::string& program, const std::string& test) {
    folder.write(
        "job.script",
        "let ready = pose(400mm, 100mm, 400mm, 180deg, 0deg, 0deg)\nuse robot arm\nmoveto ready\n" + program);
    folder.write("tests.script", "test \"it\"\n  run\n  wait Stage == 1 timeout 20s\n" + test + "end\n");
    const Finished run = run_command({"test", folder.path()});
    EXPECT_EQ(run.exit_code, 0) << run.output;
  }
  test::Folder folder;
};

constexpr const char* kPress = "set Stage = 1\ncomply(\"z\", force = 20N, reach = 150mm)\n";

TEST_F(InTheAir, TheToolGoesOnWithForceOverDamping) {
  expect_passes(std::string(kPress) +
                    "wait 1s\nlet deep = ready.z - here().z\nstiff()\n"
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
  expect_passes(std::string(kPress) +
                    "movel offset(ready, x = 100mm), speed 50mm/s, touch\nlet there = here()\nstiff()\n"
                    "if abs(there.x - ready.x - 100mm) > 1mm or there.z > ready.z - 30mm\n"
                    "  raise \"{there.x:.2mm} {there.z:.2mm}\"\nend\n",
                "  wait 800ms\n  person(\"hold\")\n  wait 500ms\n  person(\"resume\")\n"
                "  expect program.state == \"finished\" timeout 20s\n");
}

TEST_F(InTheAir, ATrapRunsBetweenAndTheToolGoesOn) {
  expect_passes(
      "let n = 0\ntrap when Trip\n  set n = n + 1\n  wait 200ms\nend\n" + std::string(kPress) +
          "movel offset(ready, x = 100mm), speed 50mm/s, touch\nstiff()\nif n != 1\n  raise \"{n}\"\nend\n",
      "  wait 500ms\n  set Trip = true\n  expect program.state == \"finished\" timeout 20s\n");
}

TEST_F(InTheAir, TwoRobotsYieldEachByItself) {
  expect_passes(
      "task a\n  use robot arm\n  set Stage = 1\n  comply(\"z\", force = 20N, reach = 150mm)\n  wait 1s\n"
      "  stiff()\nend\n"
      "task b\n  use robot other\n  moveto pose(400mm, 2100mm, 400mm, 180deg, 0deg, 0deg)\n"
      "  comply(\"z\", force = -10N, reach = 150mm)\n  wait 1s\n  stiff()\nend\n",
      "  expect program.state == \"finished\" timeout 20s\n  expect abs(Z - 0.38) < 0.001\n"
      "  expect abs(OtherZ - 0.41) < 0.001\n");
}

TEST_F(InTheAir, TheEndOfAProgramMakesTheToolStiff) {
  expect_passes(
      std::string(kPress) + "wait 200ms\n",
      "  expect program.state == \"finished\" timeout 20s\n  wait 300ms\n  let z = Z\n  wait 500ms\n"
      "  expect abs(Z - z) < 0.00001\n");
}

TEST_F(InTheAir, TheToolIsStiffBeforeTheBlockOnStop) {
  expect_passes(std::string(kPress) + "wait 300ms\non stop\n  set Stage = 2\nend\n",
                "  wait Stage == 2 timeout 2s\n  let z = Z\n  wait 500ms\n  expect abs(Z - z) < 0.00001\n");
}

TEST_F(InTheAir, ADiscardMakesTheToolStiffWhereItIs) {
  expect_passes(
      std::string(kPress) + "wait 6s\nstiff()\n",
      "  wait 500ms\n  person(\"hold\")\n  wait 300ms\n  person(\"discard\")\n  wait 300ms\n  let z = Z\n"
      "  person(\"resume\")\n  wait 500ms\n  expect abs(Z - z) < 0.00001\n");
}

TEST_F(InTheAir, AStopEndsItWhereTheToolIs) {
  expect_passes(std::string(kPress) + "wait 6s\nstiff()\n",
                "  wait 500ms\n  person(\"stop\")\n  wait 300ms\n  let z = Z\n  wait 500ms\n"
                "  expect program.state == \"stopped\"\n  expect abs(Z - z) < 0.00001\n");
}

TEST_F(InTheAir, AMoveAfterADiscardFailsInsteadOfPressingWithAStiffTool) {
  const std::string expected =
      "on error e\n  if not (find(e.text, \"no longer\") > 0)\n    raise\n  end\nend\n";
  expect_passes(std::string(kPress) + "wait 3s\ntry\n  movel ready, touch\n  raise \"it moved\"\n" +
                    expected + "try\n  stiff()\n  raise \"fine\"\n" + expected + "movel ready\n",
                "  wait 500ms\n  person(\"hold\")\n  wait 300ms\n  person(\"discard\")\n  wait 300ms\n"
                "  person(\"resume\")\n  expect program.state == \"finished\" timeout 20s\n");
}

TEST_F(InTheAir, AnotherComplyMayFollowStiffAtOnce) {
  expect_passes(std::string(kPress) +
                    "wait 300ms\nstiff()\ncomply(\"z\", force = -20N, reach = 150mm)\n"
                    "movel offset(ready, x = 50mm), speed 50mm/s, touch\nstiff()\n",
                "  expect program.state == \"finished\" timeout 20s\n  expect Z > 0.405\n");
}

TEST_F(InTheAir, ASecondComplyIsAnError) {
  expect_passes(std::string(kPress) +
                    "try\n  comply(\"x\")\n  raise \"taken\"\non error e\n  stiff()\n"
                    "  if not (find(e.text, \"already\") > 0)\n    raise\n  end\nend\n",
                "  expect program.state == \"finished\" timeout 20s\n");
}

/// A sensor with noise, a bias and drift, at rest in the air of physics.
TEST(NoisySensor, ZeroTakesTheBiasAndTheDriftAway) {
  const test::Folder folder;
  folder.write(
      "cell.yaml",
      "polyarm: cell/1\nrobots:\n  arm: {model: universal_robots/ur5e, hardware: mujoco, tool: suction_cup, "
      "force_sensor: {noise: 0.3N, bias: [2N, -1N, 3N, 0Nm, 0Nm, 0Nm], drift: 4N}}\nprogram: job.script\n");
  folder.write(
      "job.script",
      "func level(n)\n  let sum = 0N\n  for i in 1 .. n\n    wait 4ms\n    set sum = sum + wrench().z\n  "
      "end\n"
      "  return sum / n\nend\n"
      "wait 300ms\nzero_force()\nlet first = level(50)\nwait 20s\nlet later = level(50)\nzero_force()\n"
      "let again = level(50)\nlog(\"{first:.3N} {later:.3N} {again:.3N}\")\n"
      "if abs(first) > 0.2N or abs(again) > 0.2N\n  raise \"the zero is wrong: {first:.2N} "
      "{again:.2N}\"\nend\n"
      "if abs(later) < 0.25N\n  raise \"nothing has drifted: {later:.2N}\"\nend\n");
  const Finished run = run_command({"run", folder.path(), "--fast"});
  EXPECT_EQ(run.exit_code, 0) << run.output;
}

/// A wall in the way, with contacts allowed: the torques of the motors are left to find it.
TEST(CollisionTorque, StopsARobotThatPushesAgainstAWall) {
  const test::Folder folder;
  const auto write = [&](const char* limit) {
    folder.write("cell.yaml",
                 std::string("polyarm: cell/1\nrobots:\n  arm: {model: universal_robots/ur5e, hardware: "
                             "mujoco, tool: suction_cup, collision_torque: ") +
                     limit + "}\nscene: scene.yaml\nprogram: job.script\n");
  };
  folder.write("scene.yaml",
               "polyarm: scene/1\nfixtures:\n  wall: {box: [40mm, 400mm, 600mm], at: [0.62, 0, 0.3]}\n");
  folder.write(
      "job.script",
      "movej pose(450mm, 0mm, 300mm, 180deg, 0deg, 0deg)\nmovel pose(500mm, 0mm, 300mm, 180deg, 0deg, 0deg)\n"
      "movel pose(640mm, 0mm, 300mm, 180deg, 0deg, 0deg), speed 200mm/s\nlog(\"through\")\n");
  const std::vector<std::string> line = {"run", folder.path(), "--fast", "--allow-contact"};
  write("30Nm");
  const Finished stopped = run_command(line);
  EXPECT_EQ(stopped.exit_code, 1) << stopped.output;
  EXPECT_NE(stopped.output.find("job.script:2:1: error: "), std::string::npos) << stopped.output;
  EXPECT_NE(stopped.output.find("from outside, more than the 30 Nm of collision_torque"), std::string::npos)
      << stopped.output;
  write("{elbow: 30Nm}");
  EXPECT_NE(run_command({"check", folder.path()}).output.find("the robot has no joint 'elbow'"),
            std::string::npos);
}

/// Fast moves in the air with a small limit: masses and motion are not taken for a collision.
TEST(CollisionTorque, DoesNotStopFastMovesInTheAir) {
  const test::Folder folder;
  folder.write(
      "cell.yaml",
      "polyarm: cell/1\nrobots:\n  arm: {model: universal_robots/ur5e, hardware: mujoco, tool: suction_cup, "
      "collision_torque: 12Nm}\nprogram: job.script\n");
  folder.write("job.script",
               "for i in 1 .. 3\n  movej pose(400mm, 300mm, 500mm, 180deg, 0deg, 0deg)\n"
               "  movej pose(400mm, -300mm, 300mm, 180deg, 0deg, 0deg)\nend\n");
  const Finished run = run_command({"run", folder.path(), "--fast"});
  EXPECT_EQ(run.exit_code, 0) << run.output;
}

/// While a pad slides, single readings of its force are several times their mean. None ends the compliance.
TEST(Sliding, WorksWithOtherArmsAtTheSpeedsOfTheExample) {
  for (const char* robot : {"ufactory/xarm_6", "franka/fr3"}) {
    const Finished run = run_command({"test", POLYARM_SOURCE_DIR "/examples/polishing", "--robot", robot});
    EXPECT_EQ(run.exit_code, 0) << robot << "\n" << run.output;
  }
}

}  // namespace
}  // namespace polyarm
