#pragma once
/// Inverse kinematics of several tips of one tree at once: two arms on a shared torso, a hand's fingers, a
/// tool and a camera. Metres, radians, poses in the world.
#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "polyarm/kinematics/chain.hpp"
#include "polyarm/kinematics/ik_solution.hpp"
#include "polyarm/kinematics/ik_task.hpp"

namespace polyarm::ik {

using namespace kinematics;

/// A point of the tree that is to be put somewhere.
struct TreeTip {
  int link = 0;  ///< indexes RobotModel::links
  Pose T_link_tcp;
};

/// Where one tip is wanted, what of the pose counts, and how much against the other tips where not all can be
/// had; with weight 0 the tip is left alone.
struct TreeTask {
  Pose target;
  IkTask task;
  double weight = 1;
};

struct TreeSettings {
  double position_tolerance = 1e-6;     ///< m
  double orientation_tolerance = 1e-6;  ///< rad
  int steps = 60;                       ///< of one descent
  int restarts = 200;                   ///< random states tried after the seed
};

struct TreeSolution {
  static constexpr std::size_t kMaxTips = 8;
  std::array<double, Chain::kMaxJoints> q;  ///< a joint state of the model; the first joints() count
  std::array<double, kMaxTips> position_error{}, orientation_error{};  ///< of each tip, m and rad
  bool exact = false;                                                  ///< all tips within tolerance
};

/// Damped least squares over all tips (Nakamura and Hanafusa 1986) with joint limits as walls. Built once
/// (allocates), then const and without hidden state: any thread. solve() allocates nothing, throws nothing,
/// reads no clock, and its work is bounded; some 60 kB of stack. The same question has the same answer.
class TreeIk {
 public:
  static constexpr std::size_t kMostMoving = 64;
  /// Joint states are those of the model: one value for each actuated joint. Throws Error("bad-model") for
  /// what a Chain to one of the tips refuses, for no tip, and for more than TreeSolution::kMaxTips;
  /// Error("too-many-joints") where more than kMostMoving joints move the tips.
  TreeIk(const description::RobotModel& model, std::span<const TreeTip> tips, const Pose& T_world_base = {},
         TreeSettings settings = {});

  std::size_t joints() const noexcept { return chains_.front().joints(); }
  std::size_t tips() const noexcept { return chains_.size(); }
  Pose forward(std::size_t tip, std::span<const double> q) const noexcept { return chains_[tip].forward(q); }

  /// From `seed`, then from random states. `tasks` has one for each tip. Joints that move no tip with a
  /// weight keep the seed's values; joints that turn further than once come to the turn nearest the seed.
  /// `unreachable`: `out` is the nearest within limits that was found.
  IkOutcome solve(std::span<const TreeTask> tasks, std::span<const double> seed,
                  TreeSolution& out) const noexcept;

 private:
  struct Work;
  bool accepts(std::span<const TreeTask> tasks, std::span<const double> seed) const noexcept;
  void measure(std::span<const TreeTask> tasks, Work& work) const noexcept;
  void add_rows(std::size_t tip, const TreeTask& task, Work& work) const noexcept;
  bool step(Work& work) const noexcept;
  bool descend(std::span<const TreeTask> tasks, Work& work, TreeSolution& best, double& least) const noexcept;

  std::vector<Chain> chains_;
  std::vector<std::size_t> moving_;                 ///< joints that move a tip
  std::array<double, Chain::kMaxJoints> unit_{};    ///< rad or m of one unit
  std::array<double, Chain::kMaxJoints> period_{};  ///< as Chain::period, over all tips
  TreeSettings settings_;
  double length_ = 1;  ///< m that a radian counts as
};

}  // namespace polyarm::ik
