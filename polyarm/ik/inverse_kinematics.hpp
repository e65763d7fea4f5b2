#pragma once
/// Inverse kinematics of one arm: joint states for a pose of its TCP. The only header of inverse kinematics
/// that other rooms include.
///
/// Units and frames: metres, radians, poses of the TCP in the world. Joint states have one value for each of
/// Chain::joints().
/// Memory and threads: constructors allocate and take 15 to 40 us (100 us where the polynomial of degree 16
/// is tried). After that the object is const and has no hidden state: any thread. Every call marked noexcept
/// allocates nothing, locks nothing, reads no clock, does a bounded amount of work and gives the same answer
/// every time, so that it may run in the control cycle; up to 250 kB of stack are used. explain() allocates.
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
  /// m and rad: where solve_move() and solutions of parts of poses end their descent. It is polished to
  /// rounding afterwards where a few steps lead there; at singularities they do not.
  double descent_tolerance = 1e-6;
  /// What a radian (or a metre) of each joint counts in a distance; empty: 1 each.
  std::vector<double> weights;
  /// For an arm with one joint too many: how many values of that joint are tried over its range.
  int samples = 16;
  /// How many other states a descent tries after the seed; 0: none.
  int restarts = 100;
  /// What parts of poses do with the joints that they leave free.
  IkGoal goal = IkGoal::none;
};

/// How an arm's poses are solved.
enum class IkWay {
  none,         ///< not at all: no joint moves the TCP
  closed_form,  ///< all branches
  search,       ///< a closed form for each of 64 values of one axis, and descent from what is near
  algebra,      ///< the roots of a polynomial of degree 16: all branches
  spare_axis,   ///< one axis at one value after another, one of the ways above for each
  descent,      ///< damped least squares from the seed and from a table of states
};

/// Why a pose was not reached, for a person.
struct IkExplanation {
  IkOutcome outcome = IkOutcome::malformed;
  IkSolution nearest;  ///< within limits; the solution itself where the outcome is `solved`
  std::string reason;  ///< with numbers; empty where the outcome is `solved`
};

class InverseKinematics {
 public:
  /// Keeps nothing of `chain` but copies. Throws Error("bad-model") for more than 64 joints and followers.
  explicit InverseKinematics(const Chain& chain, IkSettings settings = {});
  /// For the chain from the model's root to link `tip`, which is the TCP. Throws as Chain does.
  InverseKinematics(const description::RobotModel& model, int tip, IkSettings settings = {});
  ~InverseKinematics();
  InverseKinematics(InverseKinematics&&) noexcept;
  InverseKinematics& operator=(InverseKinematics&&) noexcept;

  /// True if this arm has a closed form, be it for each value of one axis.
  explicit operator bool() const noexcept;
  IkWay way() const noexcept;
  /// Of six axes in closed form or searched along; else none.
  ArmFamily family() const noexcept;
  /// True if solve_all() finds all solutions of a pose: closed forms and algebra. A search misses some where
  /// two branches are about to merge; an arm with a joint too many has infinitely many.
  bool complete() const noexcept;
  /// What was found in this arm and why, in words.
  const std::string& report() const noexcept;
  const Chain& chain() const noexcept;
  const IkSettings& settings() const noexcept;

  /// The exact solution within limits that is nearest to `seed`. Joints that turn further than once come to
  /// the turn nearest the seed; joints that do not move the TCP keep its values. If there is none, `out` is
  /// the nearest to the pose that the arm's branches offer within limits, and not exact; where they offer
  /// none, the seed.
  IkOutcome solve(const Pose& target, std::span<const double> seed, IkSolution& out) const noexcept;
  /// All branches within limits that reach the pose exactly, nearest to the seed first.
  IkOutcome solve_all(const Pose& target, std::span<const double> seed, IkSolutions& out) const noexcept;
  /// solve() for each of `targets`, with the same seed; the same answers to within 1e-12, and always the same
  /// from run to run. If an arm of six axes has a closed form in quadratics and its description is exact,
  /// eight poses go side by side through all branches (poses near singularities and out of reach still one by
  /// one). Returns how many are solved. Precondition: `out` and `outcomes` are as long as `targets`.
  std::size_t solve_batch(std::span<const Pose> targets, std::span<const double> seed,
                          std::span<IkSolution> out, std::span<IkOutcome> outcomes) const noexcept;

  /// What a move to a pose needs: the solution that descent from `current` finds, if it ends near and not
  /// close to a singularity; else, of all solutions and preferring those not close to a singularity, the one
  /// nearest to `current`, a tie going to the one nearest `home`. "Near": no joint by more than kNearby;
  /// "close to a singularity": below kSingular; neighbours within kSameBranch are taken whatever their
  /// singular value, so that a small step never turns into a change of branch.
  IkOutcome solve_move(const Pose& target, std::span<const double> current, std::span<const double> home,
                       IkSolution& out) const noexcept;
  static constexpr double kNearby = 2.2;          ///< rad or m
  static constexpr double kSameBranch = 0.2;      ///< rad
  static constexpr double kVerySingular = 0.001;  ///< of smallest_singular_value(), for what is near

  /// A joint state that has what `task` asks of the pose, by damped least squares (Chan and Lawrence 1988;
  /// Sugihara 2011): from the seed, then from other states. `exact` means within descent_tolerance here.
  IkOutcome solve(const Pose& target, const IkTask& task, std::span<const double> seed,
                  IkSolution& out) const noexcept;
  /// Distinct ones of these, as many as the restarts find, nearest to the seed first.
  IkOutcome solve_all(const Pose& target, const IkTask& task, std::span<const double> seed,
                      IkSolutions& out) const noexcept;
  /// The solution that one descent from `seed` leads to, and no other: a servo tick, mostly two steps of
  /// third order. If it does not lead there, how far it came.
  IkOutcome track(const Pose& target, std::span<const double> seed, IkSolution& out) const noexcept;

  /// Why there is no solution, which joint or distance is at fault and how near the arm comes. Some hundred
  /// descents; allocates. Never throws for any numbers: a malformed target, seed or task has its own reason.
  IkExplanation explain(const Pose& target, std::span<const double> seed, const IkTask& task = {}) const;

 private:
  struct Arm;
  std::unique_ptr<const Arm> arm_;
};

}  // namespace polyarm::ik
