#pragma once
/// One descent of inverse kinematics, from one seed, without allocation. Used by inverse.cpp and explain.cpp
/// only.
#include <array>
#include <span>

#include "polyarm/kinematics/chain.hpp"
#include "polyarm/kinematics/inverse.hpp"
#include "polyarm/kinematics/random.hpp"

namespace polyarm::kinematics {

using JointState = std::array<double, Chain::kMaxJoints>;

struct PoseError {
  double position = 1e300;     // m
  double orientation = 1e300;  // rad
};

/// Towards one target. `weight` is what a radian counts as, in metres; 0 leaves the orientation free.
class Descent {
 public:
  Descent(const Chain& chain, const Pose& target, const IkOptions& options, double weight)
      : chain_(chain), target_(target), options_(options), weight_(weight) {}

  /// Improves `q` until the tolerances are met and rounding stops the polish, or nothing improves any more.
  /// Leaves the best state seen in `q` and its error in error(). With `walls`, joints stay within their
  /// limits.
  bool run(JointState& q, bool walls);
  const PoseError& error() const noexcept { return best_error_; }
  /// What is minimised: metres, with radians weighted.
  double size() const noexcept { return best_size_; }

 private:
  static constexpr std::size_t kMost = Chain::kMaxJoints;
  using Twist = std::array<double, 6>;

  PoseError measure(const JointState& q);
  bool within_tolerance() const noexcept;
  void step(JointState& q, bool walls);
  bool solve(std::array<double, kMost>& dq) const;
  bool pin(const JointState& q, const std::array<double, kMost>& dq);

  const Chain& chain_;
  const Pose& target_;
  const IkOptions& options_;
  double weight_;
  std::array<double, 6 * kMost> jacobian_;
  Twist twist_{};
  double size_ = 0, best_size_ = 1e300;
  PoseError best_error_;
};

/// Brings joints that turn to the turn nearest `near` that is inside the limits; where no turn is, the one
/// least outside.
void unwind(const Chain& chain, JointState& q, std::span<const double> near);
/// How far joint `i` is outside its limits, 0 inside.
double excess(const Chain& chain, const JointState& q, std::size_t i);
bool inside_limits(const Chain& chain, const JointState& q);
/// Sets the joints that move the TCP at random, within limits.
void scatter(const Chain& chain, JointState& q, Random& random);

/// Fills in status and reason of a solve that failed with `result.q` as the best found.
void explain_failure(const Chain& chain, const Pose& target, std::span<const double> seed,
                     const IkOptions& options, IkResult& result);

}  // namespace polyarm::kinematics
