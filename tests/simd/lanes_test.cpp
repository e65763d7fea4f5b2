#include "polyarm/simd/lanes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "polyarm/kinematics/random.hpp"

#pragma GCC diagnostic ignored "-Wpsabi"

namespace polyarm::kinematics {
namespace {

TEST(Lanes, AnglesAreRightToTheLastPlace) {
  Random random(1);
  for (int i = 0; i < 20000; ++i) {
    const double y = random.between(-1, 1), x = random.between(-1, 1) * (i % 7 == 0 ? 1e-9 : 1);
    const double exact = std::atan2(y, x);
    EXPECT_NEAR(angle_of(splat(y), splat(x))[3], exact, 4e-16 * std::max(1.0, std::abs(exact)));
  }
  const double pi = std::numbers::pi;
  EXPECT_EQ(angle_of(splat(0.0), splat(1.0))[0], 0);
  EXPECT_EQ(angle_of(splat(0.0), splat(0.0))[0], 0);
  EXPECT_EQ(angle_of(splat(0.0), splat(-1.0))[0], pi);
  EXPECT_EQ(angle_of(splat(1.0), splat(0.0))[0], pi / 2);
  EXPECT_EQ(angle_of(splat(-1.0), splat(0.0))[0], -pi / 2);
}

}  // namespace
}  // namespace polyarm::kinematics
