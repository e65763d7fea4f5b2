/// On paths of the TCP of several arms of the catalogue: at random overrides, stops, resumes and steps back
/// at random moments the commanded TCP stays on its path and every joint within its limits.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/moves/cartesian_joints.hpp"
#include "polyarm/timing/path_override.hpp"
#include "polyarm/timing/timing.hpp"
#include "tests/support/arm_stop_moments.hpp"
#include "tests/support/slow_stop.hpp"

namespace polyarm::moves::stop_laws_test {
namespace {

using namespace paths;
using namespace timing;
using namespace trajectory;
constexpr double kPeriod = 1e-3;

struct Arm {
  const char* name;
  std::vector<double> q;
};

kinematics::Chain chain_of(const std::string& name) {
  const auto model = description::Catalogue({POLYARM_SOURCE_DIR "/robots"}).load(name);
  for (const char* tip : {"tool0", "flange", "ee_link", "tool_link"})
    for (std::size_t i = 0; i < model.links.size(); ++i)
      if (model.links[i].name == tip) return kinematics::Chain(model, static_cast<int>(i));
  return kinematics::Chain(model, static_cast<int>(model.links.size()) - 1);
}

/// What the joints do within a cycle, ten times: the highest share of a limit.
double most_used(const TimedPath& path, const std::vector<MotionLimits>& limits, double time, double factor,
                 double rate, double bend) {
  const std::size_t n = limits.size();
  std::vector<double> q(n), v(n), a(n), j(n);
  std::size_t hint = 0;
  double most = 0;
  for (int k = 0; k <= 10; ++k) {
    const double t = kPeriod * k / 10, at = time + t * (factor + t * (rate / 2 + t * bend / 6));
    if (at < 0 || at > path.duration()) continue;
    const double f = factor + t * (rate + t * bend / 2), g = rate + t * bend;
    path.sample(at, q, v, a, j, hint);
    for (std::size_t i = 0; i < n; ++i) {
      const MotionLimits& l = limits[i];
      const double acceleration = a[i] * f * f + v[i] * g;
      most = std::max({most, v[i] * f / l.max_velocity, v[i] * f / l.min_velocity,
                       acceleration / l.max_acceleration, acceleration / l.min_acceleration,
                       std::abs(j[i] * f * f * f + 3 * a[i] * f * g + v[i] * bend) / l.max_jerk});
    }
  }
  return most;
}

class StopLaws : public testing::TestWithParam<Arm> {};

TEST_P(StopLaws, TheTcpStaysOnItsPathAndTheJointsWithinTheirLimits) {
  const kinematics::Chain chain = chain_of(GetParam().name);
  const std::vector<double>& q0 = GetParam().q;
  const std::size_t n = q0.size();
  std::mt19937_64 engine(11);
  const auto draw = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine);
  };
  double furthest = 0, most = 0;
  int paths = 0, stops = 0;
  for (int attempt = 0; attempt < 30 && paths < 4; ++attempt) {
    const auto near = [&] {
      std::vector<double> q = q0;
      for (double& x : q) x += draw(-0.25, 0.25);
      return chain.forward(q);
    };
    CartesianPathBuilder builder(chain.forward(q0));
    for (int i = 0; i < 4; ++i) {
      const Pose to = near(), via = near();
      if (i % 3 < 2)
        builder.line(to, {0.03, ""});
      else
        builder.arc(via.position, to, ArcOrientation::interpolated, {0.03, ""});
    }
    const CartesianSections way = builder.build();
    std::shared_ptr<const Path> joints;
    try {
      joints = joints_along(chain, way.sections.front(), q0);
    } catch (const Error&) {
      continue;  // leads where this arm does not go
    }
    ++paths;
    std::vector<MotionLimits> limits;
    for (std::size_t i = 0; i < n; ++i)
      limits.push_back({draw(1.5, 3), draw(5, 15), draw(60, 150), -draw(1.5, 3), -draw(5, 15)});
    const TimedPath path = timed(joints, limits);
    PathOverride o(path, limits, kPeriod);
    std::vector<double> q(n), v(n), a(n);
    double target = 1;
    std::size_t hint = 0;
    for (int cycle = 0, next = 0; cycle < 15'000 && !o.finished(); ++cycle) {
      if (cycle == next) {
        const double what = draw(0, 1);
        target = what < 0.35 ? 0 : what < 0.5 ? -draw(0, 0.5) : what < 0.7 ? 1 : draw(0, 1);
        next += int(draw(5, 300));
        ++stops;
      }
      const double time = o.time(), factor = o.factor(), rate = o.rate();
      o.advance(target);
      // Back at the start it stands at once, where the plan rests.
      if (o.time() > 0) most = std::max(most, most_used(path, limits, time, factor, rate, o.bend()));
      o.sample(q, v, a);
      const double s = path.profile().at(o.time(), hint).s;
      furthest =
          std::max(furthest, norm(chain.forward(q).position - way.sections.front().at(s).pose.position));
    }
  }
  std::printf("%d paths, %d changes: %.2e m off, limits exceeded by %.2e\n", paths, stops, furthest,
              most - 1);
  EXPECT_GE(paths, 3);
  EXPECT_GE(stops, 30);
  EXPECT_LT(furthest, 1e-6);
  EXPECT_LE(most, 1 + 1e-6);
}

/// A joint whose planned jerk takes most of its limit: in the middle of a cycle there is a little less left
/// for braking than at its ends, and that was taken for none. And stops from moments beside it.
TEST(StopTimes, AreNearTheShortestThereIs) {
  for (const std::uint64_t seed : {2001, 2019}) {
    const polyarm::test::StopMoment m = polyarm::test::moment_of_an_arm(seed);
    PathOverride o(m.path, m.limits, kPeriod);
    o.begin(m.time, m.factor);
    const StoppingWay stop = o.stopping();
    ASSERT_TRUE(stop.known);
    const double shortest = polyarm::test::SlowStop(m.path, m.limits).search(m.time, m.factor);
    std::printf("stop %llu: %.4f s, the shortest found %.4f s\n", (unsigned long long)seed, stop.time,
                shortest);
    EXPECT_LE(stop.time, 1.1 * shortest) << seed;
  }
}

INSTANTIATE_TEST_SUITE_P(Catalogue, StopLaws,
                         testing::Values(Arm{"universal_robots/ur5e", {0, -1.4, 1.8, -2.0, -1.57, 0.3}},
                                         Arm{"abb/irb_120", {0.2, 0.2, -0.1, 0.4, 0.8, 0.3}},
                                         Arm{"fanuc/lr_mate_200id_7l", {0.1, 0.3, -0.2, 0.3, -0.9, 0.2}},
                                         Arm{"kuka/lbr_iiwa_7_r800", {0.2, 0.5, -0.1, -1.4, 0.2, 0.9, 0}},
                                         Arm{"franka/fer_panda", {0, -0.4, 0, -2.0, 0, 1.7, 0.8}}),
                         [](const testing::TestParamInfo<Arm>& arm) {
                           std::string name = arm.param.name;
                           std::replace_if(
                               name.begin(), name.end(), [](char c) { return !std::isalnum(c); }, '_');
                           return name;
                         });

}  // namespace
}  // namespace polyarm::moves::stop_laws_test
