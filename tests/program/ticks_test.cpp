/// What a tick may cost, counted: however large its values and long its lines, a program takes little more
/// than its budget, and does what it says all the same.
#include <gtest/gtest.h>

#include <algorithm>
#include <ostream>
#include <string>
#include <vector>

#include "polyarm/language/parser.hpp"
#include "polyarm/vm/large_work.hpp"
#include "tests/program/fake_host.hpp"

namespace polyarm::program {
namespace {

constexpr int kBudget = 200;
/// A piece of work, an error, or the longest run of steps without a look at the budget.
constexpr int kMostBeyond = 260;

struct Ticks {
  int count = 0, dearest = 0;
  std::vector<std::string> logs;
  TaskState state = TaskState::running;
};

Ticks run(const std::string& text, int most = 20000) {
  FakeHost host;
  Problems problems;
  Interpreter interpreter(parse(text, "t.script", problems), host);
  problems.throw_if_errors();
  Ticks out;
  while ((out.state == TaskState::running || out.state == TaskState::waiting) && out.count < most) {
    const StepResult result = interpreter.step(kBudget);
    out.state = result.state;
    out.dearest = std::max(out.dearest, result.executed);
    ++out.count;
    host.time += 2'000'000;
  }
  for (const auto& [line, log] : host.logs) out.logs.push_back(log);
  return out;
}

const std::string kNumbers = "let l = []\nfor i in 1 .. 9000\n  set l = l + [i]\nend\n";
const std::string kPoints = "let p = pallet(pose(), pose(x = 1m), pose(y = 1m), rows = 90, cols = 100)\n";

struct Large {
  std::string name;
  std::string text;
  const char* log;
  int least;  ///< ticks that it takes
};

void PrintTo(const Large& large, std::ostream* out) {
  *out << large.text;
}

class LargeValues : public testing::TestWithParam<Large> {};

TEST_P(LargeValues, AreWorkedOnInPieces) {
  const Ticks ticks = run(GetParam().text);
  EXPECT_EQ(ticks.state, TaskState::finished);
  EXPECT_EQ(ticks.logs, std::vector<std::string>{GetParam().log});
  EXPECT_LE(ticks.dearest, kBudget + kMostBeyond);
  EXPECT_GE(ticks.count, GetParam().least);
}

std::string long_list() {
  std::string out = "let l = [0";
  for (int i = 1; i < 9000; ++i) out += ", " + std::to_string(i);
  return out + "]\nlog(l[9000] + length(l))\n";
}

const Large kLarge[] = {
    {"Pallet", kPoints + "log(length(p), p[9000].x)\n", "9000 1m", 30},
    {"CopyOfNumbers", kNumbers + "let k = l\nset k[1] = 5\nlog(k[1], l[1], k[9000])\n", "5 1 9000", 46},
    {"CopyOfPoints", kPoints + "let k = p\nset k[1] = pose(x = 3m)\nlog(k[1].x, p[1].x)\n", "3m 0m", 40},
    {"Sum", kNumbers + "let k = [7] + l\nlog(k[1], k[9001])\n", "7 9000", 46},
    {"SumInPlace", kNumbers + "let k = [7]\nset k = k + l\nlog(k[1], k[9001])\n", "7 9000", 46},
    {"AppendToOneThatIsShared", kNumbers + "let k = l\nset k = k + [1]\nlog(length(k), length(l))\n",
     "9001 9000", 46},
    {"Equality", kNumbers + "let k = [] + l\nlet same = k == l\nset k[9000] = 0\nlog(same, k == l, k != l)\n",
     "True False True", 49},
    {"EqualityThatJumps", kPoints + "let k = [] + p\nif k == p\n  log(\"same\")\nend\n", "same", 45},
    {"PartsOfParts",
     kNumbers + "let w = [l]\nlet k = w\nset k[1][2] = 5\nlog(k[1][2], w[1][2], l[2], k[1][9000])\n",
     "5 2 2 9000", 46},
    {"PartsOfRecords", kNumbers + "let w = {x = l}\nset w.x[2] = 5\nlog(w.x[2], l[2])\n", "5 2", 46},
    {"ListInAList", kNumbers + "let w = [0, [1]]\nset w[2] = l\nlog(length(w[2]), w[2][7])\n", "9000 7", 45},
    {"ErrorAboutAList",
     kNumbers + "let n = 0\ntry\n  set n = l\non error e\n  log(length(e.text) < 200)\nend\n", "True", 45},
    {"TextOfAList", kNumbers + "let t = \"{l}\"\nlog(length(t))\n", "52893", 60},
    {"LongLine", long_list(), "17999", 2},
    {"DeepCalls",
     "func deep(n)\n  if n == 0\n    return 0\n  end\n  return 1 + deep(n - 1)\nend\nlog(deep(190))\n", "190",
     2},
    {"Errors",
     "let n = 0\nwhile n < 100\n  try\n    raise \"x\"\n  on error e\n    set n = n + 1\n  "
     "end\nend\nlog(n)\n",
     "100", 20},
};

INSTANTIATE_TEST_SUITE_P(All, LargeValues, testing::ValuesIn(kLarge),
                         [](const auto& named) { return named.param.name; });

TEST(Ticks, ListsThatWouldBeTooLargeAreRefusedBeforeTheyAreMade) {
  const Ticks ticks = run(kNumbers + "try\n  set l = l + l\non error e\n  log(e.text, length(l))\nend\n");
  EXPECT_EQ(ticks.logs, std::vector<std::string>{"this list would hold more than 10000 values 9000"});
  const Ticks inside =
      run(kNumbers +
          "let w = [[1], [2], l]\ntry\n  set w[1] = l\non error e\n  log(e.text, length(w[1]))\n"
          "end\n");
  EXPECT_EQ(inside.logs, std::vector<std::string>{"this list would hold more than 10000 values 1"});
}

/// Steps `from` until the copy is under way.
void step_into_the_copy(Interpreter& from, FakeHost& host) {
  constexpr int kSmall = 20;
  while (host.logs.empty()) from.step(kSmall);
  from.step(kSmall);
  ASSERT_EQ(from.status().front().where.line, 7);
}

const std::string kCopy = kNumbers + "let k = l\nlog(\"now\")\nset k[3] = 1\nlog(k[3], l[3], length(k))\n";

TEST(Ticks, WorkOnALargeListIsDoneAgainWhereItWasWrittenDownInTheMiddle) {
  FakeHost host;
  Problems problems;
  Interpreter interrupted(parse(kCopy, "t.script", problems), host);
  step_into_the_copy(interrupted, host);
  ASSERT_TRUE(interrupted.safe());
  Interpreter again(parse(kCopy, "t.script", problems), host);
  again.restore(interrupted.save());
  while (again.state() == TaskState::running) again.step(kBudget);
  EXPECT_EQ(host.logs.back().second, "1 3 9000");
}

TEST(Ticks, AnotherValueForTheListThatIsCopiedIsNotLost) {
  FakeHost host;
  host.store.declare_tag("Now", false);
  const std::string text = "let g = [1]\nwhen Now\n  set g = [5, 6]\nend\n" + kNumbers +
                           "let k = [] + l\nset g = l\nlog(\"now\")\nset g[3] = 1\nlog(length(g), l[3])\n";
  Problems problems;
  Interpreter interpreter(parse(text, "t.script", problems), host);
  while (host.logs.empty()) interpreter.step(20), host.time += 1;
  interpreter.step(20);
  host.time += 1;
  host.store.set("Now", true, "plc");
  while (interpreter.step(20).state == TaskState::running) host.time += 1;
  EXPECT_EQ(interpreter.state(), TaskState::failed) << "the list has two values now, and no third place";
  EXPECT_EQ(interpreter.overview().problem->what, "there is no element 3 in a list of 2");
}

TEST(Ticks, WhensShareWhatATickMayTakeBeyond) {
  std::string text;
  for (int i = 0; i < 20; ++i)
    text += "when true\n  let x = 0\n  for i in 1 .. 40\n    set x = x + i\n  end\nend\n";
  const Ticks ticks = run(text + "wait 10ms\n");
  EXPECT_EQ(ticks.state, TaskState::failed);
}

}  // namespace
}  // namespace polyarm::program
