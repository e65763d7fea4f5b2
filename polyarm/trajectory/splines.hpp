#pragma once
/// Trajectories given as points in time, with the meaning that ros2_control's joint trajectory controller
/// gives them.
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
/// The coefficients of the polynomial from one end to the other in `duration` seconds: degree 1 uses
/// positions, 3 velocities too, 5 accelerations too. No allocation.
std::array<double, Trajectory::kCoefficients> spline_piece(int degree, const SplineEnd& from,
                                                           const SplineEnd& to, double duration) noexcept;

/// `splines`: polynomials between the points. `none`: the start state until the first point's time, then at
/// once the point that each interval leads to.
enum class InterpolationMethod { splines, none };

/// How a continuous joint takes the shorter way round to its first point.
/// `start`: the start state is shifted by whole turns, as ros2_control does, so the positions are those of
/// the message but the trajectory may begin whole turns away from where the joint is said to be. `points`:
/// all points are shifted instead, and the trajectory begins exactly at the start state; take this one for a
/// controller that refuses jumps.
enum class Wraparound { start, points };

struct SplineOptions {
  InterpolationMethod method = InterpolationMethod::splines;
  Wraparound wraparound = Wraparound::start;
  bool allow_nonzero_velocity_at_end = false;
};

/// From `start` (its time is not used; velocities and accelerations may be empty) at time 0 through all
/// points. Between two points the polynomial has the degree that the fields present on both ends determine:
/// positions linear, with velocities cubic, with accelerations quintic. A first point at time 0 replaces the
/// start state; if it is the only one, it is held for 1 ms. `continuous` flags joints that turn without end;
/// empty: none. Effort is checked for size and not kept. Throws Error with every fault found: "no-points",
/// "wrong-size" (names point and field), "bad-time" (negative, or not later than the point before),
/// "bad-number", "no-positions", "moves-at-end".
Trajectory interpolate(const TrajectoryPoint& start, std::span<const TrajectoryPoint> points,
                       const std::vector<bool>& continuous = {}, const SplineOptions& options = {});
/// The same findings without the trajectory.
std::vector<Problem> check_points(const TrajectoryPoint& start, std::span<const TrajectoryPoint> points,
                                  const SplineOptions& options = {});

}  // namespace polyarm::trajectory
