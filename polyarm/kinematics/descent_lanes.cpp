#include "polyarm/kinematics/descent_lanes.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "polyarm/kinematics/lane_turns.hpp"
#include "polyarm/kinematics/lanes.hpp"

#pragma GCC diagnostic ignored "-Wpsabi"
#pragma GCC diagnostic ignored "-Wpedantic"

namespace polyarm::kinematics {

namespace {

constexpr double kLargestStep = 0.9;  // rad or lengths in one step
constexpr double kDamping = 0.02;     // times the squared error (Chan and Lawrence 1988)
constexpr double kLeastDamping = 1e-10;
constexpr double kHardlyHelped = 0.7;  // of the squared error
constexpr std::size_t kMost = Chain::kMaxJoints;

using Bend = DescentArm::Bend;

POLYARM_INLINE Lane load(const double* from) {
  Lane out;
  __builtin_memcpy(&out, __builtin_assume_aligned(from, 64), sizeof out);
  return out;
}
POLYARM_INLINE void store(Lane value, double* to) {
  __builtin_memcpy(__builtin_assume_aligned(to, 64), &value, sizeof value);
}
POLYARM_INLINE std::uint32_t bits_of(LaneMask mask) {
  std::uint32_t out = 0;
  for (std::size_t i = 0; i < kLanes; ++i) out |= mask[i] ? 1u << i : 0u;
  return out;
}
POLYARM_INLINE Lane most(Lane a, Lane b) {
  return select(below(a, b), b, a);
}
POLYARM_INLINE Lane least(Lane a, Lane b) {
  return select(below(a, b), a, b);
}

struct LaneFrame {
  LaneVec x, y, z, p;
};

POLYARM_INLINE LaneFrame first_frame(const DescentArm& arm) {
  return {splat(arm.first_turn.x), splat(arm.first_turn.y), splat(arm.first_turn.z), splat(arm.first_point)};
}

POLYARM_INLINE LaneVec operator-(const LaneVec& a) {
  return {-a.x, -a.y, -a.z};
}

/// About x.
POLYARM_INLINE void bend(LaneFrame& f, const DescentArm::Axis& axis) {
  const LaneVec y = f.y;
  switch (axis.bend) {
    case Bend::none:
      break;
    case Bend::back:
      f.y = -f.y;
      f.z = -f.z;
      break;
    case Bend::left:
      f.y = f.z;
      f.z = -y;
      break;
    case Bend::right:
      f.y = -f.z;
      f.z = y;
      break;
    case Bend::any: {
      const Lane c = splat(axis.bend_cos), s = splat(axis.bend_sin);
      f.y = c * y + s * f.z;
      f.z = c * f.z - s * y;
      break;
    }
  }
}

POLYARM_INLINE void move(LaneFrame& f, const DescentArm::Axis& axis, Lane value) {
  LaneAngle angle{splat(axis.offset_sin), splat(axis.offset_cos)};
  if (axis.slides)
    f.p = f.p + value * f.z;
  else
    angle = turn_by(value + axis.offset);
  const LaneVec x = angle.c * f.x + angle.s * f.y;
  f.y = angle.c * f.y - angle.s * f.x;
  f.x = x;
  if (axis.step.x != 0) f.p = f.p + splat(axis.step.x) * f.x;
  if (axis.step.y != 0) f.p = f.p + splat(axis.step.y) * f.y;
  if (axis.step.z != 0) f.p = f.p + splat(axis.step.z) * f.z;
}

/// Solves a x = b for a symmetric positive definite matrix given by its lower half (Cholesky's method
/// without roots). Returns the determinant.
POLYARM_INLINE Lane solve_definite(Lane (&a)[6][6], Lane (&b)[6]) {
  Lane inverse[6], determinant = splat(1.0);
#pragma GCC unroll 6
  for (int j = 0; j < 6; ++j) {
    inverse[j] = 1.0 / a[j][j];
    determinant *= a[j][j];
#pragma GCC unroll 6
    for (int i = j + 1; i < 6; ++i) {
      const Lane factor = a[i][j] * inverse[j];
#pragma GCC unroll 6
      for (int k = j + 1; k <= i; ++k) a[i][k] -= factor * a[k][j];
      b[i] -= factor * b[j];
    }
  }
#pragma GCC unroll 6
  for (int i = 5; i >= 0; --i) {
#pragma GCC unroll 6
    for (int k = i + 1; k < 6; ++k) b[i] -= a[k][i] * b[k];
    b[i] *= inverse[i];
  }
  return determinant;
}

struct Sweep {
  LaneFrame end;
  Lane column[kMost][6];
  Lane e[6];
  Lane position2, orientation2;
  Lane size2;  ///< of `e`: what is minimised
};

POLYARM_INLINE void sweep(const DescentArm& arm, const Descents& all, Sweep& out) {
  constexpr std::size_t kKept = 64;
  LaneVec axis[kKept], origin[kKept];
  LaneFrame f = first_frame(arm);
  const std::size_t n = arm.axes.size();
  for (std::size_t i = 0; i < n; ++i) {
    const DescentArm::Axis& a = arm.axes[i];
    bend(f, a);
    axis[i] = f.z;
    origin[i] = f.p;
    move(f, a, a.ratio * load(all.x[a.joint]));
  }
  for (std::size_t i = 0; i < n; ++i) {
    const DescentArm::Axis& a = arm.axes[i];
    LaneVec linear = a.slides ? axis[i] : cross(axis[i], f.p - origin[i]);
    LaneVec angular = a.slides ? LaneVec{Lane{}, Lane{}, Lane{}} : axis[i];
    if (a.ratio != 1) {
      linear = splat(a.ratio) * linear;
      angular = splat(a.ratio) * angular;
    }
    Lane* c = out.column[a.joint];
    if (!a.first_of_joint) {
      linear = linear + LaneVec{c[0], c[1], c[2]};
      angular = angular + LaneVec{c[3], c[4], c[5]};
    }
    c[0] = linear.x, c[1] = linear.y, c[2] = linear.z;
    c[3] = angular.x, c[4] = angular.y, c[5] = angular.z;
  }
  out.end = f;
}

POLYARM_INLINE void find_ends_here(const DescentArm& arm, Descents& all) {
  LaneFrame f = first_frame(arm);
  for (const DescentArm::Axis& axis : arm.axes) {
    bend(f, axis);
    move(f, axis, axis.ratio * load(all.x[axis.joint]));
  }
  int row = 0;
  for (const LaneVec& v : {f.x, f.y, f.z, f.p}) {
    store(v.x, all.target[row++]);
    store(v.y, all.target[row++]);
    store(v.z, all.target[row++]);
  }
}

POLYARM_INLINE LaneVec load_vec(const double (*from)[kDescents]) {
  return {load(from[0]), load(from[1]), load(from[2])};
}

/// The turn from `now` to `then` given as sum of cross products of their columns (twice its sine along its
/// axis) and sum of their dot products; as a vector along the axis of length 2 sin(angle / 2).
POLYARM_INLINE LaneVec turn_vector(const LaneVec& twice_sine, Lane cosine) {
  const Lane above = most(1.0 + cosine, splat(1e-9));
  return (root(0.5 / above)) * twice_sine;
}

/// The same as the true rotation vector, as long as the angle.
POLYARM_INLINE LaneVec rotation_vector(const LaneVec& v) {
  const Lane half2 = least(0.25 * dot(v, v), splat(1.0));
  const Lane half = root(half2);
  const Lane angle = angle_of(half, root(1.0 - half2));
  return select(below(half, splat(1e-9)), splat(1.0), angle / most(half, splat(1e-9))) * v;
}

POLYARM_INLINE void whole_error(const Descents& all, Sweep& s) {
  const LaneVec tx = load_vec(all.target), ty = load_vec(all.target + 3), tz = load_vec(all.target + 6);
  const LaneVec dp = load_vec(all.target + 9) - s.end.p;
  const LaneVec twice = cross(s.end.x, tx) + cross(s.end.y, ty) + cross(s.end.z, tz);
  const Lane cosine = 0.5 * (dot(s.end.x, tx) + dot(s.end.y, ty) + dot(s.end.z, tz) - 1.0);
  const LaneVec dr = turn_vector(twice, cosine);
  s.e[0] = dp.x, s.e[1] = dp.y, s.e[2] = dp.z;
  s.e[3] = dr.x, s.e[4] = dr.y, s.e[5] = dr.z;
  s.position2 = dot(dp, dp);
  s.orientation2 = dot(dr, dr);
  s.size2 = s.position2 + s.orientation2;
}

struct LaneAxes {
  LaneVec x, y, z;
};
POLYARM_INLINE LaneVec along(const LaneAxes& f, const LaneVec& v) {
  return {dot(f.x, v), dot(f.y, v), dot(f.z, v)};
}
POLYARM_INLINE LaneVec combined(const LaneAxes& f, const Vec3& v) {
  return splat(v.x) * f.x + splat(v.y) * f.y + splat(v.z) * f.z;
}
POLYARM_INLINE Vec3 column_of(const Rotation& r, int i) {
  return i == 0 ? r.x : i == 1 ? r.y : r.z;
}

/// Errors and columns in the task's frame, what is free or within its box left out.
POLYARM_INLINE void task_error(const DescentArm& arm, const DescentTask& task, const Descents& all,
                               Sweep& s) {
  whole_error(all, s);
  const LaneAxes target{load_vec(all.target), load_vec(all.target + 3), load_vec(all.target + 6)};
  LaneAxes frame{splat(Vec3{1, 0, 0}), splat(Vec3{0, 1, 0}), splat(Vec3{0, 0, 1})};
  if (task.of_tool)
    frame = {combined(target, arm.last_turn.x), combined(target, arm.last_turn.y),
             combined(target, arm.last_turn.z)};
  LaneVec dp{s.e[0], s.e[1], s.e[2]}, dr{s.e[3], s.e[4], s.e[5]};
  if (task.spin >= 0) {
    const Vec3 free = column_of(arm.last_turn, task.spin);
    const LaneVec now = combined({s.end.x, s.end.y, s.end.z}, free), then = combined(target, free);
    dr = turn_vector(splat(2.0) * cross(now, then), dot(now, then));
  } else {
    dr = rotation_vector(dr);
  }
  dp = along(frame, dp);
  dr = along(frame, dr);
  Lane e[6] = {dp.x, dp.y, dp.z, dr.x, dr.y, dr.z}, weight[6];
  for (int i = 0; i < 6; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const Lane over = e[i] + task.low[at], under = e[i] + task.high[at];
    const Lane rest = most(over, Lane{}) + least(under, Lane{});
    // Deviations are the current pose minus the target, errors the other way round.
    weight[i] = select(below(Lane{}, magnitude(rest)), splat(task.weight[at]), Lane{});
    if (task.low[at] == 0 && task.high[at] == 0) weight[i] = splat(task.weight[at]);
    e[i] = rest;
  }
  s.position2 = e[0] * e[0] + e[1] * e[1] + e[2] * e[2];
  s.orientation2 = e[3] * e[3] + e[4] * e[4] + e[5] * e[5];
  s.size2 = Lane{};
  for (int i = 0; i < 6; ++i) {
    s.e[i] = weight[i] * e[i];
    s.size2 += s.e[i] * s.e[i];
  }
  for (std::size_t k = 0; k < arm.joints; ++k) {
    Lane* c = s.column[k];
    const LaneVec linear = along(frame, {c[0], c[1], c[2]}), angular = along(frame, {c[3], c[4], c[5]});
    c[0] = weight[0] * linear.x, c[1] = weight[1] * linear.y, c[2] = weight[2] * linear.z;
    c[3] = weight[3] * angular.x, c[4] = weight[4] * angular.y, c[5] = weight[5] * angular.z;
  }
}

POLYARM_INLINE void add_square(Lane (&a)[6][6], const Lane* c) {
#pragma GCC unroll 6
  for (int i = 0; i < 6; ++i)
#pragma GCC unroll 6
    for (int j = 0; j <= i; ++j) a[i][j] += c[i] * c[j];
}

/// Takes joints that stand at a limit and are drawn beyond it out of the step.
POLYARM_INLINE void pin(const DescentArm& arm, const Descents& all, Sweep& s) {
  for (std::size_t k = 0; k < arm.joints; ++k) {
    if (arm.lower[k] < -1e8 && arm.upper[k] > 1e8) continue;
    Lane* c = s.column[k];
    Lane drawn{};
#pragma GCC unroll 6
    for (int i = 0; i < 6; ++i) drawn += c[i] * s.e[i];
    const Lane x = load(all.x[k]);
    const LaneMask at_upper = ~below(x, splat(arm.upper[k])) & below(Lane{}, drawn);
    const LaneMask at_lower = ~below(splat(arm.lower[k]), x) & below(drawn, Lane{});
    const LaneMask stays = at_upper | at_lower;
#pragma GCC unroll 6
    for (int i = 0; i < 6; ++i) c[i] = (Lane)((LaneMask)c[i] & ~stays);
  }
}

POLYARM_INLINE void step(const DescentArm& arm, const DescentRules& rules, Descents& all, Sweep& s) {
  if (rules.walls) pin(arm, all, s);
  Lane a[6][6];
  const Lane damping = kDamping * s.size2 + kLeastDamping;
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j <= i; ++j) a[i][j] = i == j ? damping : Lane{};
  for (std::size_t k = 0; k < arm.joints; ++k) add_square(a, s.column[k]);
  Lane b[6];
  for (int i = 0; i < 6; ++i) b[i] = s.e[i];
  if (rules.pulled)
    for (std::size_t k = 0; k < arm.joints; ++k)
      for (int i = 0; i < 6; ++i) b[i] -= s.column[k][i] * load(all.pull[k]);
  store(solve_definite(a, b), all.spread);
  Lane d[kMost], largest = splat(kLargestStep);
  for (std::size_t k = 0; k < arm.joints; ++k) {
    Lane sum{};
#pragma GCC unroll 6
    for (int i = 0; i < 6; ++i) sum += s.column[k][i] * b[i];
    if (rules.pulled) sum += load(all.pull[k]);
    d[k] = sum;
    largest = most(largest, magnitude(sum));
  }
  const Lane scale = kLargestStep / largest;
  for (std::size_t k = 0; k < arm.joints; ++k) {
    Lane x = load(all.x[k]) + scale * d[k];
    if (rules.walls) x = most(least(x, splat(arm.upper[k])), splat(arm.lower[k]));
    store(x, all.x[k]);
  }
}

template <bool kTask>
POLYARM_INLINE void evaluate(const DescentArm& arm, const DescentTask* task, Descents& all, Sweep& s) {
  sweep(arm, all, s);
  if constexpr (kTask)
    task_error(arm, *task, all, s);
  else
    whole_error(all, s);
  store(s.position2, all.position2);
  store(s.orientation2, all.orientation2);
}

template <bool kTask>
POLYARM_INLINE int descend_here(const DescentArm& arm, const DescentRules& rules, const DescentTask* task,
                                Descents& all) {
  Sweep s;
  for (int i = 0;; ++i) {
    evaluate<kTask>(arm, task, all, s);
    const Lane best = load(all.least);
    // The first errors are those that the last call ended with, or of a new start.
    const LaneMask helped = below(s.size2, kHardlyHelped * best);
    const Lane stuck = select(helped, Lane{}, load(all.stuck) + (i == 0 ? 0.0 : 1.0));
    store(stuck, all.stuck);
    store(least(best, s.size2), all.least);
    // Rounding may leave an error at zero; below() is strict.
    const LaneMask done =
        ~below(splat(rules.position2), s.position2) & ~below(splat(rules.orientation2), s.orientation2);
    const LaneMask weary = ~below(stuck, splat(rules.patience));
    all.converged = bits_of(done);
    all.stale = bits_of(weary);
    if (all.converged | all.stale) return i;
    if (i == rules.steps) return i;
    step(arm, rules, all, s);
  }
}

template <bool kTask>
POLYARM_INLINE void measure_here(const DescentArm& arm, const DescentTask* task, Descents& all) {
  Sweep s;
  evaluate<kTask>(arm, task, all, s);
  Lane a[6][6], b[6]{};
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j <= i; ++j) a[i][j] = i == j ? splat(kLeastDamping) : Lane{};
  for (std::size_t k = 0; k < arm.joints; ++k) add_square(a, s.column[k]);
  store(solve_definite(a, b), all.spread);
}

typedef float Floats __attribute__((vector_size(64)));
typedef std::int32_t FloatMask __attribute__((vector_size(64)));

POLYARM_INLINE Floats pick(FloatMask where, Floats yes, Floats no) {
  return (Floats)((where & (FloatMask)yes) | (~where & (FloatMask)no));
}

template <std::size_t kUsed>
POLYARM_INLINE void find_near_in(const FeatureTable& table, const float* at, const float* beyond,
                                 NearPoints& out) {
  Floats nearest = Floats{} + 1e30f, border, wanted[kUsed];
  __builtin_memcpy(&border, beyond, sizeof border);
#pragma GCC unroll 9
  for (std::size_t f = 0; f < kUsed; ++f) wanted[f] = Floats{} + at[f];
  FloatMask index{};
  const float* row = table.rows.data();
  for (std::size_t i = 0; i < table.count; i += kNearGroups, row += kNearGroups) {
    Floats sum{};
#pragma GCC unroll 9
    for (std::size_t f = 0; f < kUsed; ++f) {
      Floats v;
      __builtin_memcpy(&v, row + f * table.count, sizeof v);
      v -= wanted[f];
      sum += v * v;
    }
    const FloatMask better = ((FloatMask)(sum - nearest) >> 31) & ((FloatMask)(border - sum) >> 31);
    nearest = pick(better, sum, nearest);
    index = (better & static_cast<std::int32_t>(i)) | (~better & index);
  }
  __builtin_memcpy(out.distance2, &nearest, sizeof nearest);
  __builtin_memcpy(out.index, &index, sizeof index);
  for (std::size_t k = 0; k < kNearGroups; ++k) out.index[k] += static_cast<std::int32_t>(k);
}

POLYARM_INLINE void find_near_here(const FeatureTable& table, const float* at, const float* beyond,
                                   NearPoints& out) {
  switch (table.used) {
    case 5:
      return find_near_in<5>(table, at, beyond, out);
    case 6:
      return find_near_in<6>(table, at, beyond, out);
    case 8:
      return find_near_in<8>(table, at, beyond, out);
    default:
      return find_near_in<9>(table, at, beyond, out);
  }
}

// ---- one for each kind of processor ---------------------------------------------------------------------

struct Kernels {
  int (*whole)(const DescentArm&, const DescentRules&, const DescentTask*, Descents&);
  int (*task)(const DescentArm&, const DescentRules&, const DescentTask*, Descents&);
  void (*measure)(const DescentArm&, Descents&);
  void (*measure_task)(const DescentArm&, const DescentTask*, Descents&);
  void (*ends)(const DescentArm&, Descents&);
  void (*near)(const FeatureTable&, const float*, const float*, NearPoints&);
};

#define POLYARM_KERNELS(suffix, attributes)                                                                \
  attributes int whole_##suffix(const DescentArm& arm, const DescentRules& rules, const DescentTask* task, \
                                Descents& all) {                                                           \
    return descend_here<false>(arm, rules, task, all);                                                     \
  }                                                                                                        \
  attributes int task_##suffix(const DescentArm& arm, const DescentRules& rules, const DescentTask* task,  \
                               Descents& all) {                                                            \
    return descend_here<true>(arm, rules, task, all);                                                      \
  }                                                                                                        \
  attributes void measure_##suffix(const DescentArm& arm, Descents& all) {                                 \
    measure_here<false>(arm, nullptr, all);                                                                \
  }                                                                                                        \
  attributes void measure_task_##suffix(const DescentArm& arm, const DescentTask* task, Descents& all) {   \
    measure_here<true>(arm, task, all);                                                                    \
  }                                                                                                        \
  attributes void ends_##suffix(const DescentArm& arm, Descents& all) {                                    \
    find_ends_here(arm, all);                                                                              \
  }                                                                                                        \
  attributes void near_##suffix(const FeatureTable& table, const float* at, const float* beyond,           \
                                NearPoints& out) {                                                         \
    find_near_here(table, at, beyond, out);                                                                \
  }                                                                                                        \
  constexpr Kernels kKernels_##suffix{whole_##suffix,        task_##suffix, measure_##suffix,              \
                                      measure_task_##suffix, ends_##suffix, near_##suffix};

POLYARM_KERNELS(anywhere, )
#if defined(__x86_64__)
POLYARM_KERNELS(avx512, __attribute__((target("avx512f,avx512dq,avx512vl,avx2,fma"))))
#endif

// Not for AVX2: eight lanes are two of its registers, and what the compiler makes of that takes half as long
// again as pairs of numbers do (1.7 against 1.2 us for a step of six joints).
Kernels kernels_here() {
#if defined(__x86_64__)
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl")) return kKernels_avx512;
#endif
  return kKernels_anywhere;
}

const Kernels kKernels = kernels_here();

}  // namespace

int descend(const DescentArm& arm, const DescentRules& rules, const DescentTask* task,
            Descents& all) noexcept {
  return task ? kKernels.task(arm, rules, task, all) : kKernels.whole(arm, rules, task, all);
}

int descend_portably(const DescentArm& arm, const DescentRules& rules, const DescentTask* task,
                     Descents& all) noexcept {
  return task ? task_anywhere(arm, rules, task, all) : whole_anywhere(arm, rules, task, all);
}

void find_ends(const DescentArm& arm, Descents& all) noexcept {
  kKernels.ends(arm, all);
}

void measure(const DescentArm& arm, const DescentTask* task, Descents& all) noexcept {
  if (task)
    kKernels.measure_task(arm, task, all);
  else
    kKernels.measure(arm, all);
}

void find_near(const FeatureTable& table, const float* at, const float* beyond, NearPoints& out) noexcept {
  kKernels.near(table, at, beyond, out);
}

}  // namespace polyarm::kinematics
