#include "polyarm/vm/interpreter.hpp"

#include <gtest/gtest.h>

#include "fake_host.hpp"
#include "parsed.hpp"
#include "polyarm/language/parser.hpp"

namespace polyarm::program {
namespace {

TEST(Interpreter, TakesNoMoreStepsThanItsBudget) {
  FakeHost host;
  Interpreter interpreter(parsed("let x = 0\nwhile true\nset x = 1\nend\n"), host);
  const StepResult result = interpreter.step(50);
  EXPECT_EQ(result.executed, 50);
  EXPECT_EQ(result.state, TaskState::running);
}

TEST(Interpreter, WaitsOnlyAfterTheMoveHasEnded) {
  FakeHost host;
  host.store.declare_tag("Home", data::Point{});
  host.store.declare_tag("Vacuum", false);
  Interpreter interpreter(parsed("moveto Home\nset Vacuum True\n"), host);
  interpreter.step(100);
  EXPECT_EQ(interpreter.status().front().waiting.kind, WaitKind::move);
  EXPECT_EQ(interpreter.status().front().waiting.text, "Home");
  EXPECT_TRUE(host.sets.empty());
  host.time = host.move_time;
  EXPECT_EQ(interpreter.step(100).state, TaskState::finished);
  EXPECT_EQ(host.sets, std::vector<std::string>{"Vacuum=True"});
}

TEST(Interpreter, TellsLineAndNamesOfWhatItWaitsFor) {
  FakeHost host;
  host.store.declare_tag("A", false);
  host.store.declare_tag("B", 1);
  Interpreter interpreter(parsed("\n  let mine = 2\n  wait A or B == mine\n"), host);
  EXPECT_EQ(interpreter.step(100).state, TaskState::waiting);
  const TaskStatus status = interpreter.status().front();
  EXPECT_EQ(status.where.text(), "test.script:3:3");
  EXPECT_EQ(status.source, "wait A or B == mine");
  EXPECT_EQ(status.waiting.names, (std::vector<std::string>{"A", "B"}));
  host.store.set("B", 2, "plc");
  EXPECT_EQ(interpreter.step(100).state, TaskState::finished);
}

TEST(Interpreter, WaitsForTheTimeItSays) {
  FakeHost host;
  host.time = 7;
  Interpreter interpreter(parsed("wait 500ms\nlog(\"x\")\n"), host);
  interpreter.step(100);
  EXPECT_EQ(interpreter.status().front().waiting.until, 500'000'007);
  host.time = 500'000'006;
  EXPECT_EQ(interpreter.step(100).state, TaskState::waiting);
  host.time = 500'000'007;
  EXPECT_EQ(interpreter.step(100).state, TaskState::finished);
}

TEST(Interpreter, AnErrorThatIsPassedOnNamesLineAndColumn) {
  FakeHost host;
  Interpreter interpreter(parsed("try\n  raise \"a\"\non error e\n  retry 1\nend\n"), host);
  EXPECT_EQ(interpreter.step(1000).state, TaskState::failed);
  EXPECT_EQ(interpreter.overview().problem->where.text(), "test.script:2:3");
}

TEST(Interpreter, IsInTheLineOfAHoldUntilTheCellGoesOn) {
  FakeHost host;
  Interpreter interpreter(parsed("hold \"look\"\nlog(1)\n"), host);
  interpreter.step(100);
  EXPECT_EQ(interpreter.overview().where.line, 1);
  EXPECT_TRUE(host.logs.empty());
  host.time += 2'000'000;
  EXPECT_EQ(interpreter.step(100).state, TaskState::finished);
  EXPECT_EQ(host.logs.size(), 1u);
}

TEST(Interpreter, AQuestionSaysItsDefaultAndWhyAnAnswerWasRefused) {
  FakeHost host;
  host.given_answers = {"abc"};
  Interpreter interpreter(parsed("log(ask(\"How deep?\", 40mm))\n"), host);
  interpreter.step(100);
  EXPECT_EQ(interpreter.status().front().waiting.note, "Enter alone means 0.04m");
  host.time += 20'000'000;
  interpreter.step(100);
  EXPECT_EQ(interpreter.status().front().waiting.note, "the answer is a length, such as 0.04m");
}

TEST(Interpreter, AsksTheUserAndGoesOnWithTheAnswer) {
  FakeHost host;
  host.answers = false;
  Interpreter interpreter(parsed("wait user \"tray in place?\"\nwait input\n"), host);
  run(interpreter, host, nanoseconds(1));
  EXPECT_EQ(interpreter.state(), TaskState::waiting);
  EXPECT_EQ(interpreter.status().front().waiting.text, "tray in place?");
  host.answers = true;
  EXPECT_EQ(run(interpreter, host).state, TaskState::finished);
  EXPECT_EQ(host.questions, (std::vector<std::string>{"tray in place?", ""}));
}

TEST(Interpreter, WaitUserIsAVariableWhereOneHasThatName) {
  FakeHost host;
  host.store.declare_tag("user", true);
  Interpreter interpreter(parsed("wait user\n"), host);
  EXPECT_EQ(run(interpreter, host).state, TaskState::finished);
  EXPECT_TRUE(host.questions.empty());
}

TEST(Interpreter, EndsAfterTheWantedPassesAndClearsTheCondition) {
  FakeHost host;
  host.store.declare_tag("Repeat", true);
  Interpreter interpreter(parsed("while Repeat\nfor i in 1 .. 3\nlog(i)\nend\nend\nlog(\"end\")\n"), host);
  interpreter.limit_passes(2);
  EXPECT_EQ(run(interpreter, host).state, TaskState::finished);
  EXPECT_EQ(host.logs.size(), 7u);
  EXPECT_EQ(host.sets, std::vector<std::string>{"Repeat=False"});
}

TEST(Interpreter, CountsAPassThatContinueCutShort) {
  FakeHost host;
  Interpreter interpreter(parsed("while true\nlog(1)\ncontinue\nend\n"), host);
  interpreter.limit_passes(3);
  EXPECT_EQ(run(interpreter, host).state, TaskState::finished);
  EXPECT_EQ(host.logs.size(), 3u);
}

TEST(Interpreter, SaysTheLineThatItWaitsIn) {
  FakeHost host;
  host.store.declare_tag("Ready", false);
  Interpreter interpreter(parsed("wait 1s\nlog(1)\nwait time 2\nwait Ready\nlog(2)\n"), host);
  interpreter.step(100);
  EXPECT_EQ(interpreter.overview().where.line, 1);
  EXPECT_EQ(interpreter.overview().source, "wait 1s");
  EXPECT_EQ(interpreter.position().line, 1);
  host.time = nanoseconds(1);
  interpreter.step(100);
  EXPECT_EQ(interpreter.overview().where.line, 3);
  host.time = nanoseconds(3);
  interpreter.step(100);
  EXPECT_EQ(interpreter.overview().where.line, 4);
  interpreter.stop();
  EXPECT_EQ(interpreter.overview().where.line, 4) << "where it was stopped";
}

/// Moves arrive one after the other; which of them is under way the host knows.
class HostWithMotion : public FakeHost {
 public:
  bool under_way(Handle handle) const override { return travel(handle).left > 0; }
};

TEST(Interpreter, SaysTheLineOfTheMoveUnderWayNotOfTheOneItQueues) {
  HostWithMotion host;
  for (const char* point : {"A", "B", "C"}) host.store.set(point, data::Point{}, "test");
  Interpreter interpreter(parsed("movej A\nmovej B\nlet x = 1\nmovej C\nwait 1s\nmoveto A\nlog(x)\n"), host);
  std::vector<int> lines;
  interpreter.on_wait_over([&] { lines.push_back(interpreter.overview().where.line); });
  for (int tick = 0; tick < 2000 && interpreter.state() != TaskState::finished; ++tick) {
    interpreter.step(100);
    lines.push_back(interpreter.overview().where.line);
    host.time += 2'000'000;
  }
  lines.erase(std::unique(lines.begin(), lines.end()), lines.end());
  EXPECT_EQ(lines, (std::vector<int>{1, 2, 4, 5, 6, 7}));
}

/// A task that watches makes a pass each tick.
TEST(Interpreter, CountsTheCyclesOfTasksThatMoveNotOfThoseThatWatch) {
  HostWithMotion host;
  for (const char* point : {"A", "B"}) host.store.set(point, data::Point{}, "test");
  host.store.declare_tag("Part", false);
  Interpreter interpreter(parsed("task watcher\nwhile true\nwait 10ms\nend\nend\n"
                                 "task belt\nwhile true\nwait 30ms\nset Part = not Part\nend\nend\n"
                                 "task arm\nwait 50ms\nwhile true\nmovej A\nmovej B\nwait 1s\nend\nend\n"),
                          host);
  std::uint64_t before_it_moved = 0, waits = 0;
  for (int tick = 0; tick < 1500; ++tick) {
    interpreter.step(100);
    if (host.moves.empty()) before_it_moved = std::max(before_it_moved, interpreter.overview().cycles);
    waits = interpreter.overview().cycles;
    host.time += 2'000'000;
  }
  EXPECT_EQ(before_it_moved, 0u);
  EXPECT_EQ(waits, 2u) << "each takes 1.2 s of the 3 s";
  for (const TaskStatus& task : interpreter.status())
    EXPECT_TRUE(task.name != "watcher" || task.cycles > 100u) << "each task has its own count";
}

/// The parts of a `together` are gone when they have ended.
TEST(Interpreter, CountsTheCyclesOfTasksWhosePartsMove) {
  HostWithMotion host;
  for (const char* point : {"A", "B"}) host.store.set(point, data::Point{}, "test");
  Interpreter interpreter(
      parsed("task arm\nwhile true\ntogether\nmovej A\nwait 100ms\nend\nwait 1s\nend\nend\n"
             "task watcher\nwhile true\nwait 10ms\nend\nend\n"),
      host);
  std::uint64_t before = 0;
  for (int tick = 0; tick < 3000; ++tick) {
    interpreter.step(100);
    const std::uint64_t now = interpreter.overview().cycles;
    EXPECT_GE(now, before);
    before = now;
    host.time += 2'000'000;
  }
  EXPECT_GE(before, 2u);
  EXPECT_LE(before, 6u);
}

TEST(Interpreter, AProgramWithoutALoopThatHasFinishedCountsOnePass) {
  FakeHost host;
  Interpreter once(parsed("log(1)\n"), host), looped(parsed("while true\nlog(1)\nend\n"), host),
      stopped(parsed("log(1)\nstop\n"), host);
  looped.limit_passes(3);
  EXPECT_EQ(once.overview().passes, 0u);
  run(once, host);
  run(looped, host);
  run(stopped, host);
  EXPECT_EQ(once.overview().passes, 1u);
  EXPECT_EQ(looped.overview().passes, 3u);
  EXPECT_EQ(stopped.overview().passes, 0u);
}

/// A host whose names others see.
class SharingHost : public FakeHost {
 public:
  void end_loop(const std::string&, const Location&) override {}
};

TEST(Interpreter, EndsAfterTheWantedPassesWhereItMayNotClearTheCondition) {
  SharingHost host;
  host.store.declare_tag("Repeat", true);
  Interpreter interpreter(parsed("while Repeat\nlog(1)\nend\nlog(\"end\")\n"), host);
  interpreter.limit_passes(2);
  EXPECT_EQ(run(interpreter, host).state, TaskState::finished);
  EXPECT_EQ(host.logs.size(), 3u);
  EXPECT_TRUE(host.sets.empty());
}

TEST(Interpreter, UntilIsLookedAtWhileAnotherRobotStillMoves) {
  FakeHost host;
  for (const char* name : {"A", "B"}) host.store.declare_tag(name, data::Point{});
  host.store.declare_tag("Contact", false);
  Interpreter interpreter(
      parsed("movej A, robot left\nmovel B, robot right, until Contact\nlog(met())\n"), host);
  interpreter.step(100);
  EXPECT_EQ(interpreter.status().front().waiting.kind, WaitKind::until);
  host.time = nanoseconds(0.01);
  host.store.set("Contact", true, "plc");
  interpreter.step(100);
  EXPECT_EQ(host.ended_moves, std::vector<std::string>{"B"});
}

TEST(Interpreter, AMoveDoesNotGoOnWithoutItsUntil) {
  FakeHost host;
  for (const char* name : {"A", "B"}) host.store.declare_tag(name, data::Point{});
  host.store.declare_tag("Zero", 0);
  Interpreter interpreter(
      parsed("try\nmovel B, until 1 / Zero > 1\non error e\nlog(e.kind)\nend\n"), host);
  EXPECT_EQ(run(interpreter, host).state, TaskState::finished);
  EXPECT_EQ(host.ended_moves, std::vector<std::string>{"B"});
  EXPECT_EQ(host.logs.size(), 1u);
}

TEST(Interpreter, DoesNothingAfterStop) {
  FakeHost host;
  Interpreter interpreter(parsed("while true\nlog(1)\nwait 1s\nend\n"), host);
  interpreter.step(100);
  interpreter.stop();
  host.time = nanoseconds(10);
  EXPECT_EQ(interpreter.step(100).state, TaskState::stopped);
  EXPECT_EQ(host.logs.size(), 1u);
}

TEST(Interpreter, FailsWithThePlaceOfTheLine) {
  FakeHost host;
  Interpreter interpreter(parsed("log(1)\nload nowhere\n"), host);
  host.folder = POLYARM_SOURCE_DIR "/tests/program/thesis/sorting";
  EXPECT_EQ(run(interpreter, host).state, TaskState::failed);
  EXPECT_EQ(interpreter.status().front().problem->where.text(), "test.script:2:1");
}

TEST(Interpreter, SameInputsGiveTheSameRun) {
  const auto once = [] {
    FakeHost host;
    host.store.declare_tag("Go", false);
    Interpreter interpreter(
        parsed("while true\nwait Go timeout 30ms else\nlog(\"late\")\nend\nwait 7ms\nend\n"), host);
    int ticks = 0;
    run(interpreter, host, nanoseconds(2), [&] { host.store.set("Go", ++ticks % 37 == 0, "plc"); });
    return host.logs.size();
  };
  EXPECT_EQ(once(), once());
  EXPECT_GT(once(), 10u);
}

}  // namespace
}  // namespace polyarm::program
