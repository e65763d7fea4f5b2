#pragma once
/// Computes how much of their limits joints use on a timed path whose speed factor changes: at every
/// extremum.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "polyarm/timing/timed_path.hpp"
#include "polyarm/trajectory/state_to_state.hpp"

namespace polyarm::test {

/// One cycle of PathOverride: its start on the planned time, factor and rate there, and the constant bend.
struct FactorCycle {
  double time, factor, rate, bend, period;
  double harder = 1;  ///< of an immediate stop: factor for the acceleration, and its square for the jerk
};

/// Evaluates velocities, accelerations and jerks exactly (chain rule, closed form) on both sides of every
/// jump. Between jumps they are smooth: they are sampled at `looks` times. Around each sample that is a local
/// maximum close to its limit, a search finds the extremum to the last bits.
class LimitExtrema {
 public:
  LimitExtrema(const timing::TimedPath& path, std::span<const trajectory::MotionLimits> limits,
               int looks = 11)
      : path_(path), limits_(limits.begin(), limits.end()), looks_(looks) {
    for (const timing::SpeedProfile::Piece& piece : path.profile().pieces()) jumps_.push_back(piece.begin);
    for (const double s : path.path().breaks()) jumps_.push_back(path.profile().time_at(s));
    std::sort(jumps_.begin(), jumps_.end());
    // Removes jumps of path and profile that are the same except for rounding.
    jumps_.erase(std::unique(jumps_.begin(), jumps_.end(), [](double a, double b) { return b - a < kSame; }),
                 jumps_.end());
    for (auto* v : {&q_, &v_, &a_, &j_}) v->resize(limits_.size());
  }

  /// The highest fraction of a limit in this cycle.
  double most(const FactorCycle& cycle) {
    cycle_ = cycle;
    const double end = at(cycle.period);
    const double low = std::min(cycle.time, end), high = std::max(cycle.time, end);
    std::vector<double> ends{0, cycle.period};
    for (auto jump = std::upper_bound(jumps_.begin(), jumps_.end(), low);
         jump != jumps_.end() && *jump < high; ++jump)
      ends.push_back(when(*jump));
    std::sort(ends.begin(), ends.end());
    double out = 0;
    for (std::size_t k = 0; k + 1 < ends.size(); ++k) {
      // One side of a jump is evaluated slightly beside it.
      const double f = std::abs(cycle.factor + ends[k] * (cycle.rate + ends[k] * cycle.bend / 2));
      const double side = std::min(2 * kSame / std::max(f, 1e-3), (ends[k + 1] - ends[k]) / 4);
      out = std::max(out, between(ends[k] + side, ends[k + 1] - side));
    }
    return out;
  }
  /// The row with the highest use so far: its joint, and its derivative (1 to 3).
  std::size_t joint() const { return joint_; }
  int derivative() const { return derivative_; }

 private:
  static constexpr double kSame = 4e-9;  // s of the plan
  static constexpr double kNear = 0.98;  // of a limit: below this, no extremum between two samples reaches
                                         // the limit

  double at(double t) const {
    return cycle_.time + t * (cycle_.factor + t * (cycle_.rate / 2 + t * cycle_.bend / 6));
  }
  double when(double time) const {
    double low = 0, high = cycle_.period;
    const bool forward = at(high) >= at(low);
    for (int i = 0; i < 60; ++i) {
      const double middle = (low + high) / 2;
      ((at(middle) < time) == forward ? low : high) = middle;
    }
    return (low + high) / 2;
  }
  /// Computes the fractions of all joints' limits at `t` into shares_, three for each joint.
  const std::vector<double>& look(double t) {
    const double f = cycle_.factor + t * (cycle_.rate + t * cycle_.bend / 2),
                 g = cycle_.rate + t * cycle_.bend;
    const double time = at(t);
    shares_.assign(3 * limits_.size(), 0.0);
    if (time < 0 || time > path_.duration()) return shares_;
    path_.sample(time, q_, v_, a_, j_, hint_);
    for (std::size_t i = 0; i < limits_.size(); ++i) {
      const trajectory::MotionLimits& l = limits_[i];
      const double v = v_[i] * f, a = a_[i] * f * f + v_[i] * g;
      const double jerk = j_[i] * f * f * f + 3 * a_[i] * f * g + v_[i] * cycle_.bend;
      shares_[3 * i] = std::max(v / l.max_velocity, v / l.min_velocity);
      shares_[3 * i + 1] = std::max(a / l.max_acceleration, a / l.min_acceleration) / cycle_.harder;
      shares_[3 * i + 2] = std::abs(jerk) / (cycle_.harder * cycle_.harder * l.max_jerk);
    }
    return shares_;
  }
  double between(double begin, double end) {
    std::vector<std::vector<double>> seen;
    for (int k = 0; k < looks_; ++k) seen.push_back(look(begin + (end - begin) * k / (looks_ - 1)));
    double out = 0;
    for (std::size_t row = 0; row < 3 * limits_.size(); ++row)
      for (std::size_t k = 0; k < seen.size(); ++k) {
        double share = seen[k][row];
        if (share > kNear && (k == 0 || share >= seen[k - 1][row]) &&
            (k + 1 == seen.size() || share >= seen[k + 1][row]))
          share = std::max(
              share,
              peak(row, begin + (end - begin) * std::max(0.0, double(k) - 1) / (looks_ - 1),
                   begin + (end - begin) * std::min(double(looks_ - 1), double(k) + 1) / (looks_ - 1)));
        if (share > highest_) highest_ = share, joint_ = row / 3, derivative_ = int(row % 3) + 1;
        out = std::max(out, share);
      }
    return out;
  }
  /// Finds a peak by golden-section search.
  double peak(std::size_t row, double low, double high) {
    constexpr double kGolden = 0.6180339887498949;
    double a = high - kGolden * (high - low), b = low + kGolden * (high - low);
    double at_a = look(a)[row], at_b = look(b)[row];
    for (int i = 0; i < 36; ++i) {
      if (at_a > at_b) {
        high = b, b = a, at_b = at_a;
        at_a = look(a = high - kGolden * (high - low))[row];
      } else {
        low = a, a = b, at_a = at_b;
        at_b = look(b = low + kGolden * (high - low))[row];
      }
    }
    return std::max(at_a, at_b);
  }

  const timing::TimedPath& path_;
  std::vector<trajectory::MotionLimits> limits_;
  int looks_;
  std::vector<double> jumps_, q_, v_, a_, j_, shares_;
  FactorCycle cycle_{};
  std::size_t hint_ = 0, joint_ = 0;
  double highest_ = 0;
  int derivative_ = 0;
};

}  // namespace polyarm::test
