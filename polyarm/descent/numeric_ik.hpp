#pragma once
/// Inverse kinematics by iteration, for every chain: any number of joints, sliding ones and followers too,
/// within joint limits, for whole poses and for parts of them. Metres, radians, poses of the TCP in the
/// world.
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "polyarm/kinematics/chain.hpp"
#include "polyarm/kinematics/ik_solution.hpp"
#include "polyarm/kinematics/ik_task.hpp"

namespace polyarm::kinematics {

struct NumericSettings {
  double position_tolerance = 1e-6;     ///< m
  double orientation_tolerance = 1e-6;  ///< rad
  /// After the tolerances are met, go on to rounding where a few steps lead there.
  bool polish = true;
  int steps = 1500;         ///< of eight descents, before a solve gives up
  int track_steps = 20;     ///< of track()
  int searches = 160;       ///< descents of solve_all()
  std::size_t seeds = 512;  ///< of the table that descents start from
  IkGoal goal = IkGoal::none;
  int goal_steps = 24;
  std::vector<double> weights;  ///< what a radian or metre of each joint counts in distances; empty: 1 each
};
inline constexpr double kAwayFromSingular = 0.03;  ///< of the smallest singular value, see inverse.hpp

struct NumericCore;

/// Damped least squares (Chan and Lawrence 1988; Nakamura and Hanafusa 1986) with joint limits as walls, in
/// eight descents side by side: from the seed and from the nearest states of a table. Built once (some 100
/// us, allocates), then const and without hidden state: any thread. Nothing else here allocates, locks,
/// throws or reads a clock, and the work is bounded, so that all of it may be called in the control cycle;
/// some 60 kB of stack are used. The same question has the same answer, on processors with the same vector
/// instructions to the last bit.
class NumericIk {
 public:
  /// Keeps nothing of `chain` but copies. Throws Error("bad-model") for more than 64 joints and followers.
  explicit NumericIk(const Chain& chain, NumericSettings settings = {});
  /// For the same arm with other settings; shares what was worked out for it (settings.seeds is ignored).
  NumericIk(const NumericIk& same_arm, NumericSettings settings);
  ~NumericIk();
  NumericIk(NumericIk&&) noexcept;
  NumericIk& operator=(NumericIk&&) noexcept;

  /// Any solution within limits; of those found at the same step the nearest to `seed`, a joint state of the
  /// chain. Joints that turn further than once come to the turn nearest the seed, joints that do not move the
  /// TCP keep its values. Where none is found, `out` is the nearest to the pose that was, within limits, and
  /// not exact; the outcome is `limits` where there is one outside the limits.
  IkOutcome solve(const Pose& target, std::span<const double> seed, IkSolution& out) const noexcept;
  IkOutcome solve(const Pose& target, const IkTask& task, std::span<const double> seed,
                  IkSolution& out) const noexcept;
  /// The solution that one descent from `seed` leads to, and no other: a servo tick; mostly two steps of
  /// third order, of one arm alone. Within tolerance it ends, polish or not. Where it does not lead there,
  /// how far it came.
  IkOutcome track(const Pose& target, std::span<const double> seed, IkSolution& out) const noexcept;
  IkOutcome track(const Pose& target, const IkTask& task, std::span<const double> seed,
                  IkSolution& out) const noexcept;
  /// Distinct solutions within limits, nearest to the seed first: those of settings.searches descents.
  IkOutcome solve_all(const Pose& target, std::span<const double> seed, IkSolutions& out) const noexcept;
  IkOutcome solve_all(const Pose& target, const IkTask& task, std::span<const double> seed,
                      IkSolutions& out) const noexcept;
  /// One solution for each target, eight at work at a time. `seeds`: a joint state for each target, one after
  /// the other; empty: none (joints turn nearest zero). Returns how many were solved; the others' are not
  /// exact. All three sizes must match.
  std::size_t solve_batch(std::span<const Pose> targets, std::span<const double> seeds,
                          std::span<IkSolution> out) const noexcept;

  const NumericSettings& settings() const noexcept;
  const NumericCore& core() const noexcept { return *core_; }

 private:
  std::unique_ptr<const NumericCore> core_;
};

}  // namespace polyarm::kinematics
