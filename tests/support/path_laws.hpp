#pragma once
/// Laws of every path: its derivatives are correct, and there is no jump up to the second derivative.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "polyarm/paths/path.hpp"

namespace polyarm::test {

struct PathPoint {
  std::vector<double> q, first, second, third;
};
inline PathPoint point_at(const paths::Path& path, double s) {
  PathPoint p;
  for (auto* v : {&p.q, &p.first, &p.second, &p.third}) v->assign(path.joints(), NAN);
  path.at(s, {p.q, p.first, p.second, p.third});
  return p;
}

/// Compares the derivatives with central differences at `samples` places between every two breaks.
inline void expect_derivatives(const paths::Path& path, int samples = 5, double tolerance = 1e-5) {
  const auto breaks = path.breaks();
  for (std::size_t i = 0; i + 1 < breaks.size(); ++i) {
    const double length = breaks[i + 1] - breaks[i], h = 1e-4 * length;
    for (int k = 0; k < samples; ++k) {
      const double s = breaks[i] + length * (k + 0.5) / samples;
      const PathPoint a = point_at(path, s - h), at = point_at(path, s), b = point_at(path, s + h);
      const auto differ = [&](const std::vector<double>& low, const std::vector<double>& high,
                              const std::vector<double>& told, const std::vector<double>& next,
                              const char* what) {
        double scale = 1e-6, of = 0, most = 0;
        for (const double v : told) scale = std::max(scale, std::abs(v));
        for (const double v : next) scale = std::max(scale, std::abs(v) * length);
        for (const double v : low) of = std::max(of, std::abs(v));
        for (std::size_t j = 0; j < told.size(); ++j)
          most = std::max(most, std::abs((high[j] - low[j]) / (2 * h) - told[j]));
        ASSERT_LE(most, tolerance * scale + 4e-16 * of / h) << what << " at " << s << " of " << path.length();
      };
      differ(a.q, b.q, at.first, at.second, "first");
      differ(a.first, b.first, at.second, at.third, "second");
      differ(a.second, b.second, at.third, at.third, "third");
    }
  }
}

/// Checks that value, first and second derivative do not jump at any break. `tolerance` is relative to the
/// largest value of each near the break. The ends of the path do not count.
inline void expect_continuous(const paths::Path& path, double tolerance = 1e-8) {
  const auto breaks = path.breaks();
  ASSERT_GE(breaks.size(), 2u);
  ASSERT_EQ(breaks.front(), 0);
  ASSERT_EQ(breaks.back(), path.length());
  for (std::size_t i = 1; i + 1 < breaks.size(); ++i) {
    ASSERT_GT(breaks[i], breaks[i - 1]);
    const double near = std::min(breaks[i] - breaks[i - 1], breaks[i + 1] - breaks[i]), h = 1e-7 * near;
    const PathPoint a = point_at(path, breaks[i] - h), b = point_at(path, breaks[i]);
    double first = 0, second = 0, third = 0;
    for (const PathPoint* p : {&a, &b})
      for (std::size_t j = 0; j < path.joints(); ++j) {
        first = std::max(first, std::abs(p->first[j]));
        second = std::max(second, std::abs(p->second[j]));
        third = std::max(third, std::abs(p->third[j]));
      }
    for (std::size_t j = 0; j < path.joints(); ++j) {
      ASSERT_NEAR(a.q[j] + h * a.first[j], b.q[j], tolerance * first * near + 1e-14 * (1 + std::abs(b.q[j])))
          << "at " << breaks[i];
      ASSERT_NEAR(a.first[j] + h * a.second[j], b.first[j], tolerance * (first + second * near))
          << "at " << breaks[i];
      ASSERT_NEAR(a.second[j] + h * a.third[j], b.second[j],
                  tolerance * (second + third * near + first / near * 1e-3))
          << "at " << breaks[i];
    }
  }
}

}  // namespace polyarm::test
