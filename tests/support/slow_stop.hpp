#pragma once
/// Searches for the fastest possible stop on a timed path. It takes seconds; tests compare with it.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "polyarm/timing/timed_path.hpp"
#include "polyarm/trajectory/state_to_state.hpp"

namespace polyarm::test {

/// The shortest stop found from `time` of the plan at the steady `factor`, s. The search proceeds in layers
/// of `step` s. From every state it tries eleven f'' between the lowest and the highest that the rows allow,
/// and also those that change nothing or end at a steady f. Of states with nearly equal f and f' it keeps the
/// one that has advanced least. Rows are checked at the beginning, middle and end of each step, with slightly
/// higher limits, so the result is rather too fast than too slow.
class SlowStop {
 public:
  SlowStop(const timing::TimedPath& path, std::span<const trajectory::MotionLimits> limits,
           double step = 4e-3, double slack = 1.001)
      : path_(path), limits_(limits.begin(), limits.end()), step_(step) {
    for (trajectory::MotionLimits& l : limits_)
      l.max_acceleration *= slack, l.min_acceleration *= slack, l.max_jerk *= slack;
    for (auto* v : {&q_, &v_, &a_, &j_}) v->resize(limits.size());
  }

  double search(double time, double factor, double longest = 1.5) {
    std::vector<State> layer{{time, factor, 0}};
    double best = longest;
    for (int k = 0; double(k) * step_ < best && !layer.empty(); ++k) {
      std::unordered_map<std::int64_t, State> next;
      for (const State& s : layer) {
        best = std::min(best, double(k) * step_ + landing(s, best));
        for (const double bend : bends(s)) {
          const State to = after(s, bend, step_);
          if (to.factor < 0 || to.factor > 1 + 1e-9 || to.rate > 1e-9) continue;
          const auto bin =
              std::int64_t(std::round(to.factor * 300)) * 100'000 + std::int64_t(std::round(-to.rate * 30));
          const auto at = next.find(bin);
          if (at != next.end() && !(to.time < at->second.time)) continue;
          if (kept(s, bend, step_)) next[bin] = to;
        }
      }
      layer.clear();
      for (const auto& [bin, s] : next) layer.push_back(s);
    }
    return best;
  }

 private:
  struct State {
    double time, factor, rate;
  };
  State after(const State& s, double bend, double t) const {
    return {s.time + t * (s.factor + t * (s.rate / 2 + t * bend / 6)), s.factor + t * (s.rate + t * bend / 2),
            s.rate + t * bend};
  }
  void look(double time) { path_.sample(time, q_, v_, a_, j_, hint_); }
  std::vector<double> bends(const State& s) {
    std::vector<double> out{0, -s.rate / step_};
    double low = -20'000, high = 20'000;
    for (const double part : {0.0, 0.5, 1.0}) narrow(s, part * step_, low, high);
    for (int i = 0; i <= 10 && low <= high; ++i) out.push_back(low + (high - low) * i / 10);
    return out;
  }
  /// Narrows the range of f'' to what the rows allow after it has acted for `t` s.
  void narrow(const State& s, double t, double& low, double& high) {
    const State in = after(s, 0, t);
    look(in.time);
    const double square = in.factor * in.factor;
    const auto within = [&](double own, double slope, double least, double most) {
      if (std::abs(slope) < 1e-12) return;
      const double x = (least - own) / slope, y = (most - own) / slope;
      low = std::max(low, std::min(x, y)), high = std::min(high, std::max(x, y));
    };
    for (std::size_t i = 0; i < limits_.size(); ++i) {
      const double turn = a_[i] * in.factor;
      within(j_[i] * square * in.factor + 3 * turn * s.rate, v_[i] + 3 * turn * t, -limits_[i].max_jerk,
             limits_[i].max_jerk);
      within(a_[i] * square + v_[i] * s.rate, t * (v_[i] + turn * t), limits_[i].min_acceleration,
             limits_[i].max_acceleration);
    }
  }
  bool kept(const State& s, double bend, double t) {
    for (const double part : {0.0, 0.5, 1.0}) {
      const State in = after(s, bend, part * t);
      look(in.time);
      const double square = in.factor * in.factor;
      for (std::size_t i = 0; i < limits_.size(); ++i) {
        const double a = a_[i] * square + v_[i] * in.rate;
        const double j = j_[i] * square * in.factor + 3 * a_[i] * in.factor * in.rate + v_[i] * bend;
        if (a > limits_[i].max_acceleration || a < limits_[i].min_acceleration ||
            std::abs(j) > limits_[i].max_jerk)
          return false;
      }
    }
    return true;
  }
  /// The time to rest with one constant f'' from here; `longest` if that is not possible.
  double landing(const State& s, double longest) {
    if (!(s.rate < 0) || !(s.factor > 0)) return longest;
    const double t = -2 * s.factor / s.rate, bend = -s.rate / t;
    if (t > 0.4) return longest;
    for (int k = 0; k < 8; ++k)
      if (!kept(after(s, bend, t * k / 8), bend, t / 8)) return longest;
    return t;
  }

  const timing::TimedPath& path_;
  std::vector<trajectory::MotionLimits> limits_;
  double step_;
  std::vector<double> q_, v_, a_, j_;
  std::size_t hint_ = 0;
};

}  // namespace polyarm::test
