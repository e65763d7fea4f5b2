#include "polyarm/trajectory/limit_use.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "polyarm/base/error.hpp"
#include "polyarm/trajectory/splines.hpp"

namespace polyarm::trajectory {
namespace {

/// A polynomial of degree 5 or less over [0, 1].
using Coefficients = std::array<double, Trajectory::kCoefficients>;

double value(const Coefficients& c, double x) {
  double out = 0;
  for (std::size_t k = c.size(); k-- > 0;) out = out * x + c[k];
  return out;
}

Coefficients derivative(const Coefficients& c) {
  Coefficients out{};
  for (std::size_t k = 1; k < c.size(); ++k) out[k - 1] = double(k) * c[k];
  return out;
}

/// The sign changes of `c` within [0, 1], and both ends. Between two zeros of the derivative there is at most
/// one, which bisection finds.
std::vector<double> zeros_and_ends(const Coefficients& c, int degree) {
  if (degree <= 0) return {0, 1};
  const std::vector<double> edges = zeros_and_ends(derivative(c), degree - 1);
  std::vector<double> out{0};
  for (std::size_t i = 1; i < edges.size(); ++i) {
    double low = edges[i - 1], high = edges[i];
    const bool below = value(c, low) < 0;
    if (below == (value(c, high) < 0)) continue;
    for (int k = 0; k < 60; ++k) {
      const double middle = (low + high) / 2;
      ((value(c, middle) < 0) == below ? low : high) = middle;
    }
    out.push_back((low + high) / 2);
  }
  out.push_back(1);
  return out;
}

/// Calls `take` with the value and time of each extremum of `c` within the piece.
template <typename Take>
void extrema(const Coefficients& c, int degree, double begin, double duration, Take take) {
  for (const double x : zeros_and_ends(derivative(c), degree - 1)) take(value(c, x), begin + x * duration);
}

Coefficients scaled(Coefficients c, double factor) {
  for (double& x : c) x *= factor;
  return c;
}

class Looker {
 public:
  Looker(const Trajectory& t, std::span<const MotionLimits> limits) : t_(t), limits_(limits), n_(t.joints()) {
    for (auto* v : {&q_, &v_, &a_}) v->resize(2 * n_);
  }
  std::vector<JointUse> look() {
    std::vector<JointUse> out(n_);
    std::vector<double> v(n_, 0.0), a(n_, 0.0);
    double begin = 0;
    for (std::size_t i = 0; i < t_.segments(); ++i) {
      const double end = t_.end_of(i);
      sample(begin, i, 0), sample(std::nextafter(end, 0.0), i, n_);
      for (std::size_t j = 0; j < n_; ++j) {
        if (i == 0) start(out[j], j);
        step(out[j], j, begin, v_[j] - v[j], a_[j] - a[j]);
        piece(out[j], j, begin, end - begin);
        v[j] = v_[n_ + j], a[j] = a_[n_ + j];
      }
      begin = end;
    }
    for (std::size_t j = 0; j < n_ && t_.segments() > 0; ++j) step(out[j], j, begin, -v[j], -a[j]);
    return out;
  }

 private:
  void sample(double t, std::size_t segment, std::size_t at) {
    std::size_t hint = segment;
    const auto part = [&](std::vector<double>& x) { return std::span(x).subspan(at, n_); };
    t_.sample(t, part(q_), part(v_), part(a_), hint);
  }
  void start(JointUse& use, std::size_t j) const { use.lowest = use.highest = {q_[j], 0}; }
  void step(JointUse& use, std::size_t j, double time, double velocity, double acceleration) const {
    const MotionLimits& l = limits_[j];
    if (std::abs(velocity) > 1e-6 * l.max_velocity) {
      ++use.velocity_steps;
      if (std::abs(velocity) > std::abs(use.velocity_step.value)) use.velocity_step = {velocity, time};
    }
    if (std::abs(acceleration) > 1e-5 * l.max_acceleration) {
      ++use.acceleration_steps;
      if (std::abs(acceleration) > std::abs(use.acceleration_step.value))
        use.acceleration_step = {acceleration, time};
    }
  }
  void piece(JointUse& use, std::size_t j, double begin, double duration) const {
    // The polynomial that agrees with the piece at both ends is the piece, because its degree is at most 5.
    const Coefficients q =
        spline_piece(5, {q_[j], v_[j] * duration, a_[j] * duration * duration},
                     {q_[n_ + j], v_[n_ + j] * duration, a_[n_ + j] * duration * duration}, 1.0);
    const Coefficients v = scaled(derivative(q), 1 / duration), a = scaled(derivative(v), 1 / duration),
                       jerk = scaled(derivative(a), 1 / duration);
    extrema(q, 5, begin, duration, [&](double x, double t) {
      if (x < use.lowest.value) use.lowest = {x, t};
      if (x > use.highest.value) use.highest = {x, t};
    });
    const auto take = [](Peak& peak, double& most, double low, double high) {
      return [&peak, &most, low, high](double x, double t) {
        const double ratio = x < 0 ? x / low : x / high;
        if (ratio > most) peak = {x, t}, most = ratio;
      };
    };
    const MotionLimits& l = limits_[j];
    extrema(v, 4, begin, duration, take(use.velocity, use.velocity_use, l.min_velocity, l.max_velocity));
    extrema(a, 3, begin, duration,
            take(use.acceleration, use.acceleration_use, l.min_acceleration, l.max_acceleration));
    extrema(jerk, 2, begin, duration, take(use.jerk, use.jerk_use, -l.max_jerk, l.max_jerk));
  }

  const Trajectory& t_;
  std::span<const MotionLimits> limits_;
  std::size_t n_;
  std::vector<double> q_, v_, a_;  // at the start, then at the end of a piece
};

}  // namespace

std::vector<JointUse> limit_use(const Trajectory& trajectory, std::span<const MotionLimits> limits) {
  if (limits.size() != trajectory.joints())
    throw Error("wrong-size", "limits for " + std::to_string(limits.size()) + " joints, the trajectory has " +
                                  std::to_string(trajectory.joints()));
  return Looker(trajectory, limits).look();
}

double stretch_needed(std::span<const JointUse> uses) {
  double out = 0;
  for (const JointUse& u : uses)
    out = std::max({out, u.velocity_use, std::sqrt(u.acceleration_use), std::cbrt(u.jerk_use)});
  return out;
}

}  // namespace polyarm::trajectory
