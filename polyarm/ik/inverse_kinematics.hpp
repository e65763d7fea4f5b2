#pragma once
/// Inverse kinematics of one arm: joint states for a pose of its TCP. Other rooms include only this header
/// and tree_ik.hpp.
///
/// Units and frames: metres, radians; poses of the TCP in the world. A joint state has one value for each of
/// Chain::joints().
/// Memory and threads: constructors allocate and take 15 to 40 us (100 us if they try the polynomial of
/// degree 16). After that the object is const and has no hidden state: any thread. A call marked noexcept
/// allocates nothing, locks nothing, reads no clock, does a bounded amount of work and always gives the same
/// answer, so it may run in the control cycle. It uses up to 250 kB of stack. explain() allocates.
/// Errors: constructors throw Error("bad-model"); calls return an IkOutcome.
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "polyarm/kinematics/chain.hpp"
#include "polyarm/kinematics/ik_solution.hpp"
#include "polyarm/kinematics/ik_task.hpp"

namespace polyarm::kinematics {
enum class ArmFamily;  // closed_form/arm_class.hpp
}

namespace polyarm::ik {

using namespace kinematics;

struct IkSettings {
  double position_tolerance = 1e-9;     ///< m; a solution is exact up to this error
  double orientation_tolerance = 1e-9;  ///< rad
  /// Where the descents of solve_move() and of partial poses end, m and rad. Afterwards the solution is
  /// polished to rounding if a few steps suffice; at singularities they do not.
  double descent_tolerance = 1e-6;
  /// Weight of each joint's change, per rad or m, in a distance; empty: 1 each.
  std::vector<double> weights;
  /// For an arm with one redundant joint: the number of values of that joint that are tried over its range.
  int samples = 16;
  /// The number of other states from which a descent restarts after the seed; 0 disables restarts.
  int restarts = 100;
  /// How partial poses use the joints that they leave free.
  IkGoal goal = IkGoal::none;
};

/// The method that solves the poses of an arm.
enum class IkWay {
  none,         ///< no joint moves the TCP
  closed_form,  ///< all branches
  search,       ///< a closed form for each of 64 values of one axis, then descents from near solutions
  algebra,      ///< the roots of a polynomial of degree 16: all branches
  spare_axis,   ///< one of the methods above for each of several values of one axis
  descent,      ///< damped least squares from the seed and from a table of states
};

/// The reason why a pose is not reached, as text for a person.
struct IkExplanation {
  IkOutcome outcome = IkOutcome::malformed;
  IkSolution nearest;  ///< within limits; the solution itself if the outcome is `solved`
  std::string reason;  ///< with numbers; empty if the outcome is `solved`
};

class InverseKinematics {
 public:
  /// Copies what it needs from `chain`. Throws Error("bad-model") for more than 64 joints and followers.
  explicit InverseKinematics(const Chain& chain, IkSettings settings = {});
  /// For the chain from the model's root to link `tip`; the TCP is that link. Throws as Chain does.
  InverseKinematics(const description::RobotModel& model, int tip, IkSettings settings = {});
  ~InverseKinematics();
  InverseKinematics(InverseKinematics&&) noexcept;
  InverseKinematics& operator=(InverseKinematics&&) noexcept;

  /// True if this arm has a closed form, or has one for each value of one axis.
  explicit operator bool() const noexcept;
  IkWay way() const noexcept;
  /// The family of six axes with a closed form or a search along one axis; else `none`.
  ArmFamily family() const noexcept;
  /// True if solve_all() finds all solutions of a pose: closed forms and algebra. A search misses some where
  /// two branches are about to merge; a redundant arm has infinitely many.
  bool complete() const noexcept;
  /// The method that was chosen for this arm and why, as text.
  const std::string& report() const noexcept;
  const Chain& chain() const noexcept;
  const IkSettings& settings() const noexcept;

  /// The exact solution within limits that is nearest to `seed`. A joint that can turn more than once takes
  /// the turn nearest the seed; a joint that does not move the TCP keeps the seed's value. If there is no
  /// exact solution, `out` is the state nearest to the pose among the arm's branches within limits, or the
  /// seed if no branch is within limits; it is then not exact.
  IkOutcome solve(const Pose& target, std::span<const double> seed, IkSolution& out) const noexcept;
  /// All branches within limits that reach the pose exactly, nearest to the seed first.
  IkOutcome solve_all(const Pose& target, std::span<const double> seed, IkSolutions& out) const noexcept;
  /// solve() for each of `targets`, with the same seed. The answers agree to within 1e-12, and are the same
  /// in every run. If an arm of six axes has a closed form in quadratics and an exact description, eight
  /// poses are solved side by side (poses near singularities and out of reach still one by one). Returns the
  /// number of solved poses. Precondition: `out` and `outcomes` are as long as `targets`.
  std::size_t solve_batch(std::span<const Pose> targets, std::span<const double> seed,
                          std::span<IkSolution> out, std::span<IkOutcome> outcomes) const noexcept;

  /// The solution for a move to a pose. A descent from `current` is preferred if it ends near and not close
  /// to a singularity. Else the nearest of all solutions to `current`, with preference for those not close to
  /// a singularity; on a tie the one nearest `home`. "Near": no joint changes by more than kNearby. "Close to
  /// a singularity": below kSingular. A solution within kSameBranch is taken at any singular value, so a
  /// small step never changes the branch.
  IkOutcome solve_move(const Pose& target, std::span<const double> current, std::span<const double> home,
                       IkSolution& out) const noexcept;
  static constexpr double kNearby = 2.2;          ///< rad or m
  static constexpr double kSameBranch = 0.2;      ///< rad
  static constexpr double kVerySingular = 0.001;  ///< of smallest_singular_value(), for near solutions

  /// A joint state that satisfies `task`, by damped least squares (Chan and Lawrence 1988; Sugihara 2011):
  /// from the seed, then from other states. `exact` means within descent_tolerance here.
  IkOutcome solve(const Pose& target, const IkTask& task, std::span<const double> seed,
                  IkSolution& out) const noexcept;
  /// Distinct solutions of this kind, as many as the restarts find, nearest to the seed first.
  IkOutcome solve_all(const Pose& target, const IkTask& task, std::span<const double> seed,
                      IkSolutions& out) const noexcept;
  /// The solution that one descent from `seed` reaches, for servo ticks; usually two steps of third order. If
  /// the descent does not reach the target, `out` is where it ended.
  IkOutcome track(const Pose& target, std::span<const double> seed, IkSolution& out) const noexcept;

  /// The reason why there is no solution, the joint or distance at fault, and how near the arm comes. Runs
  /// some hundred descents; allocates. Accepts any numbers: a malformed target, seed or task has its own
  /// reason.
  IkExplanation explain(const Pose& target, std::span<const double> seed, const IkTask& task = {}) const;

 private:
  struct Arm;
  std::unique_ptr<const Arm> arm_;
};

}  // namespace polyarm::ik
