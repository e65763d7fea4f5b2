/// Every state of a cell has a way back that its refusals name, and a contact is blamed on what moved.
#include "polyarm/inside/ways.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <cstdio>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "tests/cell/requests_cell.hpp"
#include "tests/support/lock_step_cell.hpp"

namespace polyarm::ways_test {
namespace {

using test::error_of;
using test::FailingMock;
using test::Folder;
using test::Json;
using test::LockStepCell;

/// The failing mock in a world where the arm touches a wall whenever a test says so.
class TouchingMock : public FailingMock {
 public:
  static inline std::atomic<bool> touches{false}, is_real{false};
  static inline std::atomic<double> depth{0.002};
  static inline std::string other = "fixture wall";
  const hardware::WorldState* world() const noexcept override { return &world_; }
  std::vector<std::string> world_names() const override { return {"arm/link_6", other}; }
  bool real() const noexcept override { return is_real; }
  hardware::ReturnType read(const hardware::Cycle& cycle, std::span<double> states) noexcept override {
    constexpr int kMost = hardware::WorldState::kMaxFindings;
    if (touches && !touched_) {
      world_.findings[static_cast<std::size_t>(world_.finding_count++ % kMost)] = {
          cycle.time, 0, 1, depth, {0.4, 0.1, 0.2}, true};
    }
    touched_ = touches;
    if (world_.finding_count > 0)
      world_.findings[static_cast<std::size_t>((world_.finding_count - 1) % kMost)].now = touches;
    return FailingMock::read(cycle, states);
  }

 private:
  hardware::WorldState world_;
  bool touched_ = false;
};

constexpr const char* kPoints =
    "JS: joint_1 joint_2 joint_3 joint_4 joint_5 joint_6\n"
    "Name: A\nPoint: 0.9, 0, 0, 0, 0, 0\nName: B\nPoint: -0.9, 0.2, 0, 0, 0, 0\n";
constexpr const char* kData = "Name: PointFile\nText: places\nName: ScriptFile\nText: work\n";

class Ways : public ::testing::Test {
 protected:
  explicit Ways(const std::string& more = "") {
    TouchingMock::touches = TouchingMock::is_real = false;
    folder.write("places.points", kPoints);
    folder.write("work_data.data", kData);
    folder.write("work.script", "load work_data\nmovej A\nmovej B\nmovej A\n");
    folder.write("bad.script", "load work_data\nwait time 0.01\nraise \"on purpose\"\n");
    write_cell(more);
    hardware::register_driver("touching",
                              [] { return std::unique_ptr<hardware::Component>(new TouchingMock); });
  }
  ~Ways() override {
    cell.reset();
    FailingMock::fails = false;
    FailingMock::pushed = 0;
    TouchingMock::other = "fixture wall";
  }
  void write_cell(const std::string& more) {
    folder.write("cell.yaml", "polyarm: cell/1\nrobots:\n  arm: {model: " POLYARM_SOURCE_DIR
                              "/examples/r6bot/r6bot.urdf, hardware: touching}\n" + more);
  }
  void build(bool real = false) {
    FailingMock::fails = false;
    FailingMock::pushed = 0;
    TouchingMock::touches = false;
    TouchingMock::is_real = real;
    cell::CellOptions options;
    options.waits = true;
    options.real = real;
    cell.reset();
    cell = std::make_unique<LockStepCell>(cell::read_cell_file(folder.path()), options);
    cell->run(0.05);
  }
  std::string state() { return cell->result({{"request", "health"}})["state"]; }
  Json ask(const std::string& request) { return cell->ask({{"request", request}}); }
  void begin(const std::string& script, double then) {
    const Json loaded = cell->ask({{"request", "program.load"}, {"file", script}});
    ASSERT_TRUE(loaded["ok"].get<bool>()) << loaded;
    const Json begun = ask("program.start");
    ASSERT_TRUE(begun["ok"].get<bool>()) << begun;
    cell->run(then);
  }
  void touch() {
    TouchingMock::touches = true;
    cell->run(2);
  }
  Json contacts() { return ask("contacts")["result"]; }

  Folder folder;
  std::unique_ptr<LockStepCell> cell;
};

Json joints_at(double first) {
  return {{"joints",
           {{"joint_1", first}, {"joint_2", 0}, {"joint_3", 0}, {"joint_4", 0}, {"joint_5", 0}, {"joint_6", 0}}}};
}

/// As a person reads an advice: the first thing in it that can be done. False: nothing in it can.
/// What is refused on the way has an advice of its own.
bool follow(const std::string& advice, LockStepCell& cell, int depth = 0) {
  const std::vector<std::pair<std::string, Json>> known = {
      {"polyarm control arm", {{"request", "control.arm"}, {"confirmed", true}}},
      {"polyarm control recover", {{"request", "control.recover"}}},
      {"polyarm control resume", {{"request", "control.resume"}}},
      {"polyarm control discard", {{"request", "control.discard"}}},
      {"polyarm control hold", {{"request", "control.hold"}}},
      {"polyarm control back", {{"request", "control.back"}}},
      {"program.pause", {{"request", "program.pause"}, {"at_once", true}}},
      {"polyarm control pause", {{"request", "program.pause"}, {"at_once", true}}},
      {"program.stop", {{"request", "program.stop"}}},
      {"program.start", {{"request", "program.start"}}},
      {"program.go", {{"request", "program.go"}}},
      {"program.load", {{"request", "program.load"}, {"file", "work.script"}}},
      {"polyarm control from", {{"request", "program.from"}}}};
  std::size_t first = std::string::npos;
  const Json* chosen = nullptr;
  for (const auto& [words, request] : known)
    if (const auto at = advice.find(words); at < first) first = at, chosen = &request;
  const bool waits = advice.starts_with("try again") || advice.starts_with("ask again") || advice.starts_with("wait") || advice.starts_with("let it go");
  if (!chosen && !waits) return false;
  Json answer;
  if (chosen && !waits) answer = cell.ask(*chosen);
  if (advice.find("jog away") != std::string::npos || advice.find("leads out") != std::string::npos)
    TouchingMock::touches = false;
  if (advice.starts_with("let it go")) FailingMock::pushed = 0;
  FailingMock::fails = false;
  cell.run(1.5);
  if (answer.contains("error") && depth < 4) follow(answer["error"].value("advice", ""), cell, depth + 1);
  return true;
}

TEST_F(Ways, EveryActionInEveryStateIsDoneOrNamesTheWayToIt) {
  const std::map<std::string, std::function<void()>> states = {
      {"running", [&] {}},
      {"program runs", [&] { begin("work.script", 0.3); }},
      {"stopping", [&] { begin("work.script", 0.3), ask("control.hold"), cell->run(0.02); }},
      {"held", [&] { begin("work.script", 0.3), ask("control.hold"), cell->run(2); }},
      {"held after contact", [&] { begin("work.script", 0.3), touch(); }},
      {"held after contact with nothing under way", [&] { touch(); }},
      {"held after being moved",
       [&] {
         begin("work.script", 0.3), ask("control.hold"), cell->run(2);
         FailingMock::pushed = 0.03;
         cell->run(0.1);
       }},
      {"program paused",
       [&] {
         begin("work.script", 0.1);
         cell->ask({{"request", "program.pause"}, {"at_once", true}});
         cell->run(4);
       }},
      {"program ended", [&] { begin("work.script", 0.1), ask("program.stop"), cell->run(2); }},
      {"program failed", [&] { begin("bad.script", 0.5); }}};
  const std::map<std::string, Json> actions = {
      {"start", {{"request", "program.start"}}},
      {"resume", {{"request", "control.resume"}}},
      {"discard", {{"request", "control.discard"}}},
      {"hold", {{"request", "control.hold"}}},
      {"recover", {{"request", "control.recover"}}},
      {"jog", {{"request", "jog"}, {"joints", {{"joint_2", 0.05}}}}},
      {"step", {{"request", "jog"}, {"joints", {{"joint_2", 0.01}}}, {"by", true}}},
      {"goto", {{"request", "move"}, {"points", {joints_at(0.2)}}}},
      {"home", {{"request", "move"}, {"points", {joints_at(0)}}}},
      {"go", {{"request", "program.go"}}},
      {"statement", {{"request", "program.step"}, {"at_once", true}}},
      {"from", {{"request", "program.from"}}}};
  for (const auto& [state_name, enter] : states)
    for (const auto& [action_name, request] : actions) {
      SCOPED_TRACE(action_name + " in " + state_name);
      build();
      enter();
      if (HasFatalFailure()) return;
      std::string way;
      bool done = false;
      for (int steps = 0; steps < 8 && !done; ++steps) {
        const Json answer = cell->ask(request);
        ASSERT_FALSE(answer.is_null()) << "no answer" << way;
        const std::string code = error_of(answer);
        // What cannot be because there is nothing to do it to is no dead end.
        done = answer.value("ok", false) || code == "no-fault" || code == "no-program" || code == "has-ended" ||
               code == "not-paused" || code == "not-begun";
        if (done) break;
        const std::string advice = answer["error"].value("advice", "");
        way += "\n  " + answer["error"].value("what", "") + " → " + advice;
        if (!follow(advice, *cell)) break;
      }
      EXPECT_TRUE(done) << way;
      TouchingMock::touches = false;
      FailingMock::pushed = 0;
      cell->run(2);
      for (int steps = 0; steps < 4 && state() != "running"; ++steps) {  // and from there to work again
        const Json answer = ask("control.resume");
        if (!answer.value("ok", false)) follow(answer["error"].value("advice", ""), *cell);
        cell->run(1);
      }
      EXPECT_EQ(state(), "running") << way;
    }
}

TEST_F(Ways, AFaultIsLeftByWhatItsRefusalsName) {
  build();
  begin("work.script", 0.3);
  FailingMock::fails = true;
  cell->run(0.2);
  ASSERT_EQ(state(), "fault");
  for (const char* request : {"control.resume", "control.discard", "control.back", "program.start"}) {
    const Json answer = ask(request);
    EXPECT_EQ(error_of(answer), "fault") << request << answer;
    EXPECT_NE(answer["error"].value("advice", "").find("control recover"), std::string::npos) << answer;
  }
  FailingMock::fails = false;
  EXPECT_TRUE(ask("control.recover")["ok"].get<bool>());
  cell->run(0.1);
  EXPECT_EQ(state(), "held");
}

// A robot that fails in a move is behind its command. Its hardware comes back at the measured position:
// nobody has moved it.
TEST_F(Ways, AComponentThatComesBackWasNotMovedDuringTheHold) {
  build();
  begin("work.script", 0.3);
  FailingMock::pushed = -0.03;
  cell->run(0.2);
  FailingMock::fails = true;
  cell->run(0.2);
  ASSERT_EQ(state(), "fault");
  ASSERT_TRUE(ask("control.recover")["ok"].get<bool>());
  cell->run(1);
  FailingMock::fails = false;
  FailingMock::pushed = 0;
  const Json back = cell->ask({{"request", "hardware.recover"}, {"controllers", true}});
  ASSERT_TRUE(back["ok"].get<bool>()) << back;
  cell->run(1);
  const Json resumed = ask("control.resume");
  EXPECT_TRUE(resumed["ok"].get<bool>()) << resumed;
  ask("control.hold");
  cell->run(1);
  FailingMock::pushed = 0.03;
  cell->run(0.2);
  EXPECT_EQ(error_of(ask("control.resume")), "moved-while-held") << "who is pushed then is noticed";
}

// A controller may change its command a little in every cycle, also while it is held.
TEST_F(Ways, ACommandThatDriftsDuringAHoldHidesNoPush) {
  build();
  const auto places = cell->cell().joint_places();
  control::Snapshot seen = cell->cell().snapshot();
  const auto& first = places.all()[0];
  double& command = seen.commands[static_cast<std::size_t>(first.command)];
  double& measured = seen.states[static_cast<std::size_t>(first.state)];
  seen.state = control::RunState::held;
  command = measured = 0;
  cell::HeldPlace held;
  const auto hold = [&] {
    for (int i = 0; i < 500; ++i) {
      command += 1e-9;
      seen.cycle.time += 2'000'000;
      held.tick(seen, places);
    }
  };
  hold();
  EXPECT_FALSE(held.pushed());
  measured = 0.05;
  hold();
  EXPECT_TRUE(held.pushed());
  command = measured;
  hold();
  EXPECT_FALSE(held.pushed()) << "it was activated where it is";
}

// The tag says that the gripper holds. So does the output, from the first cycle on in which its hardware is
// back.
TEST_F(Ways, AnOutputIsWhatItsTagSaysWhenItsHardwareComesBack) {
  folder.write("cell.yaml", "polyarm: cell/1\nrobots:\n  arm: {model: " POLYARM_SOURCE_DIR
                            "/examples/r6bot/r6bot.urdf, hardware: touching, tool: suction_cup}\n"
                            "signals: signals.yaml\n");
  folder.write("signals.yaml", "polyarm: signals/1\ntags:\n  Vacuum: {command: arm/tool/vacuum}\n");
  build();
  const auto vacuum = cell->cell().loop().table().find_command("arm/tool/vacuum");
  ASSERT_TRUE(vacuum);
  const auto commanded = [&] { return cell->cell().snapshot().commands[*vacuum]; };
  cell->result({{"request", "tags.set"}, {"name", "Vacuum"}, {"value", true}});
  cell->run(0.1);
  ASSERT_EQ(commanded(), 1);
  FailingMock::fails = true;
  cell->run(0.2);
  ASSERT_EQ(state(), "fault");
  FailingMock::fails = false;
  ask("control.recover");
  cell->run(0.2);
  cell->result({{"request", "hardware.recover"}, {"controllers", true}});
  cell->run(0.2);
  EXPECT_EQ(commanded(), 1);
  cell->result({{"request", "tags.set"}, {"name", "Vacuum"}, {"value", false}});
  cell->run(0.2);
  EXPECT_EQ(commanded(), 0);
}

TEST_F(Ways, WhatIsNotHeldIsNotDiscardedAndSaysSo) {
  build();
  EXPECT_EQ(error_of(ask("control.discard")), "not-held");
  EXPECT_EQ(error_of(ask("control.recover")), "no-fault");
}

TEST_F(Ways, DiscardForgetsThatTheRobotWasMovedWhileHeld) {
  build();
  begin("work.script", 0.3);
  ask("control.hold");
  cell->run(2);
  FailingMock::pushed = 0.03;
  cell->run(0.2);
  ASSERT_EQ(error_of(ask("control.resume")), "moved-while-held");
  const Json discarded = ask("control.discard");
  ASSERT_TRUE(discarded["ok"].get<bool>()) << discarded;
  EXPECT_TRUE(discarded["result"]["discarded"].get<bool>());
  cell->run(1);
  EXPECT_TRUE(ask("control.resume")["ok"].get<bool>());
  cell->run(0.1);
  EXPECT_EQ(state(), "running");
}

TEST_F(Ways, AReasonComesWithTheValuesOfItsSentence) {
  build();
  begin("work.script", 0.3);
  ask("control.hold");
  cell->run(2);
  const protocol::PossibleNow held = possible_now(cell->cell().in());
  EXPECT_EQ(held.jog.at("arm")->code, "motion-held");
  EXPECT_EQ(std::get<std::string>(held.program->facts->at("cause")), "asked");
  FailingMock::pushed = 0.03;
  cell->run(0.2);
  const Json pushed = ask("control.resume")["error"]["facts"];
  EXPECT_EQ(pushed["joint"], "arm/joint_1");
  EXPECT_NEAR(pushed["moved_rad"].get<double>(), 0.03, 1e-3);
  FailingMock::pushed = 0;
  cell->run(0.2);
  ask("control.resume");
  cell->run(0.1);
  touch();
  const Json refused = ask("control.resume")["error"];
  EXPECT_EQ(refused["facts"], (Json{{"a", "arm/link_6"}, {"b", "fixture wall"}, {"depth_m", 0.002}}))
      << refused;
  FailingMock::fails = true;
  cell->run(0.1);
  EXPECT_EQ(ask("control.resume")["error"]["facts"], (Json{{"cause", "component"}}));
  EXPECT_EQ(possible_now(cell->cell().in()).jog.at("arm")->code, "fault");
}

TEST_F(Ways, AHoldOfTheProgramHasItsOwnCauseUntilTheCellRunsAgain) {
  folder.write("hold.script", "load work_data\nhold \"look at the gripper\"\nmovej A\n");
  build();
  begin("hold.script", 0.5);
  EXPECT_EQ(state(), "held");
  const Problem cause = cell->cell().stop_cause();
  EXPECT_EQ(cause.code, "program-hold");
  ASSERT_EQ(cause.facts.size(), 1u);
  EXPECT_EQ(std::get<std::string>(cause.facts[0].value), "look at the gripper");
  EXPECT_EQ(ask("health")["result"]["cause_code"], "program-hold");
  EXPECT_TRUE(ask("control.resume")["ok"].get<bool>());
  cell->run(0.3);
  ask("control.hold");
  cell->run(1);
  EXPECT_EQ(cell->cell().stop_cause().code, "asked");
}

TEST_F(Ways, AContactStopsWithItsOwnCauseAndIsBlamedOnTheMoveUnderWay) {
  build();
  begin("work.script", 0.3);  // on the way to A; B and A again are queued
  touch();
  EXPECT_EQ(state(), "held");
  EXPECT_EQ(cell->cell().snapshot().cause, control::StopCause::contact);
  ASSERT_EQ(cell->cell().stops().size(), 1u);
  EXPECT_EQ(cell->cell().stops().front().category, 1);
  EXPECT_EQ(cell->cell().stops().front().cause, "a contact");
  const Json told = contacts();
  ASSERT_EQ(told["list"].size(), 1u) << told;
  const Json& contact = told["list"][0];
  EXPECT_EQ(contact["a"], "arm/link_6");
  EXPECT_EQ(contact["b"], "fixture wall");
  EXPECT_EQ(contact["robot"], "arm");
  EXPECT_EQ(contact["doing"], "program");
  EXPECT_NE(contact["where"].get<std::string>().find("work.script:2"), std::string::npos) << contact;
  EXPECT_EQ(contact["position"], (Json{0.4, 0.1, 0.2}));
  EXPECT_DOUBLE_EQ(contact["depth"].get<double>(), 0.002);
  EXPECT_TRUE(told["touching"].get<bool>());
  const Json refused = ask("control.resume");
  EXPECT_EQ(error_of(refused), "in-contact") << refused;
  ASSERT_TRUE(ask("control.discard")["ok"].get<bool>());
  EXPECT_TRUE(cell->ask({{"request", "jog"}, {"joints", {{"joint_2", 0.002}}}, {"by", true}})["ok"].get<bool>());
  TouchingMock::touches = false;
  cell->run(1);
  EXPECT_FALSE(contacts()["touching"].get<bool>());
  EXPECT_TRUE(ask("control.resume")["ok"].get<bool>());
  cell->run(0.1);
  EXPECT_EQ(state(), "running");
}

TEST_F(Ways, AContactWhileJoggingIsTheJogsAndNoProgramsThatHasEnded) {
  build();
  begin("work.script", 30);
  ASSERT_TRUE(cell->cell().program()->ended());
  cell->give(Json{{"request", "jog"}, {"joints", {{"joint_2", 0.05}}}, {"hold", 2}});
  cell->run(0.5);
  touch();
  const Json told = contacts();
  ASSERT_EQ(told["list"].size(), 1u) << told;
  EXPECT_EQ(told["list"][0]["doing"], "jog");
  EXPECT_EQ(told["list"][0]["where"], "");
  EXPECT_EQ(state(), "held");
}

TEST_F(Ways, AContactWithARobotAtRestHasNoLineAndSaysSo) {
  folder.write("stand.script", "load work_data\nmovej A\nwait 60s\nmovej B\n");
  build();
  begin("stand.script", 20);
  ASSERT_FALSE(cell->cell().program()->ended());
  ASSERT_TRUE(cell->cell().snapshot().standing) << "it waits at A";
  touch();
  EXPECT_EQ(state(), "held");
  const Json told = contacts();
  ASSERT_EQ(told["list"].size(), 1u) << told;
  EXPECT_EQ(told["list"][0]["doing"], "rest");
  EXPECT_EQ(told["list"][0]["where"], "") << "no line moved the robot";
  EXPECT_EQ(told["list"][0]["robot"], "") << "nor did it move itself";
  EXPECT_NE(told["list"][0]["text"].get<std::string>().find("while the robot only stood there"),
            std::string::npos)
      << told;
}

// Of two robots, one rests. Nothing holds the joints of the other, so it may have moved.
TEST_F(Ways, AContactOfTwoRobotsIsNoneAtRestUnlessBothRest) {
  write_cell("  second: {model: " POLYARM_SOURCE_DIR
             "/examples/r6bot/r6bot.urdf, hardware: mock, at: [0, 2, 0]}\n");
  TouchingMock::other = "second/link_6";
  hardware::register_driver("mock",
                            [] { return std::unique_ptr<hardware::Component>(new drivers::MockComponent); });
  for (const char* expected : {"rest", "other"}) {
    build();
    if (expected == std::string("other")) {
      std::vector<std::string> names;
      const Json all = ask("control.list");
      for (const Json& each : all["result"])
        if (each["name"].get<std::string>().find("second") != std::string::npos)
          names.push_back(each["name"]);
      ASSERT_FALSE(names.empty());
      cell->ask({{"request", "control.switch"}, {"deactivate", names}});
      cell->run(0.1);
    }
    touch();
    const Json told = contacts();
    ASSERT_EQ(told["list"].size(), 1u) << told;
    EXPECT_EQ(told["list"][0]["doing"], expected) << told;
  }
}

TEST_F(Ways, ContactsAreToldAfterManyOfThem) {
  build();
  for (int k = 0; k < hardware::WorldState::kMaxFindings + 5; ++k) {
    TouchingMock::touches = true;
    cell->run(0.01);
    TouchingMock::touches = false;
    cell->run(0.01);
  }
  ask("control.resume");
  cell->run(0.5);
  ASSERT_EQ(state(), "running");
  touch();
  EXPECT_EQ(state(), "held");
  EXPECT_TRUE(contacts()["touching"].get<bool>());
  EXPECT_LE(contacts()["list"].size(), cell::ContactWatch::kKept);
}

class WaysCut : public Ways {
 protected:
  WaysCut() : Ways("contacts: {stop: 0}\n") {}
};

TEST_F(WaysCut, Category0StopsSoonerAndForgetsTheMotion) {
  build();
  begin("work.script", 0.5);
  touch();
  ASSERT_EQ(cell->cell().stops().size(), 1u);
  const cell::StopReport& stop = cell->cell().stops().front();
  EXPECT_EQ(stop.category, 0);
  EXPECT_LT(stop.time_s, 0.1);
  EXPECT_FALSE(cell->cell().motion_left());
  TouchingMock::touches = false;
  cell->run(0.5);
  EXPECT_TRUE(ask("control.resume")["ok"].get<bool>());
}

TEST_F(WaysCut, AContactBrakesHarderThanAHoldAndCategory0HarderThan1) {
  for (const double percent : {30.0, 100.0}) {
    std::map<std::string, double> way;
    for (const char* kind : {"hold", "1", "0"}) {
      write_cell("contacts: {stop: " + std::string(kind[0] == 'h' ? "1" : kind) + "}\n");
      build();
      cell->ask({{"request", "control.override"}, {"percent", percent}});
      begin("work.script", 0.5);
      if (kind[0] == 'h')
        ask("control.hold"), cell->run(2);
      else
        touch();
      ASSERT_EQ(cell->cell().stops().size(), 1u);
      const cell::StopReport& stop = cell->cell().stops().front();
      std::printf("override %g %%, %s: %s\n", percent, kind, stop.sentence().c_str());
      way[kind] = stop.tcps.empty() ? 0 : stop.tcps.front().way;
    }
    EXPECT_LT(way["1"], 0.6 * way["hold"]) << percent;
    EXPECT_LT(way["0"], way["1"]) << percent;
  }
}

}  // namespace
}  // namespace polyarm::ways_test
