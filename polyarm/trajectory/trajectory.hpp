#pragma once
/// A trajectory: the exact values of every joint at every time. Radians or metres, seconds. Built outside the
/// control loop, then const.
#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace polyarm::trajectory {

/// Piecewise polynomials in time, one for each joint and segment, of degree at most kDegree.
/// Thread: built on any thread; sample() is const, allocates nothing and never throws.
class Trajectory {
 public:
  static constexpr int kDegree = 5;
  static constexpr int kCoefficients = kDegree + 1;

  Trajectory() = default;
  explicit Trajectory(std::size_t joints) : joints_(joints) {}

  std::size_t joints() const noexcept { return joints_; }
  std::size_t segments() const noexcept { return ends_.size(); }
  /// Seconds from start to end; 0 for an empty trajectory.
  double duration() const noexcept { return ends_.empty() ? 0.0 : ends_.back(); }
  bool empty() const noexcept { return ends_.empty(); }
  /// End time of segment `i`, s from the start.
  double end_of(std::size_t i) const noexcept { return ends_[i]; }

  /// Appends a segment of `duration` > 0 seconds. `coefficients[j * kCoefficients + k]` belongs to joint j
  /// and power k of the time since the segment began.
  void append(double duration, std::span<const double> coefficients);

  /// Replaces the polynomial of one joint in one segment: `coefficients` has kCoefficients values. Allocates
  /// nothing; for the thread that owns the trajectory.
  void set_piece(std::size_t segment, std::size_t joint, std::span<const double> coefficients) noexcept;

  /// Adds `offset` to every position of one joint. Allocates nothing.
  void shift(std::size_t joint, double offset) noexcept;

  /// Position, velocity and acceleration at `t` seconds; spans of `joints()` values, empty if not needed.
  /// Before the start: the first values with zero velocity. After the end: the last values with zero velocity
  /// and acceleration. `hint` is a segment index that the caller keeps between calls; it makes the lookup
  /// O(1).
  void sample(double t, std::span<double> position, std::span<double> velocity,
              std::span<double> acceleration, std::size_t& hint) const noexcept;

 private:
  std::size_t joints_ = 0;
  std::vector<double> ends_;          // s, increasing
  std::vector<double> coefficients_;  // [segment][power][joint], so joints are sampled in lanes
};

}  // namespace polyarm::trajectory
