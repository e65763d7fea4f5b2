/// Breakpoints, steps, and programs that begin in the middle.
#include <gtest/gtest.h>

#include "fake_host.hpp"
#include "parsed.hpp"
#include "polyarm/language/parser.hpp"

namespace polyarm::program {
namespace {

const char* const kCalls =
    "func twice(x)\n"       // 1
    "  let y = x * 2\n"     // 2
    "  return y\n"          // 3
    "end\n"                 // 4
    "let a = 1\n"           // 5
    "for i in 1 .. 2\n"     // 6
    "  let b = twice(a)\n"  // 7
    "  log(b + i)\n"        // 8
    "end\n"                 // 9
    "log(\"end\")\n";       // 10

int line_of(const Interpreter& interpreter) {
  return interpreter.overview().where.line;
}

TEST(Debugging, PausesInFrontOfABreakpointEachTime) {
  FakeHost host;
  Interpreter interpreter(parsed(kCalls), host);
  EXPECT_EQ(interpreter.set_breakpoints({{"test.script", 8, 0}}).front().line, 8);
  for (int pass = 1; pass <= 2; ++pass) {
    run(interpreter, host, host.time + 10'000'000);
    ASSERT_TRUE(interpreter.paused());
    EXPECT_EQ(line_of(interpreter), 8);
    EXPECT_EQ(host.logs.size(), static_cast<std::size_t>(pass - 1));
    interpreter.resume();
  }
  EXPECT_EQ(run(interpreter, host).state, TaskState::finished);
  EXPECT_EQ(host.logs.size(), 3u);
}

TEST(Debugging, ABreakpointMovesDownToTheNextStatement) {
  FakeHost host;
  Interpreter interpreter(parsed(kCalls), host);
  EXPECT_EQ(interpreter.set_breakpoints({{"test.script", 9, 0}}).front().line, 10);
  EXPECT_TRUE(interpreter.set_breakpoints({{"test.script", 11, 0}}).empty());
}

TEST(Debugging, TheTaskThatStandsPausedIsTheOneThatIsShown) {
  FakeHost host;
  Interpreter interpreter(parsed("task one\n"
                                 "  wait 5s\n"
                                 "end\n"
                                 "task two\n"
                                 "  wait 10ms\n"
                                 "  log(2)\n"
                                 "end\n"),
                          host);
  interpreter.set_breakpoints({{"test.script", 6, 0}});
  run(interpreter, host, host.time + 100'000'000);
  ASSERT_TRUE(interpreter.paused());
  EXPECT_EQ(line_of(interpreter), 6);
  EXPECT_EQ(interpreter.position().line, 6);
  EXPECT_TRUE(interpreter.overview().paused);
  interpreter.resume();
  run(interpreter, host, host.time + 100'000'000);
  EXPECT_EQ(line_of(interpreter), 2);
}

TEST(Debugging, DoesNothingWhilePaused) {
  FakeHost host;
  Interpreter interpreter(parsed(kCalls), host);
  interpreter.pause();
  interpreter.step(100);
  EXPECT_TRUE(interpreter.paused());
  EXPECT_EQ(interpreter.step(100).executed, 0);
  EXPECT_EQ(interpreter.state(), TaskState::running);
  interpreter.stop();
  EXPECT_EQ(interpreter.step(100).state, TaskState::stopped);
}

TEST(Debugging, StepsIntoOverAndOutOfFunctions) {
  FakeHost host;
  Interpreter interpreter(parsed(kCalls), host);
  interpreter.set_breakpoints({{"test.script", 7, 0}});
  interpreter.step(100);
  ASSERT_EQ(line_of(interpreter), 7);
  interpreter.resume_for(StepKind::into);
  interpreter.step(100);
  EXPECT_EQ(line_of(interpreter), 2);
  EXPECT_EQ(interpreter.calls("main").size(), 2u);
  EXPECT_EQ(interpreter.calls("main").front().line, 7);
  interpreter.resume_for(StepKind::over);
  interpreter.step(100);
  EXPECT_EQ(line_of(interpreter), 3);
  interpreter.resume_for(StepKind::out);
  interpreter.step(100);
  EXPECT_EQ(line_of(interpreter), 8);
  interpreter.set_breakpoints({});
  interpreter.resume_for(StepKind::over);
  interpreter.step(100);
  EXPECT_EQ(line_of(interpreter), 6);
  interpreter.resume_for(StepKind::over);
  interpreter.step(100);
  interpreter.resume_for(StepKind::over);
  interpreter.step(100);
  EXPECT_EQ(line_of(interpreter), 8) << "the call in line 7 was stepped over";
}

TEST(Debugging, StepsOutOfATrapIntoTheTaskThatItInterrupts) {
  FakeHost host;
  host.store.declare_tag("A", data::Point{});
  host.store.declare_tag("Stop", false);
  Interpreter interpreter(parsed("trap when Stop\nlog(1)\nend\nmoveto A\nlog(2)\nlog(3)\n"), host);
  interpreter.set_breakpoints({{"test.script", 2, 0}});
  interpreter.step(100);
  host.store.set("Stop", true, "plc");
  run(interpreter, host, host.time + 100'000'000);
  ASSERT_TRUE(interpreter.paused());
  ASSERT_EQ(line_of(interpreter), 2);
  interpreter.resume_for(StepKind::over);
  run(interpreter, host, host.time + 60'000'000'000);
  EXPECT_TRUE(interpreter.paused()) << "it does not run on by itself";
  EXPECT_EQ(line_of(interpreter), 5);
}

TEST(Debugging, ShowsTheNamesThatHold) {
  FakeHost host;
  Interpreter interpreter(parsed(kCalls), host);
  interpreter.set_breakpoints({{"test.script", 3, 0}, {"test.script", 8, 0}});
  interpreter.step(100);
  const auto shown = [&] {
    std::string out;
    for (const VariableValue& each : interpreter.variables("main"))
      out += each.name + "=" + each.value.text() + " ";
    return out;
  };
  EXPECT_EQ(shown(), "x=1 y=2 a=1 ");
  interpreter.resume();
  interpreter.step(100);
  EXPECT_EQ(shown(), "i=1 b=2 a=1 ");
}

TEST(Debugging, BeginsAtALineWithTheNamesAndUsesBeforeIt) {
  FakeHost host;
  host.store.declare_tag("A", data::Point{});
  host.store.declare_tag("Open", false);
  host.store.declare_tag("Count", 0);
  Interpreter interpreter(parsed("let n = 2\n"
                                 "use tool gripper, robot left\n"
                                 "movel A\n"
                                 "set Open = true\n"
                                 "while Count < n\n"
                                 "  set Count = Count + 1\n"
                                 "  movel A\n"
                                 "end\n"),
                          host);
  const StartReport report = interpreter.start_at(7);
  EXPECT_EQ(report.tool, "gripper");
  EXPECT_EQ(report.robot, "left");
  EXPECT_EQ(report.last_point, "A");
  EXPECT_EQ(report.sets, (std::vector<std::string>{"Count", "Open"}));
  EXPECT_EQ(run(interpreter, host).state, TaskState::finished);
  EXPECT_EQ(host.asked.size(), 3u);
  EXPECT_EQ(host.asked.front().second, "line A robot left tool gripper exact");
  EXPECT_EQ(*host.store.find("Open"), data::Value(false));
}

TEST(Debugging, RefusesToBeginWhereABlockMakesWhatIsNeeded) {
  FakeHost host;
  for (const int line : {1, 2, 3, 7, 8}) {
    Interpreter interpreter(parsed(kCalls), host);
    EXPECT_THROW(interpreter.start_at(line), Error) << line;
  }
}

TEST(Debugging, AStopIsNoErrorOfTheProgram) {
  FakeHost host;
  host.store.declare_tag("A", data::Point{});
  Interpreter interpreter(parsed("try\nmoveto A\non error\nlog(\"handled\")\nend\n"), host);
  interpreter.step(100);
  host.dropped = true;
  EXPECT_EQ(run(interpreter, host).state, TaskState::failed);
  EXPECT_TRUE(host.logs.empty());
  EXPECT_EQ(interpreter.overview().problem->code, "discarded");
}

TEST(Debugging, AStopIsNoErrorOfThePartsOfATogether) {
  for (const char* parts : {"movej A, robot left\nmovej A, robot right\n", "movej A\nwait 1s\n"}) {
    FakeHost host;
    host.store.declare_tag("A", data::Point{});
    Interpreter interpreter(
        parsed(std::string("try\ntogether\n") + parts + "end\non error\nlog(\"handled\")\nend\n"), host);
    interpreter.step(100);
    host.dropped = true;
    EXPECT_EQ(run(interpreter, host).state, TaskState::failed) << parts;
    EXPECT_TRUE(host.logs.empty()) << parts;
    EXPECT_EQ(interpreter.overview().problem->code, "discarded") << parts;
  }
}

TEST(Motion, QueuesNoMoreThanThereIsRoomFor) {
  FakeHost host;
  host.room = 3;
  host.store.declare_tag("A", data::Point{});
  Interpreter interpreter(parsed("for i in 1 .. 20\nmovel A, blend 1mm\nend\n"), host);
  EXPECT_EQ(run(interpreter, host).state, TaskState::finished);
  EXPECT_EQ(host.asked.size(), 20u);
  EXPECT_LE(host.most_open, 3u);
}

TEST(Motion, OnStopRunsWhenTheRobotsStand) {
  FakeHost host;
  host.store.declare_tag("A", data::Point{});
  Interpreter interpreter(parsed("movel A\nwhile true\nend\non stop\nlog(\"clean\")\nend\n"), host);
  interpreter.step(10);
  interpreter.stop();
  EXPECT_EQ(interpreter.step(10).state, TaskState::waiting);
  EXPECT_TRUE(host.logs.empty());
  host.time = host.move_time;
  EXPECT_EQ(interpreter.step(10).state, TaskState::stopped);
  EXPECT_EQ(host.logs.size(), 1u);
}

}  // namespace
}  // namespace polyarm::program
