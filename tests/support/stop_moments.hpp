#pragma once
/// Random stop requests on random timed paths.
#include <cstddef>
#include <cstdint>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "polyarm/timing/timing.hpp"
#include "tests/support/test_paths.hpp"

namespace polyarm::test {

struct StopMoment {
  timing::TimedPath path;
  std::vector<trajectory::MotionLimits> limits;
  double time, factor;
};

/// Velocities of 1.5 to 4.5 rad/s; full speed is reached in 1/8 to 1/2 s, full acceleration in 1/30 to 1/5 s.
inline std::vector<trajectory::MotionLimits> unequal_limits(std::mt19937_64& engine, std::size_t joints) {
  std::uniform_real_distribution<double> draw(0, 1);
  std::vector<trajectory::MotionLimits> out;
  for (std::size_t j = 0; j < joints; ++j) {
    const double v = 1.5 + 3 * draw(engine), a = v * (2 + 6 * draw(engine));
    out.push_back(trajectory::MotionLimits::symmetric(v, a, a * (5 + 25 * draw(engine))));
  }
  return out;
}

/// A random time on the path; at full speed or at a random factor.
inline StopMoment moment_on(std::shared_ptr<const paths::Path> path,
                            std::vector<trajectory::MotionLimits> limits, std::mt19937_64& engine,
                            bool full_speed) {
  std::uniform_real_distribution<double> draw(0, 1);
  StopMoment out{timing::timed(std::move(path), limits), std::move(limits), 0, 1};
  out.time = (0.03 + 0.9 * draw(engine)) * out.path.duration();
  if (!full_speed) out.factor = 0.1 + 0.9 * draw(engine);
  return out;
}

/// Six joints with different limits: a spline (even seeds), or lines with rounded corners.
inline StopMoment random_moment(std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  std::uniform_real_distribution<double> draw(0, 1);
  std::vector<trajectory::MotionLimits> limits = unequal_limits(engine, 6);
  std::shared_ptr<const paths::Path> path;
  if (seed % 2 == 0) {
    path = random_spline(6, 8, seed);
  } else {
    std::vector<std::vector<double>> points(6, std::vector<double>(6));
    for (auto& point : points)
      for (double& x : point) x = -1.5 + 3 * draw(engine);
    path = blended_lines(points, 0.05 + 0.3 * draw(engine));
  }
  return moment_on(std::move(path), std::move(limits), engine, seed % 4 < 2);
}

}  // namespace polyarm::test
