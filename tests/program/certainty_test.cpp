/// What a program does with values that others change while it runs.
#include "polyarm/program/certainty.hpp"

#include <gtest/gtest.h>

#include <string>

#include "tests/program/parsed.hpp"

namespace polyarm::program {
namespace {

/// The lines whose values are known, where `Tag` is open.
std::string known(const std::string& text) {
  const Program program = parsed(text);
  const Certainty certainty(program, {"Tag", "in.part"});
  std::string out;
  for (int line = 1; line <= static_cast<int>(program.lines.size()); ++line)
    if (certainty.values_known({program.file, line, 0})) out += std::to_string(line) + " ";
  return out;
}

TEST(Certainty, OfALineThatReadsAnOpenNameOrWhatIsCalculatedFromIt) {
  EXPECT_EQ(known("let a = 1\nlet b = a + 1\nlet c = b + Tag\nlog(c)\nlog(b)\nlog(in.part)\n"), "1 2 5 ");
  EXPECT_EQ(known("let b = 1\nlog(b)\nset b = Tag\n"), "1 ") << "whatever comes first";
}

TEST(Certainty, OfANameThatIsSetByAnOpenCondition) {
  EXPECT_EQ(known("let a = 1\nif Tag\n  set a = 2\nend\nlog(a)\n"), "1 3 ");
  EXPECT_EQ(known("let a = 1\nif a == 1\n  set a = 2\nend\nlog(a)\n"), "1 2 3 5 ");
  EXPECT_EQ(known("let a = 1\nwait Tag timeout 1s else\n  set a = 2\nend\nlog(a)\n"), "1 3 ");
  EXPECT_EQ(known("let a = 1\nwhile Tag\n  set a = a + 1\nend\n"), "1 ");
  EXPECT_EQ(known("set Count = 1\nif Tag\n  set Count = 2\nend\nlog(Count)\n"), "1 3 ");
}

TEST(Certainty, WhatABlockMakesItselfIsKnownInIt) {
  EXPECT_EQ(known("while Tag\n  let y = 2\n  set y = y + 1\n  log(y)\nend\n"), "2 3 4 ");
}

TEST(Certainty, OfALoopThatAnOpenValueEnds) {
  EXPECT_EQ(known("for i in 1 .. 4\n  log(i)\nend\n"), "1 2 ");
  EXPECT_EQ(known("for i in 1 .. 4\n  if Tag\n    break\n  end\n  log(i)\nend\n"), "1 3 ");
  EXPECT_EQ(known("for i in 1 .. Tag\n  log(i)\nend\n"), "");
  EXPECT_EQ(known("for i in 1 .. 4\n  wait Tag\n  log(i)\nend\n"), "1 3 ") << "a wait ends nothing";
}

TEST(Certainty, GoesThroughFunctions) {
  EXPECT_EQ(known("func f(x)\n  return 1 / x\nend\nlog(f(0))\n"), "1 2 4 ");
  EXPECT_EQ(known("func f(x)\n  return 1 / x\nend\nlog(f(Tag))\n"), "1 ");
  EXPECT_EQ(known("func f(x, y)\n  return y\nend\nlog(f(y = 1, x = Tag))\n"), "1 2 ")
      << "the call reads it, the other parameter does not";
  EXPECT_EQ(known("func f()\n  if Tag\n    return 1\n  end\n  return 2\nend\nlog(f())\n"), "1 3 5 ");
  EXPECT_EQ(
      known("func f(i)\n  if Tag\n    raise \"no\"\n  end\nend\nfor i in 1 .. 3\n  f(i)\n  log(i)\nend\n"),
      "1 3 6 ");
}

TEST(Certainty, OfALineInAFunctionItIsJudgedByTheCall) {
  const Program program = parsed(
      "func inner(x)\n  let y = x + 1\n  log(y)\nend\nfunc outer(a, b)\n  inner(b)\nend\n"
      "outer(Tag, 1)\nouter(1, Tag)\n");
  const Certainty certainty(program, {"Tag"});
  const auto at = [&](int line) { return Location{program.file, line, 0}; };
  EXPECT_FALSE(certainty.values_known(at(3))) << "some call gives it an open value";
  EXPECT_TRUE(certainty.values_known({at(8), at(6), at(3)}));
  EXPECT_FALSE(certainty.values_known({at(9), at(6), at(3)}));
}

TEST(Certainty, WhatAPersonAnswersIsOpen) {
  EXPECT_EQ(known("let n = ask(\"How many?\", 1)\nlog(n)\n"), "");
}

bool follows(const std::string& text, int from, int to) {
  const Program program = parsed(text);
  const Certainty certainty(program, {"Tag"});
  return certainty.follows(from > 0 ? Location{program.file, from, 0} : Location{}, {program.file, to, 0});
}

TEST(Certainty, AMoveFollowsAnotherWhereNoOpenConditionHasMovesBetweenThem) {
  EXPECT_TRUE(follows("movej A\nwait Tag\nmovel B\n", 1, 3));
  EXPECT_FALSE(follows("movej A\nif Tag\n  movej C\nend\nmovel B\n", 1, 5));
  EXPECT_FALSE(follows("movej A\nif Tag\n  movej C\nend\nmovel B\n", 3, 5));
  EXPECT_TRUE(follows("movej A\nif Tag\n  log(1)\nend\nmovel B\n", 1, 5));
  EXPECT_TRUE(follows("while Tag\n  movej A\n  movel B\nend\n", 2, 3));
  EXPECT_TRUE(follows("movej A\nmovel B\nif Tag\n  movej C\nend\n", 1, 2));
  EXPECT_FALSE(follows("if Tag\n  movej C\nend\nmovel B\n", 0, 4)) << "from the start";
  EXPECT_FALSE(follows("func go()\n  movej C\nend\nmovej A\nif Tag\n  go()\nend\nmovel B\n", 4, 8));
}

}  // namespace
}  // namespace polyarm::program
