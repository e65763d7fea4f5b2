/// Parts that are inside something where they start.
#include "polyarm/surroundings/at_start.hpp"

#include <gtest/gtest.h>

#include "tests/surroundings/gantry.hpp"

namespace polyarm::surroundings {
namespace {

description::Part part(const std::string& name, const Vec3& at) {
  description::Part out;
  out.name = name;
  out.shape = box(0.04, 0.04, 0.04);
  out.start.position = at;
  return out;
}

TEST(PartsInside, AreReportedWithTheirDepthAndWhatTheyAreIn) {
  description::Scene scene;
  scene.floor_height = -0.5;
  scene.fixtures = {fixture("table", {1, 1, 0.1}, {0, 0, -0.05})};
  scene.parts = {part("on", {0, 0, 0.02}), part("sunk", {0.2, 0, 0.01}), part("through", {0.2, 0.02, 0.01}),
                 part("deep", {2, 0, -0.51})};
  const std::vector<Problem> found = parts_inside(scene);
  ASSERT_EQ(found.size(), 4u);
  EXPECT_EQ(found[0].code, "part-in-contact");
  EXPECT_EQ(found[0].severity, Severity::warning);
  EXPECT_NE(found[0].what.find("part sunk is 10.0 mm inside fixture table where it starts"),
            std::string::npos)
      << found[0].what;
  EXPECT_NE(found[1].what.find("part through is 10.0 mm inside fixture table"), std::string::npos);
  EXPECT_NE(found[2].what.find("part through is 20.0 mm inside part sunk"), std::string::npos)
      << found[2].what;
  EXPECT_NE(found[3].what.find("part deep is 30.0 mm inside floor"), std::string::npos) << found[3].what;
}

TEST(PartsInside, AFeederIsLookedAtWithItsFirstPart) {
  description::Scene scene;
  scene.fixtures = {fixture("belt", {1, 1, 0.1}, {0, 0, 0.05})};
  scene.feeders = {{"infeed", {{0, 0, 0.09}, {}}}};
  scene.parts = {part("a", {}), part("b", {})};
  for (description::Part& each : scene.parts) each.feeder = "infeed";
  const std::vector<Problem> found = parts_inside(scene);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NE(found[0].what.find("part a is 30.0 mm inside fixture belt where the feeder infeed brings it"),
            std::string::npos)
      << found[0].what;
}

TEST(PartsInside, WhatOnlyTouchesIsNotReported) {
  description::Scene scene;
  scene.fixtures = {fixture("table", {1, 1, 0.1}, {0, 0, -0.0485})};
  scene.floor_height = -0.0985;
  scene.parts = {part("a", {0, 0, 0.02}), part("b", {0, 0, 0.06})};
  EXPECT_TRUE(parts_inside(scene).empty());
}

description::Fixture belt(const std::string& name, const Vec3& at) {
  description::Fixture out = fixture(name, {1, 0.2, 0.04}, at);
  out.shapes.front().pose.position = {0, 0, -0.02};  // its frame is in the middle of its surface
  out.belt = name;
  return out;
}

TEST(BeltsBlocked, ABinWhoseWallsStandInABeltIsReported) {
  description::Scene scene;
  scene.fixtures = {belt("line", {0, 0, 0.1}), fixture("box", {0.1, 0.1, 0.1}, {0.3, 0.1, 0.1})};
  scene.bins = {{"box", {}, {}}};
  std::vector<Problem> found = belts_blocked(scene);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].code, "belt-blocked");
  EXPECT_EQ(found[0].severity, Severity::warning);
  EXPECT_EQ(found[0].what,
            "bin box stands 50.0 mm deep in belt line, and rises above its surface: parts cannot pass");
  scene.fixtures[1].mover = "gate";
  EXPECT_TRUE(belts_blocked(scene).empty());
}

TEST(BeltsBlocked, WhatIsBesideBelowOrOnABeltIsNotReported) {
  description::Scene scene;
  scene.fixtures = {belt("line", {0, 0, 0.1}), fixture("leg", {0.1, 0.1, 0.1}, {0.3, 0, 0.05}),
                    fixture("beside", {0.1, 0.1, 0.3}, {0.3, 0.15, 0.1}),
                    fixture("guide", {1, 0.01, 0.05}, {0, 0.08, 0.125}),
                    fixture("portal", {0.05, 0.5, 0.05}, {0, 0, 0.3})};
  EXPECT_TRUE(belts_blocked(scene).empty());
  scene.fixtures.push_back(belt("across", {0.9, 0, 0.11}));
  const std::vector<Problem> found = belts_blocked(scene);
  ASSERT_FALSE(found.empty());
  EXPECT_NE(found[0].what.find("belt across stands"), std::string::npos) << found[0].what;
}

}  // namespace
}  // namespace polyarm::surroundings
