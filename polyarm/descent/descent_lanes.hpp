#pragma once
/// Eight descents of inverse kinematics side by side: forward kinematics, Jacobian, damped least squares and
/// joint limits, in whatever vector instructions the processor has. What NumericIk and SeedTable are built
/// on; used inside this room only. After construction nothing here allocates, throws or reads a clock; any
/// thread, each with a state of its own.
///
/// Units inside: lengths are divided by `length`, so that the error has no unit and small and large arms are
/// treated alike; joint values are radians, of sliding joints multiples of `length`.
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "polyarm/kinematics/arm_geometry.hpp"
#include "polyarm/kinematics/chain.hpp"
#include "polyarm/simd/instruction_set.hpp"

namespace polyarm::kinematics {

/// The arm in frames whose z is the joint's axis and which lead into one another by a turn about their common
/// x: where axes are parallel or square to each other, as they mostly are, next to nothing is to be computed.
struct DescentArm {
  enum class Bend : std::uint8_t { none, back, left, right, any };  ///< 0, 180, +90, -90 deg, another angle
  struct Axis {
    Bend bend = Bend::none;
    bool slides = false;
    bool first_of_joint = true;  ///< no axis before belongs to the same joint
    double bend_cos = 1, bend_sin = 0;
    double ratio = 1;   ///< its value per value of the joint
    double offset = 0;  ///< rad, its angle where the joint is at zero
    double offset_cos = 1, offset_sin = 0;
    std::size_t joint = 0;  ///< index among the joints that move the TCP
    Vec3 step;              ///< from this axis to the next (last: to the TCP), as seen behind this axis
  };
  std::vector<Axis> axes;
  Rotation first_turn;  ///< of the first axis' frame
  Vec3 first_point;
  Rotation last_turn;      ///< from the frame behind the last axis to the TCP
  std::size_t joints = 0;  ///< that move the TCP
  std::array<std::size_t, Chain::kMostMoving> chain_joint;  ///< their places in a joint state
  std::array<double, Chain::kMostMoving> unit;              ///< rad or m of one unit
  std::array<double, Chain::kMostMoving> lower, upper;      ///< +-1e9: none, or further than a whole turn
  double length = 1;                                        ///< m
  /// The same with the joints side by side, for descend_alone(); what is left of eight is zero.
  struct alignas(64) Single {
    bool possible = false;  ///< at most eight axes, each with a joint of its own that it follows one to one
    bool slides = false;    ///< one of them
    double turns[8] = {};   ///< 1, or 0 where it slides
    double offset[8] = {}, lower[8] = {}, upper[8] = {};
  };
  Single single;

  explicit DescentArm(const Chain& chain);
};

inline constexpr std::size_t kDescents = 8;

/// What of a pose counts: deviations from the target (current minus target) between `low` and `high` are as
/// good as none. x y z in units of length, about x y z in rad; along the target's own axes, or the world's.
struct DescentTask {
  bool of_tool = true;
  std::array<double, 6> low{}, high{}, weight{1, 1, 1, 1, 1, 1};
  int spin = -1;  ///< the one axis of the tool about which it may turn freely
};

/// Eight descents at work: joint values, targets, errors.
struct alignas(64) Descents {
  double x[Chain::kMostMoving][kDescents];
  double target[12][kDescents];    ///< columns of the rotation behind the last axis (9), position (3)
  double position2[kDescents];     ///< squares of the errors at `x`
  double orientation2[kDescents];  ///< of 2 sin(angle / 2)
  double spread[kDescents];        ///< det(J J^T + damping): the square of the manipulability, roughly
  double least[kDescents];         ///< the least error so far (squared)
  double stuck[kDescents];         ///< steps that hardly helped
  double pull[Chain::kMostMoving][kDescents];  ///< what joints would do if the pose did not matter
  std::uint32_t converged = 0, stale = 0;      ///< bits

  void restart(std::size_t lane) noexcept {
    least[lane] = 1e300;
    stuck[lane] = 0;
  }
};

struct DescentRules {
  double position2 = 0, orientation2 = 0;  ///< squares of the tolerances
  int steps = 1;                           ///< at most so many
  double patience = 4;                     ///< stuck steps after which a descent is stale
  bool pulled = false;                     ///< Descents::pull counts, in what the pose leaves free
  bool walls = true;                       ///< limits hold
};

/// Goes on until a descent converges or is stale, or all steps are done; the errors are those of `x`. `task`
/// null: the whole pose. Returns the steps done.
int descend(const DescentArm& arm, const DescentRules& rules, const DescentTask* task,
            Descents& all) noexcept;
/// The same with the instructions of `set`, which the processor has; results differ in the last digits. For
/// tests.
int descend(InstructionSet set, const DescentArm& arm, const DescentRules& rules, const DescentTask* task,
            Descents& all) noexcept;
/// One descent alone, of a seed near a solution: joint values within limits and, afterwards, errors as
/// Descents has them. Joints that the arm does not have are zero.
struct alignas(64) SingleDescent {
  double x[kDescents] = {};
  double position2 = 1e300, orientation2 = 1e300;
};
/// A few steps towards the whole pose `target` (as Descents::target), until it is within the tolerances of
/// `rules`. False where they do not lead there quickly, or DescentArm::single is not possible: `one` is then
/// as it was, and descend() is the way.
bool descend_alone(const DescentArm& arm, const DescentRules& rules, const double* target,
                   SingleDescent& one) noexcept;
bool descend_alone(InstructionSet set, const DescentArm& arm, const DescentRules& rules, const double* target,
                   SingleDescent& one) noexcept;

/// Eight states of an arm of seven turning axes that slide along their self-motions, the curves of joint
/// states that leave the pose alone, to where these come nearest to the seed.
struct alignas(64) Slides {
  static constexpr std::size_t kJoints = 7;
  double x[kJoints][kDescents];
  double along[kJoints][kDescents];  ///< the curve's direction, of length 1; at first any
  double target[12][kDescents];      ///< as Descents::target
  double slope[kDescents];           ///< of half the squared distance, one step ago
  double stride[kDescents];          ///< of the last step, rad
  double size2[kDescents];           ///< square of the error, lengths and rad
  double steps[kDescents];
  std::uint32_t working = 0;  ///< bits: the others are not looked at
  std::uint32_t done = 0;     ///< bits, of those at work
  std::uint32_t settled =
      0;  ///< bits, of those done: at an end or out of patience, not as others promise more

  void restart(std::size_t lane) noexcept { slope[lane] = stride[lane] = steps[lane] = 0; }
};
struct SlideRules {
  std::array<double, Slides::kJoints> lower, upper, seed, weight;  ///< weights of squared distances
  double size2 = 0;                                                ///< of errors, as exact as is asked for
  double stride = 0;     ///< rad: steps as short are no longer worth it
  double best = 1e300;   ///< square of a distance: slides that do not promise less are done
  int steps = 1;         ///< at most so many
  double patience = 40;  ///< steps after which a slide is done
};
/// Goes on until a slide is done, or all steps are. What is done has not moved in the last step. Returns the
/// steps.
int slide(const DescentArm& arm, const SlideRules& rules, Slides& all) noexcept;
/// How a table of ends sees them: without the turns of a first and a last joint about their own axes.
struct EndSeen {
  Vec3 point;  ///< of the last axis, from the TCP, as seen behind that axis, whose z it is
  bool first_turns = false, last_turns = false;
  Rotation base;  ///< from the world into the frame of the first axis
  Vec3 first_point;
};
/// Joint states and what is seen of where they end, in rows; `count` of them, a multiple of kDescents. Blocks
/// are kDescents rows: of one number those of all its rows, then the next number.
struct EndTable {
  EndSeen seen;
  std::size_t count = 0;
  const double* states = nullptr;  ///< blocks, joint after joint
  const bool* still = nullptr;     ///< joints that have the same value in all rows
  double place_weight = 1;         ///< of lengths against directions
  /// The point, the last axis, what is beside it, but what turns leave out: number after number of all rows.
  float* numbers = nullptr;
  double* turn = nullptr;    ///< that was left out, rad; where first_turns
  double* beside = nullptr;  ///< blocks of three; where last_turns
};
void see_ends(const DescentArm& arm, const EndTable& table) noexcept;
/// Errors and spread at `x`, nothing else.
void measure(const DescentArm& arm, const DescentTask* task, Descents& all) noexcept;

/// A table of points for find_near(): up to kFeatures numbers each, in rows of `count`, a multiple of 16.
struct FeatureTable {
  static constexpr std::size_t kFeatures = 9;
  std::size_t count = 0, used = 0;
  std::unique_ptr<float[]> rows;  ///< feature after feature
};
inline constexpr std::size_t kNearGroups = 16;
/// Of each sixteenth of the table the point nearest to `at` that is not nearer than `beyond` (squared, of
/// that sixteenth): its place and its squared distance.
struct NearPoints {
  alignas(64) float distance2[kNearGroups];
  alignas(64) std::int32_t index[kNearGroups];
};
void find_near(const FeatureTable& table, const float* at, const float* beyond, NearPoints& out) noexcept;

/// What find_states() looks for: states whose ends are near a place, and whose joints near a seed's.
struct StatesWanted {
  std::array<float, FeatureTable::kFeatures> place;
  float place_weight = 1;             ///< of squares, against those of joint values
  std::size_t first = 0, joints = 0;  ///< these joints count, each one row of `values`
  std::array<float, 8> seed{}, weight{}, period{}, over_period{};  ///< no period: zero
};
inline constexpr std::size_t kStateGroups = 128;
/// Of every 128th state from each on the best: its row and what it costs.
struct StatesNear {
  alignas(64) float cost[kStateGroups];
  alignas(64) std::int32_t row[kStateGroups];
};
/// `values`: of all joints, one after the other, as long as the table, a multiple of 128.
void find_states(const FeatureTable& table, const float* values, const StatesWanted& wanted,
                 StatesNear& out) noexcept;

}  // namespace polyarm::kinematics
