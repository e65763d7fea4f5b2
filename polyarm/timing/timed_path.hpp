#pragma once
/// A path with its timing: the place on the path and the joint state at each time. Radians or metres,
/// seconds.
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "polyarm/paths/path.hpp"
#include "polyarm/trajectory/constant_jerk.hpp"
#include "polyarm/trajectory/trajectory.hpp"

namespace polyarm::timing {

/// The path parameter and its time derivatives: s, per s, per s², per s³.
struct PathMotion {
  double s = 0, speed = 0, acceleration = 0, jerk = 0;
};

/// The motion `t` seconds later, at the same jerk.
inline PathMotion after(const PathMotion& m, double t) noexcept {
  const trajectory::JerkState end = after(trajectory::JerkState{m.s, m.speed, m.acceleration}, t, m.jerk);
  return {end.p, end.v, end.a, m.jerk};
}

/// s(t) as pieces of constant jerk: continuous up to the acceleration, never backwards. Const after
/// construction: any thread, no allocation in at().
class SpeedProfile {
 public:
  /// The start of one piece (s) and the motion there; `jerk` holds until the next piece.
  struct Piece {
    double begin;
    PathMotion motion;
  };

  SpeedProfile() = default;
  /// Starts at `start`; pieces of zero duration are skipped.
  explicit SpeedProfile(const PathMotion& start) : state_(start) {}
  void append(double duration, double jerk);
  /// The same with a known end: uses `end` instead of the sum, which avoids the rounding errors of many
  /// pieces.
  void append(double duration, double jerk, const PathMotion& end);

  double duration() const noexcept { return duration_; }
  /// The path parameter at the end of the profile.
  double length() const noexcept { return state_.s; }
  std::span<const Piece> pieces() const noexcept { return pieces_; }
  /// `t` in s, clamped to [0, duration()]. `hint`: an index of a piece that the caller keeps between calls.
  PathMotion at(double t, std::size_t& hint) const noexcept;
  /// The time from the start, s, at which the profile passes the place `s`; exact to the last bits.
  double time_at(double s) const noexcept;
  /// The same path in `factor` times the duration: divides speeds, accelerations and jerks by powers of the
  /// factor.
  void stretch(double factor) noexcept;
  /// The same times on a path that ends at `length`: removes small differences at the end.
  void fit(double length) noexcept;

 private:
  std::vector<Piece> pieces_;
  PathMotion state_;  // at the end
  double duration_ = 0;
};

/// A path and its timing. Keeps the path alive; const: any thread, no allocation in sample().
class TimedPath {
 public:
  TimedPath() = default;
  /// `profile` runs from s = 0 to the path's length.
  TimedPath(std::shared_ptr<const paths::Path> path, SpeedProfile profile);

  bool empty() const noexcept { return !path_; }
  const paths::Path& path() const noexcept { return *path_; }
  const std::shared_ptr<const paths::Path>& shared_path() const noexcept { return path_; }
  const SpeedProfile& profile() const noexcept { return profile_; }
  std::size_t joints() const noexcept { return path_ ? path_->joints() : 0; }
  double duration() const noexcept { return profile_.duration(); }

  /// Exact position, velocity, acceleration and jerk of all joints at `t` seconds (clamped). Spans of
  /// joints() values; trailing spans may be empty.
  void sample(double t, std::span<double> position, std::span<double> velocity,
              std::span<double> acceleration, std::span<double> jerk, std::size_t& hint) const noexcept;

 private:
  std::shared_ptr<const paths::Path> path_;
  SpeedProfile profile_;
};

/// The joint motion on `path` for the path motion `motion`. Spans as with TimedPath::sample.
void joints_on_path(const paths::Path& path, const PathMotion& motion, std::span<double> position,
                    std::span<double> velocity, std::span<double> acceleration,
                    std::span<double> jerk) noexcept;

/// The timed path as quintics that agree with it in position, velocity and acceleration at both ends of each,
/// and in position to `tolerance` (rad or m) in between. The error is measured at seven inner points of each
/// piece, which is halved until it holds (or is shorter than 1 µs). Allocates.
trajectory::Trajectory to_trajectory(const TimedPath& timed, double tolerance = 1e-8);

}  // namespace polyarm::timing
