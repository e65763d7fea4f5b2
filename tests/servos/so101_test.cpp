#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "drivers/feetech/family.hpp"
#include "drivers/servo_bus/fake_bus.hpp"
#include "polyarm/base/file.hpp"
#include "tests/servos/arm_on_a_wire.hpp"
#include "tests/support/command.hpp"

namespace polyarm {
namespace {

using test::ArmOnAWire;
using test::change;
using test::ExampleCopy;
using test::Finished;
using test::run_command;

TEST(So101, WavesSimulatedAndRepeatsItself) {
  const ExampleCopy copy("so101");
  const Finished ran = run_command({"run", copy.path(), "--fast", "--json", "--no-socket"});
  ASSERT_EQ(ran.exit_code, 0) << ran.output;
  EXPECT_GT(ran.result()["sim_time_s"].get<double>(), 10.9);
  EXPECT_EQ(run_command({"run", copy.path(), "--fast", "--json", "--no-socket"}).result()["trace_hash"],
            ran.result()["trace_hash"]);
}

TEST(So101, WavesOverTheRealWireByOneWord) {
  const ExampleCopy copy("so101");
  change(copy, "hardware: mock", "hardware: feetech_fake");
  const Finished ran = run_command({"run", copy.path(), "--fast", "--json", "--no-socket"});
  ASSERT_EQ(ran.exit_code, 0) << ran.output;
  EXPECT_GT(ran.result()["sim_time_s"].get<double>(), 10.9);
}

/// Runs the cell on its hardware, with somebody at the terminal who arms it.
Finished run_armed(const std::string& cell) {
  test::Command command({"run", cell, "--real", "--full-speed", "--json", "--no-socket"},
                        test::Input::terminal);
  if (command.wait_for("nothing moves before a person types")) command.type("arm\n");
  return command.wait();
}

TEST(So101, TheDriverMovesTheServosOfTheArm) {
  ArmOnAWire arm;
  int most = 0, least = 4096;
  arm.bus.on_instruction([&](std::uint64_t) {
    const int at = arm.bus.get(5, feetech::sts_family().present_position);
    most = std::max(most, at);
    least = std::min(least, at);
  });
  const Finished ran = run_armed(arm.copy.path());
  arm.bus.on_instruction({});
  ASSERT_EQ(ran.exit_code, 0) << ran.output;
  EXPECT_NEAR(least, 2048 - 0.5 * 4096 / 6.283185, 10) << "wrist_roll goes to 0.5 rad, against its servo";
  EXPECT_NEAR(arm.bus.get(1, feetech::sts_family().present_position), 2048, 2);
  EXPECT_EQ(arm.bus.get(1, feetech::sts_family().torque), 1) << "the end of a run lets nothing fall";
  EXPECT_EQ(arm.bus.get(6, feetech::sts_family().soft_limit), 500);
}

TEST(So101, TheDriverMovesNothingBeforeItIsArmed) {
  ArmOnAWire arm;
  const Finished ran =
      run_command({"run", arm.copy.path(), "--real", "--seconds", "1", "--json", "--no-socket"});
  EXPECT_NE(ran.output.find("disarmed"), std::string::npos) << ran.output;
  EXPECT_EQ(arm.bus.get(5, feetech::sts_family().torque), 0);
  EXPECT_EQ(arm.bus.get(5, feetech::sts_family().present_position), 2048);
}

TEST(So101, APersonArmsItFromAnotherTerminal) {
  ArmOnAWire arm;
  const std::filesystem::path doors = arm.copy.path() + "/doors";
  std::filesystem::create_directory(doors);
  ::setenv("XDG_RUNTIME_DIR", doors.c_str(), 1);
  test::Command cell({"run", arm.copy.path(), "--real", "--full-speed", "--json"}, test::Input::terminal);
  ASSERT_TRUE(cell.wait_for("nothing moves before a person types"));

  const Finished nobody = run_command({"control", "arm"});
  EXPECT_EQ(nobody.exit_code, 1);
  EXPECT_NE(nobody.output.find("only a person at a terminal"), std::string::npos) << nobody.output;
  const auto answered = [](const std::string& answer) {
    test::Command ask({"control", "arm"}, test::Input::terminal);
    ask.type(answer);
    return ask.wait();
  };
  const Finished no = answered("no\n");
  EXPECT_EQ(no.exit_code, 1);
  EXPECT_NE(no.output.find("wrist_roll"), std::string::npos) << "shows where the joints are\n" << no.output;
  EXPECT_EQ(arm.bus.get(5, feetech::sts_family().torque), 0);

  const Finished yes = answered("yes\n");
  EXPECT_EQ(yes.exit_code, 0) << yes.output;
  EXPECT_EQ(arm.bus.get(5, feetech::sts_family().torque), 1);
  cell.signal(SIGINT);
  EXPECT_EQ(cell.wait().exit_code, 3);
}

/// A cell on the wire whose gripper, servo 6, has begun to move.
struct MovingArm : ArmOnAWire {
  test::Command cell{{"run", copy.path(), "--real", "--full-speed", "--json", "--no-socket"},
                     test::Input::terminal};
  const servo_bus::Family& family = feetech::sts_family();
  ::testing::AssertionResult begins() {
    if (!cell.wait_for("nothing moves before a person types"))
      return ::testing::AssertionFailure() << "no question";
    cell.type("arm\n");
    if (bus.wait(6, family.goal_position, [](int goal) { return goal > 2048 + 5; }))
      return ::testing::AssertionSuccess();
    cell.signal(SIGINT);
    return ::testing::AssertionFailure() << cell.wait().output;
  }
};

TEST(So101, AfterAStandstillTheArmHoldsUntilAPersonSaysMore) {
  MovingArm arm;
  ASSERT_TRUE(arm.begins());
  arm.cell.signal(SIGSTOP);
  ::usleep(900'000);  // what is tested is the gap itself
  arm.cell.signal(SIGCONT);
  ASSERT_TRUE(arm.cell.wait_for("\"state\":\"held\""));
  const int goal = arm.bus.get(6, arm.family.goal_position);
  arm.cell.signal(SIGINT);
  const Finished ended = arm.cell.wait();
  EXPECT_NE(ended.output.find("wall time was lost"), std::string::npos) << ended.output;
  EXPECT_NEAR(arm.bus.get(6, arm.family.goal_position), goal, 1) << "nothing went on by itself";
  EXPECT_EQ(arm.bus.get(6, arm.family.torque), 1);
}

TEST(So101, KilledTheArmGoesToItsLastGoalAndHolds) {
  MovingArm arm;
  ASSERT_TRUE(arm.begins());
  arm.cell.signal(SIGKILL);
  arm.cell.wait();
  EXPECT_GT(arm.bus.get(6, arm.family.goal_position), 2048 + 5);
  EXPECT_EQ(arm.bus.get(6, arm.family.torque), 1);
  const Finished next =
      run_command({"run", arm.copy.path(), "--real", "--seconds", "0.2", "--json", "--no-socket"});
  EXPECT_EQ(next.output.find("in use"), std::string::npos) << next.output;
}

TEST(So101, WithoutRealItIsSimulated) {
  ArmOnAWire arm;
  const Finished ran = run_command({"run", arm.copy.path(), "--fast", "--json", "--no-socket"});
  EXPECT_EQ(ran.exit_code, 0) << ran.output;
  EXPECT_NE(ran.output.find("feetech drives real hardware; it is simulated by"), std::string::npos)
      << ran.output;
}

TEST(So101, WithoutACalibrationItSaysHowToMakeOne) {
  ArmOnAWire arm;
  std::filesystem::remove(arm.copy.file("calibration.yaml"));
  const Finished ran = run_command({"run", arm.copy.path(), "--real", "--json", "--no-socket"});
  EXPECT_EQ(ran.exit_code, 1);
  EXPECT_NE(ran.output.find("polyarm setup feetech --calibration"), std::string::npos) << ran.output;
}

TEST(So101, APulledCableEndsTheRunWithTheJoints) {
  ArmOnAWire arm;
  arm.bus.on_instruction([&](std::uint64_t number) {
    if (number != 700) return;
    servo_bus::Mischief silent;
    silent.silent = {4, 5, 6};
    arm.bus.mischief(silent);
  });
  change(arm.copy, "answer_timeout_ms: 500", "answer_timeout_ms: 50");
  const Finished ran = run_armed(arm.copy.path());
  EXPECT_EQ(ran.exit_code, 1) << ran.output;
  EXPECT_NE(ran.output.find("wrist_flex (servo 4"), std::string::npos) << ran.output;
  EXPECT_EQ(ran.output.find("shoulder_pan (servo 1"), std::string::npos) << ran.output;
}

TEST(SetupCommand, ScansKeepsAndBringsBack) {
  servo_bus::FakeBus bus(servo_bus::Wire::feetech, {1, 2, 3, 4, 5, 6});
  const ExampleCopy copy("so101");
  const std::string backup = copy.file("backup.yaml").string();
  const std::vector<std::string> common{
      "--port", bus.path(), "--baud", "1000000", "--highest-id", "8", "--answer-timeout-ms", "100"};
  const auto setup = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"setup", "feetech"});
    arguments.insert(arguments.end(), common.begin(), common.end());
    return run_command(arguments);
  };
  const Finished scan = setup({"--scan"});
  EXPECT_EQ(scan.exit_code, 0) << scan.output;
  EXPECT_NE(scan.output.find("id 6 at 1000000 bit/s: STS3215"), std::string::npos) << scan.output;
  EXPECT_EQ(setup({"--check"}).exit_code, 0);
  const Finished kept = setup({"--back-up", "--backup", backup});
  EXPECT_EQ(kept.exit_code, 0) << kept.output;
  bus.set(4, feetech::sts_family().min_limit, 77);
  EXPECT_EQ(setup({"--restore", backup, "--answer", "no"}).exit_code, 1);
  EXPECT_EQ(bus.get(4, feetech::sts_family().min_limit), 77);
  const Finished back = setup({"--restore", backup, "--answer", "yes"});
  EXPECT_EQ(back.exit_code, 0) << back.output;
  EXPECT_EQ(bus.get(4, feetech::sts_family().min_limit), 0);
  bus.unplug(2);
  EXPECT_EQ(setup({"--check"}).exit_code, 1);
}

}  // namespace
}  // namespace polyarm
