#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "polyarm/ik/inverse_kinematics.hpp"
#include "polyarm/kinematics/random.hpp"
#include "tests/closed_form/sample_families.hpp"

namespace polyarm::ik {
namespace {

/// Five axes of which two are nearly what six could be solved by (0.7 mm): a hobby arm's as a drawing program
/// wrote them.
description::RobotModel nearly_five() {
  return test::robot_of_axes("nearly five",
                             {{normalized(Vec3{-1, 0.000004, -0.000004}), {0.054200, -0.030399, -0.018278}},
                              {normalized(Vec3{-1, 0.000004, -0.000004}), {0.054199, -0.057890, 0.095564}},
                              {normalized(Vec3{0, -1, 0.000006}), {-0.175481, -0.076166, 0.191526}},
                              {normalized(Vec3{1, 0, 0.000007}), {-0.193758, -0.310538, -0.040606}},
                              {normalized(Vec3{-0.000011, 0, 1}), {-0.175657, -0.309171, -0.102708}}},
                             {{-0.171496, -0.294618, -0.200836}, from_axis_angle({1, 0, 0}, -1.5708)});
}

TEST(FiveAxes, AFormThatFitsOnlySomePosesIsNotTaken) {
  const auto model = nearly_five();
  const Chain chain(model, model.tool_link());
  const InverseKinematics arm(chain);
  ASSERT_TRUE(arm) << arm.report();
  Random random(5);
  IkSolutions found;
  for (int i = 0; i < 500; ++i) {
    std::vector<double> q, seed;
    for (std::size_t j = 0; j < 5; ++j) {
      q.push_back(random.between(-1.6, 1.6));
      seed.push_back(random.between(-1.6, 1.6));
    }
    ASSERT_EQ(arm.solve_all(chain.forward(q), seed, found), IkOutcome::solved)
        << arm.report() << ", state " << i;
    double nearest = 9;
    for (const IkSolution& one : found) {
      double worst = 0;
      for (std::size_t j = 0; j < 5; ++j)
        worst = std::max(worst, std::abs(std::remainder(one.q[j] - q[j], 2 * std::numbers::pi)));
      nearest = std::min(nearest, worst);
    }
    EXPECT_LT(nearest, 1e-6) << arm.report() << ", state " << i;
  }
}

}  // namespace
}  // namespace polyarm::ik
