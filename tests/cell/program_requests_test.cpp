/// Programs that are loaded, begun, paused, stepped and ended in a running cell, asked for as people do.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "tests/cell/requests_cell.hpp"
#include "tests/support/lock_step_cell.hpp"

namespace polyarm {
namespace {

using test::error_of;
using test::Folder;
using test::Json;
using test::LockStepCell;

constexpr const char* kPoints =
    "JS: joint_1 joint_2 joint_3 joint_4 joint_5 joint_6\n"
    "Name: A\nPoint: 0.3, 0, 0, 0, 0, 0\nName: B\nPoint: -0.3, 0.2, 0, 0, 0, 0\n";
constexpr const char* kInformation =
    "Name: PointFile\nText: places\nName: ScriptFile\nText: work\nName: Repeat\nBool: True\n"
    "Name: Ready\nBool: False\n";
constexpr const char* kProgram =
    "load work_data\nwhile Repeat\nmoveto A\nmoveto B\nendwhile\nlog \"at the end\"\n";

/// The arm of examples/r6bot in a folder with data and a script.
class ProgramRequests : public ::testing::Test {
 protected:
  ProgramRequests() {
    folder.write("places.points", kPoints);
    folder.write("work_data.data", kInformation);
    folder.write("work.script", kProgram);
    folder.write("cell.yaml", "polyarm: cell/1\nrobots:\n  arm: {model: " POLYARM_SOURCE_DIR
                              "/examples/r6bot/r6bot.urdf, hardware: mock}\n");
    cell = std::make_unique<LockStepCell>(cell::read_cell_file(folder.path()));
    cell->run(0.01);
  }
  Json state() { return cell->result({{"request", "program"}}); }
  /// Its state; "paused" once it stands so.
  std::string word() {
    const Json now = state();
    return now.value("paused", false) && now["state"] != "ready" ? "paused" : now["state"].get<std::string>();
  }
  Json load(const std::string& file) { return cell->ask({{"request", "program.load"}, {"file", file}}); }
  Json ask(const std::string& request) { return cell->ask({{"request", request}}); }
  double joint(const std::string& name) { return cell->value_of("states", "arm/" + name + "/position"); }
  void until(const std::string& wanted, double most = 60) {
    for (double t = 0; word() != wanted && t < most; t += 0.02) cell->run(0.02);
    ASSERT_EQ(word(), wanted) << state().dump(1);
  }

  Folder folder;
  std::unique_ptr<LockStepCell> cell;
};

TEST_F(ProgramRequests, ALoadedProgramBeginsWhenSomebodySaysSo) {
  EXPECT_EQ(word(), "none");
  const Json loaded = load("work_data");
  ASSERT_TRUE(loaded["ok"].get<bool>()) << loaded;
  EXPECT_EQ(loaded["result"]["state"], "ready");
  const double before = joint("joint_1");
  cell->run(1);
  EXPECT_EQ(word(), "ready");
  EXPECT_EQ(joint("joint_1"), before);
  EXPECT_TRUE(cell->ask({{"request", "program.start"}, {"passes", 2}})["ok"].get<bool>());
  until("finished");
  EXPECT_EQ(state()["passes"], 2);
  EXPECT_NEAR(joint("joint_1"), -0.3, 1e-6);
  EXPECT_FALSE(cell->cell().finished()) << "the cell goes on";
  EXPECT_EQ(error_of(ask("program.start")), "program-begun");
}

TEST_F(ProgramRequests, AnEndlessProgramThatQueuesAheadCountsTheCyclesThatTheRobotHasDone) {
  folder.write("work.script", "load work_data\nwhile true\n  movej A\n  movej B\nend\n");
  ASSERT_TRUE(load("work.script")["ok"].get<bool>());
  ask("program.start");
  cell->run(0.05);
  const std::uint64_t queued = cell->cell().program()->status().passes;
  EXPECT_GT(queued, 10u) << "it is far ahead";
  EXPECT_EQ(state()["passes"], 0);
  int turns = 0;  // arrivals at B
  const auto at_b = [this] { return std::abs(joint("joint_1") + 0.3) < 1e-3; };
  for (bool there = false, was = false; turns < 3; was = there) {
    cell->run(0.01);
    there = at_b();
    if (there && !was) ++turns;
    EXPECT_LE(std::abs(state()["passes"].get<int>() - turns), 1);
    ASSERT_LT(cell->cell().now(), 100'000'000'000);
  }
  ask("program.stop");
  cell->run(1);
  EXPECT_LE(std::abs(state()["passes"].get<int>() - turns), 1) << "nor does its end count what was queued";
}

TEST_F(ProgramRequests, ADiscardReachesWhatATrapHasSetApart) {
  folder.write("work.script",
               "load work_data\ntrap when Ready\n  wait 60s\nend\nmovej A, at start + 200ms set Ready = true\nmoveto B\n");
  ASSERT_TRUE(load("work.script")["ok"].get<bool>());
  ask("program.start");
  cell->run(3);
  ask("control.hold");
  cell->run(1);
  EXPECT_EQ(cell->result({{"request", "control.discard"}})["discarded"], true);
  EXPECT_EQ(cell->result({{"request", "control.discard"}})["discarded"], false) << "the robot can be jogged";
}

TEST_F(ProgramRequests, ACanceledMotionCountsNoCycleThatTheRobotHasNotDone) {
  folder.write("work.script", "load work_data\nwhile true\n  movej A\n  movej B\nend\n");
  ASSERT_TRUE(load("work.script")["ok"].get<bool>());
  ask("program.start");
  cell->run(0.05);
  ASSERT_GT(cell->cell().program()->status().passes, 10u) << "it is far ahead";
  ask("control.hold");
  cell->run(1);
  ask("control.discard");
  cell->run(1);
  EXPECT_EQ(state()["passes"], 0);
  ask("control.resume");
  cell->run(1);
  EXPECT_EQ(word(), "failed");
  EXPECT_EQ(state()["passes"], 0);
}

TEST_F(ProgramRequests, WhatStandsReadyMayBeginAsItWasSavedSince) {
  ASSERT_TRUE(load("work.script")["ok"].get<bool>());
  folder.write("work.script", "load work_data\nmoveto B\nmoveto Nowhere\n");
  const Json as_saved{{"request", "program.start"}, {"as_saved", true}};
  EXPECT_EQ(error_of(cell->ask(as_saved)), "unknown-name");
  EXPECT_EQ(word(), "ready") << "as it was";
  folder.write("work.script", "load work_data\nmoveto B\n");
  const Json begun = cell->ask(as_saved);
  ASSERT_TRUE(begun["ok"].get<bool>()) << begun;
  until("finished");
  EXPECT_NEAR(joint("joint_1"), -0.3, 1e-6) << "B";
  EXPECT_EQ(state()["passes"], 1) << "it has no loop any more, and is one pass itself";
}

TEST_F(ProgramRequests, WhatIsStartedIsWhatWasShown) {
  folder.write("other.script", "load work_data\nmoveto A\n");
  const Json shown = load("work.script")["result"];
  ASSERT_FALSE(shown["hash"].get<std::string>().empty());
  const Json start{{"request", "program.start"}, {"file", shown["file"]}, {"hash", shown["hash"]}};
  ASSERT_TRUE(load("other.script")["ok"].get<bool>());
  EXPECT_EQ(error_of(cell->ask(start)), "program-changed") << "somebody has loaded another one";
  folder.write("work.script", "load work_data\nmoveto B\n");
  ASSERT_TRUE(load("work.script")["ok"].get<bool>());
  EXPECT_EQ(error_of(cell->ask(start)), "program-changed") << "the same file, which says something else";
  EXPECT_EQ(word(), "ready");
  EXPECT_TRUE(cell->ask({{"request", "program.start"}, {"file", "work.script"}, {"hash", state()["hash"]}})["ok"]
                  .get<bool>());
}

TEST_F(ProgramRequests, WhatBeginsAnewIsWhatWasShown) {
  const Json shown = cell->ask({{"request", "files.read"}, {"name", "work.script"}})["result"];
  Json from{{"request", "program.from"}, {"program", "work.script"}, {"hash", shown["hash"]}, {"confirmed", true}};
  folder.write("work.script", "load work_data\nmoveto B\n");
  EXPECT_EQ(error_of(cell->ask(from)), "program-changed");
  EXPECT_EQ(word(), "none") << "nothing has begun";
  from["hash"] = cell->ask({{"request", "files.read"}, {"name", "work.script"}})["result"]["hash"];
  EXPECT_TRUE(cell->ask(from)["ok"].get<bool>());
}

TEST_F(ProgramRequests, ACellWithoutAProgramSaysSoAndBeginsOneAtALine) {
  const Json now = state();
  EXPECT_EQ(now["state"], "none");
  EXPECT_EQ(now["robots"], Json::array({"arm"}));
  EXPECT_TRUE(now["tasks"].empty());
  EXPECT_EQ(error_of(ask("program.go")), "no-program");
  const Json told = cell->ask({{"request", "program.from"}, {"program", "work_data"}, {"line", 4}});
  ASSERT_TRUE(told["ok"].get<bool>()) << told;
  EXPECT_EQ(word(), "paused");
  EXPECT_EQ(state()["where"]["line"], 4);
}

TEST_F(ProgramRequests, EachLoadTakesTheFilesAsTheyAreThen) {
  ASSERT_TRUE(load("work_data")["ok"].get<bool>());
  cell->ask({{"request", "program.start"}, {"passes", 1}});
  until("finished");
  std::string moved = kPoints;
  moved.replace(moved.find("-0.3"), 4, "-0.5");
  folder.write("places.points", moved);
  ASSERT_TRUE(load("work_data")["ok"].get<bool>());
  cell->ask({{"request", "program.start"}, {"passes", 1}});
  until("finished");
  EXPECT_NEAR(joint("joint_1"), -0.5, 1e-6);
}

TEST_F(ProgramRequests, AScriptAloneFindsWhatItLoads) {
  const Json loaded = load("work.script");
  ASSERT_TRUE(loaded["ok"].get<bool>()) << loaded;
  cell->ask({{"request", "program.start"}, {"passes", 1}});
  until("finished");
  EXPECT_NEAR(joint("joint_2"), 0.2, 1e-6);
}

TEST_F(ProgramRequests, EveryMistakeOfAScriptIsToldAndTheOldOneStays) {
  ASSERT_TRUE(load("work_data")["ok"].get<bool>());
  folder.write("wrong.script", "load work_data\nmoveto Aa\nmoveto Nowhere\n");
  const Json refused = load("wrong.script");
  ASSERT_FALSE(refused["ok"].get<bool>());
  ASSERT_TRUE(refused["error"].contains("all")) << refused;
  EXPECT_EQ(refused["error"]["all"].size(), 2u);
  EXPECT_NE(refused["error"]["where"].get<std::string>().find("wrong.script:"), std::string::npos);
  EXPECT_NE(state()["file"].get<std::string>().find("work.script"), std::string::npos);
  EXPECT_EQ(error_of(load("nowhere")), "no-file");
}

TEST_F(ProgramRequests, APausedProgramStandsIsSteppedAndGoesOn) {
  ASSERT_TRUE(load("work_data")["ok"].get<bool>());
  cell->ask({{"request", "program.start"}, {"paused", true}, {"passes", 1}});
  until("paused");
  EXPECT_EQ(state()["where"]["line"], 1);
  std::vector<int> lines;
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(cell->ask({{"request", "program.step"}, {"how", "into"}})["ok"].get<bool>());
    cell->run(0.01);
    until("paused");
    lines.push_back(state()["where"]["line"]);
  }
  EXPECT_EQ(lines, (std::vector<int>{2, 3, 4}));
  EXPECT_NEAR(joint("joint_1"), 0.3, 1e-6) << "the move of the line has arrived";
  EXPECT_EQ(error_of(cell->ask({{"request", "program.step"}, {"how", "int"}})), "bad-argument");
  // While it stands a person may teach; the program goes on from there.
  const Json jogged = cell->ask({{"request", "jog"}, {"joints", {{"joint_3", 0.1}}}, {"by", true}});
  ASSERT_TRUE(jogged["ok"].get<bool>()) << jogged;
  EXPECT_NEAR(joint("joint_3"), 0.1, 1e-4);
  cell->run(1);
  ASSERT_TRUE(ask("program.go")["ok"].get<bool>());
  EXPECT_EQ(error_of(cell->ask({{"request", "jog"}, {"joints", {{"joint_3", 0.1}}}, {"by", true}})),
            "program-runs");
  until("finished");
  EXPECT_NEAR(joint("joint_1"), -0.3, 1e-6);
  EXPECT_NEAR(joint("joint_3"), 0, 1e-6);
}

TEST_F(ProgramRequests, PausesAtABreakpoint) {
  ASSERT_TRUE(load("work_data")["ok"].get<bool>());
  EXPECT_EQ(cell->result({{"request", "program.break"}, {"at", "4"}})["breakpoints"][0]["line"], 4);
  cell->ask({{"request", "program.start"}});
  until("paused");
  EXPECT_EQ(state()["where"]["line"], 4);
}

TEST_F(ProgramRequests, EndingAProgramStopsItsMoveAndKeepsTheCell) {
  ASSERT_TRUE(load("work_data")["ok"].get<bool>());
  cell->ask({{"request", "program.start"}});
  cell->run(0.3);
  EXPECT_EQ(error_of(load("work_data")), "program-runs");
  ASSERT_TRUE(ask("program.stop")["ok"].get<bool>());
  EXPECT_EQ(word(), "stopped");
  cell->run(2);
  const double stands = joint("joint_1");
  cell->run(1);
  EXPECT_EQ(joint("joint_1"), stands);
  EXPECT_FALSE(cell->cell().finished());
  EXPECT_FALSE(cell->cell().failure());
  EXPECT_TRUE(load("work_data")["ok"].get<bool>());
}

TEST_F(ProgramRequests, AProgramThatFailsIsToldAndTheCellGoesOn) {
  folder.write("far.points", "Pose: RPY\nName: Far\nPoint: 5, 3, 2, 0, 0, 0\n");
  folder.write("far.script", "load far\nmoveto Far\n");
  const auto events = cell->give(Json{{"request", "events"}});
  ASSERT_TRUE(load("far.script")["ok"].get<bool>());
  cell->ask({{"request", "program.start"}});
  until("failed");
  const Json problem = state()["problem"];
  EXPECT_NE(problem["what"].get<std::string>().find("Far"), std::string::npos) << problem;
  EXPECT_NE(problem["where"].get<std::string>().find("far.script:2"), std::string::npos) << problem;
  EXPECT_FALSE(cell->cell().failure());
  int told = 0;
  for (const Json& answer : *events)
    for (const Json& event : answer["result"]) told += event["event"] == "problem" ? 1 : 0;
  EXPECT_EQ(told, 1);
}

TEST_F(ProgramRequests, AQuestionWaitsForItsAnswer) {
  folder.write("ask.script", "wait user \"part in place?\"\nlog \"thanks\"\n");
  ASSERT_TRUE(load("ask.script")["ok"].get<bool>());
  EXPECT_EQ(error_of(ask("program.answer")), "no-question");
  cell->cell().answers().can_answer = true;
  cell->ask({{"request", "program.start"}});
  cell->run(1);
  EXPECT_EQ(state()["question"], "part in place?");
  ASSERT_TRUE(cell->ask({{"request", "program.answer"}, {"text", "yes"}})["ok"].get<bool>());
  until("finished");
}

TEST_F(ProgramRequests, AnAnswerBelongsToTheQuestionThatWasSeen) {
  folder.write("ask.script", "let n = ask(\"How many?\", 2)\nwait user \"Stand back\"\nlog(\"{n}\")\n");
  ASSERT_TRUE(load("ask.script")["ok"].get<bool>());
  cell->cell().answers().can_answer = true;
  cell->ask({{"request", "program.start"}});
  cell->run(1);
  const auto answer = [&](const std::string& text, const std::string& question) {
    return error_of(cell->ask({{"request", "program.answer"}, {"text", text}, {"question", question}}));
  };
  EXPECT_EQ(answer("3", "Stand back"), "other-question");
  const std::string shown = "How many?";
  cell->ask({{"request", "control.hold"}});
  cell->run(1);
  EXPECT_EQ(answer("3", shown), "none");
  EXPECT_EQ(answer("3", shown), "answered-already") << "the program is held: a second answer would be the next question's";
  cell->ask({{"request", "control.resume"}});
  cell->run(1);
  EXPECT_EQ(state()["question"], "Stand back");
  EXPECT_EQ(answer("", shown), "other-question");
  // What answers a question that ends with its program does not answer one of the next program.
  cell->ask({{"request", "control.hold"}});
  cell->run(1);
  EXPECT_EQ(answer("", "Stand back"), "none");
  cell->ask({{"request", "program.stop"}});
  cell->ask({{"request", "control.resume"}});
  cell->run(1);
  ASSERT_TRUE(load("ask.script")["ok"].get<bool>());
  cell->ask({{"request", "program.start"}});
  cell->run(1);
  EXPECT_EQ(state()["question"], "How many?\nEnter alone means 2");
}

TEST_F(ProgramRequests, ABeginningInTheMiddleSaysWhatItTakesForGranted) {
  ASSERT_TRUE(load("work_data")["ok"].get<bool>());
  const Json told =
      cell->ask({{"request", "program.from"}, {"program", "work_data"}, {"line", 6}, {"confirmed", true}});
  ASSERT_TRUE(told["ok"].get<bool>()) << told;
  EXPECT_EQ(told["result"]["last_point"], "B");
  const double before = joint("joint_1");
  until("finished");
  EXPECT_EQ(joint("joint_1"), before) << "the moves before it are not made";
}

TEST_F(ProgramRequests, WithoutALineItBeginsAtItsFirstStatement) {
  folder.write("remarked.script", "# what it does\n\nlog \"begun\"\nwait 100ms\n");
  const Json told = cell->ask({{"request", "program.from"}, {"program", "remarked.script"}});
  ASSERT_TRUE(told["ok"].get<bool>()) << told;
  EXPECT_EQ(told["result"]["where"]["line"], 3);
  EXPECT_EQ(word(), "paused");
  EXPECT_EQ(error_of(cell->ask({{"request", "program.from"}, {"program", "remarked.script"}, {"line", 1}})),
            "no-start")
      << "nothing begins in a remark";
  ASSERT_TRUE(
      cell->ask({{"request", "program.from"}, {"program", "remarked.script"}, {"confirmed", true}})["ok"]
          .get<bool>());
  until("finished");
}

TEST_F(ProgramRequests, EventsTellLinesAndLogsOnceEach) {
  const auto events = cell->give(Json{{"request", "events"}});
  ASSERT_TRUE(load("work_data")["ok"].get<bool>());
  cell->ask({{"request", "program.start"}, {"passes", 1}});
  until("finished");
  std::vector<int> lines, numbers;
  std::string logged;
  for (const Json& answer : *events)
    for (const Json& event : answer["result"]) {
      numbers.push_back(event["number"]);
      if (event["event"] == "line") lines.push_back(event["line"]);
      if (event["event"] == "log") logged += event["text"];
    }
  EXPECT_EQ(logged, "at the end");
  for (const int line : {3, 4}) EXPECT_EQ(std::count(lines.begin(), lines.end(), line), 1) << line;
  for (std::size_t i = 1; i < numbers.size(); ++i) EXPECT_EQ(numbers[i], numbers[i - 1] + 1);
  const Json again = cell->give(Json{{"request", "events"}, {"since", 0}})->front();
  EXPECT_EQ(again["result"].size(), cell->cell().events().events().size());
}

TEST_F(ProgramRequests, AQuestionOfATogetherIsAsked) {
  folder.write("asking.script", "together\n  wait user \"go?\"\n  wait 100ms\nend\n");
  cell->cell().answers().can_answer = true;
  ASSERT_TRUE(load("asking.script")["ok"].get<bool>());
  cell->ask({{"request", "program.start"}});
  cell->run(0.3);
  EXPECT_EQ(state()["question"], "go?") << state().dump(1);
  EXPECT_TRUE(cell->ask({{"request", "program.answer"}, {"text", "yes"}})["ok"].get<bool>());
  until("finished", 2);
}

TEST_F(ProgramRequests, VariablesAndDataCanBeLookedAt) {
  ASSERT_TRUE(load("work_data")["ok"].get<bool>());
  const Json now = cell->result({{"request", "program"}, {"data", true}});
  EXPECT_EQ(now["data"]["Repeat"], "True");
}

// --- moves without a program ------------------------------------------------------------------------------

class MoveRequest : public ProgramRequests {
 protected:
  Json to(double a, double b) {
    return {
        {"joints",
         {{"joint_1", a}, {"joint_2", b}, {"joint_3", 0}, {"joint_4", 0}, {"joint_5", 0}, {"joint_6", 0}}}};
  }
  Json move(Json points, Json more = Json::object()) {
    more["request"] = "move";
    more["points"] = std::move(points);
    return cell->ask(more);
  }
  /// How often all stands while the move is under way, not counting before and after.
  int stops(Json request) {
    request["request"] = "move";
    const auto answers = cell->give(request);
    int stops = 0;
    bool moved = false, stood = true;
    for (int ticks = 0; ticks < 20000; ++ticks) {
      cell->tick();
      const bool standing = cell->cell().snapshot().standing;
      moved = moved || !standing;
      if (moved && standing && !stood) ++stops;
      stood = standing;
      if (!answers->empty() && !answers->back().value("more", false)) break;
    }
    EXPECT_TRUE(answers->back()["ok"].get<bool>()) << answers->back();
    return stops;
  }
};

TEST_F(MoveRequest, GoesToJointsPosesAndNamedPoints) {
  const Json there = move({to(0.4, 0.1)});
  ASSERT_TRUE(there["ok"].get<bool>()) << there;
  EXPECT_TRUE(there["result"]["done"].get<bool>());
  EXPECT_NEAR(joint("joint_1"), 0.4, 1e-9);
  const Json at = cell->result({{"request", "jog.state"}});
  ASSERT_TRUE(move({to(0, 0)})["ok"].get<bool>());
  ASSERT_TRUE(move({{{"pose", {{"position", at["position"]}, {"rpy", at["rpy"]}}}}})["ok"].get<bool>());
  const Json back = cell->result({{"request", "jog.state"}});
  for (int k = 0; k < 3; ++k)
    EXPECT_NEAR(back["position"][k].get<double>(), at["position"][k].get<double>(), 1e-5);
  ASSERT_TRUE(load("work_data")["ok"].get<bool>());
  ASSERT_TRUE(move("A")["ok"].get<bool>());
  EXPECT_NEAR(joint("joint_1"), 0.3, 1e-9);
}

TEST_F(MoveRequest, GoesToPointsInFramesWhereTheirFramesPutThem) {
  ASSERT_TRUE(move({to(0.4, 0.1)})["ok"].get<bool>());
  const Json at = cell->result({{"request", "jog.state"}});
  ASSERT_TRUE(move({to(0, 0)})["ok"].get<bool>());
  std::string numbers;
  for (int k = 0; k < 3; ++k)
    numbers += Json(at["position"][k].get<double>() - (k == 0 ? 0.1 : 0.0)).dump() + ", ";
  for (int k = 0; k < 3; ++k) numbers += (k > 0 ? ", " : "") + at["rpy"][k].dump();
  folder.write("places.points", std::string(kPoints) +
                                    "Pose: RPY\nName: shelf\nPoint: 0.1, 0, 0, 0, 0, 0\nName: P\nPoint: " +
                                    numbers + "; frame = \"shelf\"\n");
  ASSERT_TRUE(load("work_data")["ok"].get<bool>());
  ASSERT_TRUE(move("P")["ok"].get<bool>());
  const Json there = cell->result({{"request", "jog.state"}});
  for (int k = 0; k < 3; ++k)
    EXPECT_NEAR(there["position"][k].get<double>(), at["position"][k].get<double>(), 1e-4);
}

TEST_F(MoveRequest, APoseMayBeInAFrame) {
  ASSERT_TRUE(move({to(0.4, 0.1)})["ok"].get<bool>());
  const Json at = cell->result({{"request", "jog.state"}});
  const Json framed = {{"pose", {{"position", {0, 0, -0.02}}, {"rpy", {0, 0, 0}}}}, {"frame", "arm/tcp"}};
  ASSERT_TRUE(move({framed})["ok"].get<bool>());
  const Json there = cell->result({{"request", "jog.state"}});
  double moved = 0;
  for (int k = 0; k < 3; ++k)
    moved = std::hypot(moved, there["position"][k].get<double>() - at["position"][k].get<double>());
  EXPECT_NEAR(moved, 0.02, 1e-4);
  Json lost = framed;
  lost["frame"] = "tabel";
  EXPECT_EQ(move({lost})["error"]["code"], "unknown-frame");
  Json joints = to(0, 0);
  joints["frame"] = "world";
  EXPECT_EQ(move({joints})["error"]["code"], "bad-argument");
}

TEST_F(MoveRequest, SeveralPointsAreOnePathUnlessItIsToRestAtEach) {
  const Json points = {to(0.4, 0.1), to(0.6, -0.3), to(0.1, 0.2)};
  EXPECT_EQ(stops({{"points", points}}), 1) << "at the end alone";
  EXPECT_NEAR(joint("joint_2"), 0.2, 1e-9);
  EXPECT_EQ(stops({{"points", points}, {"rests", true}}), 3);
}

TEST_F(MoveRequest, TakesAsLongAsItIsTold) {
  Json slow = to(0.4, 0);
  slow["duration"] = 3;
  EXPECT_GE(move({slow})["result"]["elapsed_s"].get<double>(), 3 - 1e-6);
  const double paced = move({to(0, 0)}, {{"pace", 5}})["result"]["elapsed_s"];
  EXPECT_NEAR(paced, 0.4 * 5, 0.1);
  EXPECT_LT(move({to(0.4, 0)})["result"]["elapsed_s"].get<double>(), 2);
}

TEST_F(MoveRequest, SaysWhyItDoesNotMove) {
  const auto why = [](const Json& answer) { return error_of(answer); };
  EXPECT_EQ(why(move("Nowhere")), "unknown-point");
  EXPECT_EQ(why(move({{{"joints", {{"joint_9", 1}}}}})), "unknown-joint");
  EXPECT_EQ(why(move({{{"joints", {{"joint_1", 1}}}}})), "missing-joint");
  EXPECT_EQ(why(move({to(99, 0)})), "limit");
  EXPECT_EQ(why(move({{{"pose", {{"position", {5, 3, 2}}, {"rpy", {0, 0, 0}}}}}})), "unreachable");
  EXPECT_EQ(why(move({{{"pose", {{"position", {0.1, 0, 0.2}}}}}})), "bad-argument");
  EXPECT_EQ(why(move({{{"pose", {{"position", {0.1, 0, 0.2}}, {"orientation", {0, 0, 0, 3}}}}}})),
            "bad-argument");
  EXPECT_EQ(why(move(Json::array())), "bad-argument");
  EXPECT_EQ(why(move({to(0, 0)}, {{"kind", "circle"}})), "bad-argument");
  EXPECT_EQ(why(move({to(0, 0)}, {{"pace", -1}})), "bad-argument");
  Json wrong = to(0, 0);
  wrong["duraton"] = 1;
  EXPECT_NE(move({wrong})["error"]["what"].get<std::string>().find("did you mean 'duration'"),
            std::string::npos);
  ASSERT_TRUE(load("work_data")["ok"].get<bool>());
  cell->ask({{"request", "program.start"}});
  EXPECT_EQ(why(move({to(0, 0)})), "program-runs");
  ask("program.stop");
  ask("control.hold");
  cell->run(2);
  EXPECT_EQ(why(move({to(0, 0)})), "held");
}

TEST_F(MoveRequest, AHeldMoveGoesOnOrIsForgotten) {
  const auto first = cell->give(Json{{"request", "move"}, {"points", {to(0.8, 0)}}, {"pace", 5}});
  cell->run(0.3);
  ask("control.hold");
  cell->run(1.5);
  EXPECT_EQ(first->back()["result"]["cell"], "held");
  ask("control.resume");
  cell->run(6);
  EXPECT_TRUE(first->back()["result"].value("done", false)) << first->back();
  const auto second = cell->give(Json{{"request", "move"}, {"points", {to(0, 0)}}, {"pace", 5}});
  cell->run(0.3);
  ask("control.hold");
  cell->run(1.5);
  ask("control.discard");
  cell->run(0.1);
  EXPECT_EQ(error_of(second->back()), "discarded") << second->back();
  ask("control.resume");
  cell->run(0.5);
  EXPECT_GT(joint("joint_1"), 0.1);
  EXPECT_TRUE(move({to(0, 0)})["ok"].get<bool>()) << "and the next begins where it stands";
}

TEST_F(MoveRequest, WhenNobodyFollowsItAnyMoreItStopsOnItsPath) {
  int told = 0;
  cell->cell().requests().handle(Json{{"request", "move"}, {"points", {to(0.8, 0)}}, {"pace", 5}}.dump(),
                                 [&told](const std::string&) { return ++told < 2; });
  cell->run(3);
  EXPECT_EQ(told, 2);
  EXPECT_EQ(state()["control"], "held");
  EXPECT_LT(joint("joint_1"), 0.79);
}

TEST_F(MoveRequest, ComesAfterAJogOnceTheRobotIsBack) {
  ASSERT_TRUE(
      cell->ask({{"request", "jog"}, {"joints", {{"joint_1", 0.2}}}, {"by", true}})["ok"].get<bool>());
  const Json moved = move({to(0, 0)});
  ASSERT_TRUE(moved["ok"].get<bool>()) << moved;
  EXPECT_NEAR(joint("joint_1"), 0, 1e-9);
}

TEST_F(ProgramRequests, APauseThatWaitsForItsStatementHoldsBackNoLaterRequestOfItsAsker) {
  folder.write("long.script", "wait 30s\nlog \"done\"\n");
  ASSERT_TRUE(load("long.script")["ok"].get<bool>());
  ASSERT_TRUE(ask("program.start")["ok"].get<bool>());
  until("waiting");
  const int asker = 0;
  const auto paused = cell->give(std::string(R"({"request": "program.pause"})"), &asker);
  const auto answered = cell->give(std::string(R"({"request": "program"})"), &asker);
  cell->run(0.1);
  EXPECT_TRUE(paused->empty());
  ASSERT_EQ(answered->size(), 1u) << "it needs no pause";
  EXPECT_EQ(error_of(answered->front()), "none") << answered->front();
  cell->run(31);
  EXPECT_EQ(paused->size(), 1u);
  EXPECT_EQ(word(), "paused");
}

TEST_F(ProgramRequests, WhatIsOpenWhenTheCellOfAnAskerGoesIsRefused) {
  folder.write("long.script", "wait 30s\n");
  ASSERT_TRUE(load("long.script")["ok"].get<bool>());
  ASSERT_TRUE(ask("program.start")["ok"].get<bool>());
  until("waiting");
  const int asker = 0, other = 0;
  const auto own = cell->give(std::string(R"({"request": "program.pause", "id": 7})"), &asker);
  const auto others = cell->give(std::string(R"({"request": "program.pause"})"), &other);
  cell->cell().requests().refuse(&asker, Error("no-cell", "the cell was closed"));
  ASSERT_EQ(own->size(), 1u);
  EXPECT_EQ(error_of(own->front()), "no-cell");
  EXPECT_EQ(own->front()["id"], 7);
  EXPECT_TRUE(others->empty());
}

}  // namespace
}  // namespace polyarm
