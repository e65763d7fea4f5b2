/// Moves around obstacles, and what `polyarm check` says about contacts and clearances: on mock hardware.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "polyarm/cell/check.hpp"
#include "polyarm/setup/cell_file.hpp"
#include "tests/support/lock_step_cell.hpp"

namespace polyarm::cell {
namespace {

const std::string kLeft = "pose(300mm, 180mm, 100mm, 180deg, 0deg, 0deg)",
                  kRight = "pose(300mm, -180mm, 100mm, 180deg, 0deg, 0deg)",
                  kInside = "pose(300mm, 0mm, 100mm, 180deg, 0deg, 0deg)";
const std::string kWall = "  wall: {box: [0.34, 0.02, 0.16], at: [0.34, 0, 0.08]}\n";

struct Found {
  CheckResult result;
  std::string texts;

  const Problem* of(const std::string& code) const {
    const auto at = std::find_if(result.problems.begin(), result.problems.end(),
                                 [&](const Problem& p) { return p.code == code; });
    return at == result.problems.end() ? nullptr : &*at;
  }
};

/// A UR3 on mock hardware, on a table with a wall across.
Found checked(const std::string& program, bool dry, const std::string& fixtures = kWall,
              const std::string& more = "") {
  hardware::register_driver("mock",
                            [] { return std::unique_ptr<hardware::Component>(new drivers::MockComponent); });
  const test::Folder folder;
  folder.write("go.script", program);
  folder.write("scene.yaml",
               "polyarm: scene/1\nfloor: {height: -0.75}\nfixtures:\n"
               "  table: {box: [1.4, 1.4, 0.04], at: [0.2, 0, -0.02]}\n" +
                   fixtures);
  folder.write(
      "cell.yaml",
      "polyarm: cell/1\nrobots:\n  arm: {model: universal_robots/ur3, hardware: mock, tool: suction_cup}\n"
      "scene: scene.yaml\nprogram: go\n" +
          more);
  CheckOptions options;
  options.dry = dry;
  Found out{check(folder.path(), {}, description::Catalogue({std::string(POLYARM_SOURCE_DIR) + "/robots"}),
                  options),
            ""};
  for (const Problem& p : out.result.problems)
    out.texts += (p.severity == Severity::error ? "E" : "W") + std::to_string(p.where.line) + " " + p.code +
                 " " + p.what + "\n";
  for (const std::string& note : out.result.notes) out.texts += note + "\n";
  return out;
}

TEST(SweptCheck, AContactOnMockHardwareIsAnErrorOfItsLine) {
  const Found found = checked("moveto " + kLeft + "\nmoveto " + kRight + "\n", true);
  const Problem* contact = found.of("contact");
  ASSERT_TRUE(contact) << found.texts;
  EXPECT_TRUE(found.result.has_errors());
  EXPECT_EQ(contact->where.line, 2);
  EXPECT_NE(contact->what.find("touched fixture wall at "), std::string::npos) << contact->what;
  EXPECT_NE(contact->what.find(" mm deep, at ("), std::string::npos) << contact->what;
  ASSERT_EQ(contact->facts.size(), 4u);
  EXPECT_EQ(std::get<std::string>(contact->facts[1].value), "fixture wall");
  EXPECT_GT(std::get<double>(contact->facts[2].value), 0.001);
  EXPECT_FALSE(checked("moveto " + kLeft + "\nmoveto " + kRight + "\n", false).of("contact"))
      << "without --dry nothing moves";
}

TEST(SweptCheck, TheClearanceOfTheCellIsAWarningWithTheSmallestDistance) {
  const std::string program = "moveto " + kLeft + "\n";
  const Found far = checked(program, true),
              near = checked(program, true, kWall, "contacts: {clearance: 150mm}\n");
  EXPECT_FALSE(far.of("clearance")) << far.texts;
  EXPECT_NE(far.texts.find("keeps 5 mm of clearance"), std::string::npos) << far.texts;
  const Problem* warning = near.of("clearance");
  ASSERT_TRUE(warning) << near.texts;
  EXPECT_FALSE(near.result.has_errors()) << near.texts;
  EXPECT_EQ(warning->severity, Severity::warning);
  EXPECT_NE(near.texts.find("the nearest of the dry run: "), std::string::npos) << near.texts;
  EXPECT_NE(near.texts.find("arm/tool comes within 1"), std::string::npos) << near.texts;
}

TEST(SweptCheck, AStartInsideSomethingIsSaidAsThat) {
  const Found found = checked("log \"here\"\n", false, "  cage: {box: [0.2, 0.2, 0.9], at: [0, 0, 0.6]}\n");
  const Problem* start = found.of("start-in-contact");
  ASSERT_TRUE(start) << found.texts;
  EXPECT_NE(start->what.find("fixture cage where it starts"), std::string::npos) << start->what;
  EXPECT_NE(start->where.text().find("cell.yaml"), std::string::npos);
}

TEST(Around, AMoveGoesOverTheWall) {
  const std::string program = "moveto " + kLeft + "\nmoveto " + kRight + ", around true\n";
  for (const bool dry : {false, true}) {
    const Found found = checked(program, dry);
    EXPECT_FALSE(found.result.has_errors()) << found.texts;
    EXPECT_EQ(found.result.moves, 2u);
  }
  const Found all =
      checked("moveto " + kLeft + "\nmoveto " + kRight + "\n", true, kWall, "motion: {around: true}\n");
  EXPECT_FALSE(all.result.has_errors()) << all.texts;
  const Found use = checked("use around true\nmovej " + kLeft + ", blend 10mm\nmovej " + kRight + "\n", true);
  EXPECT_FALSE(use.result.has_errors()) << use.texts;
}

TEST(Around, ALineNeverBendsAndIsRefused) {
  const Found found = checked("moveto " + kLeft + "\nmovel " + kRight + ", around true\n", false);
  const Problem* contact = found.of("contact");
  ASSERT_TRUE(contact) << found.texts;
  EXPECT_EQ(contact->where.line, 2);
  EXPECT_NE(contact->what.find("would hit something after "), std::string::npos) << contact->what;
  EXPECT_NE(contact->what.find("fixture wall"), std::string::npos) << contact->what;
  EXPECT_FALSE(checked("moveto " + kLeft + "\nmovel " + kRight + ", around false\n", false, kWall,
                       "motion: {around: true}\n")
                   .of("contact"));
}

TEST(Around, AGoalInsideSomethingSaysWhatItTouches) {
  const Found found = checked("moveto " + kLeft + "\nmoveto " + kInside + ", around true\n", false);
  const Problem* goal = found.of("goal-in-contact");
  ASSERT_TRUE(goal) << found.texts;
  EXPECT_EQ(goal->where.line, 2);
  EXPECT_NE(goal->what.find("fixture wall"), std::string::npos) << goal->what;
}

TEST(Around, AProgramCatchesThatThereIsNoWay) {
  const Found found = checked("moveto " + kLeft + "\ntry\n  moveto " + kInside +
                                  ", around true\non error\n  moveto " + kLeft + "\nend\n",
                              true);
  EXPECT_FALSE(found.result.has_errors()) << found.texts;
}

}  // namespace
}  // namespace polyarm::cell
