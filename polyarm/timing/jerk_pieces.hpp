#pragma once
/// A motion along a path as one piece of constant jerk between every two nodes of s. Part of timing.hpp.
#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "polyarm/timing/timed_path.hpp"

namespace polyarm::timing {

/// Squared speed b = ṡ² and acceleration a = s̈ at the nodes s. Both are free, but for one equation per piece:
/// constant jerk over the time that the piece takes has to lead from one node's motion to the next one's. The
/// motion at both ends is given and stays.
struct NodeMotion {
  std::vector<double> s, b, a;
};

/// Derivatives by b and a of the node before and b and a of the node behind.
using ByNodes = std::array<double, 4>;

/// What happens between two nodes. `gap`: what is missing in the equation,
/// b₁ - b₀ - (a₀ + a₁)Δs - h²(a₁² - a₀²)/12, which is (v₁ - v₀ - (a₀ + a₁)h/2)(v₁ + v₀).
struct JerkPiece {
  double time = 0, jerk = 0, gap = 0;
  ByNodes time_by{}, jerk_by{}, gap_by{};
};

/// The pieces of a motion and the directions in which it may change. Pieces and nodes have numbers: piece k
/// ends at node k.
class JerkPieces {
 public:
  /// `motion` stays with the caller, who may change it before evaluate().
  explicit JerkPieces(NodeMotion& motion);

  /// The pieces as the nodes are now.
  void evaluate();
  /// Takes the gaps out, with the least changes around each; evaluates. One step of Newton's method.
  void close();
  /// The largest gap, per the squared speeds there.
  double worst_gap() const;
  /// Whether no gap is worth a word and every piece is passed forwards, with some margin.
  bool sound() const;
  double duration() const;

  std::size_t count() const { return motion_.s.size() - 1; }
  const JerkPiece& piece(std::size_t k) const { return pieces_[k]; }
  double speed(std::size_t node) const { return v_[node]; }
  /// The derivative of a node's speed by its b; 0 at rest.
  double speed_by(std::size_t node) const { return per_v_[node]; }

  /// Directions that keep every gap as it is: direction i, of 1 to count() - 2, changes nodes i and i + 1
  /// alone.
  void find_directions();
  /// How direction `i` changes b and a of nodes i and i + 1; zeros for numbers that are none.
  const ByNodes& direction(std::size_t i) const { return directions_[i]; }
  /// Of a step along all directions: the changes of a node.
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

/// The same motion with a node more in the middle of each of the pieces in `which`.
NodeMotion halved(const NodeMotion& motion, const JerkPieces& pieces, const std::vector<char>& which);

/// The motion after the `way`, which is passed between the times `begin` and `end` of constant jerk.
PathMotion after_way(const PathMotion& motion, double way, double end, double begin = 0);

/// The profile of a motion without gaps on a path with `breaks`.
SpeedProfile profile_of(NodeMotion& motion, std::span<const double> breaks);

}  // namespace polyarm::timing
