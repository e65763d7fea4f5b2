#include "polyarm/program/interpreter.hpp"

#include <gtest/gtest.h>

#include "fake_host.hpp"
#include "parsed.hpp"
#include "polyarm/program/parser.hpp"

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
