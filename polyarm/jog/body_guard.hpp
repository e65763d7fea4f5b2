#pragma once
/// Makes the barriers of a robot that is jogged from the bodies around it, in each tick. Cell thread;
/// allocates in the constructor alone. Metres, radians, seconds.
#include <array>
#include <span>
#include <vector>

#include "polyarm/jog/barriers.hpp"
#include "polyarm/surroundings/guard_bodies.hpp"

namespace polyarm::jog {

struct BodyGuardOptions {
  double clearance = 0.005;  ///< m that links keep from everything else
  double tool_clearance =
      0.001;  ///< m that the tool, or the hand, keeps from fixtures: places are taught with it
  /// Exact distances in one tick; beyond it bounds of earlier ones count.
  std::uint64_t most_measured = 400;
};

/// How far a joint moves until it stands, at most, with the most of what cycles and ticks take before it
/// begins to brake.
double stopping_reach(double velocity, const AxisLimits& limits) noexcept;

class BodyGuard {
 public:
  /// `limits`: of all joints of the robot.
  BodyGuard(surroundings::GuardBodies& bodies, int robot, std::vector<AxisLimits> limits,
            const BodyGuardOptions& options = {});

  /// The barriers now, after bodies.look(). `velocity`: of the joints; `stopping`: of each robot, how far its
  /// joints still move, by variable.
  void fill(std::span<const double> velocity, std::span<const std::vector<double>> stopping,
            Barriers& out) noexcept;

 private:
  double margin(const surroundings::GuardPair& pair) const noexcept;
  void add(const Barrier& barrier, Barriers& out) noexcept;
  void add_points(std::size_t pair, double keep, double range, Barriers& out) noexcept;
  double room_in_levers(double room, const surroundings::GuardPair& pair, const Barriers& out) noexcept;
  void keep_rest(double room, std::size_t pair, Barriers& out) noexcept;

  surroundings::GuardBodies& bodies_;
  int robot_;
  std::vector<AxisLimits> limits_;
  BodyGuardOptions options_;
  std::vector<double> reach_, one_;
  std::array<surroundings::GuardGap, 6> points_;
};

}  // namespace polyarm::jog
