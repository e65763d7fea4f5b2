#pragma once
/// Closed forms of six turning axes, all eight branches side by side, and the search along one axis for arms
/// without a closed form. InverseKinematics is built on them; private to the rooms closed_form and ik.
/// Metres, radians, world frame. Nothing here allocates or throws after construction; any thread.
#include <array>
#include <cstdint>
#include <span>

#include "polyarm/closed_form/arm_class.hpp"
#include "polyarm/simd/instruction_set.hpp"

namespace polyarm::kinematics {

struct IkSolution;

inline constexpr std::size_t kBranches = 8;

/// A pose in the form of the solvers, in the world.
struct PoseTarget {
  Rotation rotation;
  Vec3 position;
};

/// Three axes that position a point: p = R1 (p12 + R2 (p23 + R3 p34)); p12 lies along the common
/// perpendicular of axes 1 and 2.
struct Shoulder {
  enum class Kind { any, meets, parallel } kind = Kind::any;  ///< relation of axes 1 and 2
  Vec3 h1, h2, h3, p12, p23;
  Vec3 first;                   ///< a point of axis 1; positions are relative to it
  Vec3 e1, e2;                  ///< right-handed frame with h2; p12 = distance * e1
  double distance = 0;          ///< between axes 1 and 2
  double sine = 0, cosine = 0;  ///< h1 . e2 and h1 . h2
  double least_length = 0;
};

/// The distance |R(k, angle) p - q| of two points p and q, one of which turns about an axis k.
struct Reach {
  double s = 0, c = 0;  ///< q . (k x p), and the part of q . p perpendicular to the axis
  double radius = 0;    ///< of (c, s)
  double half = 0;      ///< half the squared distance without the part that depends on the angle
  double least = 0;     ///< a smaller radius counts as zero
};

/// Constants of one arm's family, from its ideal form.
struct SixAxisForm {
  ArmFamily family = ArmFamily::none;
  bool from_tool = false;
  std::array<Vec3, 6> h;          ///< directions of the axes
  Vec3 p12, p23, p34, p45;        ///< from a point of one axis to a point of the next
  Vec3 first;                     ///< a point of axis 1
  Vec3 center_in_tool;            ///< the wrist's point (or where axes 5 and 6 meet), in the tool frame
  Vec3 beside_6;                  ///< a unit vector perpendicular to axis 6
  Vec3 beside_1;                  ///< a unit vector perpendicular to axis 1
  Rotation from_tool_rotation;    ///< transposed rotation of the tool at zero
  double height = 0;              ///< the constant length that the first step of the family uses, m
  double side_3 = 1, side_4 = 1;  ///< 1 if axes 3 and 4 point along axis 2, -1 if against it
  double least_length = 0;        ///< a smaller length counts as zero, m
  double least_sine = 0;          ///< below this two axes count as parallel
  double edge = 0;                ///< separation of solutions at a border (Edge::part)
  bool wary = false;              ///< a pose near a border counts as free
  double edge_slope = 0;          ///< Edge::slope
  double near_edge = 0;           ///< Edge::near
  bool square_wrist = false;      ///< axis 5 is perpendicular to axes 4 and 6, to the last digit
  double bend_s = 0, bend_c = 1;  ///< angle 5 at which axes 4 and 6 of such a wrist coincide
  Reach elbow;                    ///< of axis 3
  Vec3 axis_in_tool;              ///< axis 6 and its perpendicular, in the tool frame
  Vec3 beside_in_tool;
  Rotation tool_rotation;  ///< of the tool at zero
  Shoulder shoulder;       ///< for families with any kind of first three axes
  Vec3 p56, to_56;         ///< from a point of axis 5 to one of axis 6; from axis 4 to where both meet
  Vec3 to_45, beside_5;    ///< from axis 6 to where axes 4 and 5 meet; a unit vector perpendicular to axis 5
  double from_5[4] = {};   ///< maps the parts that axes 2 to 4 do not change to (c5, s5), row-major
};
/// `known` has a family. With `wary`, nearly singular counts as singular; the threshold grows with the
/// distance of the ideal arm from the true one.
SixAxisForm form_of(const SixAxisClass& known, bool wary = false);

/// One axis of an arm whose axes all lie along those of one frame.
struct SquareStep {
  std::uint8_t about = 2;  ///< x, y or z of that frame
  bool against = false;    ///< it points in the negative direction
  bool aside = false;      ///< `step` is not zero
  Vec3 step;               ///< from a point of the previous axis (at first: the world's origin), in that
                           ///< frame
};

/// The true arm for sweeps over all branches: each axis is z of its own frame.
struct LaneArm {
  std::size_t count = 0;
  std::array<Rotation, ArmGeometry::kMostAxes + 1> turn;  ///< from the previous frame to this one (last: the
                                                          ///< tool)
  std::array<Vec3, ArmGeometry::kMostAxes + 1> step;
  std::array<bool, ArmGeometry::kMostAxes> slides{};
  double size = 1;
  /// A faster form, for turning axes that all lie along those of one frame, except for rounding.
  bool square = false, level = false;  ///< level: that frame is the world frame
  Rotation frame;                      ///< from that frame to the world
  std::array<SquareStep, ArmGeometry::kMostAxes> along;
  Vec3 tool_x, tool_y, tool_step;  ///< the tool's axes and position at zero, in that frame
};
LaneArm lane_arm(const ArmGeometry& arm);

/// Limits and weights of the axes of the true arm.
struct LaneLimits {
  std::array<double, ArmGeometry::kMostAxes> lower{}, upper{}, weight{};  ///< weight: of squared distances
};

/// One question to the kernel.
struct BranchJob {
  const SixAxisForm* form = nullptr;
  const LaneArm* arm = nullptr;
  PoseTarget target;
  /// For each axis of the form, the axis of the true arm; -1 if the arm does not have it.
  std::array<int, 6> to_arm{0, 1, 2, 3, 4, 5};
  /// Values of all axes of the true arm: free angles and axes outside the form take them.
  const double* seed = nullptr;
  const LaneLimits* limits = nullptr;
  const double* near = nullptr;  ///< joint values; answers take the nearest whole turn. Set together with
                                 ///< limits
  /// Errors up to this are polished, m and rad; with 0 answers are only checked.
  double worth_polishing = 1e-3;
  bool all_move = false;       ///< a descent moves every axis of the arm, not only those of the form
  int patience = 4;            ///< number of steps after which only small errors are worth more steps
  int most_steps = 30;         ///< of a descent
  double good_enough = 1e-11;  ///< smaller errors are not polished, m and rad
  /// Distance of the true arm from the ideal one of the form, m and rad; 0 disables the stray check.
  double ideal = 0;
};

/// The results, axis after axis, for each branch. Angles are within one turn about zero, or the turn within
/// limits that is nearest to BranchJob::near.
struct Branches {
  alignas(64) double value[ArmGeometry::kMostAxes][kBranches];
  alignas(64) double position_error2[kBranches];     ///< square of metres
  alignas(64) double orientation_error2[kBranches];  ///< square of radians; at most twice the true value
  alignas(64) double distance2[kBranches];           ///< weighted, from BranchJob::near
  std::uint32_t inside = ~0u;                        ///< bit mask of branches within limits
  std::uint32_t free = 0;                            ///< bit mask of branches with a free angle
  /// Bit mask, for a slightly non-ideal arm: branches near which there may be other solutions or none. Set
  /// from the descents that start at the ideal arm's answers, and where the ideal arm has no answer.
  std::uint32_t strayed = 0;
};

/// Selects the turn of a joint: within limits, and nearest to a given value. A window of one turn contains
/// exactly one candidate; its center is the value, clamped to low_center and high_center.
struct JointWindow {
  double low_center = 0, high_center = 0;
  double bias = 0;  ///< in turns: makes rounding at half a turn always choose the same side
  double lower = 0, upper = 0;
  double weight = 1;  ///< of the square of the distance
  double root_weight = 1;
};
JointWindow window_of(double lower, double upper, double weight) noexcept;

/// s * sine + c * cosine = b, with everything but b constant.
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
/// The bend of axis 5 if it is perpendicular to axis 6 and to the hub, to the last digit: the three angles
/// are then Euler angles, and the other bend has the turn and angle 6 half a turn further. Axis 5 at zero is
/// x of the hub's frame.
struct SquareBend {
  bool usable = false;
  double hub_s = 0, hub_c = 1;  ///< for a wrist: the angle from the plane's x to the hub; else to axis 5
  double side_5 = 1;            ///< for a wrist: 1 if axis 5 points along axis 2, -1 if against it
  double six_s = 0, six_c = 1;  ///< of the bend at which axis 6 lies along the hub
  double six_angle = 0;         ///< the same angle, turns
  double least_sine2 = 0;       ///< smaller is nearly singular
};

/// Constants of an arm whose axes 2 and 3 are parallel (planar_form.hpp), made by planar_form().
struct PlanarForm {
  bool usable = false;
  bool wrist = false;     ///< axes 4 to 6 meet; else axis 4 is parallel to 2 and 3, and 5 and 6 meet
  Rotation into_base;     ///< from world axes to a frame whose z is axis 1
  double rise = 0;        ///< x of axis 2 in that frame (its y is zero)
  double rise_along = 0;  ///< z of axis 2 in that frame
  double height = 0;      ///< of the wrist's point along axis 2
  /// Between points of the axes, in a frame whose z is axis 2 and whose x is perpendicular to axes 1 and 2.
  Vec3 p12, p23, p34, p45;
  double side_3 = 1, side_4 = 1;
  PlanarCircle elbow, bend;  ///< of axes 3 and 5
  double elbow_half = 0;     ///< Reach::half, in radii of the elbow
  Rotation into_hub;         ///< from the plane's frame to one whose z is the reference axis of the bend
  TurnedVector six, beside, across;  ///< axis 6 and its perpendiculars, turned about axis 5, in that frame
  double least_length2 = 0, least_sine2 = 0, near_edge = 0;
  bool level = false;    ///< axis 1 is parallel to the world's z
  bool upright = false;  ///< axis 2 is perpendicular to axis 1
  Vec3 beside_in_tool;   ///< perpendicular to axis 6, in the tool frame: the zero direction of angle 6
  SquareBend square;
};

/// Constants of the fast solver, for six turning axes with an exact closed form (takes_quick()).
struct QuickJob {
  SixAxisForm form;                      ///< form_for_quick()
  std::array<JointWindow, 6> window;     ///< of the form's axes
  std::array<std::uint8_t, 6> to_arm{};  ///< for each axis of the form, the axis of the arm
  std::array<std::uint8_t, 6> joint{};   ///< the joint of each axis; answers take the turn nearest its value
                                         ///< in the seed
  PlanarForm planar;                     ///< a faster method, if it is usable
  double most_weight = 1;                ///< largest weight of the windows
};
/// True if the fast solver supports this class: exact, and solved by square roots only.
bool takes_quick(const SixAxisClass& known) noexcept;
/// True if the quick solver's preconditions hold.
bool takes_quick(const QuickJob& job) noexcept;
/// A form that reports every nearly singular pose, so the fast solver need not handle it.
SixAxisForm form_for_quick(const SixAxisClass& known);

/// The eight branches of one pose, or one branch of each of eight poses, checked on the true arm.
struct QuickAnswers {
  alignas(64) double value[6][kBranches];           ///< of the arm's axes
  alignas(64) double position_error[kBranches];     ///< m
  alignas(64) double orientation_error[kBranches];  ///< rad
  alignas(64) double distance[kBranches];           ///< weighted, from the seed
  std::uint32_t good = 0;                           ///< bit mask: exact to kGoodEnough and within limits
};
/// All branches of a pose. False if a branch is nearly singular, or near a solution but not exact: call
/// solve_branches() then.
bool solve_quickly(const QuickJob& job, const LaneArm& arm, const Pose& target, const double* seed,
                   QuickAnswers& out) noexcept;
/// For each pose the branch nearest to the seed (a joint state of the chain), by the same arithmetic. `good`
/// has one bit for each pose (eight to a byte, the lowest first). A pose whose bit is not set has no valid
/// entry in `out`: solve it separately.
void solve_together(const QuickJob& job, const LaneArm& arm, std::span<const Pose> targets,
                    std::span<const double> seed, std::span<IkSolution> out,
                    std::span<std::uint8_t> good) noexcept;
/// The same for up to eight poses.
void solve_eight(const QuickJob& job, const LaneArm& arm, std::span<const Pose> targets, const double* seed,
                 QuickAnswers& out) noexcept;
/// As above, with the instruction set `set`, which the processor must have. For tests and benchmarks.
void solve_eight(InstructionSet set, const QuickJob& job, const LaneArm& arm, std::span<const Pose> targets,
                 const double* seed, QuickAnswers& out) noexcept;

/// Solves, checks on the true arm, and polishes what is not exact. The errors end near rounding, or are those
/// of the nearest state that the family offers.
void solve_branches(const BranchJob& job, Branches& out) noexcept;
/// The same with the portable instructions; results differ in the last digits. For tests.
void solve_branches_portably(const BranchJob& job, Branches& out) noexcept;

/// The largest number of blocks of one search.
inline constexpr std::size_t kSearchBlocks = 40;
/// For families with searched(): takes axis 4 (or 6) at 64 values side by side. For each value the first
/// three axes have up to four ways to reach the point where axes 5 and 6 (or 4 and 5) meet; one descent step
/// follows. Where that step stays near, the descent continues to the end. Returns the number of filled
/// entries of `out`; some branches are duplicates or not exact.
std::size_t search_branches(const BranchJob& job, std::span<Branches> out) noexcept;

/// The distance of eight joint states from a singularity: the direction in joint space (a unit vector) that
/// moves the TCP least, and by how much, lengths in units of LaneArm::size; then the same for the directions
/// perpendicular to it. By inverse iteration, so approximate. For arms of turning axes; of more than six axes
/// only the first six count.
struct LeastMotions {
  alignas(64) double way[6][kBranches], next_way[6][kBranches];
  alignas(64) double least[kBranches], next[kBranches];
};
/// Input: `at.value`. Without `both` the second direction is not computed.
void find_least_motions(const LaneArm& arm, const Branches& at, bool both, LeastMotions& out) noexcept;

/// Checks and polishes given values on the true arm. Input: `out.value`; output: all of `out`.
void polish_branches(const BranchJob& job, Branches& out) noexcept;

}  // namespace polyarm::kinematics
