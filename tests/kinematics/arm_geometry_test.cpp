#include "polyarm/kinematics/arm_geometry.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "polyarm/kinematics/random.hpp"
#include "tests/kinematics/sample_robots.hpp"

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

}  // namespace
}  // namespace polyarm::kinematics
