#pragma once
/// How soon a timed path can come to rest at all: a search that takes seconds, to measure by.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "polyarm/trajectory/path_trajectory.hpp"
#include "polyarm/trajectory/state_to_state.hpp"

namespace polyarm::test {

/// The shortest stop found from `time` on the plan at the steady `factor`, s. In layers of `step` s all f''
/// out of nine between the lowest and the highest that the rows leave are tried from every state; of states
/// with nearly the same f and f' one is kept, that which has come the least far. Rows are looked at where
/// steps begin and end and in their middle, with limits a little higher, so that it errs on the fast side.
class SlowStop {
 public:
  SlowStop(const trajectory::TimedPath& path, std::span<const trajectory::MotionLimits> limits,
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
        const auto [low, high] = room(s);
        for (int i = 0; i <= 8 && low <= high; ++i) {
          const State to = after(s, low + (high - low) * i / 8, step_);
          if (to.factor < 0 || to.factor > 1 + 1e-9 || to.rate > 1e-9) continue;
          if (!kept(s, low + (high - low) * i / 8, step_)) continue;
          const auto bin =
              std::int64_t(std::round(to.factor * 150)) * 100'000 + std::int64_t(std::round(-to.rate * 15));
          const auto [at, fresh] = next.try_emplace(bin, to);
          if (!fresh && to.time < at->second.time) at->second = to;
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
  /// What the rows leave f'' here.
  std::pair<double, double> room(const State& s) {
    look(s.time);
    double low = -20'000, high = 20'000;
    const double square = s.factor * s.factor;
    for (std::size_t i = 0; i < limits_.size(); ++i) {
      const double own = j_[i] * square * s.factor + 3 * a_[i] * s.factor * s.rate,
                   most = limits_[i].max_jerk;
      if (std::abs(v_[i]) < 1e-12) continue;
      const double x = (-most - own) / v_[i], y = (most - own) / v_[i];
      low = std::max(low, std::min(x, y)), high = std::min(high, std::max(x, y));
      // The acceleration at the step's end, roughly: what ends beyond it is found out by kept().
      const double now = a_[i] * square + v_[i] * s.rate, gain = v_[i] * step_;
      const double p = (limits_[i].min_acceleration - now) / gain,
                   r = (limits_[i].max_acceleration - now) / gain;
      low = std::max(low, std::min(p, r) - 5), high = std::min(high, std::max(p, r) + 5);
    }
    return {low, high};
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
  /// To rest with one f'' from here, where that can be; else a long time.
  double landing(const State& s, double longest) {
    if (!(s.rate < 0) || !(s.factor > 0)) return longest;
    const double t = -2 * s.factor / s.rate, bend = -s.rate / t;
    if (t > 0.4) return longest;
    for (int k = 0; k < 8; ++k)
      if (!kept(after(s, bend, t * k / 8), bend, t / 8)) return longest;
    return t;
  }

  const trajectory::TimedPath& path_;
  std::vector<trajectory::MotionLimits> limits_;
  double step_;
  std::vector<double> q_, v_, a_, j_;
  std::size_t hint_ = 0;
};

}  // namespace polyarm::test
