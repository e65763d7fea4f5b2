#include "polyarm/closed_form/arm_class.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "polyarm/catalogue/catalogue.hpp"
#include "tests/closed_form/sample_families.hpp"

namespace polyarm::kinematics {
namespace {

ArmGeometry geometry(const description::RobotModel& model, const Pose& base = {}, const Pose& tool = {}) {
  std::string why_not;
  const auto out = geometry_of(Chain(model, test::tip_of(model), base, tool), why_not);
  EXPECT_TRUE(out) << why_not;
  return out.value_or(ArmGeometry{});
}

constexpr ArmFamily kFamilies[] = {
    ArmFamily::wrist_2_parallel_3,
    ArmFamily::wrist_1_parallel_2,
    ArmFamily::wrist_1_meets_2,
    ArmFamily::wrist_2_meets_3,
    ArmFamily::wrist,
    ArmFamily::parallel_234_5_meets_6,
    ArmFamily::parallel_234,
    ArmFamily::parallel_123_5_meets_6,
    ArmFamily::search_5_meets_6,
    ArmFamily::search_4_meets_5,
};

TEST(ArmClass, SeesEachFamilyFromTheBaseAndFromTheTool) {
  Random random(4);
  for (const ArmFamily family : kFamilies)
    for (int i = 0; i < 50; ++i) {
      const auto axes = test::random_axes(family, random, 0.06);
      const SixAxisClass seen = classify(geometry(test::random_arm(axes, random)));
      EXPECT_EQ(seen.family, family) << describe(seen.family) << " for " << describe(family);
      EXPECT_FALSE(seen.from_tool);
      EXPECT_TRUE(seen.exact()) << seen.worst_gap << " " << seen.worst_angle;
      const SixAxisClass round = classify(geometry(test::random_arm(test::turned_round(axes), random)));
      EXPECT_EQ(round.family, family);
      EXPECT_TRUE(round.from_tool);
    }
}

TEST(ArmClass, StillSeesThemInACalibratedArmAndSaysHowFarOff) {
  Random random(5);
  for (const ArmFamily family : kFamilies) {
    const auto axes = test::spoiled(test::random_axes(family, random), 2e-4, random);
    const SixAxisClass seen = classify(geometry(test::random_arm(axes, random)));
    EXPECT_EQ(seen.family, family);
    EXPECT_FALSE(seen.exact());
    EXPECT_LT(seen.worst_gap, 1e-3);
    EXPECT_LT(seen.worst_angle, 1e-3);
    if (family == ArmFamily::search_4_meets_5) continue;  // whose other end is left as it is
    const SixAxisClass ideal = classify(seen.ideal, 1e-9);
    EXPECT_EQ(ideal.family, family);
  }
}

/// The point that is reached for goes round the axis that is searched along: of two ways the one where it
/// goes round in the smaller circle, if that is clearly smaller.
TEST(ArmClass, SearchesAlongTheAxisWhereLessIsLeftToMove) {
  const auto seen = [](double wrist) {
    const Vec3 x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
    const Vec3 hand{0.4, 0, 0.7 - wrist};
    return classify(geometry(test::robot_of_axes(
        "arm",
        {{z, {}}, {y, {0, 0, 0.3}}, {y, {0, 0, 0.6}}, {x, {0.1, 0, 0.7}}, {y, {0.4, 0, 0.7}}, {x, hand}},
        {hand, {}})));
  };
  // From axis 3 to the shoulder, where axes 1 and 2 meet, it is 0.3 m.
  EXPECT_EQ(seen(0.08).family, ArmFamily::search_4_meets_5);
  EXPECT_FALSE(seen(0.08).from_tool);
  EXPECT_EQ(seen(0.4).family, ArmFamily::search_5_meets_6);
  EXPECT_TRUE(seen(0.4).from_tool);
}

TEST(ArmClass, SaysWhatIsMissing) {
  Random random(6);
  const ArmGeometry arm = geometry(test::random_arm(test::random_axes(ArmFamily::none, random), random));
  EXPECT_EQ(classify(arm).family, ArmFamily::none);
  EXPECT_NE(why_no_family(arm).find("axes 4, 5 and 6 miss a common point by "), std::string::npos);
}

TEST(ArmClass, KnowsTheFamiliesOfTheCatalogue) {
  const description::Catalogue catalogue({POLYARM_SOURCE_DIR "/robots"});
  std::map<ArmFamily, int> count;
  for (const std::string& name : catalogue.names()) {
    const auto model = catalogue.load(name);
    std::string why_not;
    const auto arm = geometry_of(Chain(model, model.tool_link()), why_not);
    ASSERT_TRUE(arm) << name << ": " << why_not;
    if (arm->count == 6) ++count[classify(*arm).family];
  }
  EXPECT_GE(count[ArmFamily::wrist_2_parallel_3], 229);
  EXPECT_GE(count[ArmFamily::parallel_234_5_meets_6], 50);
  EXPECT_EQ(count[ArmFamily::none], 0);
}

}  // namespace
}  // namespace polyarm::kinematics
