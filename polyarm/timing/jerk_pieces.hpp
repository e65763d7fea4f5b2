#pragma once
/// A motion along a path as one piece of constant jerk between every two nodes of s. Part of timing.hpp; not
/// for the control cycle.
#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "polyarm/timing/timed_path.hpp"

namespace polyarm::timing {

/// Squared speed b = ṡ² and acceleration a = s̈ at the nodes s. They are free except for one equation per
/// piece: constant jerk over the duration of the piece must connect the motions of its two nodes. The motion
/// at both ends of the path is fixed.
struct NodeMotion {
  std::vector<double> s, b, a;
};

/// Derivatives with respect to b and a of the previous node and b and a of the next node.
using ByNodes = std::array<double, 4>;

/// The motion between two nodes. `gap`: the residual of the equation, b₁ - b₀ - (a₀ + a₁)Δs - h²(a₁² -
/// a₀²)/12, which equals (v₁ - v₀ - (a₀ + a₁)h/2)(v₁ + v₀).
struct JerkPiece {
  double time = 0, jerk = 0, gap = 0;
  ByNodes time_by{}, jerk_by{}, gap_by{};
};

/// The pieces of a motion and the directions in which it may change. Piece k ends at node k.
class JerkPieces {
 public:
  /// Keeps a reference to `motion`; the caller may change it before evaluate().
  explicit JerkPieces(NodeMotion& motion);

  /// Evaluates the pieces at the present nodes.
  void evaluate();
  /// Removes the gaps with the smallest change around each, then evaluates: one step of Newton's method.
  void close();
  /// The largest gap relative to the squared speeds there.
  double worst_gap() const;
  /// True if all gaps are negligible and every piece moves forwards, with some margin.
  bool sound() const;
  double duration() const;

  std::size_t count() const { return motion_.s.size() - 1; }
  const JerkPiece& piece(std::size_t k) const { return pieces_[k]; }
  double speed(std::size_t node) const { return v_[node]; }
  /// The derivative of a node's speed by its b; 0 at rest.
  double speed_by(std::size_t node) const { return per_v_[node]; }

  /// Finds the directions that keep every gap. Direction i, from 1 to count() - 2, changes only the nodes i
  /// and i + 1.
  void find_directions();
  /// The change of b and a of nodes i and i + 1 in direction `i`; zeros if there is no such direction.
  const ByNodes& direction(std::size_t i) const { return directions_[i]; }
  /// The change of a node for a step along all directions.
  double change_of_b(std::size_t node, const double* step) const {
    return (node > 0 ? directions_[node - 1][2] * step[node - 1] : 0) + directions_[node][0] * step[node];
  }
  double change_of_a(std::size_t node, const double* step) const {
    return (node > 0 ? directions_[node - 1][3] * step[node - 1] : 0) + directions_[node][1] * step[node];
  }

 private:
  NodeMotion& motion_;
  std::vector<double> v_, per_v_, way_;
  std::vector<JerkPiece> pieces_;
  std::vector<ByNodes> directions_;
  std::vector<double> diagonal_, beside_, share_;
};

/// The same motion with an additional node in the middle of each piece marked in `which`.
NodeMotion halved(const NodeMotion& motion, const JerkPieces& pieces, const std::vector<char>& which);

/// The motion after the distance `way`, which it reaches between the times `begin` and `end` at constant
/// jerk.
PathMotion after_way(const PathMotion& motion, double way, double end, double begin = 0);

/// The profile of a motion without gaps, on a path with `breaks`.
SpeedProfile profile_of(NodeMotion& motion, std::span<const double> breaks);

}  // namespace polyarm::timing
