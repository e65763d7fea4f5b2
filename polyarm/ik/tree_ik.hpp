#pragma once
/// Inverse kinematics of several tips of one tree at once: two arms on a shared torso, the fingers of a hand,
/// a tool and a camera. Metres, radians; poses in the world.
#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "polyarm/kinematics/chain.hpp"
#include "polyarm/kinematics/ik_solution.hpp"
#include "polyarm/kinematics/ik_task.hpp"

namespace polyarm::ik {

using namespace kinematics;

/// A point of the tree that gets a target.
struct TreeTip {
  int link = 0;  ///< indexes RobotModel::links
  Pose T_link_tcp;
};

/// The target of one tip, the components of the pose that count, and the weight against the other tips if not
/// all can be reached; weight 0 ignores the tip.
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
/// reads no clock, does a bounded amount of work and always gives the same answer; it uses about 60 kB of
/// stack.
class TreeIk {
 public:
  static constexpr std::size_t kMostMoving = 64;
  /// A joint state has one value for each actuated joint of the model. Throws Error("bad-model") as Chain
  /// does for each tip, for zero tips, and above TreeSolution::kMaxTips; throws Error("too-many-joints") if
  /// more than kMostMoving joints move the tips.
  TreeIk(const description::RobotModel& model, std::span<const TreeTip> tips, const Pose& T_world_base = {},
         TreeSettings settings = {});

  std::size_t joints() const noexcept { return chains_.front().joints(); }
  std::size_t tips() const noexcept { return chains_.size(); }
  Pose forward(std::size_t tip, std::span<const double> q) const noexcept { return chains_[tip].forward(q); }

  /// Descends from `seed`, then from random states. `tasks` has one entry for each tip. Joints that move no
  /// weighted tip keep the seed's values; joints that can turn more than once take the turn nearest the seed.
  /// For the outcome `unreachable`, `out` is the nearest state within limits that was found.
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
  std::array<double, Chain::kMaxJoints> period_{};  ///< as Chain::period, for all tips
  TreeSettings settings_;
  double length_ = 1;  ///< m that one radian counts as
};

}  // namespace polyarm::ik
