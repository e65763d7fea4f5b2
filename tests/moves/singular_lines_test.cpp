/// Lines that pass a singularity at 0 to 5 cm, of arms of the catalogue: each is followed within every limit,
/// slowly where it has to be, or refused with what is in the way and where.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "tests/moves/arm_moves.hpp"

namespace polyarm::moves::singular_lines_test {
namespace {

using test::Arm;
using test::Values;

class SingularLines : public testing::TestWithParam<const char*> {};

TEST_P(SingularLines, AreFollowedWithinTheLimitsOrRefusedWithTheReason) {
  const Arm arm(GetParam());
  const std::size_t n = arm.chain().joints();
  std::mt19937_64 engine(9);
  const auto draw = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine);
  };
  /// A joint state in a singularity: from a random one downhill along one joint after the other.
  const auto singular = [&] {
    Values q(n);
    for (std::size_t j = 0; j < n; ++j)
      q[j] = draw(std::max(arm.chain().lower()[j], -2.0), std::min(arm.chain().upper()[j], 2.0));
    double least = kinematics::smallest_singular_value(arm.chain(), q);
    for (double step = 0.3; step > 1e-7; step /= 2)
      for (std::size_t j = 0; j < n; ++j)
        for (const double by : {step, -step}) {
          Values there = q;
          there[j] = std::clamp(q[j] + by, arm.chain().lower()[j], arm.chain().upper()[j]);
          const double value = kinematics::smallest_singular_value(arm.chain(), there);
          if (value < least) least = value, q = there;
        }
    return q;
  };
  const std::set<std::string> reasons{"unreachable", "limit", "singular", "branch"};
  const auto& names = arm.chain().names();
  int followed = 0, refused = 0;
  double most = 0, off = 0;
  for (int i = 0; i < 40; ++i) {
    const Values at = singular();
    const Pose there = arm.chain().forward(at);
    Vec3 way{draw(-1, 1), draw(-1, 1), draw(-1, 1)}, aside{draw(-1, 1), draw(-1, 1), draw(-1, 1)};
    way = normalized(way);
    constexpr std::array kBeside{0.0, 1e-4, 1e-3, 1e-2, 5e-2};
    const Vec3 beside = kBeside[static_cast<std::size_t>(i) % kBeside.size()] * normalized(cross(way, aside));
    const Pose from{there.position + beside - 0.08 * way, there.rotation};
    const Pose to{there.position + beside + 0.08 * way, there.rotation};
    Values start;
    try {
      start = joints_for(*arm.facts, from, at, "the start");
    } catch (const Error&) {
      continue;
    }
    const Move move = test::line(to, "the end");
    MovePlan plan;
    try {
      plan = plan_moves(*arm.facts, start, {&move, 1});
    } catch (const MoveError& e) {
      ++refused;
      const Problem& why = e.problems().front();
      EXPECT_TRUE(reasons.contains(why.code)) << why.text();
      EXPECT_NE(why.what.find(" m"), std::string::npos) << why.what;
      const bool of_a_joint = why.code == "limit" || why.code == "singular";
      const bool named = std::any_of(names.begin(), names.end(), [&](const std::string& name) {
        return why.what.find(name) != std::string::npos;
      });
      EXPECT_TRUE(named || !of_a_joint) << why.what;
      continue;
    }
    ++followed;
    for (const PlannedMotion& motion : plan.motions) {
      Values q(n), v(n), a(n), j(n);
      std::size_t hint = 0;
      for (int k = 0; k <= 5000; ++k) {
        motion.path.sample(motion.path.duration() * k / 5000, q, v, a, j, hint);
        for (std::size_t joint = 0; joint < n; ++joint) {
          const trajectory::MotionLimits& l = plan.limits[joint];
          most = std::max({most, std::abs(v[joint]) / l.max_velocity, std::abs(a[joint]) / l.max_acceleration,
                           std::abs(j[joint]) / l.max_jerk});
        }
        const Vec3 here = arm.chain().forward(q).position - from.position;
        off = std::max(off, norm(here - dot(here, way) * way));
      }
    }
  }
  std::printf("%d followed (limits %.1e, %.1e m off), %d refused\n", followed, most - 1, off, refused);
  EXPECT_GT(followed + refused, 10);
  EXPECT_GT(followed, 0);
  EXPECT_LE(most, 1 + 1e-6);
  EXPECT_LT(off, 1e-6);
}

INSTANTIATE_TEST_SUITE_P(Catalogue, SingularLines,
                         testing::Values("universal_robots/ur5e", "abb/irb_120", "kuka/kr_10_r1100_2",
                                         "fanuc/m_10ia", "yaskawa/gp7", "ufactory/xarm_6",
                                         "franka/fer_panda"),
                         [](const testing::TestParamInfo<const char*>& arm) {
                           std::string name = arm.param;
                           std::replace_if(
                               name.begin(), name.end(), [](char c) { return !std::isalnum(c); }, '_');
                           return name;
                         });

}  // namespace
}  // namespace polyarm::moves::singular_lines_test
