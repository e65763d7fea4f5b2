#pragma once
/// Joint velocities for a velocity of the TCP, near singularities and in them too. Metres, radians, world
/// axes. For the control cycle: no allocation, no exceptions, bounded (some 10 us for six joints).
#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "polyarm/jog/twist.hpp"
#include "polyarm/kinematics/chain.hpp"
#include "polyarm/moves/arm_derivatives.hpp"

namespace polyarm::jog {

/// Most joints of an arm that is jogged.
inline constexpr std::size_t kMostJogJoints = 128;
using JogValues = std::array<double, kMostJogJoints>;

enum class TwistOutcome {
  exact,        ///< the TCP moves as asked
  slowed,       ///< along the direction asked, but slower: a joint would have to turn too fast
  damped,       ///< not quite along it: close to a singularity
  joint_wise,   ///< in a singularity: joints move so that it is left
  blocked,      ///< a singularity is in the way: what would have to be done cannot
  unavailable,  ///< the arm has too few joints to move that way
};

/// Least squares over what the arm can do. An arm of six and more joints trades all six directions; one of
/// fewer keeps the TCP's place exact and turns it as nearly as it can.
///
/// Method: singular value decomposition (one-sided by the eigenvectors of J W J^T, Jacobi rotations), each
/// singular direction judged by itself (numerical filtering, Maciejewski and Klein 1988): the whole is slowed
/// down first, to a fifth at most; what still asks too much of a joint is damped; what leads into the
/// singularity slows down so that it stops there; and in the singularity itself, where no first order motion
/// leads out, the joint motion of the null space is taken whose second order does.
class TwistSolver {
 public:
  explicit TwistSolver(const kinematics::Chain& chain);

  /// What joints may do: velocities, accelerations and jerks of all joints of the chain.
  struct Abilities {
    std::span<const double> velocity, acceleration, jerk, lower, upper;
  };

  /// Sets the joint state; then pose(), J() and solve() are about it.
  void at(std::span<const double> q) noexcept;
  const Vec3& position() const noexcept { return arm_.position(); }
  Quaternion rotation() const noexcept;
  /// The TCP's velocity for joint velocities.
  Twist twist_of(std::span<const double> rates) const noexcept;

  struct Solution {
    JogValues rates{};  ///< of all joints of the chain
    double share = 1;   ///< of the speed asked for along the direction
    TwistOutcome outcome = TwistOutcome::exact;
  };
  /// Joints to spare beyond those that are locked.
  std::size_t spare() const noexcept { return columns_ > locked_ + kRows ? columns_ - locked_ - kRows : 0; }
  /// Solves without this joint until the next at().
  void lock(std::size_t joint) noexcept;
  void solve(const Twist& twist, const Abilities& abilities, Solution& out) noexcept;
  std::size_t columns() const noexcept { return columns_; }
  /// Joint velocities that the twist asks for where nothing is in the way, to judge how quickly it may
  /// change; singular directions are left out.
  void reach(const Twist& twist, JogValues& out) const noexcept;
  /// A new wish: what was decided in a singularity is forgotten.
  void forget() noexcept {
    escaping_ = false;
    patience_ = 0;
  }

 private:
  static constexpr std::size_t kRows = 6;
  /// A task of `rows` rows and its singular directions.
  struct Level {
    std::size_t first = 0, rows = 0;
    std::array<double, kRows * kMostJogJoints> A{};    // row after row
    std::array<std::array<double, kRows>, kRows> u{};  // singular vectors of the TCP
    std::array<double, kRows> sigma{};
    std::array<JogValues, kRows> v{};  // of the joints, length 1; 0 where singular
    std::size_t rank = kRows;          // that the arm has somewhere
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
  double length_;  // what a metre counts as against a radian
  std::size_t levels_, locked_ = 0;
  std::array<bool, kMostJogJoints> is_locked_{};  // by column
  std::array<Level, 2> level_;
  Level trial_;
  std::array<double, kinematics::Chain::kMaxJoints> q_{};
  // In a singularity: the way that was taken last, and when to look again where there was none.
  bool escaping_ = false;
  JogValues way_{};
  int patience_ = 0;
};

}  // namespace polyarm::jog
