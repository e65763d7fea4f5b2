#pragma once
/// Trajectories from points in time, with the semantics of ros2_control's joint trajectory controller.
/// Allocates and throws: not for the control cycle. Any thread.
#include <array>
#include <span>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/trajectory/trajectory.hpp"

namespace polyarm::trajectory {

/// One point of a trajectory message. Each list is empty or has a value for each joint: rad or m, per s, per
/// s²; effort in N m or N. `time_from_start` in s.
struct TrajectoryPoint {
  std::vector<double> positions, velocities, accelerations, effort;
  double time_from_start = 0;
};

/// Position, velocity and acceleration of a joint at one end of a segment.
struct SplineEnd {
  double position = 0, velocity = 0, acceleration = 0;
};
/// The coefficients of the polynomial from one end to the other in `duration` seconds. Degree 1 uses
/// positions, degree 3 also velocities, degree 5 also accelerations. No allocation.
std::array<double, Trajectory::kCoefficients> spline_piece(int degree, const SplineEnd& from,
                                                           const SplineEnd& to, double duration) noexcept;

/// `splines`: polynomials between the points. `none`: holds the start state until the first point's time,
/// then jumps in each interval to the point at its end.
enum class InterpolationMethod { splines, none };

/// How a continuous joint takes the shorter way to its first point.
/// `start`: shifts the start state by whole turns, as ros2_control does. The positions are those of the
/// message, but the trajectory may begin whole turns away from the given start state. `points`: shifts all
/// points instead, and the trajectory begins exactly at the start state; use it for a controller that refuses
/// jumps.
enum class Wraparound { start, points };

struct SplineOptions {
  InterpolationMethod method = InterpolationMethod::splines;
  Wraparound wraparound = Wraparound::start;
  bool allow_nonzero_velocity_at_end = false;
};

/// A trajectory from `start` at time 0 through all points (the time of `start` is ignored; its velocities and
/// accelerations may be empty). The fields present at both ends determine the degree of the polynomial
/// between two points: positions linear, with velocities cubic, with accelerations quintic. A first point at
/// time 0 replaces the start state; if it is the only one, it is held for 1 ms. `continuous` flags joints
/// without limits that turn freely; empty: none. Effort is checked for size and dropped. Throws Error with
/// all faults: "no-points", "wrong-size" (names point and field), "bad-time" (negative, or not later than the
/// previous point), "bad-number", "no-positions", "moves-at-end".
Trajectory interpolate(const TrajectoryPoint& start, std::span<const TrajectoryPoint> points,
                       const std::vector<bool>& continuous = {}, const SplineOptions& options = {});
/// Returns the same faults without the trajectory.
std::vector<Problem> check_points(const TrajectoryPoint& start, std::span<const TrajectoryPoint> points,
                                  const SplineOptions& options = {});

}  // namespace polyarm::trajectory
