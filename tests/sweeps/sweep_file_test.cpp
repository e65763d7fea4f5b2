/// Sweep files: what they mean, and what is said of mistakes in them.
#include "polyarm/sweeps/sweep_file.hpp"

#include <gtest/gtest.h>

#include <random>

#include "polyarm/sweeps/robot_choice.hpp"
#include "polyarm/sweeps/variants.hpp"

namespace polyarm::sweeps {
namespace {

const std::filesystem::path kFolder = std::filesystem::path(POLYARM_SOURCE_DIR) / "examples";

Sweep read(const std::string& more) {
  const description::Catalogue catalogue({std::filesystem::path(POLYARM_SOURCE_DIR) / "robots"});
  return read_sweep("polyarm: sweep/1\ncell: pick_and_place\n" + more, kFolder / "of_the_test.yaml",
                    catalogue);
}

/// The text of the error, or "accepted".
std::string refusal(const std::string& more) {
  try {
    read(more);
    return "accepted";
  } catch (const Error& e) {
    return e.what();
  }
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(SweepFile, WithoutAxesIsTheCellAsItIs) {
  const Sweep sweep = read("");
  const Variants variants(sweep);
  EXPECT_EQ(variants.count(), 1u);
  const Variant one = variants.at(0);
  EXPECT_EQ(one.robot, "");
  EXPECT_EQ(one.place, Place{});
  EXPECT_EQ(one.speed, 1);
  EXPECT_TRUE(one.fault->steps.empty());
}

TEST(SweepFile, AGridHasItsEndsAndEachCombination) {
  const Sweep sweep = read("base: {grid: {x: {from: -100mm, to: 100mm, steps: 3}, yaw: [0, 90deg]}}\n");
  ASSERT_EQ(sweep.places.size(), 6u);
  EXPECT_DOUBLE_EQ(*sweep.places.front().x, -0.1);
  EXPECT_DOUBLE_EQ(*sweep.places.back().x, 0.1);
  EXPECT_NEAR(*sweep.places.back().yaw, 1.5707963, 1e-6);
  EXPECT_FALSE(sweep.places.back().y);
}

TEST(SweepFile, PlacesLinesAndGridsStandInOneList) {
  const Sweep sweep = read(
      "base:\n  - {x: 0.1, y: 0.2}\n  - {line: {from: {x: 0, y: 0}, to: {x: 0.3, y: 0.6}, steps: 4}}\n"
      "  - {grid: {x: [1, 2]}}\n");
  ASSERT_EQ(sweep.places.size(), 7u);
  EXPECT_DOUBLE_EQ(*sweep.places[2].x, 0.1);
  EXPECT_DOUBLE_EQ(*sweep.places[2].y, 0.2);
}

TEST(SweepFile, RobotsAreNamesPatternsAndConditions) {
  const auto has = [](const Sweep& sweep, const char* name) {
    return std::find(sweep.robots.begin(), sweep.robots.end(), name) != sweep.robots.end();
  };
  const Sweep by_pattern = read("robots: ['ur*', 'abb/irb_120']\n");
  EXPECT_TRUE(has(by_pattern, "universal_robots/ur3"));
  EXPECT_TRUE(has(by_pattern, "abb/irb_120"));
  const Sweep by_condition = read("robots: ['payload >= 3kg and reach < 900mm and axes == 6']\n");
  EXPECT_TRUE(has(by_condition, "universal_robots/ur3"));
  EXPECT_FALSE(has(by_condition, "universal_robots/ur10e"));
}

TEST(SweepFile, AMistakeIsNamedWithItsLineAndTheNearestName) {
  EXPECT_TRUE(contains(refusal("robts: [ur3]\n"),
                       "of_the_test.yaml:3:1: error: 'robts' is not known here; did you "
                       "mean 'robots'?"));
  EXPECT_TRUE(contains(refusal("robots: [universal_robots/ur33]\n"), "did you mean 'universal_robots/ur3'?"));
  EXPECT_TRUE(contains(refusal("robots: ['paylod > 3kg']\n"), "did you mean 'payload'?"));
  EXPECT_TRUE(contains(refusal("robots: ['payload > 3m']\n"), "'3m' is no value for payload"));
  EXPECT_TRUE(contains(refusal("speeds: [0]\n"), "a speed of 0 cannot be"));
  EXPECT_TRUE(contains(refusal("speeds: []\n"), "'speeds' has no value"));
  EXPECT_TRUE(contains(refusal("base: {x: [1, 2]}\n"), "places in a grid are"));
  EXPECT_TRUE(contains(refusal("faults: {a: {at: 1s}}\n"), "this step does nothing"));
  EXPECT_TRUE(contains(refusal("faults: {a: {person: holt}}\n"), "did you mean 'hold'?"));
  EXPECT_TRUE(contains(refusal("seeds: [1, 2]\n"), "several seeds, and nothing that they vary"));
  EXPECT_TRUE(contains(refusal("require: {clearance: 300mm}\n"), "larger than what is measured"));
  EXPECT_TRUE(contains(
      refusal("base: {grid: {x: {from: 0, to: 1, steps: 1000}, y: {from: 0, to: 1, steps: 1000}}}\n"),
      "more than 100000 values"));
  EXPECT_TRUE(contains(refusal("speeds: [0.5]\nspeeds: [1]\n"), "speeds"));
}

TEST(SweepFile, SeveralMistakesAreNamedAtOnce) {
  const std::string text = refusal("speeds: [2]\nprograms: {}\nstop_after: {cycles: 0}\n");
  EXPECT_TRUE(contains(text, ":3:")) << text;
  EXPECT_TRUE(contains(text, ":5:")) << text;
}

TEST(SweepFile, OptionsSayTheSameAsAFile) {
  const description::Catalogue catalogue({std::filesystem::path(POLYARM_SOURCE_DIR) / "robots"});
  Words words;
  words.cell = (kFolder / "pick_and_place").string();
  words.robots = "universal_robots/ur3,payload >= 100kg";
  words.base = "x=-0.1:0.1:5,yaw=0|90deg";
  words.speeds = "50%,100%";
  const Sweep sweep = read_sweep(text_of(words), kFolder / "options", catalogue);
  EXPECT_GT(sweep.robots.size(), 1u);
  EXPECT_EQ(sweep.places.size(), 10u);
  EXPECT_EQ(sweep.speeds, (std::vector<double>{0.5, 1}));
}

/// Damaged files are refused or accepted; nothing else happens.
TEST(SweepFile, DamagedTextsAreRefusedWithAnError) {
  const std::string whole =
      "robots: ['ur3*', 'payload >= 3kg']\nbase: [{grid: {x: {from: 0, to: 1, steps: 3}}}, {x: 1}]\nspeeds: "
      "[50%, 1]\n"
      "faults: {none: {}, a: [{at: 1s, for: 2s, force: {arm/tool/vacuum: 0}}]}\nvalues: {Repeat: [true, "
      "false]}\n"
      "seeds: {from: 1, count: 3}\nvary: {base: 1mm, points: {Pick: 1mm}}\ncombine: product\nsample: 5\n";
  ASSERT_EQ(refusal(whole), "accepted");
  std::mt19937_64 random(1);
  for (int i = 0; i < 300; ++i) {
    std::string text = whole;
    for (int k = 0; k < 3; ++k) {
      const std::size_t at = random() % text.size();
      if (random() % 2)
        text.erase(at, 1 + random() % 5);
      else
        text.insert(at, 1, "{}[]:,'\"-0 a\n\t%&*"[random() % 17]);
      if (text.empty()) text = " ";
    }
    refusal(text);  // no other exception, no crash, no end of memory
  }
}

}  // namespace
}  // namespace polyarm::sweeps
