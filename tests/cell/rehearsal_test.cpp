/// What `polyarm check` says about the ways of a program's moves.
#include "polyarm/cell/rehearsal.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "polyarm/cell/cell_file.hpp"
#include "polyarm/cell/check.hpp"
#include "tests/support/lock_step_cell.hpp"

namespace polyarm::cell {
namespace {

const std::string kBend = "moveto joints(0, -30deg, 60deg, 0, 60deg, 0)\nlet start = here()\n";

struct Found {
  CheckResult result;
  std::string texts;
};
Found checked(const std::string& program, const std::string& more = "", const std::string& robots = "") {
  hardware::register_driver("mock",
                            [] { return std::unique_ptr<hardware::Component>(new drivers::MockComponent); });
  const test::Folder folder;
  folder.write("go.script", program);
  folder.write("tags.yaml", "polyarm: signals/1\ntags:\n  Ready: {initial: False}\n");
  folder.write("cell.yaml",
               "polyarm: cell/1\nrobots:\n" +
                   (robots.empty() ? "  arm: {model: " + test::kSixAxes + ", hardware: mock}\n" : robots) +
                   "program: go\n" + more);
  Found out{check(folder.path(), {}, description::Catalogue({}), {}), ""};
  for (const Problem& p : out.result.problems)
    out.texts += (p.severity == Severity::error ? "E" : "W") + std::to_string(p.where.line) + " " + p.code +
                 " " + p.what + "\n";
  return out;
}

TEST(Rehearsal, GoodWaysAreGood) {
  const Found found = checked(kBend +
                              "for i in 1 .. 3\n  movel offset(start, z = -50mm), blend 10mm\n"
                              "  movel start, blend 10mm\nend\nmovel offset(start, x = 20mm)\n");
  EXPECT_EQ(found.texts, "");
  EXPECT_EQ(found.result.moves, 8u);
  EXPECT_TRUE(found.result.reached.file.empty());
}

TEST(Rehearsal, EveryLineThatCannotBeGoneIsNamed) {
  const Found found = checked(kBend +
                                  "movel offset(start, z = -500mm)\n"  // 3: below the table
                                  "moveto joints(0, -30deg, 60deg, 0, 60deg, 0)\n"
                                  "movel offset(start, z = -50mm)\n"
                                  "movel offset(start, x = 9m)\n"  // 6: out of reach
                                  "movel start\n"
                                  "moveto joints(0, -30deg, 60deg, 0, 60deg, 0)\n"
                                  "movel offset(start, z = -400mm)\n",  // 9
                              "workspace:\n  table: {plane: [0, 0, 1300mm], normal: [0, 0, 1]}\n");
  EXPECT_NE(found.texts.find("E3 workspace"), std::string::npos) << found.texts;
  EXPECT_NE(found.texts.find("crosses 'table'"), std::string::npos) << found.texts;
  EXPECT_NE(found.texts.find("\nE6 "), std::string::npos) << found.texts;
  EXPECT_NE(found.texts.find("\nE9 workspace"), std::string::npos) << found.texts;
  EXPECT_EQ(found.texts.find("E4 "), std::string::npos) << found.texts;
  EXPECT_EQ(found.texts.find("E5 "), std::string::npos) << found.texts;
}

TEST(Rehearsal, ALineThroughASingularityIsJudgedByItsWay) {
  // Both ends are in reach; the straight way between them leads through the robot's own axis.
  const Found found = checked(
      "moveto joints(0, -60deg, 100deg, 0, 60deg, 0)\nlet start = here()\n"
      "movel offset(start, x = -2 * start.x, y = -2 * start.y)\n");
  EXPECT_NE(found.texts.find("E3 "), std::string::npos) << found.texts;
  EXPECT_NE(found.texts.find("joint_"), std::string::npos) << found.texts;
}

TEST(Rehearsal, WhatLiesBehindAWaitIsAWarning) {
  const Found found =
      checked("wait Ready\n" + kBend + "wait Ready == False\nmovel offset(start, z = -500mm)\n",
              "signals: tags.yaml\nworkspace:\n  table: {plane: [0, 0, 1300mm], normal: [0, 0, 1]}\n");
  EXPECT_EQ(found.texts.rfind("W5 workspace", 0), 0u) << found.texts;
  EXPECT_FALSE(found.result.has_errors());
}

TEST(Rehearsal, EveryRobotOfTheProgramIsLookedAt) {
  const Found found = checked(
      "moveto joints(0, -30deg, 60deg, 0, 60deg, 0), robot left\n"
      "moveto joints(0, -30deg, 60deg, 0, 60deg, 0), robot right\n"
      "use robot right\nlet start = here()\nmovel offset(start, z = -500mm)\n",
      "",
      "  left: {model: " + test::kSixAxes + ", hardware: mock}\n  right: {model: " + test::kSixAxes +
          ", at: [0, 2, 0], hardware: mock, workspace: {table: {plane: [0, 0, 1300mm], normal: [0, 0, "
          "1]}}}\n");
  EXPECT_NE(found.texts.find("E5 workspace"), std::string::npos) << found.texts;
}

TEST(Rehearsal, AProgramWithoutEndIsLookedAtForTwoPasses) {
  const Found found = checked(kBend + "while True\n  movel offset(start, z = -50mm)\n  movel start\nend\n");
  EXPECT_EQ(found.texts, "");
  EXPECT_EQ(found.result.moves, 5u);
}

}  // namespace
}  // namespace polyarm::cell
