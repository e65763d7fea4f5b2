#pragma once
/// Joint velocities for a velocity of the TCP, also near singularities and in them. Metres, radians, world
/// axes. For the control cycle: no allocation, no exceptions, bounded time (some 10 us for six joints).
#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "polyarm/jog/twist.hpp"
#include "polyarm/kinematics/chain.hpp"
#include "polyarm/moves/arm_derivatives.hpp"

namespace polyarm::jog {

/// The largest number of joints of an arm that can be jogged.
inline constexpr std::size_t kMostJogJoints = 128;
using JogValues = std::array<double, kMostJogJoints>;

enum class TwistOutcome {
  exact,        ///< the TCP moves as requested
  slowed,       ///< along the requested direction, but slower, because a joint would turn too fast
  damped,       ///< nearly along the direction, because a singularity is close
  joint_wise,   ///< in a singularity: joints move to leave it
  blocked,      ///< a singularity blocks the motion, and no joint motion passes it
  unavailable,  ///< the arm has too few joints to move in this direction
};

/// Least squares in the directions that the arm can move. An arm with six and more joints weighs all six
/// directions; an arm with fewer joints keeps the TCP's position exact and rotates it as nearly as it can.
///
/// Method: singular value decomposition (one-sided, by the eigenvectors of J W J^T, Jacobi rotations) with a
/// separate decision for each singular direction (numerical filtering, Maciejewski and Klein 1988). First the
/// whole motion slows down, to a fifth at most. A direction that still requires too much of a joint is
/// damped. A direction into the singularity slows down and stops there. In the singularity itself no
/// first-order motion leads out; there the null space motion with the right second-order effect is taken.
class TwistSolver {
 public:
  explicit TwistSolver(const kinematics::Chain& chain);

  /// The abilities of the joints: velocities, accelerations and jerks of all joints of the chain.
  struct Abilities {
    std::span<const double> velocity, acceleration, jerk, lower, upper;
  };

  /// Sets the joint state for pose(), J() and solve().
  void at(std::span<const double> q) noexcept;
  const Vec3& position() const noexcept { return arm_.position(); }
  Quaternion rotation() const noexcept;
  /// The TCP's velocity for joint velocities.
  Twist twist_of(std::span<const double> rates) const noexcept;

  /// How a value that grows with each part of the TCP's velocity by `row` grows with the joint velocities.
  void gradient_of(const Twist& row, JogValues& out) const noexcept;

  struct Solution {
    JogValues rates{};  ///< of all joints of the chain
    double share = 1;   ///< fraction of the requested speed along the direction
    TwistOutcome outcome = TwistOutcome::exact;
  };
  /// Number of redundant joints that are not locked.
  std::size_t spare() const noexcept { return columns_ > locked_ + kRows ? columns_ - locked_ - kRows : 0; }
  /// Solves without this joint until the next at().
  void lock(std::size_t joint) noexcept;
  void solve(const Twist& twist, const Abilities& abilities, Solution& out) noexcept;
  /// The joint velocities for a twist without any limits, exact but for singular directions, which are left
  /// out. Returns the share of the twist that they take. An arm with fewer than six joints turns as nearly as
  /// it can.
  double exact(const Twist& twist, JogValues& out) const noexcept;
  /// Of a joint, [0, 1]: the less it weighs, the more others do for it; 0: it does nothing. Counts for exact()
  /// after decompose_again(), until the next at(). solve() and reach() need a decomposition without weights.
  void weigh(std::size_t joint, double weight) noexcept;
  void decompose_again() noexcept { prepare(); }
  std::size_t columns() const noexcept { return columns_; }
  /// The joint velocities for a twist without any limits, to judge how quickly it may change; singular
  /// directions are left out.
  void reach(const Twist& twist, JogValues& out) const noexcept;
  /// Call this for a new wish; clears the decisions made in a singularity.
  void forget() noexcept {
    escaping_ = false;
    wait_limit_ = 0;
  }

 private:
  static constexpr std::size_t kRows = 6;
  /// A task of `rows` rows and its singular directions.
  struct Level {
    std::size_t first = 0, rows = 0;
    std::array<double, kRows * kMostJogJoints> A{};    // row-major
    std::array<std::array<double, kRows>, kRows> u{};  // singular vectors of the TCP
    std::array<double, kRows> sigma{};
    std::array<JogValues, kRows> v{};  // of the joints, unit length; 0 if singular
    std::size_t rank = kRows;          // the largest rank that the arm has anywhere
  };
  void fill(Level& level, std::span<const double> J) const noexcept;
  void prepare() noexcept;
  void decompose(Level& level) const noexcept;
  void project(Level& second, const Level& first) const noexcept;
  void solve_level(Level& level, const std::array<double, kRows>& wish, const Abilities& abilities,
                   JogValues& rates, double& share, TwistOutcome& outcome) noexcept;
  double into_singularity(const Level& level, std::size_t k, const JogValues& part,
                          const Abilities& abilities) noexcept;
  bool escape(const Level& level, const std::array<double, kRows>& wish, const Abilities& abilities,
              JogValues& direction) noexcept;
  bool complement(const Level& level, JogValues& direction) const noexcept;
  double feasible(const Level& level, const std::array<double, kRows>& wish) const noexcept;
  void find_ranks(const kinematics::Chain& chain);

  moves::ArmDerivatives arm_, probe_;
  std::size_t joints_, columns_;
  double length_;  // the weight of a metre relative to a radian
  std::size_t levels_, locked_ = 0;
  std::array<bool, kMostJogJoints> is_locked_{};  // by column
  JogValues weight_{};                            // by column
  std::array<Level, 2> level_;
  Level trial_;
  std::array<double, kinematics::Chain::kMaxJoints> q_{};
  // In a singularity: the last escape motion, and the cycles until the next search if none was found.
  bool escaping_ = false;
  JogValues way_{};
  int wait_limit_ = 0;
};

}  // namespace polyarm::jog
