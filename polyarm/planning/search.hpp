#pragma once
/// The search of plan(). Private to this room.
#include <optional>

#include "polyarm/collision/state_set.hpp"
#include "polyarm/kinematics/random.hpp"
#include "polyarm/planning/planner.hpp"

namespace polyarm::planning {

/// A tree of states; each is joined with its parent by a proven edge.
class SearchTree {
 public:
  static constexpr std::size_t kRoot = static_cast<std::size_t>(-1);

  SearchTree(const collision::Checker& checker, std::span<const double> weights);
  std::size_t add(std::span<const double> q, std::size_t parent);
  std::size_t size() const noexcept { return parents_.size(); }
  std::span<const double> state(std::size_t i) const noexcept {
    return {states_.data() + i * width_, width_};
  }
  std::size_t nearest(std::span<const double> q) noexcept { return set_.nearest(q); }
  /// From state `i` to its root.
  std::vector<JointState> way_to_root(std::size_t i) const;
  std::size_t root_of(std::size_t i) const;
  double& domain(std::size_t i) noexcept { return domains_[i]; }

 private:
  std::size_t width_;
  collision::StateSet set_;
  std::vector<double> states_, domains_;
  std::vector<std::size_t> parents_;
};

/// Grows both trees until they meet. Edges by spheres or by exact shapes.
class Search {
 public:
  Search(collision::Probe& probe, const PlanQuery& query, const PlanOptions& options, bool exact);

  /// `goals`: indices of the goals that are free. Fills waypoints, goal, samples, states and edges of `out`.
  PlanOutcome run(std::span<const std::size_t> goals, std::size_t most_samples, Plan& out);
  /// Shortens the waypoints of `out`.
  void shorten(Plan& out);

  double length(std::span<const double> a, std::span<const double> b) const noexcept;
  double length(const std::vector<JointState>& path) const noexcept;

 private:
  bool free(std::span<const double> from, std::span<const double> to);
  bool straight(std::span<const std::size_t> goals, Plan& out);
  void find_box(std::span<const std::size_t> goals);
  void draw(JointState& q);
  /// A new state of `tree` from its nearest state towards `target`, at most by the range.
  std::optional<std::size_t> extend(SearchTree& tree, std::span<const double> target);
  /// Extends as far as it goes; true if it arrives.
  std::optional<std::size_t> connect(SearchTree& tree, std::span<const double> target);
  void join(const SearchTree& a, std::size_t i, const SearchTree& b, std::size_t k, bool a_is_start,
            Plan& out) const;
  bool skip_corners(std::vector<JointState>& path);
  bool cut_between(std::vector<JointState>& path);

  collision::Probe& probe_;
  const PlanQuery& query_;
  const PlanOptions& options_;
  bool exact_;
  std::vector<double> weights_;
  std::vector<double> low_, high_;  // samples lie between
  kinematics::Random random_;
  std::size_t edges_ = 0;
  JointState next_;
};

}  // namespace polyarm::planning
