/// What a program calls robots, tools, frames and tags is of its cell.
#include <gtest/gtest.h>

#include <string>

#include "polyarm/program/checker.hpp"
#include "tests/program/parsed.hpp"

namespace polyarm::program {
namespace {

std::string found(const std::string& text, bool with_robots = true) {
  KnownNames known;
  known.names = {{"P", {data::Kind::pose, {}}},       {"Nozzle", {data::Kind::pose, {}}},
                 {"Count", {data::Kind::number, {}}}, {"Held", {data::Kind::boolean, {}}},
                 {"Lamp", {data::Kind::boolean, {}}}, {"Home", {data::Kind::joints, {}}},
                 {"Go", {data::Kind::boolean, {}}}};
  known.measured = {"Held"};
  known.brought = {{"Go", "plc"}};
  if (with_robots) known.robots = KnownNames::Robots{{"left", "right"}, {"suction_cup", "cup.yaml"}};
  Problems problems;
  check(parsed(text), known, problems);
  std::string out;
  for (const Problem& p : problems.list())
    out += std::to_string(p.where.line) + ":" + std::to_string(p.where.column) + " " + p.code + " " + p.what +
           "\n";
  return out;
}

TEST(CellNames, ARobotToolOrFrameThatTheCellDoesNotHaveIsAnError) {
  EXPECT_EQ(found("wait Held\nmovel P, robot lefft\n"),
            "2:16 unknown-robot the cell has no robot 'lefft'; did you mean 'left'?\n");
  EXPECT_EQ(found("movel P, robot left, tool Nozle\n"),
            "1:27 unknown-tool the cell has no tool 'Nozle'; did you mean 'Nozzle'?\n");
  EXPECT_EQ(found("use robot left, frame \"left/tpc\"\nmovel P\n"),
            "1:23 unknown-frame the cell has no frame 'left/tpc'; did you mean 'left/tcp'?\n");
  EXPECT_EQ(found("func f(p)\n  movel p, robot left, tool Count\nend\nf(P)\n"),
            "2:29 unknown-tool the cell has no tool 'Count'\n");
}

TEST(CellNames, WhatTheCellOrTheProgramHasIsRight) {
  EXPECT_EQ(
      found("movel P, robot left, tool Nozzle, frame P\nmovel P, robot right, tool suction_cup, frame world\n"
            "movel P, robot right, tool tool0, frame base\nmovel P, robot left, tool \"cup.yaml\", frame "
            "\"right/base\"\n"),
      "");
  EXPECT_EQ(found("let which = \"left\"\nlet tip = Nozzle\nmovel P, robot which, tool tip, frame pose(1m)\n"),
            "");
  EXPECT_EQ(found("func f(r, t)\n  movel P, robot r, tool t\nend\nf(\"left\", \"tool0\")\n"), "");
  EXPECT_EQ(found("movel P, robot any, tool other, frame third\n", false), "") << "nobody knows the cell";
}

TEST(CellNames, NoProgramSetsWhatTheHardwareMeasures) {
  const std::string text = " read-only 'Held' is a measured value of the hardware; a program cannot set it\n";
  EXPECT_EQ(found("set Held = true\n"), "1:5" + text);
  EXPECT_EQ(found("set Held True\n"), "1:5" + text);
  EXPECT_EQ(found("when Lamp\n  set Held = false\nend\n"), "2:7" + text);
  EXPECT_EQ(found("movel P, at end - 10mm set Held = true\n"), "1:10" + text);
  EXPECT_EQ(found("set Lamp = Held\nwait Held\n"), "");
  EXPECT_EQ(
      found("func f(Held)\n  set Held = false\n  return Held\nend\nset Lamp = f(true)\n").find("read-only"),
      std::string::npos)
      << "a name of its own";
  EXPECT_EQ(found("test \"a sensor\"\n  set Held = true\n  run\nend\n"), "") << "a test is the far side";
}

TEST(CellNames, AProgramThatSetsWhatALinkBringsIsWarned) {
  const std::string text = 
      " read-only 'Go' comes from the link 'plc': what a program sets holds until the other side changes it\n";
  EXPECT_EQ(found("set Go = true\n"), "1:5" + text);
  EXPECT_EQ(found("set Go True\n"), "1:5" + text);
  EXPECT_EQ(found("movel P, at end - 10mm set Go = true\n"), "1:10" + text);
  EXPECT_EQ(found("let Go = false\nset Go = true\n").find("read-only"), std::string::npos);
  EXPECT_EQ(found("test \"a PLC\"\n  set Go = true\n  run\nend\n"), "");
}

}  // namespace
}  // namespace polyarm::program
