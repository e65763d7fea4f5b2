#pragma once
/// Local minima of the distance from a seed over one variable of a redundant arm. Private to this room. Any
/// thread; allocates nothing.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>

#include "polyarm/kinematics/arm_geometry.hpp"

namespace polyarm::kinematics {

/// Keeps the `kMost` states of least cost, in order of cost.
template <std::size_t kMost>
class Dips {
 public:
  using State = std::array<double, ArmGeometry::kMostAxes>;
  using Rows = std::array<const double*, 7>;
  static constexpr double kNowhere = 1e300;  ///< the cost of a value without a state

  explicit Dips(std::span<State, kMost> states) noexcept : states_(states) {}
  std::size_t count() const noexcept { return count_; }

  /// Adds all local minima. `costs` has `count` values of the variable; joint j has the value row[j][k]
  /// there. `round`: the last value is a neighbour of the first. Neighbouring states that differ by more than
  /// 0.6 rad are on different curves, and each curve has its own minima.
  void take_all(const double* costs, const Rows& rows, std::size_t count, bool round) noexcept {
    constexpr double kJump = 0.6;  // rad
    const auto better = [&](std::size_t other, std::size_t k) {
      return costs[other] < costs[k] && apart(rows, other, k) < kJump;
    };
    for (std::size_t k = 0; k < count; ++k) {
      if (!(costs[k] < kNowhere) || (count_ == kMost && !(costs[k] < cost_[kMost - 1]))) continue;
      const std::size_t before = k > 0   ? k - 1
                                 : round ? count - 1
                                         : k,
                        after = k + 1 < count ? k + 1
                                : round       ? 0
                                              : k;
      if (!better(before, k) && !better(after, k)) take(costs[k], rows, k);
    }
  }

 private:
  static double apart(const Rows& rows, std::size_t a, std::size_t b) noexcept {
    double most = 0;
    for (const double* row : rows) most = std::max(most, std::abs(row[a] - row[b]));
    return most;
  }
  void take(double cost, const Rows& rows, std::size_t k) noexcept {
    std::size_t at = count_ < kMost ? count_++ : kMost - 1;
    for (; at > 0 && cost < cost_[at - 1]; --at) cost_[at] = cost_[at - 1], states_[at] = states_[at - 1];
    cost_[at] = cost;
    for (std::size_t i = 0; i < rows.size(); ++i) states_[at][i] = rows[i][k];
  }

  std::array<double, kMost> cost_{};
  std::span<State, kMost> states_;
  std::size_t count_ = 0;
};

}  // namespace polyarm::kinematics
