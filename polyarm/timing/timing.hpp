#pragma once
/// Time-optimal timing of a path within the limits of joints and tool, with limited jerk. Radians or metres,
/// seconds. It allocates and throws: not for the control cycle.
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/timing/timed_path.hpp"
#include "polyarm/trajectory/state_to_state.hpp"

namespace polyarm::timing {

/// Limits of the length of a vector that moves along the path: the tool's velocity (m/s) or angular velocity
/// (rad/s) and its next two time derivatives. `path` has the components of the vector as joints. Its at()
/// gives in `first` the components of dx/ds (for rotation: the angular velocity per path speed), in `second`
/// and `third` their derivatives with respect to s; `q` is not used. Its length must be that of the timed
/// path, and its breaks() must be among that path's or its own. Infinite: no limit.
struct NormLimit {
  const paths::Path* path = nullptr;
  double max_velocity = 0, max_acceleration = 0, max_jerk = 0;
  std::string name;  ///< for messages: "tool speed"
};

enum class LimitKind : std::uint8_t { velocity, acceleration, jerk };
const char* name(LimitKind kind) noexcept;

/// Between `from` and `to` (path parameter) this row limits the speed. `row`: a joint, or joints() plus the
/// index of a norm.
struct ActiveLimit {
  double from = 0, to = 0;
  std::size_t row = 0;
  LimitKind kind = LimitKind::velocity;
};

struct TimingOptions {
  /// ṡ at the start and at the end of the path, in s per second; s̈ is 0 there.
  double start_speed = 0, end_speed = 0;
  /// Bounds in addition to those of the joints.
  std::span<const NormLimit> norms;
  /// Density of the grid: 1 as the speed targets require, 4 for four times the nodes.
  double fineness = 1;
};

struct Timing {
  SpeedProfile profile;
  /// Contiguous, in order of s, from 0 to the path's length. If several rows are equally near their limits,
  /// the nearest.
  std::vector<ActiveLimit> active;
  /// The nodes of s of the plan.
  std::vector<double> grid;
  /// The highest value of any row over its limit minus one in the final check; at most 1e-6.
  double excess = 0;
  int iterations = 0;  ///< of the solver, in total
};

/// The fastest s(t) found that keeps, for every joint and at every place of the path,
///   min_velocity ≤ q'ṡ ≤ max_velocity, min_acceleration ≤ q's̈ + q''ṡ² ≤ max_acceleration,
///   |q's⃛ + 3q''ṡs̈ + q'''ṡ³| ≤ max_jerk
/// and the norms alike. Deterministic. Method: docs/decisions/0010-timing.md.
///
/// Throws Error: "wrong-size" (limits and joints differ, or a norm's path has another length), "bad-limit"
/// (wrong sign, or NaN), "bad-path" (a value of the path is not finite; says where), "path-too-fast" (the
/// speed at an end is too high for a limit; says which, where, and what speed is possible).
Timing time_path(const paths::Path& path, std::span<const trajectory::MotionLimits> limits,
                 const TimingOptions& options = {});

/// The same, as a path that can be followed.
TimedPath timed(std::shared_ptr<const paths::Path> path, std::span<const trajectory::MotionLimits> limits,
                const TimingOptions& options = {});

}  // namespace polyarm::timing
