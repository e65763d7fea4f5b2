#pragma once
/// The least of a function of one variable, looked at eight values at a time, around a place that a scan has
/// found. Where three neighbours have a value, the parabola through them says where to look next (Brent 1973,
/// chapter 5); where there are borders or none, the stretch shrinks around the best. Used inside this room
/// only.
#include <cmath>
#include <cstddef>

namespace polyarm::kinematics {

class EightfoldSearch {
 public:
  static constexpr std::size_t kValues = 8;
  static constexpr double kNowhere = 1e300;  ///< the cost of a value at which there is none

  /// `cost` is that of `at`; the least may be up to about `reach` away.
  EightfoldSearch(double at, double cost, double reach) noexcept
      : best_(at), cost_(cost), center_(at), step_(reach / 3.5) {}

  /// Whether it is worth to look at first() + k * step() for k from 0 to 7.
  bool going(double fine) const noexcept { return rounds_ < kMostRounds && step_ > fine; }
  double first() const noexcept { return center_ - 3.5 * step_; }
  double step() const noexcept { return step_; }
  double best() const noexcept { return best_; }
  double cost() const noexcept { return cost_; }

  /// Takes the eight costs. Returns the index of the new best, kValues where all are worse.
  std::size_t see(const double* costs) noexcept {
    ++rounds_;
    std::size_t least = 0;
    for (std::size_t k = 1; k < kValues; ++k)
      if (costs[k] < costs[least]) least = k;
    const double at = first() + static_cast<double>(least) * step_;
    const bool better = costs[least] < cost_;
    if (better) best_ = at, cost_ = costs[least];
    center_ = best_;
    const bool inner = least > 0 && least + 1 < kValues;
    if (better && !inner) return least;  // it goes on beyond
    if (inner && costs[least - 1] < kNowhere && costs[least + 1] < kNowhere) {
      const double slope = costs[least - 1] - costs[least + 1],
                   bend = costs[least - 1] - 2 * costs[least] + costs[least + 1];
      const double foot = bend > 0 ? at + 0.5 * step_ * slope / bend : best_ + 9 * step_;
      if (std::abs(foot - best_) < 2 * step_) {
        center_ = foot;
        step_ *= 0.02;
        return better ? least : kValues;
      }
    }
    step_ *= 0.28;
    return better ? least : kValues;
  }

 private:
  static constexpr int kMostRounds = 12;
  double best_, cost_, center_, step_;
  int rounds_ = 0;
};

}  // namespace polyarm::kinematics
