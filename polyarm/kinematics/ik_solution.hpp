#pragma once
/// Results of inverse kinematics; all solvers share them. Metres, radians; the TCP in the world. Plain data.
#include <array>
#include <cstddef>

#include "polyarm/kinematics/chain.hpp"

namespace polyarm::kinematics {

/// One joint state that reaches the pose, or comes near it.
struct IkSolution {
  std::array<double, Chain::kMaxJoints> q;  ///< a joint state of the chain; only the first joints() values
                                            ///< are valid
  double position_error = 0;                ///< of the TCP, m
  double orientation_error = 0;             ///< rad; for small errors at most a factor of 1.5 too large
  double distance = 0;                      ///< weighted distance from the seed
  bool exact = false;                       ///< within IkSettings' tolerances
  /// At a singularity infinitely many joint states reach the pose; this one has the seed's value of the free
  /// joint.
  bool singular = false;
};

/// Up to 64 solutions, nearest to the seed first.
struct IkSolutions {
  static constexpr std::size_t kCapacity = 64;
  std::array<IkSolution, kCapacity> all;
  std::size_t count = 0;
  const IkSolution* begin() const noexcept { return all.data(); }
  const IkSolution* end() const noexcept { return all.data() + count; }
  const IkSolution& operator[](std::size_t i) const noexcept { return all[i]; }
};

enum class IkOutcome {
  solved,
  immovable,    ///< no joint moves the TCP
  malformed,    ///< the pose or the seed contains NaN or infinity, or sizes do not match
  unreachable,  ///< no joint state reaches the pose, even without limits
  limits,       ///< joint states reach the pose, but all of them violate limits
};
const char* name(IkOutcome outcome);

}  // namespace polyarm::kinematics
