#pragma once
/// Eight descents of inverse kinematics side by side: forward kinematics, Jacobian, damped least squares and
/// joint limits, in the vector instructions of the processor. NumericIk and SeedTable are built on it;
/// private to the rooms descent and ik. After construction nothing here allocates, throws or reads a clock.
/// Any thread; each needs its own state.
///
/// Internal units: lengths are divided by `length`, so the error has no unit and small and large arms are
/// treated alike. Joint values are radians, of sliding joints multiples of `length`.
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "polyarm/kinematics/arm_geometry.hpp"
#include "polyarm/kinematics/chain.hpp"
#include "polyarm/simd/instruction_set.hpp"

namespace polyarm::kinematics {

/// The arm in frames whose z is the joint's axis. Each frame follows from the previous one by a rotation
/// about their common x; for parallel or perpendicular axes, which are the usual case, that rotation costs
/// almost nothing.
struct DescentArm {
  enum class Bend : std::uint8_t { none, back, left, right, any };  ///< 0, 180, +90, -90 deg, another angle
  struct Axis {
    Bend bend = Bend::none;
    bool slides = false;
    bool first_of_joint = true;  ///< no previous axis belongs to the same joint
    double bend_cos = 1, bend_sin = 0;
    double ratio = 1;   ///< axis value per joint value
    double offset = 0;  ///< rad, angle of the axis at joint value zero
    double offset_cos = 1, offset_sin = 0;
    std::size_t joint = 0;  ///< index among the joints that move the TCP
    Vec3 step;              ///< from this axis to the next (last: to the TCP), in the frame behind this axis
  };
  std::vector<Axis> axes;
  Rotation first_turn;  ///< of the first axis's frame
  Vec3 first_point;
  Rotation last_turn;      ///< from the frame behind the last axis to the TCP
  std::size_t joints = 0;  ///< number of joints that move the TCP
  std::array<std::size_t, Chain::kMostMoving> chain_joint;  ///< their indices in a joint state
  std::array<double, Chain::kMostMoving> unit;              ///< rad or m of one unit
  std::array<double, Chain::kMostMoving> lower, upper;      ///< +-1e9 if there is no limit, or if it is
                                                            ///< farther than a whole turn
  double length = 1;                                        ///< m
  /// The same with joints side by side, for descend_alone(); unused entries are zero.
  struct alignas(64) Single {
    bool possible = false;  ///< at most eight axes, each driven one to one by its own joint
    bool slides = false;    ///< at least one axis slides
    double turns[8] = {};   ///< 1, or 0 for a sliding axis
    double offset[8] = {}, lower[8] = {}, upper[8] = {};
  };
  Single single;

  explicit DescentArm(const Chain& chain);
};

inline constexpr std::size_t kDescents = 8;

/// The components of a pose that count: deviations from the target (current minus target) between `low` and
/// `high` count as zero. x y z in units of length, about x y z in rad; in the target's own axes or the
/// world's.
struct DescentTask {
  bool of_tool = true;
  std::array<double, 6> low{}, high{}, weight{1, 1, 1, 1, 1, 1};
  int spin = -1;  ///< the only tool axis about which the task allows rotation; -1: none
};

/// The state of eight descents: joint values, targets, errors.
struct alignas(64) Descents {
  double x[Chain::kMostMoving][kDescents];
  double target[12][kDescents];    ///< columns of the rotation behind the last axis (9), position (3)
  double position2[kDescents];     ///< squares of the errors at `x`
  double orientation2[kDescents];  ///< of 2 sin(angle / 2)
  double spread[kDescents];        ///< det(J J^T + damping): roughly the square of the manipulability
  double least[kDescents];         ///< the smallest squared error so far
  double stuck[kDescents];         ///< number of steps that hardly helped
  double pull[Chain::kMostMoving][kDescents];  ///< wanted joint motion in the null space of the pose
  std::uint32_t converged = 0, stale = 0;      ///< bit masks

  void restart(std::size_t lane) noexcept {
    least[lane] = 1e300;
    stuck[lane] = 0;
  }
};

struct DescentRules {
  double position2 = 0, orientation2 = 0;  ///< squares of the tolerances
  int steps = 1;                           ///< maximum number of steps
  double patience = 4;                     ///< number of stuck steps after which a descent is stale
  bool pulled = false;                     ///< Descents::pull applies, within the freedom that the pose
                                           ///< leaves
  bool walls = true;                       ///< enforces the limits
};

/// Runs until a descent converges or is stale, or until all steps are done; the errors are those of `x`. A
/// null `task` means the whole pose. Returns the number of steps.
int descend(const DescentArm& arm, const DescentRules& rules, const DescentTask* task,
            Descents& all) noexcept;
/// The same with the instruction set `set`, which the processor must have; results differ in the last digits.
/// For tests.
int descend(InstructionSet set, const DescentArm& arm, const DescentRules& rules, const DescentTask* task,
            Descents& all) noexcept;
/// A single descent from a seed near a solution: joint values within limits and, afterwards, errors as in
/// Descents. Entries of joints that the arm does not have are zero.
struct alignas(64) SingleDescent {
  double x[kDescents] = {};
  double position2 = 1e300, orientation2 = 1e300;
};
/// A few steps towards the whole pose `target` (as Descents::target), until it is within the tolerances of
/// `rules`. False, with `one` unchanged, if it does not converge quickly or if DescentArm::single is not
/// possible: use descend() then.
bool descend_alone(const DescentArm& arm, const DescentRules& rules, const double* target,
                   SingleDescent& one) noexcept;
bool descend_alone(InstructionSet set, const DescentArm& arm, const DescentRules& rules, const double* target,
                   SingleDescent& one) noexcept;

/// Eight states of an arm of seven turning axes that slide along their self-motions (curves of joint states
/// with the same pose) to where these are nearest to the seed.
struct alignas(64) Slides {
  static constexpr std::size_t kJoints = 7;
  double x[kJoints][kDescents];
  double along[kJoints][kDescents];  ///< direction of the curve, unit length; any at first
  double target[12][kDescents];      ///< as Descents::target
  double slope[kDescents];           ///< derivative of half the squared distance, one step ago
  double stride[kDescents];          ///< of the last step, rad
  double size2[kDescents];           ///< square of the error, lengths and rad
  double steps[kDescents];
  std::uint32_t working = 0;  ///< bit mask; other lanes are ignored
  std::uint32_t done = 0;     ///< bit mask, of the working lanes
  std::uint32_t settled =
      0;  ///< bit mask of done lanes: ended or out of steps, not because others promise more

  void restart(std::size_t lane) noexcept { slope[lane] = stride[lane] = steps[lane] = 0; }
};
struct SlideRules {
  std::array<double, Slides::kJoints> lower, upper, seed, weight;  ///< weights of squared distances
  double size2 = 0;                                                ///< squared error up to which a state
                                                                   ///< counts as exact
  double stride = 0;                                               ///< rad: shorter steps are not worth it
  double best = 1e300;   ///< squared distance: slides that promise no improvement on it stop
  int steps = 1;         ///< maximum number of steps
  double patience = 40;  ///< steps after which a slide is done
};
/// Runs until a slide is done, or until all steps are. A slide that is done has not moved in the last step.
/// Returns the number of steps.
int slide(const DescentArm& arm, const SlideRules& rules, Slides& all) noexcept;
/// The pose features of a table of ends: without the rotations of a first and a last joint about their own
/// axes.
struct EndSeen {
  Vec3 point;  ///< of the last axis, relative to the TCP, in the frame behind that axis, whose z it is
  bool first_turns = false, last_turns = false;
  Rotation base;  ///< from the world into the frame of the first axis
  Vec3 first_point;
};
/// Joint states and the features of their ends, in `count` rows, a multiple of kDescents. A block is
/// kDescents rows: one number of all its rows, then the next number.
struct EndTable {
  EndSeen seen;
  std::size_t count = 0;
  const double* states = nullptr;  ///< blocks, joint after joint
  const bool* still = nullptr;     ///< joints with the same value in all rows
  double place_weight = 1;         ///< of lengths relative to directions
  /// The point, the last axis and its perpendicular, without the removed rotations: number after number of
  /// all rows.
  float* numbers = nullptr;
  double* turn = nullptr;    ///< the removed rotation, rad; if first_turns
  double* beside = nullptr;  ///< blocks of three; if last_turns
};
void see_ends(const DescentArm& arm, const EndTable& table) noexcept;
/// Computes errors and spread at `x`, nothing else.
void measure(const DescentArm& arm, const DescentTask* task, Descents& all) noexcept;

/// A table of points for find_near(): up to kFeatures numbers each, in rows of `count` values, a multiple of
/// 16.
struct FeatureTable {
  static constexpr std::size_t kFeatures = 9;
  std::size_t count = 0, used = 0;
  std::unique_ptr<float[]> rows;  ///< feature after feature
};
inline constexpr std::size_t kNearGroups = 16;
/// For each sixteenth of the table: the point nearest to `at` that is not nearer than `beyond` (a squared
/// distance): its index and its squared distance.
struct NearPoints {
  alignas(64) float distance2[kNearGroups];
  alignas(64) std::int32_t index[kNearGroups];
};
void find_near(const FeatureTable& table, const float* at, const float* beyond, NearPoints& out) noexcept;

/// The query of find_states(): states with ends near a place and with joints near those of a seed.
struct StatesWanted {
  std::array<float, FeatureTable::kFeatures> place;
  float place_weight = 1;             ///< of squares, relative to squared joint values
  std::size_t first = 0, joints = 0;  ///< the joints that count, each with one row of `values`
  std::array<float, 8> seed{}, weight{}, period{}, over_period{};  ///< period 0: the joint has none
};
inline constexpr std::size_t kStateGroups = 128;
/// For each of 128 interleaved groups of states, the best one: its row and its cost.
struct StatesNear {
  alignas(64) float cost[kStateGroups];
  alignas(64) std::int32_t row[kStateGroups];
};
/// `values`: of all joints, one after the other, each as long as the table, a multiple of 128.
void find_states(const FeatureTable& table, const float* values, const StatesWanted& wanted,
                 StatesNear& out) noexcept;

}  // namespace polyarm::kinematics
