#pragma once
/// A path with its time: where along the path at which time, and what the joints do then.
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

/// `t` seconds later, under the same jerk.
inline PathMotion after(const PathMotion& m, double t) noexcept {
  const trajectory::JerkState end = after(trajectory::JerkState{m.s, m.speed, m.acceleration}, t, m.jerk);
  return {end.p, end.v, end.a, m.jerk};
}

/// s(t) as pieces of constant jerk: continuous to the acceleration, never backwards. Const after
/// construction: any thread, no allocation in at().
class SpeedProfile {
 public:
  /// Of one piece: when it begins (s), the motion there; `jerk` holds until the next one.
  struct Piece {
    double begin;
    PathMotion motion;
  };

  SpeedProfile() = default;
  /// From `start`; pieces that last no time are left out.
  explicit SpeedProfile(const PathMotion& start) : state_(start) {}
  void append(double duration, double jerk);
  /// The same, where the end is known: `end` is taken for it, without the rounding of many pieces.
  void append(double duration, double jerk, const PathMotion& end);

  double duration() const noexcept { return duration_; }
  /// Where the profile ends.
  double length() const noexcept { return state_.s; }
  std::span<const Piece> pieces() const noexcept { return pieces_; }
  /// `t` in s, clamped to [0, duration()]. `hint`: a piece's index that the caller keeps between calls.
  PathMotion at(double t, std::size_t& hint) const noexcept;
  /// When the profile passes `s`, in s (time) from the start; to the last bits.
  double time_at(double s) const noexcept;
  /// The same way in `factor` times the time: speeds, accelerations and jerks are divided by its powers.
  void stretch(double factor) noexcept;
  /// The same times on a way that ends at `length`: takes small differences off the end.
  void fit(double length) noexcept;

 private:
  std::vector<Piece> pieces_;
  PathMotion state_;  // at the end
  double duration_ = 0;
};

/// A path and when to be where on it. Keeps the path alive; const, any thread, no allocation in sample().
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

  /// Position, velocity, acceleration and jerk of all joints at `t` seconds (clamped), exactly. Spans of
  /// joints() values; a later one may be empty, but none before a span that is wanted.
  void sample(double t, std::span<double> position, std::span<double> velocity,
              std::span<double> acceleration, std::span<double> jerk, std::size_t& hint) const noexcept;

 private:
  std::shared_ptr<const paths::Path> path_;
  SpeedProfile profile_;
};

/// What the joints do on `path` while it is passed as `motion` says. Spans as with TimedPath::sample.
void joints_on_path(const paths::Path& path, const PathMotion& motion, std::span<double> position,
                    std::span<double> velocity, std::span<double> acceleration,
                    std::span<double> jerk) noexcept;

/// The timed path as quintics that agree with it in position, velocity and acceleration at both ends of each,
/// and in position to `tolerance` (rad or m) between: measured at seven inner points of each piece, which
/// is halved until it holds (or lasts less than 1 µs). Allocates.
trajectory::Trajectory to_trajectory(const TimedPath& timed, double tolerance = 1e-8);

}  // namespace polyarm::timing
