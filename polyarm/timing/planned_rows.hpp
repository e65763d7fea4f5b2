#pragma once
/// The joint motion of a timed path as a table that a control cycle can search cheaply. Radians or metres,
/// seconds.
#include <cstddef>
#include <span>
#include <vector>

#include "polyarm/timing/timed_path.hpp"
#include "polyarm/trajectory/state_to_state.hpp"

namespace polyarm::timing {

/// Velocity, acceleration and jerk of all joints as planned, at nodes of time; the last two are linear in
/// between. Every jump of a planned jerk is a pair of nodes, one for each side. Built outside the cycle; then
/// const: any thread.
class PlannedRows {
 public:
  /// Joints side by side, eight at a time; unused entries are 0.
  static constexpr std::size_t kWidth = 8;
  struct Rows {
    double velocity[kWidth], acceleration[kWidth], jerk[kWidth];
  };
  /// For up to eight joints: highest and lowest acceleration (1e300 for unused entries), highest jerk.
  struct Limits {
    double high[kWidth], low[kWidth], jerk[kWidth];
  };

  /// `spacing`: largest distance between nodes, s. Nodes are closer where the rows are curved; the error
  /// between nodes is about 1e-4 of a joint's limits.
  PlannedRows(const TimedPath& path, std::span<const trajectory::MotionLimits> limits, double spacing);

  std::size_t blocks() const noexcept { return blocks_; }
  std::size_t nodes() const noexcept { return times_.size(); }
  double time(std::size_t node) const noexcept { return times_[node]; }
  const Rows* at(std::size_t node) const noexcept { return rows_.data() + node * blocks_; }
  /// The node at or before `t`; the second node of a pair. `hint`: a node close to it.
  std::size_t before(double t, std::size_t hint) const noexcept;
  /// blocks() rows at `t` (within the path's time); `t` lies in the interval that begins at `node`.
  void between(std::size_t node, double t, Rows* out) const noexcept;

  static std::vector<Limits> limits_of(std::span<const trajectory::MotionLimits> limits, double harder);

 private:
  void add(double time, std::span<const double> v, std::span<const double> a, std::span<const double> j);

  std::size_t blocks_;
  std::vector<double> times_;
  std::vector<Rows> rows_;
};

}  // namespace polyarm::timing
