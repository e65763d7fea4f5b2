#pragma once
/// The closed forms of six turning axes, all eight branches side by side, and the search along one axis of
/// arms that have none. What InverseKinematics is built on;
/// used inside this room only. Nothing here allocates or throws after construction; any thread.
#include <array>
#include <cstdint>
#include <span>

#include "polyarm/closed_form/arm_class.hpp"
#include "polyarm/simd/instruction_set.hpp"

namespace polyarm::kinematics {

struct IkSolution;

inline constexpr std::size_t kBranches = 8;

/// A pose as the solvers take it, in the world.
struct PoseTarget {
  Rotation rotation;
  Vec3 position;
};

/// Three axes that put a point somewhere: p = R1 (p12 + R2 (p23 + R3 p34)), p12 along the common
/// perpendicular of axes 1 and 2.
struct Shoulder {
  enum class Kind { any, meets, parallel } kind = Kind::any;  ///< what axes 1 and 2 are to each other
  Vec3 h1, h2, h3, p12, p23;
  Vec3 first;                   ///< a point of axis 1, which the place is seen from
  Vec3 e1, e2;                  ///< with h2 a right-handed frame; p12 = distance * e1
  double distance = 0;          ///< of axes 1 and 2
  double sine = 0, cosine = 0;  ///< h1 . e2 and h1 . h2
  double least_length = 0;
};

/// Two lengths that turn against each other about one axis: |R(k, angle) p - q| for points p and q.
struct Reach {
  double s = 0, c = 0;  ///< q . (k x p) and the part of q . p square to the axis
  double radius = 0;    ///< of (c, s)
  double half = 0;      ///< half the square of the distance, where the angle's part of it is nothing
  double least = 0;     ///< a radius shorter than this is nothing
};

/// Constants of one arm's family, taken from its ideal form.
struct SixAxisForm {
  ArmFamily family = ArmFamily::none;
  bool from_tool = false;
  std::array<Vec3, 6> h;          ///< directions of the axes
  Vec3 p12, p23, p34, p45;        ///< from a point of one axis to a point of the next
  Vec3 first;                     ///< a point of axis 1
  Vec3 center_in_tool;            ///< the wrist's point (or where axes 5 and 6 meet), as the tool sees it
  Vec3 beside_6;                  ///< a unit vector square to axis 6
  Vec3 beside_1;                  ///< and to axis 1
  Rotation from_tool_rotation;    ///< transposed rotation of the tool at zero
  double height = 0;              ///< what the first step holds on to, m
  double side_3 = 1, side_4 = 1;  ///< whether axes 3 and 4 point along axis 2 (1) or against it (-1)
  double least_length = 0;        ///< shorter than this is nothing, m
  double least_sine = 0;          ///< smaller than this is parallel
  double edge = 0;                ///< how far from a border solutions are parted (Edge::part)
  bool wary = false;              ///< what is near a border is told
  double edge_slope = 0;          ///< Edge::slope
  double near_edge = 0;           ///< Edge::near
  bool square_wrist = false;      ///< axis 5 is square to axes 4 and 6, to the last digit
  double bend_s = 0, bend_c = 1;  ///< angle 5 at which axes 4 and 6 of such a wrist are one
  Reach elbow;                    ///< of axis 3
  Vec3 axis_in_tool;              ///< axis 6 and what is beside it, as the tool sees them
  Vec3 beside_in_tool;
  Rotation tool_rotation;  ///< of the tool at zero
  Shoulder shoulder;       ///< of families whose first three axes are of any kind
  Vec3 p56, to_56;         ///< from a point of axis 5 to one of axis 6; from axis 4 to where both meet
  Vec3 to_45, beside_5;    ///< from axis 6 to where axes 4 and 5 meet; a unit vector square to axis 5
  double from_5[4] = {};   ///< (c5, s5) from what axes 2 to 4 leave alone, row after row
};
/// `known` has a family. With `wary`, what is nearly singular, in view of how far the
/// ideal arm is from the true one, counts as singular.
SixAxisForm form_of(const SixAxisClass& known, bool wary = false);

/// One axis of an arm whose axes all lie along those of one frame.
struct SquareStep {
  std::uint8_t about = 2;  ///< x, y or z of that frame
  bool against = false;    ///< it points the other way
  bool aside = false;      ///< `step` is not nothing
  Vec3 step;               ///< from the point of the axis before (at first: the world's origin), there
};

/// The true arm for sweeps over all branches: each axis is z of a frame of its own.
struct LaneArm {
  std::size_t count = 0;
  std::array<Rotation, ArmGeometry::kMostAxes + 1> turn;  ///< from the frame before to this one (tool: last)
  std::array<Vec3, ArmGeometry::kMostAxes + 1> step;
  std::array<bool, ArmGeometry::kMostAxes> slides{};
  double size = 1;
  /// A shorter way, where all axes turn and, but for rounding, lie along those of one frame.
  bool square = false, level = false;  ///< level: that frame is the world's
  Rotation frame;                      ///< from there to the world
  std::array<SquareStep, ArmGeometry::kMostAxes> along;
  Vec3 tool_x, tool_y, tool_step;  ///< the tool's axes and place at zero, there
};
LaneArm lane_arm(const ArmGeometry& arm);

/// Within which joint values are wanted, and near which: of each axis of the true arm.
struct LaneLimits {
  std::array<double, ArmGeometry::kMostAxes> lower{}, upper{}, weight{};  ///< weights of squared distances
};

/// One question to the kernel.
struct BranchJob {
  const SixAxisForm* form = nullptr;
  const LaneArm* arm = nullptr;
  PoseTarget target;
  /// For each axis of the form, the axis of the true arm; -1: an axis that the arm has not.
  std::array<int, 6> to_arm{0, 1, 2, 3, 4, 5};
  /// Values of all axes of the true arm: what free angles take, and where axes outside of the form stay.
  const double* seed = nullptr;
  const LaneLimits* limits = nullptr;
  const double* near = nullptr;  ///< joint values that answers come near to by whole turns; set with limits
  /// Errors up to this are worked on, m and rad; 0: answers are only checked.
  double worth_polishing = 1e-3;
  bool all_move = false;       ///< descent moves every axis of the arm, not only those of the form
  int patience = 4;            ///< steps after which only small errors are worth more
  int most_steps = 30;         ///< of descent
  double good_enough = 1e-11;  ///< errors smaller than this are not worked on, m and rad
  /// How far the true arm is from the ideal one that has the form, m and rad; 0: what strayed is not asked
  /// for.
  double ideal = 0;
};

/// What came out, axis after axis, for each branch. Angles are within a turn about zero, or of the turns
/// within limits the one nearest to BranchJob::near.
struct Branches {
  alignas(64) double value[ArmGeometry::kMostAxes][kBranches];
  alignas(64) double position_error2[kBranches];     ///< square of metres
  alignas(64) double orientation_error2[kBranches];  ///< square of radians, at most double
  alignas(64) double distance2[kBranches];           ///< weighted, from BranchJob::near
  std::uint32_t inside = ~0u;                        ///< branches within limits (bits)
  std::uint32_t free = 0;                            ///< branches in which an angle was free (bits)
  /// Branches of an arm that is not quite ideal near which there may be other solutions, or none (bits): what
  /// descent from the ideal arm's answers tells, and what there is where that has no answer.
  std::uint32_t strayed = 0;
};

/// In which of its turns a joint is wanted: within limits, and of those turns nearest to a given value. A
/// window of one turn has the one that is meant; its center is the value, brought to within low_center and
/// high_center.
struct JointWindow {
  double low_center = 0, high_center = 0;
  double bias = 0;  ///< in turns: half a turn away either way is always the same way
  double lower = 0, upper = 0;
  double weight = 1;  ///< of the square of the distance
  double root_weight = 1;
};
JointWindow window_of(double lower, double upper, double weight) noexcept;

/// s * sine + c * cosine = b, of which all but b is known beforehand.
struct PlanarCircle {
  double s = 0, c = 0;  ///< divided by the radius
  double radius = 0, over = 0;
  double angle = 0;  ///< of (c, s), turns
  bool usable = false;
};
/// still + cosine * ahead + sine * across
struct TurnedVector {
  Vec3 still, ahead, across;
};
/// Where axis 5 is square to axis 6 and to the hub, to the last digit, the three are as Euler's angles, and
/// the other bend is the same with the turn and angle 6 half a turn on. Axis 5 at zero is then x of the hub's
/// frame.
struct SquareBend {
  bool usable = false;
  double hub_s = 0, hub_c = 1;  ///< of a wrist: of the angle from the plane's x to the hub; else to axis 5
  double side_5 = 1;            ///< of a wrist: whether axis 5 points along axis 2 (1) or against it (-1)
  double six_s = 0, six_c = 1;  ///< of the bend at which axis 6 is along the hub
  double six_angle = 0;         ///< and that angle, turns
  double least_sine2 = 0;       ///< less is nearly singular
};

/// Constants of an arm whose axes 2 and 3 are parallel (planar_form.hpp); made by planar_form().
struct PlanarForm {
  bool usable = false;
  bool wrist = false;     ///< axes 4 to 6 meet; else axis 4 is parallel to 2 and 3, and 5 and 6 meet
  Rotation into_base;     ///< from the world's axes to those of a frame whose z is axis 1
  double rise = 0;        ///< axis 2 there, of which y is nothing: its x
  double rise_along = 0;  ///< and its z
  double height = 0;      ///< of the wrist's point along axis 2
  /// Between points of the axes, in a frame whose z is axis 2 and whose x is square to axes 1 and 2.
  Vec3 p12, p23, p34, p45;
  double side_3 = 1, side_4 = 1;
  PlanarCircle elbow, bend;  ///< of axes 3 and 5
  double elbow_half = 0;     ///< Reach::half, in radii of the elbow
  Rotation into_hub;         ///< from the plane's frame to one whose z is the axis that the bend is seen from
  TurnedVector six, beside, across;  ///< axis 6 and what is square to it, turned about axis 5, in that frame
  double least_length2 = 0, least_sine2 = 0, near_edge = 0;
  bool level = false;    ///< axis 1 is along the world's z
  bool upright = false;  ///< axis 2 is square to axis 1
  Vec3 beside_in_tool;   ///< square to axis 6, as the tool sees it: where angle 6 is counted from
  SquareBend square;
};

/// What quick answers need: of an arm of six turning axes whose closed form is exact (takes_quick()).
struct QuickJob {
  SixAxisForm form;                      ///< form_for_quick()
  std::array<JointWindow, 6> window;     ///< of the form's axes
  std::array<std::uint8_t, 6> to_arm{};  ///< for each axis of the form, the axis of the arm
  std::array<std::uint8_t, 6> joint{};   ///< and the joint, whose value in a seed answers come near to
  PlanarForm planar;                     ///< a shorter way, where it is usable
  double most_weight = 1;                ///< of the windows
};
/// Whether the family goes in steps.
bool takes_quick(const SixAxisClass& known) noexcept;
/// Whether the steps have what they hold on to.
bool takes_quick(const QuickJob& job) noexcept;
/// A form that tells whatever is near to singular, so that the quick way need not deal with it.
SixAxisForm form_for_quick(const SixAxisClass& known);

/// The eight branches of one pose, or one branch for each of eight poses, checked on the true arm.
struct QuickAnswers {
  alignas(64) double value[6][kBranches];           ///< of the arm's axes
  alignas(64) double position_error[kBranches];     ///< m
  alignas(64) double orientation_error[kBranches];  ///< rad
  alignas(64) double distance[kBranches];           ///< weighted, from the seed
  std::uint32_t good = 0;                           ///< exact to kGoodEnough and within limits (bits)
};
/// All branches of a pose. False where something is nearly singular, or not exact but near: the answer is
/// then solve_branches()'s to give.
bool solve_quickly(const QuickJob& job, const LaneArm& arm, const Pose& target, const double* seed,
                   QuickAnswers& out) noexcept;
/// Of each pose the branch nearest to the seed (a joint state of the chain), by the same arithmetic. Poses
/// whose bit in `good` (eight to a byte, the first the lowest) is not set have to be solved on their own, one
/// by one: what `out` has of them is nothing.
void solve_together(const QuickJob& job, const LaneArm& arm, std::span<const Pose> targets,
                    std::span<const double> seed, std::span<IkSolution> out,
                    std::span<std::uint8_t> good) noexcept;
/// Of up to eight.
void solve_eight(const QuickJob& job, const LaneArm& arm, std::span<const Pose> targets, const double* seed,
                 QuickAnswers& out) noexcept;
/// As above, with the instructions of `set`, which the processor has. For tests and benchmarks.
void solve_eight(InstructionSet set, const QuickJob& job, const LaneArm& arm, std::span<const Pose> targets,
                 const double* seed, QuickAnswers& out) noexcept;

/// Solves, checks on the true arm, and improves there what is not exact: errors end near rounding or are
/// those of the nearest that the family has to offer.
void solve_branches(const BranchJob& job, Branches& out) noexcept;
/// The same with the instructions that every processor has; results differ in the last digits. For tests.
void solve_branches_portably(const BranchJob& job, Branches& out) noexcept;

/// At most so many blocks come out of a search.
inline constexpr std::size_t kSearchBlocks = 40;
/// For families of searched(): axis 4 (or 6) at 64 values side by side, for each the up to four ways of the
/// first three axes to reach where axes 5 and 6 (or 4 and 5) meet, and one step of descent from there; where
/// that step stays nearby, descent goes on to the end. Returns how many of `out` are filled; branches that
/// repeat each other or are not exact are among them.
std::size_t search_branches(const BranchJob& job, std::span<Branches> out) noexcept;

/// How close eight joint states are to a singularity: the direction in joint space (a unit vector) that moves
/// the TCP least, and by how much it does, lengths measured in LaneArm::size; then the same of what is square
/// to that. By inverse iteration, so roughly. Of arms whose axes all turn; of more than six the first six.
struct LeastMotions {
  alignas(64) double way[6][kBranches], next_way[6][kBranches];
  alignas(64) double least[kBranches], next[kBranches];
};
/// `at.value` in. Without `both` the second is left out.
void find_least_motions(const LaneArm& arm, const Branches& at, bool both, LeastMotions& out) noexcept;

/// Checks and improves, on the true arm, values that came from elsewhere: `out.value` in, all of `out` out.
void polish_branches(const BranchJob& job, Branches& out) noexcept;

}  // namespace polyarm::kinematics
