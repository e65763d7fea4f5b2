#pragma once
/// The inside of NumericIk, for its own files and for the room ik. Internal units as in descent_lanes.hpp.
/// const and without hidden state: any thread.
#include <array>
#include <memory>
#include <optional>
#include <span>

#include "polyarm/descent/descent_lanes.hpp"
#include "polyarm/descent/numeric_ik.hpp"
#include "polyarm/descent/seed_table.hpp"

namespace polyarm::kinematics {

/// One question in the units of the kernel.
struct NumericQuestion {
  std::array<double, 12> target;    ///< as Descents::target
  std::optional<DescentTask> task;  ///< empty: the whole pose
  std::array<double, Chain::kMostMoving>
      seed;  ///< of the moving joints, in the internal units of the arm, within limits
  bool walls = true;
};

/// The end of one descent.
struct NumericPlace {
  std::array<double, Chain::kMostMoving> x;
  double position2 = 1e300, orientation2 = 1e300;  ///< squared, in lengths and rad
  double size2() const noexcept { return position2 + orientation2; }
};

/// The data of an arm that all settings share.
struct NumericArm {
  Chain chain;
  DescentArm arm;
  SeedTable table;

  NumericArm(const Chain& chain, std::size_t seeds);
};

struct NumericCore {
  /// Shared, because one arm is used with different settings and its table is large.
  std::shared_ptr<const NumericArm> shared;
  NumericSettings settings;
  const Chain& chain;
  const DescentArm& arm;
  const SeedTable& table;
  DescentRules rules;  ///< with the tolerances of the settings

  NumericCore(std::shared_ptr<const NumericArm> arm, NumericSettings settings);
  NumericCore(const Chain& chain, NumericSettings settings);
  /// False if pose, task or seed contains NaN or infinity, or if sizes do not match.
  bool read(const Pose& target, const IkTask* task, std::span<const double> seed,
            NumericQuestion& out) const noexcept;
  const DescentTask* task_of(const NumericQuestion& question) const noexcept {
    return question.task ? &*question.task : nullptr;
  }
  bool good(const NumericPlace& at) const noexcept {
    return at.position2 <= rules.position2 && at.orientation2 <= rules.orientation2;
  }

  /// From the seed and the table's states until one descent converges or `steps` are done; `out` is that one,
  /// else the nearest.
  bool race(const NumericQuestion& question, int steps, NumericPlace& out) const noexcept;
  /// Uses descend_alone() with these tolerances; false if that is not possible.
  bool follow_alone(const NumericQuestion& question, const double* from, double position2,
                    double orientation2, int steps, NumericPlace& out) const noexcept;
  /// From the seed only.
  bool follow(const NumericQuestion& question, int steps, NumericPlace& out) const noexcept;
  /// Runs `searches` descents and calls `see(place)` with the end of each.
  template <typename See>
  void find_obstacles(const NumericQuestion& question, int searches, const See& see) const noexcept;
  /// A few more steps, while they help; `out` is one of eight alike.
  void polish(const NumericQuestion& question, NumericPlace& at) const noexcept;
  /// A fixed number of further steps from eight places, even if they help little.
  using Places = std::array<NumericPlace, kDescents>;
  void settle(const NumericQuestion& question, int steps, Places& all) const noexcept;
  /// Moves within the null space of the pose towards the goal.
  void improve(const NumericQuestion& question, std::span<const double> seed,
               NumericPlace& at) const noexcept;
  /// The joint state; `seed` determines turns and the joints that do not move the TCP.
  void write(const NumericPlace& at, std::span<const double> seed, IkSolution& out) const noexcept;
  IkOutcome finish(const NumericQuestion& question, std::span<const double> seed, bool found,
                   NumericPlace& at, IkSolution& out) const noexcept;

  void set_target(const NumericQuestion& question, std::size_t lane, Descents& all) const noexcept;
  /// For all lanes.
  void set_targets(const NumericQuestion& question, Descents& all) const noexcept;
  void set_states(const double* x, Descents& all) const noexcept;
  void set_state(const double* x, std::size_t lane, Descents& all) const noexcept;
  NumericPlace place_of(const Descents& all, std::size_t lane) const noexcept;
  void begin_search(const NumericQuestion& question, SeedTable::Search& search) const noexcept;
  /// Gives the lane the next state of the table.
  void restart(SeedTable::Search& search, std::size_t lane, Descents& all) const noexcept;
  double distance2(const double* x, const double* seed) const noexcept;

  /// The goal's value at each of eight states, larger is better.
  void value_goal(const NumericQuestion& question, Descents& all, double* value) const noexcept;
  void climb(const NumericQuestion& question, const NumericPlace& at, double* direction) const noexcept;
};

template <typename See>
void NumericCore::find_obstacles(const NumericQuestion& question, int searches, const See& see) const noexcept {
  Descents all;
  SeedTable::Search search;
  begin_search(question, search);
  set_targets(question, all);
  for (std::size_t lane = 1; lane < kDescents; ++lane) restart(search, lane, all);
  set_state(question.seed.data(), 0, all);
  DescentRules here = rules;
  here.walls = question.walls;
  here.steps = 60 * (searches / static_cast<int>(kDescents) + 1);
  // Takes an exact result as it is; the caller polishes the ones it keeps.
  for (int ended = 0; ended < searches && here.steps > 0;) {
    here.steps -= descend(arm, here, task_of(question), all);
    if ((all.converged | all.stale) == 0) break;
    for (std::size_t lane = 0; lane < kDescents; ++lane) {
      if (!((all.converged | all.stale) >> lane & 1)) continue;
      see(place_of(all, lane));
      restart(search, lane, all);
      ++ended;
    }
  }
}

}  // namespace polyarm::kinematics
