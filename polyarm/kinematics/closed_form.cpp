#include "polyarm/kinematics/closed_form.hpp"

#include <algorithm>
#include <cmath>

#include "polyarm/kinematics/families.hpp"
#include "polyarm/kinematics/lane_polish.hpp"

#pragma GCC diagnostic ignored "-Wpsabi"

namespace polyarm::kinematics {

namespace {

Vec3 beside(const Vec3& h) {
  const double x = std::abs(h.x), y = std::abs(h.y), z = std::abs(h.z);
  const Vec3 least = x <= y && x <= z ? Vec3{1, 0, 0} : y <= z ? Vec3{0, 1, 0} : Vec3{0, 0, 1};
  return normalized(cross(h, least));
}

/// A frame whose z is the axis.
Rotation frame_of(const Vec3& h) {
  const Vec3 x = beside(h);
  return {x, cross(h, x), h};
}

POLYARM_INLINE void solve(const BranchJob& job, Branches& out) {
  const SixAxisForm& form = *job.form;
  PoseTarget target = job.target;
  if (form.from_tool) {
    target.rotation = transposed(target.rotation);
    target.position = -(target.rotation * target.position);
  }
  LaneAngle q[kMost];
  bool moves[kMost]{};
  LaneAngle offered[6];
  SixAngles six;
  for (LaneAngle& angle : offered) angle = {splat(0.0), splat(1.0)};
  solve_family(form, target, offered, six);
  out.free = bits_of(six.free);
  if (out.free != 0 && job.seed) {
    for (std::size_t k = 0; k < 6; ++k) {
      const double at = job.to_arm[k] < 0 ? 0.0 : job.seed[job.to_arm[k]] + job.beside_seed;
      offered[k] = {splat(__builtin_sin(at)), splat(__builtin_cos(at))};
    }
    solve_family(form, target, offered, six);
  }
  if (job.arm->count > 6)
    for (std::size_t i = 0; i < job.arm->count; ++i) q[i] = angle_at(*job.arm, i, job.seed[i]);
  for (std::size_t k = 0; k < 6; ++k) {
    if (job.to_arm[k] < 0) continue;
    q[job.to_arm[k]] = six.q[k];
    moves[job.to_arm[k]] = true;
  }
  check_and_polish(job, q, moves, out);
  write_values(job, q, out);
}

POLYARM_INLINE void polish(const BranchJob& job, Branches& out) {
  LaneAngle q[kMost];
  bool moves[kMost]{};
  for (const int axis : job.to_arm)
    if (axis >= 0) moves[axis] = true;
  if (job.all_move) std::fill(moves, moves + job.arm->count, true);
  for (std::size_t i = 0; i < job.arm->count; ++i) {
    Lane s, c;
    for (std::size_t k = 0; k < kLanes; ++k) {
      if (job.arm->slides[i]) {
        s[k] = out.value[i][k];
        c[k] = 1;
        continue;
      }
      s[k] = __builtin_sin(out.value[i][k]);
      c[k] = __builtin_cos(out.value[i][k]);
    }
    q[i] = {s, c};
  }
  check_and_polish(job, q, moves, out);
  write_values(job, q, out);
}

// ---- one for each kind of processor ---------------------------------------------------------------------

using Kernel = void (*)(const BranchJob&, Branches&);
struct Kernels {
  Kernel solve, polish;
};

void solve_anywhere(const BranchJob& job, Branches& out) {
  solve(job, out);
}
void polish_anywhere(const BranchJob& job, Branches& out) {
  polish(job, out);
}
#if defined(__x86_64__)
__attribute__((target("avx2,fma"))) void solve_avx2(const BranchJob& job, Branches& out) {
  solve(job, out);
}
__attribute__((target("avx2,fma"))) void polish_avx2(const BranchJob& job, Branches& out) {
  polish(job, out);
}
__attribute__((target("avx512f,avx512dq,avx512vl,avx2,fma"))) void solve_avx512(const BranchJob& job,
                                                                                Branches& out) {
  solve(job, out);
}
__attribute__((target("avx512f,avx512dq,avx512vl,avx2,fma"))) void polish_avx512(const BranchJob& job,
                                                                                 Branches& out) {
  polish(job, out);
}
#endif

Kernels kernels_here() {
#if defined(__x86_64__)
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl"))
    return {solve_avx512, polish_avx512};
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return {solve_avx2, polish_avx2};
#endif
  return {solve_anywhere, polish_anywhere};
}

const Kernels kKernels = kernels_here();

}  // namespace

namespace {

/// Points of two axes that are not parallel where they are nearest to each other.
void nearest_points(const JointAxis& a, const JointAxis& b, Vec3& on_a, Vec3& on_b) {
  const Vec3 n = cross(a.direction, b.direction), way = b.point - a.point;
  const double scale = 1 / dot(n, n);
  on_a = a.point + (scale * dot(way, cross(b.direction, n))) * a.direction;
  on_b = b.point + (scale * dot(way, cross(a.direction, n))) * b.direction;
}

/// The first three axes of an ideal arm as what puts a point somewhere.
Shoulder shoulder_of(const ArmGeometry& arm, double least_length) {
  Shoulder s;
  const JointAxis &one = arm.axes[0], &two = arm.axes[1], &three = arm.axes[2];
  s.h1 = one.direction;
  s.h2 = two.direction;
  s.h3 = three.direction;
  s.cosine = dot(s.h1, s.h2);
  s.least_length = least_length;
  Vec3 on_1 = one.point, on_2 = two.point;
  const Vec3 square = cross(s.h1, s.h2);
  if (norm(square) < 1e-9) {
    s.kind = Shoulder::Kind::parallel;
    const Vec3 way = two.point - one.point;
    on_2 = two.point - dot(way, s.h1) * s.h1;
    s.p12 = on_2 - on_1;
    s.distance = norm(s.p12);
    s.e1 = normalized(s.p12);
  } else {
    nearest_points(one, two, on_1, on_2);
    s.e1 = normalized(square);
    s.distance = dot(s.e1, on_2 - on_1);
    if (std::abs(s.distance) < 1e-9 * arm.size()) s.kind = Shoulder::Kind::meets, s.distance = 0;
    s.p12 = s.distance * s.e1;
  }
  s.e2 = cross(s.h2, s.e1);
  s.sine = dot(s.h1, s.e2);
  s.first = on_1;
  s.p23 = three.point - on_2;
  return s;
}

/// The shoulder's point of axis 1 for the form's.
void take_points(SixAxisForm& f, const ArmGeometry& arm) {
  f.first = f.shoulder.first;
  f.p34 = arm.axes[3].point - arm.axes[2].point;
}

/// What parallel axes 2 to 4 leave alone: heights along them.
void tie_5_to_1(SixAxisForm& f, const ArmGeometry& arm) {
  Vec3 on_5, on_6;
  nearest_points(arm.axes[4], arm.axes[5], on_5, on_6);
  f.center_in_tool = transposed(arm.tool_rotation) * (on_6 - arm.tool_position);
  f.p45 = on_5 - arm.axes[3].point;
  f.p56 = on_6 - on_5;
  f.height = dot(f.h[1], on_5 - f.first);
  const auto row = [&](const Vec3& v, double& c, double& s) {
    c = dot(f.h[1], v - dot(f.h[4], v) * f.h[4]);
    s = dot(f.h[1], cross(f.h[4], v));
  };
  double c1, s1, c2, s2;
  row(f.p56, c1, s1);
  row(f.h[5], c2, s2);
  const double inverse = 1 / (c1 * s2 - s1 * c2);
  f.from_5[0] = s2 * inverse;
  f.from_5[1] = -s1 * inverse;
  f.from_5[2] = -c2 * inverse;
  f.from_5[3] = c1 * inverse;
}

}  // namespace

SixAxisForm form_of(const SixAxisClass& known, bool wary) {
  SixAxisForm f;
  const ArmGeometry& arm = known.ideal;
  const auto point = [&](std::size_t k) { return arm.axes[k - 1].point; };
  f.family = known.family;
  f.from_tool = known.from_tool;
  for (std::size_t k = 0; k < 6; ++k) f.h[k] = arm.axes[k].direction;
  f.first = point(1);
  f.p12 = point(2) - point(1);
  f.p23 = point(3) - point(2);
  f.p34 = point(4) - point(3);
  f.p45 = point(5) - point(4);
  const Vec3 center = point(6);
  f.center_in_tool = transposed(arm.tool_rotation) * (center - arm.tool_position);
  f.from_tool_rotation = transposed(arm.tool_rotation);
  f.beside_6 = beside(f.h[5]);
  f.beside_1 = beside(f.h[0]);
  const double deviation = std::max(known.worst_gap / arm.size(), known.worst_angle);
  f.least_sine = wary ? 1e-7 + 30 * deviation : 1e-10;
  f.least_length = f.least_sine * arm.size();
  f.edge = known.exact() ? 0.0 : std::min(0.1, 1e-6 + (wary ? 100 : 4) * deviation);
  f.wary = wary && !known.exact();
  const auto flattened = [](const Vec3& v, const Vec3& h) { return v - dot(h, v) * h; };
  const auto side = [&](std::size_t a, std::size_t b) {
    return dot(f.h[a - 1], f.h[b - 1]) < 0 ? -1.0 : 1.0;
  };
  switch (f.family) {
    case ArmFamily::wrist_2_parallel_3:
      f.height = dot(f.h[1], center - f.first);
      f.side_3 = side(2, 3);
      f.p23 = flattened(f.p23, f.h[1]);
      f.p34 = flattened(f.p34, f.h[1]);
      break;
    case ArmFamily::wrist_1_parallel_2:
      f.height = dot(f.h[0], f.p12 + f.p23);
      break;
    case ArmFamily::parallel_234_5_meets_6:
      f.height = dot(f.h[1], center - f.first);
      f.side_3 = side(2, 3);
      f.side_4 = side(2, 4);
      f.p23 = flattened(f.p23, f.h[1]);
      f.p34 = flattened(f.p34, f.h[1]);
      break;
    case ArmFamily::parallel_123_5_meets_6:
      f.height = dot(f.h[0], f.p12 + f.p23 + f.p34);
      f.side_3 = side(1, 2);
      f.side_4 = side(1, 3);
      break;
    case ArmFamily::wrist:
      f.shoulder = shoulder_of(arm, f.least_length);
      take_points(f, arm);
      break;
    case ArmFamily::parallel_234:
      tie_5_to_1(f, arm);
      f.side_3 = side(2, 3);
      f.side_4 = side(2, 4);
      f.p23 = flattened(f.p23, f.h[1]);
      f.p34 = flattened(f.p34, f.h[1]);
      break;
    case ArmFamily::search_5_meets_6:
      f.shoulder = shoulder_of(arm, f.least_length);
      take_points(f, arm);
      f.to_56 = center - point(4);
      break;
    default:
      break;
  }
  return f;
}

LaneArm lane_arm(const ArmGeometry& arm) {
  LaneArm out;
  for (std::size_t i = 0; i < arm.count; ++i) out.slides[i] = arm.axes[i].slides;
  out.count = arm.count;
  out.size = arm.size();
  Rotation frame;
  Vec3 at;
  for (std::size_t i = 0; i <= arm.count; ++i) {
    const Rotation next = i < arm.count ? frame_of(arm.axes[i].direction) : arm.tool_rotation;
    const Vec3 point = i < arm.count ? arm.axes[i].point : arm.tool_position;
    out.turn[i] = transposed(frame) * next;
    out.step[i] = transposed(frame) * (point - at);
    frame = next;
    at = point;
  }
  return out;
}

void solve_branches(const BranchJob& job, Branches& out) noexcept {
  kKernels.solve(job, out);
}

void solve_branches_portably(const BranchJob& job, Branches& out) noexcept {
  solve_anywhere(job, out);
}

void polish_branches(const BranchJob& job, Branches& out) noexcept {
  kKernels.polish(job, out);
}

}  // namespace polyarm::kinematics
