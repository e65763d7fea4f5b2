#pragma once
/// One motion, from rest to rest, that the robot's own controller interpolates: the moves that it gets, and
/// the path that was planned for them, on which the measured joints are followed.
#include <cstddef>
#include <span>
#include <vector>

#include "polyarm/hardware/forward_moves.hpp"
#include "polyarm/timing/timed_path.hpp"

namespace polyarm::controllers {

/// Made outside the loop; find() allocates nothing.
class ForwardMotion {
 public:
  /// `moves`: those that are left; their ids are given when they are handed over. `begin`: s of the plan at
  /// which the robot stands.
  ForwardMotion(timing::TimedPath path, std::vector<hardware::ForwardMove> moves, double begin);

  std::span<hardware::ForwardMove> moves() noexcept { return moves_; }
  std::size_t joints() const noexcept { return path_.joints(); }
  double duration() const noexcept { return path_.duration(); }
  /// s of the plan at which the path is nearest to `measured` (joints() values), not before the last answer
  /// and a little beyond it at most.
  double find(std::span<const double> measured, double period) noexcept;
  /// The largest distance of a joint between `measured` and where the motion begins, rad or m.
  double off_start(std::span<const double> measured) noexcept;

 private:
  double distance(double time, std::span<const double> measured, std::size_t& hint) noexcept;

  timing::TimedPath path_;
  std::vector<hardware::ForwardMove> moves_;
  std::vector<double> sample_;
  double time_;
  std::size_t hint_ = 0;
};

}  // namespace polyarm::controllers
