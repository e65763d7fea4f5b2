#include "polyarm/kinematics/arm_class.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "polyarm/description/catalogue.hpp"
#include "tests/kinematics/sample_families.hpp"

namespace polyarm::kinematics {
namespace {

ArmGeometry geometry(const description::RobotModel& model, const Pose& base = {}, const Pose& tool = {}) {
  std::string why_not;
  const auto out = geometry_of(Chain(model, test::tip_of(model), base, tool), why_not);
  EXPECT_TRUE(out) << why_not;
  return out.value_or(ArmGeometry{});
}

std::vector<double> random_values(std::size_t n, Random& random) {
  std::vector<double> q;
  for (std::size_t i = 0; i < n; ++i) q.push_back(random.between(-3, 3));
  return q;
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

TEST(ArmGeometry, LeadsWhereTheChainLeads) {
  const Pose base{{0.4, -0.3, 0.8}, from_rpy(0.2, -0.4, 2.1)}, tool{{0.01, 0.02, 0.1}, from_rpy(0.3, 0, 0.2)};
  Random random(1);
  for (const auto& model : {test::ur3(), test::seven(), test::five()}) {
    const Chain chain(model, test::tip_of(model), base, tool);
    const ArmGeometry arm = geometry(model, base, tool);
    for (int i = 0; i < 100; ++i) {
      const auto q = random_values(arm.count, random);
      Rotation rotation;
      Vec3 position;
      arm.forward(q, rotation, position);
      const Pose pose = chain.forward(q);
      EXPECT_LT(norm(position - pose.position), 1e-14);
      EXPECT_LT(norm(rotation.y - rotation_of(pose.rotation).y), 1e-14);
    }
  }
}

TEST(ArmGeometry, TurnedRoundReachesTheInverse) {
  const ArmGeometry arm = geometry(test::ur3()), round = reversed(arm);
  Random random(2);
  for (int i = 0; i < 100; ++i) {
    auto q = random_values(6, random);
    Rotation r, back;
    Vec3 p, p_back;
    arm.forward(q, r, p);
    std::reverse(q.begin(), q.end());
    round.forward(q, back, p_back);
    EXPECT_LT(norm(r * p_back + p), 1e-14);
    EXPECT_LT(norm((r * back).x - Vec3{1, 0, 0}), 1e-14);
  }
}

TEST(ArmGeometry, AHeldJointIsPartOfTheLinks) {
  const ArmGeometry arm = geometry(test::seven());
  Random random(3);
  for (std::size_t k = 0; k < 7; ++k) {
    auto q = random_values(7, random);
    const ArmGeometry six = locked(arm, k, q[k]);
    Rotation r, r6;
    Vec3 p, p6;
    arm.forward(q, r, p);
    q.erase(q.begin() + static_cast<std::ptrdiff_t>(k));
    six.forward(q, r6, p6);
    EXPECT_LT(norm(p - p6) + norm(r.x - r6.x), 1e-14);
  }
}

TEST(ArmGeometry, RefusesMimicJointsAndSaysWhich) {
  const auto model = test::gantry();
  std::string why_not;
  EXPECT_FALSE(geometry_of(Chain(model, test::tip_of(model)), why_not));
  EXPECT_EQ(why_not, "arm drives more than one joint");
}

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
