/// The program of a cell, paused, stepped, begun in the middle and continued, asked for as people do.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>

#include "polyarm/cell/compare.hpp"
#include "polyarm/cell/program_tests.hpp"
#include "polyarm/setup/cell_file.hpp"
#include "polyarm/tasks/safe_points.hpp"
#include "tests/support/lock_step_cell.hpp"

namespace polyarm {
namespace {

using test::Json;
using test::LockStepCell;

const char* const kScript =
    "load work\n"                                              // 1
    "func shown(x)\n"                                          // 2
    "  log(x)\n"                                               // 3
    "  return x\n"                                             // 4
    "end\n"                                                    // 5
    "let step = 2\n"                                           // 6
    "use speed 50%\n"                                          // 7
    "movej joints(0deg, -90deg, 0deg, 0deg, 0deg, 0deg)\n"     // 8
    "set Placed = Placed + step\n"                             // 9
    "while Repeat\n"                                           // 10
    "  movej joints(10deg, -90deg, 0deg, 0deg, 0deg, 0deg)\n"  // 11
    "  set Placed = shown(Placed + 1)\n"                       // 12
    "  movej joints(0deg, -90deg, 0deg, 0deg, 0deg, 0deg)\n"   // 13
    "  wait 100ms\n"                                           // 14
    "end\n"                                                    // 15
    "on stop\n"                                                // 16
    "  set Stopped = true\n"                                   // 17
    "end\n";                                                   // 18

class ProgramControl : public ::testing::Test {
 protected:
  ProgramControl() {
    const std::string urdf = std::string(POLYARM_SOURCE_DIR) + "/examples/r6bot/r6bot.urdf";
    folder.write("work.data", "Name: Placed\nNum: 0\nName: Repeat\nBool: True\nName: Stopped\nBool: False\n");
    folder.write("job.script", kScript);
    folder.write("cell.yaml",
                 "polyarm: cell/1\nrobots:\n  arm: {model: " + urdf + ", hardware: mock}\nprogram: job\n");
    begin();
  }
  void begin() { run = std::make_unique<LockStepCell>(cell::read_cell_file(folder.path())); }
  test::OpenCell& cell() { return run->cell(); }
  Json ask(const std::string& request, Json more = Json::object()) {
    more["request"] = request;
    return run->result(more);
  }
  double placed() { return cell().store().find("Placed")->as_number()->value; }
  int line() { return cell().program()->status().where.line; }
  void run_to(int wanted) {
    for (int i = 0; i < 20000 && line() != wanted; ++i) run->tick();
    ASSERT_EQ(line(), wanted);
  }

  test::Folder folder;
  std::unique_ptr<LockStepCell> run;
};

TEST_F(ProgramControl, ShowsTasksCallsVariablesAndWhatMovesUse) {
  ask("program.break", {{"at", "4"}});
  run_to(4);
  const Json told = ask("program");
  EXPECT_TRUE(told["paused"].get<bool>());
  EXPECT_EQ(told["where"]["line"], 4);
  EXPECT_EQ(told["breakpoints"].size(), 1u);
  const Json& task = told["tasks"][0];
  EXPECT_EQ(task["name"], "main");
  EXPECT_EQ(task["calls"].size(), 2u);
  EXPECT_EQ(task["calls"][0]["line"], 12);
  EXPECT_EQ(task["variables"][0], (Json{{"name", "x"}, {"value", "3"}}));
}

/// The page and people name the file as it is shown, not with the whole path that it was read by.
TEST_F(ProgramControl, ABreakpointIsInTheFileThatIsShown) {
  const std::string file = ask("program")["file"];
  const std::string shown = std::filesystem::path(file).filename().string();
  ASSERT_NE(shown, file);
  const Json set = ask("program.break", {{"at", shown + ":4"}, {"clear", true}})["breakpoints"];
  ASSERT_EQ(set.size(), 1u);
  EXPECT_EQ(set[0]["line"], 4);
}

TEST_F(ProgramControl, ABreakpointNowhereIsRefusedInWords) {
  const auto refused = [&](const std::string& at) {
    return run->ask({{"request", "program.break"}, {"at", at}})["error"];
  };
  EXPECT_EQ(refused("ob.script:4")["code"], "unknown-file");
  EXPECT_NE(refused("ob.script:4")["what"].get<std::string>().find("'ob.script'"), std::string::npos);
  EXPECT_EQ(refused("work.data:1")["code"], "unknown-file");
  EXPECT_EQ(refused("../job.script:4")["code"], "unknown-file");
  EXPECT_EQ(refused("job.script:99")["code"], "bad-argument");
  ask("program.break", {{"at", "4"}});
  EXPECT_EQ(refused("19")["code"], "bad-argument");
  EXPECT_EQ(ask("program")["breakpoints"].size(), 1u) << "those there are stay";
}

TEST_F(ProgramControl, ALineHasOneBreakpointWhichIsTakenOffByItself) {
  EXPECT_EQ(ask("program.break", {{"at", Json::array({"1", "job.script:2", "3"})}})["breakpoints"].size(), 2u)
      << "a function's head is not a statement";
  const Json left = ask("program.break", {{"off", "job.script:3"}})["breakpoints"];
  ASSERT_EQ(left.size(), 1u);
  EXPECT_EQ(left[0]["line"], 1);
}

/// Where they are set before the program is begun for the first time, and in a cell that is built anew.
TEST_F(ProgramControl, BreakpointsOfAnotherProgramWaitForItsStart) {
  folder.write("other.script", "load work\n\n# a remark\nset Placed = 7\nset Placed = 8\n");
  EXPECT_EQ(ask("program.break", {{"at", Json::array({"other.script:3", "13"})}})["breakpoints"].size(), 2u);
  run_to(13);
  ask("program.stop");
  ask("program.from", {{"program", "other.script"}, {"confirmed", true}});
  run_to(4);
  run->run(1);
  EXPECT_EQ(line(), 4);
  EXPECT_EQ(ask("program")["breakpoints"].size(), 2u) << "those of the one before hold for its next start";

  const std::vector<cell::FileBreakpoints> kept = cell().kept_breakpoints();
  run->end();
  cell::CellOptions options;
  options.lock_step = true;
  options.breakpoints = kept;
  options.breakpoints.push_back({"/somewhere/else/job.script", {3}, {}});
  cell::Observer nobody;
  test::OpenCell anew(cell::read_cell_file(folder.path()), description::Catalogue({}), options, nobody);
  EXPECT_EQ(anew.breakpoints().size(), 2u);
  ASSERT_EQ(anew.program()->interpreter().breakpoints().size(), 1u);
  EXPECT_EQ(anew.program()->interpreter().breakpoints().front().line, 13);
}

TEST_F(ProgramControl, BreakpointsOfAProgramThatHasEndedHoldForItsNextStart) {
  run_to(14);
  ask("program.stop");
  ask("program.break", {{"at", "13"}});
  ask("program.from", {{"line", 10}, {"confirmed", true}});
  run_to(13);
  run->run(1);
  EXPECT_EQ(line(), 13);
  const Json told = ask("program");
  EXPECT_TRUE(told["paused"].get<bool>());
  EXPECT_EQ(told["breakpoints"].size(), 1u);
}

/// A draft has three lines more above, and the marked line itself is written anew.
TEST_F(ProgramControl, BreakpointsGoWithTheLinesOfADraftWhileTheProgramKeepsItsText) {
  ask("program.break", {{"at", Json::array({"job.script:12", "job.script:14"})}});
  std::string draft = std::string("# one\n# two\n\n") + kScript;
  draft.replace(draft.find("wait 100ms"), 10, "wait 200ms");
  const Json now = ask("program.edited", {{"name", "job.script"}, {"text", draft}})["breakpoints"];
  ASSERT_EQ(now.size(), 2u);
  EXPECT_EQ(now[0]["line"], 15);
  EXPECT_EQ(now[1]["line"], 17);
  run_to(12);
  run->run(1);
  EXPECT_EQ(line(), 12) << "what runs has its own lines";
  ask("program.break", {{"at", "job.script:16"}, {"off", "job.script:15"}, {"text", draft}});
  EXPECT_EQ(ask("program")["breakpoints"][0]["line"], 16) << "as whoever writes the draft sees it";
  ask("program.go");
  run_to(13);
  EXPECT_TRUE(ask("program")["paused"].get<bool>());
  ask("program.stop");
  folder.write("job.script", draft);
  ask("program.from", {{"program", "job.script"}, {"confirmed", true}});
  run_to(16);
  EXPECT_TRUE(ask("program")["paused"].get<bool>());
  ask("program.edited", {{"name", "job.script"}, {"text", kScript}, {"lines", Json::array({11})}});
  EXPECT_EQ(ask("program")["breakpoints"].size(), 1u);
  ask("program.go");
  run_to(14);
  EXPECT_TRUE(ask("program")["paused"].get<bool>()) << "line 11 of the older text";
  EXPECT_EQ(run->ask({{"request", "program.edited"},
                      {"name", "job.script"},
                      {"text", ""},
                      {"lines", Json::array({0})}})["error"]["code"],
            "bad-argument");
  EXPECT_EQ(run->ask({{"request", "program.edited"},
                      {"name", "../x.script"},
                      {"text", ""},
                      {"lines", Json::array({1})}})["error"]["code"],
            "unknown-file");
}

/// Who comes after a cell with a draft that is not saved starts the file as it was saved.
TEST_F(ProgramControl, BreakpointsOfADraftAreFoundInTheFileThatIsStarted) {
  ask("program.break", {{"at", "job.script:13"}});
  ask("program.edited", {{"name", "job.script"}, {"text", std::string("# one\n") + kScript}});
  const std::vector<cell::FileBreakpoints> kept = cell().kept_breakpoints();
  run->end();
  cell::CellOptions options;
  options.lock_step = true;
  options.breakpoints = kept;
  cell::Observer nobody;
  test::OpenCell anew(cell::read_cell_file(folder.path()), description::Catalogue({}), options, nobody);
  ASSERT_EQ(anew.breakpoints().size(), 1u);
  EXPECT_EQ(anew.breakpoints().front().line, 14);
  ASSERT_EQ(anew.program()->interpreter().breakpoints().size(), 1u);
  EXPECT_EQ(anew.program()->interpreter().breakpoints().front().line, 13);
}

TEST_F(ProgramControl, TellsHowLongTheNewestPassTook) {
  const auto passed = [&](std::uint64_t wanted) {
    for (int i = 0; i < 20000 && cell().program()->status().passes < wanted; ++i) run->tick();
    return cell().now();
  };
  const Nanoseconds first = passed(1);
  EXPECT_FALSE(cell().program()->last_pass()) << "when its first one began is not known";
  const Nanoseconds second = passed(2);
  ASSERT_TRUE(cell().program()->last_pass());
  EXPECT_NEAR(seconds(*cell().program()->last_pass()), seconds(second - first), 0.003);
  EXPECT_GT(second, first);
}

TEST_F(ProgramControl, PausesStepsAndGoesOn) {
  run_to(14);
  EXPECT_EQ(ask("program.pause")["paused"], true);
  const int at = line();
  run->run(3);
  EXPECT_EQ(line(), at) << "it stands until somebody lets it go on";
  ask("program.break", {{"at", Json::array({"12"})}});
  ask("program.go");
  run_to(12);
  const double before = placed();
  EXPECT_EQ(ask("program.step", {{"how", "into"}})["where"]["line"], 3);
  EXPECT_EQ(ask("program.step", {{"how", "out"}})["where"]["line"], 13);
  EXPECT_EQ(placed(), before + 1);
  EXPECT_EQ(ask("program.step")["where"]["line"], 14);
  EXPECT_EQ(ask("program.break", {{"clear", true}})["breakpoints"].size(), 0u);
  EXPECT_EQ(run->ask({{"request", "program.step"}, {"how", "sideways"}})["error"]["code"], "bad-argument");
}

TEST_F(ProgramControl, BeginsAtALineAndSaysWhatItTakesForGiven) {
  run_to(14);
  EXPECT_EQ(run->ask({{"request", "program.from"}, {"line", 13}})["error"]["code"], "still-running");
  ask("program.pause");
  run->run(3);
  const double before = placed();
  const Json told = ask("program.from", {{"line", 12}});
  EXPECT_EQ(told["where"]["line"], 12);
  EXPECT_EQ(told["last_point"].get<std::string>().substr(0, 7), "joints(");
  EXPECT_EQ(told["sets"][0]["name"], "Placed");
  EXPECT_EQ(told["variables"][0], (Json{{"name", "step"}, {"value", "2"}}));
  run->run(1);
  EXPECT_EQ(placed(), before) << "nothing is done before a person says so";
  ask("program.go");
  run->run(0.01);
  EXPECT_EQ(placed(), before + 1);
  EXPECT_EQ(run->ask({{"request", "program.from"}, {"line", 999}})["error"]["code"], "still-running");
}

/// Moves are queued ahead of the robot, and a wait is over only when it is over.
TEST_F(ProgramControl, TellsTheLineUnderWayAndNotTheOneThatComesNext) {
  folder.write("job.script",
               "movej joints(10deg, -90deg, 0deg, 0deg, 0deg, 0deg), blend 10mm\n"  // 1
               "movej joints(20deg, -90deg, 0deg, 0deg, 0deg, 0deg), blend 10mm\n"  // 2
               "movej joints(30deg, -90deg, 0deg, 0deg, 0deg, 0deg)\n"              // 3
               "wait 500ms\n"                                                       // 4
               "movej joints(0deg, -90deg, 0deg, 0deg, 0deg, 0deg)\n"               // 5
               "wait time 1\n");                                                    // 6
  begin();
  std::vector<int> lines, asked;
  for (int i = 0; i < 20000 && !cell().program()->ended(); ++i) {
    run->tick();
    if (cell().program()->ended()) break;
    const double first = cell().snapshot().commands.front();
    if (lines.empty() || lines.back() != line()) lines.push_back(line());
    if (line() == 2) {
      EXPECT_GT(first, 9.0 * M_PI / 180) << "the robot has come past the first target";
    }
    if (line() == 4) {
      EXPECT_NEAR(first, 30 * M_PI / 180, 1e-6);
    }
    const Json told = ask("program");
    if (asked.empty() || asked.back() != told["where"]["line"]) asked.push_back(told["where"]["line"]);
  }
  EXPECT_EQ(lines, (std::vector<int>{1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(asked, lines);
  EXPECT_EQ(ask("program")["passes"], 1) << "the program itself is the pass";
}

TEST_F(ProgramControl, EndsAndItsCleanUpIsDone) {
  run_to(14);
  EXPECT_EQ(ask("program.stop")["state"], "stopped");
  EXPECT_TRUE(*cell().store().find("Stopped")->as_boolean());
}

TEST_F(ProgramControl, EndsWhileItIsHeldAndNothingOfItGoesOn) {
  run_to(11);
  run->run(0.1);
  ask("control.hold");
  ASSERT_EQ(ask("program")["state"], "waiting") << "in the middle of a move";
  EXPECT_EQ(ask("program.stop")["state"], "stopped");
  EXPECT_TRUE(*cell().store().find("Stopped")->as_boolean());
  const std::vector<double> there = cell().snapshot().commands;
  ask("control.resume");
  run->run(3);
  const std::vector<double> now = cell().snapshot().commands;
  int joints = 0;
  for (std::size_t i = 0; i < there.size(); ++i) {
    if (!std::isfinite(there[i])) continue;
    EXPECT_NEAR(now[i], there[i], 0.02) << i;
    ++joints;
  }
  EXPECT_GE(joints, 6);
  EXPECT_EQ(ask("program")["state"], "stopped");
}

TEST_F(ProgramControl, EndsWhileTheRobotIsStillComingToAHold) {
  run_to(11);
  run->run(0.1);
  cell().loop().supervisor().latch().request(realtime::StopKind::controlled);
  run->tick();
  EXPECT_EQ(ask("program.stop")["state"], "stopped");
  EXPECT_TRUE(*cell().store().find("Stopped")->as_boolean());
}

TEST_F(ProgramControl, GoesOnInAnotherProcessWhereItWasCutOff) {
  run_to(13);
  const double before = placed();
  EXPECT_EQ(before, 3);
  cell().keep_safe_point();
  cell().files().flush();
  const std::string written = read_file(folder.path() / ".state" / "program.json");
  begin();  // the data as the user wrote them; the state is taken from the file
  EXPECT_EQ(placed(), 0);
  const auto report = cell().continue_program();
  EXPECT_EQ(report.where.line, 13) << "the move is done again";
  EXPECT_EQ(placed(), before);
  run_to(14);
  run_to(11);
  run_to(14);
  EXPECT_EQ(placed(), before + 1) << "lines 1 to 9 were not done again";
  EXPECT_EQ(cell::to_json(cell::safe_point_from_json(written, "")), written);
}

TEST(SafePoint, JointStatesKeepTheUnitsInWhichTheyWereGiven) {
  data::JointState joints{{"lift", "turn"}, {0.02, 1}};
  joints.note_given(0, Dimension::length);
  cell::SafePoint point;
  point.values.emplace_back("J", joints);
  const cell::SafePoint read = cell::safe_point_from_json(cell::to_json(point), "");
  EXPECT_EQ(read.values.at(0).second.as_joints()->given_at(0), Dimension::length);
  EXPECT_EQ(read.values.at(0).second.as_joints()->given_at(1), Dimension::none);
}

TEST_F(ProgramControl, GoesOnBeforeComplyWhereTheToolYielded) {
  const std::string urdf = std::string(POLYARM_SOURCE_DIR) + "/examples/r6bot/r6bot.urdf";
  folder.write("cell.yaml", "polyarm: cell/1\nrobots:\n  arm: {model: " + urdf +
                                ", hardware: mujoco, force_sensor: true}\nprogram: job\n");
  folder.write("job.script",
               "load work\n"                                           // 1
               "movej joints(0deg, -90deg, 0deg, 0deg, 0deg, 0deg)\n"  // 2
               "wait 100ms\n"                                          // 3
               "comply(\"z\", force = 1N)\n"                           // 4
               "wait 500ms\n"                                          // 5
               "set Placed = 1\n"                                      // 6
               "wait 5s\n"                                             // 7
               "stiff()\n");                                           // 8
  begin();
  run_to(7);
  cell().keep_safe_point();
  cell().files().flush();
  begin();
  EXPECT_LE(cell().continue_program().where.line, 4);
  EXPECT_EQ(placed(), 0);
}

/// The same cell with a PLC that counts, with tags, and with points in a frame.
class WithPlc : public ProgramControl, public cell::Observer {
 protected:
  WithPlc() {
    const std::string urdf = std::string(POLYARM_SOURCE_DIR) + "/examples/r6bot/r6bot.urdf";
    folder.write("cell.yaml", "polyarm: cell/1\nrobots:\n  arm: {model: " + urdf +
                                  ", hardware: mock}\nprogram: job\nplc: plc.script\n"
                                  "signals: signals.yaml\n");
    folder.write("signals.yaml",
                 "polyarm: signals/1\ntags:\n  Lamp: {initial: false}\n  Turns: {initial: 0}\n"
                 "  Pass: {state: program/pass, type: number}\n");
    plc("let turns = 0\nwhile true\n  wait 100ms\n  set turns = turns + 1\n  set Turns = turns\nend\n");
    begin();
  }
  void plc(const std::string& script) { folder.write("plc.script", script); }
  /// As it was when the program stood still last.
  double kept(const std::string& tag) const {
    for (const auto& [name, value] : cell::SafePoints::read(folder.path() / ".state" / "program.json").tags)
      if (name == tag) return value.as_number()->value;
    return -1;
  }
  void cut_off() {
    cell().keep_safe_point();
    cell().files().flush();
    notes.clear();
    cell::CellOptions options;
    options.lock_step = true;
    run.reset();
    second = std::make_unique<test::OpenCell>(cell::read_cell_file(folder.path()), description::Catalogue({}),
                                              options, *this);
  }
  void on_note(const std::string& text) override { notes += text + "\n"; }
  double now_turns() { return second->store().find("Turns")->as_number()->value; }
  void go(double seconds_of) {
    for (const Nanoseconds end = second->loop().cycle().time + nanoseconds(seconds_of);
         second->loop().cycle().time < end;) {
      const Nanoseconds until = second->loop().cycle().time + cell::Cell::kTick;
      second->tick(second->loop().cycle().time);
      while (second->loop().cycle().time < until) second->loop().step_next();
    }
  }

  std::string notes;
  std::unique_ptr<test::OpenCell> second;
};

TEST_F(WithPlc, ThePlcGoesOnWhereItWasCutOffAndItsTagsAreThere) {
  run_to(14);
  cell().store().set("Lamp", true, "a person");
  run->run(5);
  cut_off();
  const double before = kept("Turns");
  ASSERT_GT(before, 20);
  EXPECT_EQ(now_turns(), 0);
  second->continue_program();
  EXPECT_EQ(now_turns(), before);
  EXPECT_TRUE(*second->store().find("Lamp")->as_boolean());
  EXPECT_EQ(second->store().find("Pass")->as_number()->value, 0) << "this one the cell tells";
  EXPECT_EQ(notes.find("script restarts"), std::string::npos) << notes;
  second->loop().begin();
  go(0.25);
  EXPECT_GE(now_turns(), before + 2) << "its own variables were not lost";
  EXPECT_LE(now_turns(), before + 3);
  second->loop().end();
}

TEST_F(WithPlc, ThePlcKnowsTheNamesOfTheDataThatItLoadsItself) {
  folder.write("wires.data", "Name: Wire\nNum: 3\n");
  plc("load wires\nset Turns = Wire\nset Wire = Wire + 1\nwait false\n");
  begin();  // else: there is nothing called 'Wire'
  run->run(0.1);
  EXPECT_EQ(cell().store().find("Turns")->as_number()->value, 3);
  EXPECT_EQ(cell().store().find("Wire")->as_number()->value, 4);
}

TEST_F(WithPlc, APlcThatHasChangedBeginsAnewAndIsToldOf) {
  run_to(14);
  plc("set Turns = 77\nwait false\n");
  cut_off();
  second->continue_program();
  EXPECT_NE(notes.find("the PLC's script restarts: the program has changed"), std::string::npos) << notes;
  second->loop().begin();
  go(0.1);
  EXPECT_EQ(now_turns(), 77);
  second->loop().end();
}

TEST_F(WithPlc, APlcThatHadEndedStaysAtItsEnd) {
  plc("set Turns = 5\n");
  begin();
  run_to(14);
  cell().store().set("Turns", 6, "a person");
  run->run(5);
  cut_off();
  second->continue_program();
  second->loop().begin();
  go(0.1);
  EXPECT_EQ(now_turns(), 6);
  second->loop().end();
}

TEST_F(WithPlc, APointKeepsItsFrameOverACut) {
  folder.write(
      "work.data",
      "Name: Placed\nNum: 0\nName: Repeat\nBool: True\nName: Stopped\nBool: False\nPose: RPY\nName: "
      "P\nPoint: 0.1, 0, 0, 0, 0, 0; frame = \"table\", robot = \"r6bot\", joints = joints(a = 1)\n");
  begin();
  run_to(14);
  const data::Value before = *cell().store().find("P");
  ASSERT_EQ(before.as_point()->frame(), "table");
  cut_off();
  second->continue_program();
  EXPECT_EQ(*second->store().find("P"), before);
}

TEST_F(ProgramControl, DoesNotGoOnInAProgramThatHasChanged) {
  run_to(14);
  cell().keep_safe_point();
  folder.write("job.script", std::string("log(1)\n") + kScript);
  begin();
  try {
    cell().continue_program();
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.problems().front().code, "other-program");
  }
}

TEST_F(ProgramControl, ADamagedStateIsRefusedWhole) {
  run_to(14);
  cell().keep_safe_point();
  const std::string written = read_file(folder.path() / ".state" / "program.json");
  for (std::size_t cut = 1; cut < written.size(); cut += written.size() / 50) {
    folder.write(".state/program.json", written.substr(0, cut));
    begin();
    EXPECT_THROW(cell().continue_program(), Error) << cut;
    EXPECT_EQ(line(), 1);
  }
}

TEST_F(ProgramControl, WhatHasComeToItsEndLeavesNothingToGoOnFrom) {
  folder.write("job.script", "load work\nset Placed = 1\n");
  begin();
  run->run(0.1);
  cell().keep_safe_point();
  EXPECT_FALSE(std::filesystem::exists(folder.path() / ".state" / "program.json"));
}

TEST_F(ProgramControl, TestsStandBesideTheProgramOnItsTags) {
  folder.write("tests.script",
               "test \"it counts\"\n"
               "  expect not program.running\n"
               "  run\n"
               "  expect program.running\n"
               "  expect Placed == 3 timeout 30s\n"
               "  person(\"hold\")\n"
               "  wait 3s\n"
               "  expect Placed <= 4\n"
               "  person(\"resume\")\n"
               "  expect Placed == 6 timeout 30s\n"
               "  set Repeat False\n"
               "  expect not program.running timeout 30s\n"
               "  expect Stopped and program.state == \"finished\"\n"
               "  run\n"
               "  expect program.running timeout 1s\n"
               "end\n"
               "test \"wrong\"\n"
               "  run\n"
               "  expect Placed == 100 timeout 2s\n"
               "end\n"
               "test \"a hand that fails\"\n"
               "  fault(\"arm/nothing\", 1)\n"
               "end\n");
  Problems problems;
  const auto tests = cell::find_tests(folder.path(), problems);
  ASSERT_EQ(tests.size(), 3u);
  std::vector<cell::TestResult> results;
  for (const cell::ProgramTest& test : tests) {
    cell::TestOptions options;
    options.state_folder = folder.path() / "scratch" / "data";
    results.push_back(cell::run_test(test, description::Catalogue({}), options));
  }
  EXPECT_TRUE(results[0].problems.empty()) << results[0].problems.front().text();
  EXPECT_FALSE(results[0].log.empty());
  ASSERT_FALSE(results[1].problems.empty());
  EXPECT_NE(results[1].problems.front().what.find("expected Placed == 100 within 2s; Placed is"),
            std::string::npos)
      << results[1].problems.front().text();
  EXPECT_EQ(results[1].problems.front().where.line, 19);
  ASSERT_FALSE(results[2].problems.empty());
  EXPECT_EQ(results[2].problems.front().code, "unknown-interface");
  EXPECT_EQ(read_file(folder.path() / "work.data").find("Num: 3"), std::string::npos);
}

TEST_F(ProgramControl, AProgramThatFailsFailsTheTestThatDoesNotExpectIt) {
  folder.write("job.script", "load work\nwait 20ms\nraise \"out of parts\"\n");
  folder.write("tests.script",
               "test \"unaware\"\n  run\n  wait 1s\nend\n"
               "test \"aware\"\n  run\n  expect program.error == \"out of parts\" timeout 1s\nend\n");
  Problems problems;
  const auto tests = cell::find_tests(folder.path(), problems);
  ASSERT_EQ(tests.size(), 2u);
  cell::TestOptions options;
  options.state_folder = folder.path() / "scratch" / "data";
  const auto unaware = cell::run_test(tests[0], description::Catalogue({}), options);
  ASSERT_FALSE(unaware.problems.empty());
  EXPECT_EQ(unaware.problems.front().what, "out of parts");
  EXPECT_EQ(unaware.problems.front().where.line, 3);
  const auto aware = cell::run_test(tests[1], description::Catalogue({}), options);
  EXPECT_TRUE(aware.problems.empty()) << aware.problems.front().text();
}

TEST_F(ProgramControl, ComparesTellsTheFirstLineThatCannotBeDone) {
  cell::CompareOptions options;
  options.overrides.robot = std::string(POLYARM_SOURCE_DIR) + "/examples/r6bot/r6bot.urdf";
  options.state_folder = folder.path() / "scratch" / "data";
  const cell::RobotVerdict well = cell::try_robot(folder.path(), description::Catalogue({}), options);
  EXPECT_TRUE(well.runs) << well.problem->text();
  EXPECT_EQ(well.cycles, 3u);
  ASSERT_TRUE(well.cycle_s);
  EXPECT_GT(*well.cycle_s, 0.1);
  ASSERT_TRUE(well.limit);
  EXPECT_GT(well.limit->where.line, 0);
  ASSERT_TRUE(well.singularity);
  folder.write("job.script", "load work\nlog(1)\nmovel pose(20m)\n");
  const cell::RobotVerdict badly = cell::try_robot(folder.path(), description::Catalogue({}), options);
  EXPECT_FALSE(badly.runs);
  ASSERT_TRUE(badly.problem);
  EXPECT_EQ(badly.problem->where.line, 3);
}

TEST_F(ProgramControl, AMoveKeepsNearTheJointsThatItIsToldAndLiftsWhatTheRobotMay) {
  folder.write("job.script",
               "movej joints(0deg, -60deg, 60deg, 0deg, 60deg, 0deg)\n"
               "let p = here()\n"
               "movej joints(0deg, -90deg, 0deg, 0deg, 0deg, 0deg)\n"
               "movej p, near joints(0deg, -60deg, 60deg, 0deg, 60deg, 0deg)\n"
               "log(\"there\")\nwait 10s\n");
  begin();
  run_to(6);
  const std::vector<double> wanted = {0, -M_PI / 3, M_PI / 3, 0, M_PI / 3, 0};
  const auto at = cell().joint_places().commanded(cell().snapshot());
  ASSERT_EQ(at.size(), 6u);
  for (std::size_t j = 0; j < 6; ++j) EXPECT_NEAR(at[j], wanted[j], 1e-6) << j;
}

}  // namespace
}  // namespace polyarm
