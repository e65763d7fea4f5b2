#pragma once
/// The one door to inverse kinematics: in closed form where the arm's description has one, else by search
/// along one axis, else by iteration (NumericIk), which also has the last word where a search finds nothing.
/// For the control cycle too. Metres, radians, poses of the TCP in the world.
#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <string>

#include "polyarm/closed_form/arm_class.hpp"
#include "polyarm/kinematics/chain.hpp"
#include "polyarm/kinematics/ik_solution.hpp"

namespace polyarm::kinematics {

struct IkSettings {
  double position_tolerance = 1e-9;     ///< m; errors up to this are exact
  double orientation_tolerance = 1e-9;  ///< rad
  /// What a radian (or a metre) of each joint counts in a distance; empty: 1 each.
  std::vector<double> weights;
  /// Of an arm with one joint too many: how many values of it are tried over its range.
  int samples = 16;
  /// Whether the numeric solver is made at construction (some 100 us more) also for arms in closed form, so
  /// that questions with an IkTask may be asked in the control cycle.
  bool parts_of_poses = false;
};

/// How an arm's poses are solved.
enum class IkWay {
  none,         ///< not at all: no joint moves the TCP
  closed_form,  ///< all branches
  search,       ///< a closed form for each of 64 values of one axis, and descent from what is near
  algebra,      ///< the roots of a polynomial of degree 16: all branches
  spare_axis,   ///< one axis at one value after another, one of the ways above for each
  descent,      ///< damped least squares from the seed and from a table of states (NumericIk)
};

struct IkTask;

/// The inverse kinematics of one arm. Built once (some us in closed form, 10 to 25 us else, 100 where the
/// polynomial is tried out; allocates), then const
/// and without hidden state: any thread. solve() and solve_all() allocate nothing, throw nothing and read no
/// clock; their time is bounded.
class InverseKinematics {
 public:
  /// Keeps nothing of `chain` but copies. Throws Error("bad-model") for more than 64 joints and followers.
  explicit InverseKinematics(const Chain& chain, IkSettings settings = {});
  /// Of the chain from the model's root to link `tip`, which is the TCP. Throws as Chain does.
  InverseKinematics(const description::RobotModel& model, int tip, IkSettings settings = {});
  ~InverseKinematics();
  InverseKinematics(InverseKinematics&&) noexcept;
  InverseKinematics& operator=(InverseKinematics&&) noexcept;

  /// Whether this arm has a closed form, be it for each value of one axis.
  explicit operator bool() const noexcept;
  IkWay way() const noexcept;
  /// Of six axes in closed form or searched along; else none.
  ArmFamily family() const noexcept;
  /// Whether all solutions of a pose are found: of closed forms and algebra. A search misses some where two
  /// branches are about to meet; an arm with a joint too many has endlessly many.
  bool complete() const noexcept;
  /// What was found in this arm and why, in words, for a person.
  const std::string& report() const noexcept;

  /// The exact solution within limits that is nearest to `seed` (a joint state of the chain; joints that turn
  /// further than once come to the turn nearest the seed, joints that do not move the TCP keep its values).
  /// Where there is none, `out` is the nearest to the pose that the arm's branches offer within limits, and
  /// not exact; where they offer none, the seed.
  IkOutcome solve(const Pose& target, std::span<const double> seed, IkSolution& out) const noexcept;
  /// All branches within limits that lead there exactly, nearest to the seed first.
  IkOutcome solve_all(const Pose& target, std::span<const double> seed, IkSolutions& out) const noexcept;
  /// A joint state that has what `task` (numeric_ik.hpp) asks of the pose, by NumericIk with the tolerances
  /// of the settings; ArmSolver::solve() says in words why there is none. Without
  /// IkSettings::parts_of_poses an arm in closed form makes its numeric solver anew each time, which takes
  /// some 100 us, allocates and may throw.
  IkOutcome solve(const Pose& target, const IkTask& task, std::span<const double> seed,
                  IkSolution& out) const;
  /// solve() for each of `targets`, with the same seed; the same answers to within 1e-12, and always the same
  /// from run to run. Where an arm of six axes has a closed form in quadratics and its description is exact,
  /// eight poses go side by side through all branches (poses near singularities and out of reach still one by
  /// one). Returns how many are solved. Precondition: `out` and `outcomes` are as long as `targets`.
  /// Allocates nothing, throws nothing; any thread.
  std::size_t solve_batch(std::span<const Pose> targets, std::span<const double> seed,
                          std::span<IkSolution> out, std::span<IkOutcome> outcomes) const noexcept;

 private:
  struct Arm;
  std::unique_ptr<const Arm> arm_;
};

}  // namespace polyarm::kinematics
