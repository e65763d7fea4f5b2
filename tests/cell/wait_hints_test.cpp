/// A program that waits in vain is told why, as far as the cell knows it.
#include "polyarm/tasks/wait_hints.hpp"

#include <gtest/gtest.h>

#include <string>

#include "polyarm/setup/cell_file.hpp"
#include "tests/support/lock_step_cell.hpp"

namespace polyarm::cell {
namespace {

/// A feeder with one part.
class Waits : public ::testing::Test {
 protected:
  Waits() {
    hardware::register_driver(
        "mock", [] { return std::unique_ptr<hardware::Component>(new drivers::MockComponent); });
    write_scene(1);
    folder.write("signals.yaml",
                 "polyarm: signals/1\ntags:\n  Feed: {command: scene/chute/feed, type: number}\n"
                 "  Lying: {state: scene/chute/count, type: number}\n  Spare: {state: scene/spare/present}\n"
                 "  Go: {initial: false}\n");
  }
  void write_scene(int count) {
    folder.write(
        "scene.yaml",
        "polyarm: scene/1\nfeeders:\n  chute: {at: [0.4, 0, 0.02]}\n  spare: {at: [0.4, 0.3, 0.02]}\n"
        "parts:\n  cube: {kind: cube, box: [40mm, 40mm, 40mm], mass: 0.1, feeder: chute, count: " +
            std::to_string(count) + "}\n");
  }
  /// What the run fails with.
  Problem failure(const std::string& program, const std::string& plc = "", double seconds = 6,
                  CellOptions options = {}) {
    folder.write("job.script", program);
    folder.write("plc.script", plc);
    folder.write(
        "cell.yaml",
        "polyarm: cell/1\nrobots:\n  arm: {model: " + test::kSixAxes +
            ", hardware: mock, tool: suction_cup}\nscene: scene.yaml\nsignals: signals.yaml\nprogram: "
            "job.script\n" +
            (plc.empty() ? "" : "plc: plc.script\n"));
    test::LockStepCell cell(read_cell_file(folder.path()), options);
    cell.run(seconds);
    return cell.cell().failure() ? cell.cell().failure()->problem : Problem{};
  }
  test::Folder folder;
};

TEST_F(Waits, ATimeOutNamesTheFeederThatIsEmpty) {
  const std::string empty = "the feeder 'chute' is empty: it has brought all of its 1 part";
  const std::string what = failure("set Feed = 3\nwait Lying > 2 timeout 1s\n").what;
  EXPECT_EQ(what, "the time-out passed and the condition is still false; it reads Lying; " + empty);
  EXPECT_EQ(failure("wait Go timeout 1s\n", "set Feed = 3\nwait Lying > 2\nset Go = true\n").what,
            "the time-out passed and the condition is still false; it reads Go; " + empty)
      << "the PLC waits for it";
  EXPECT_NE(failure("wait Spare timeout 1s\n")
                .what.find("'spare' is empty: no part of the scene has 'feeder: spare'"),
            std::string::npos);
  EXPECT_EQ(failure("wait Go timeout 1s\n").what.find("feeder"), std::string::npos);
}

TEST_F(Waits, ATimeOutSaysThatThePlaceOfTheFeederIsOccupied) {
  write_scene(2);
  EXPECT_EQ(
      failure("set Feed = 2\nwait Lying > 1 timeout 1s\n").what,
      "the time-out passed and the condition is still false; it reads Lying; the feeder 'chute' brings its "
      "next part when its place is free");
}

TEST_F(Waits, ATimeOutSaysThatNobodyAskedTheFeeder) {
  EXPECT_NE(
      failure("wait Lying > 0 timeout 1s\n")
          .what.find("the feeder 'chute' was to bring 0 parts and has brought none: set 'Feed' to one more"),
      std::string::npos);
}

TEST_F(Waits, ADeadlockNamesTheEmptyFeederToo) {
  const Problem told = failure("set Feed = 3\nwait Lying > 2\n");
  EXPECT_EQ(told.code, "deadlock") << told.text();
  EXPECT_EQ(told.advice, "the feeder 'chute' is empty: it has brought all of its 1 part");
}

TEST_F(Waits, OfRealHardwareAnInputMayComeAtAnyTime) {
  CellOptions real;
  real.real = true;
  EXPECT_EQ(failure("wait Spare\n", "", 60).code, "deadlock");
  EXPECT_EQ(failure("wait Spare\n", "", 60, real).text(), Problem{}.text());
}

TEST_F(Waits, ATimeOutForAGripperSaysWhyItHoldsNothing) {
  folder.write(
      "scene.yaml",
      "polyarm: scene/1\nparts:\n  cube: {kind: cube, box: [40mm, 40mm, 40mm], mass: 20kg, at: [0.4, 0.1, "
      "0.3]}\n");
  folder.write("signals.yaml",
               "polyarm: signals/1\ntags:\n  Suck: {command: arm/tool/vacuum}\n  Held: {state: "
               "arm/tool/part_present}\n");
  const std::string wait = "wait Held timeout 1s\n";
  EXPECT_NE(failure(wait).what.find("it reads Held; the vacuum of 'arm' is off: 'Suck' is False"),
            std::string::npos);
  const std::string away = failure("set Suck = true\n" + wait).what;
  EXPECT_NE(away.find(" mm away from cube, the nearest part; the cup grips within 1.5 mm"), std::string::npos)
      << away;
  folder.write("signals.yaml", "polyarm: signals/1\ntags:\n  Held: {state: arm/tool/part_present}\n");
  EXPECT_NE(failure(wait).what.find("no tag of signals.yaml has 'command: arm/tool/vacuum'"),
            std::string::npos);
}

TEST_F(Waits, ADeadlockIsOneOfAllTasks) {
  const Problem found = failure("task a\n  meet x\nend\ntask b\n  wait Go\n  meet x\nend\n");
  EXPECT_EQ(found.code, "deadlock") << "the first task waits for the second, which waits for a tag";
  EXPECT_NE(found.what.find("waits for Go"), std::string::npos) << found.what;
  EXPECT_EQ(failure("task a\n  wait Go\nend\ntask b\n  wait 5s\n  set Go = true\nend\n").text(),
            Problem{}.text())
      << "the second task sets what the first one waits for";
}

TEST_F(Waits, AProgramThatGoesRoundWithoutEndEndsTheRun) {
  const std::string text = "let n = 1\nwhile n != 0\n  set n = n * 1\nend\n";
  EXPECT_EQ(failure(text).text(), Problem{}.text()) << "a program may have much to calculate";
  const Problem told = failure(text, "", 40);
  EXPECT_EQ(told.code, "endless-loop") << told.text();
  EXPECT_NE(told.what.find("loops forever"), std::string::npos) << told.text();
}

TEST_F(Waits, APlcOfBlocksAloneGoesOnAfterItsLastLine) {
  EXPECT_EQ(failure("wait Go timeout 1s\n", "every 100ms\n  set Go = true\nend\n").text(), Problem{}.text());
  const std::string plc = "let turns = 0\nwhen Go\n  set Go = false\nend\nset turns = 1\n";
  EXPECT_EQ(failure("wait 500ms\nset Go = true\nwait not Go timeout 1s\n", plc).text(), Problem{}.text());
}

}  // namespace
}  // namespace polyarm::cell
