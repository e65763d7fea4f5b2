#pragma once
/// Makes the barriers of a robot that is jogged from the bodies around it, in each tick, and says what a
/// robot whose plan is not known would touch while it brakes. Cell thread; allocates in the constructor
/// alone. Metres, radians, seconds.
#include <array>
#include <cstddef>
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

  /// What the robot comes too near to.
  struct InTheWay {
    std::int32_t pair = -1;  ///< -1: nothing
    surroundings::GuardGap gap;
    double required = 0;
  };
  /// What is in the way of a robot whose joints still go by `way` until they stand, on a straight line, after
  /// bodies.look(). A robot that is too near already may go anywhere but deeper.
  InTheWay in_the_way(std::span<const double> way, std::span<const std::vector<double>> stopping) noexcept;

 private:
  double margin(const surroundings::GuardPair& pair) const noexcept;
  bool moves_with_tcp(const surroundings::GuardPair& pair) const noexcept;
  void add(const Barrier& barrier, Barriers& out) noexcept;
  void add_points(std::size_t pair, double keep, std::size_t count, Barriers& out) noexcept;
  double room_in_levers(double room, const surroundings::GuardPair& pair, const Barriers& out) noexcept;
  bool follow(std::size_t pair, std::span<const double> way, double least, double reach,
              InTheWay& out) noexcept;
  void keep_rest(double room, std::size_t pair, Barriers& out) noexcept;

  surroundings::GuardBodies& bodies_;
  int robot_;
  std::vector<AxisLimits> limits_;
  BodyGuardOptions options_;
  std::vector<double> reach_, trial_;  // by joint
  std::vector<double> reaches_;        // by body
  std::size_t first_pair_ = 0;         // that fill() looks at
  std::array<surroundings::GuardGap, 8> points_;
};

}  // namespace polyarm::jog
