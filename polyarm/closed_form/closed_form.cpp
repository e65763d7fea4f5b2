#include "polyarm/closed_form/closed_form.hpp"

#include <algorithm>
#include <cmath>

#include "polyarm/closed_form/branch_kernels.hpp"

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

const BranchKernels& kernels_for(InstructionSet set) {
#if defined(__x86_64__)
  switch (set) {
    case InstructionSet::avx512:
      return lanes_avx512::kBranchKernels;
    case InstructionSet::avx2:
      return lanes_avx2::kBranchKernels;
    case InstructionSet::portable:
      break;
  }
#endif
  return lanes_portable::kBranchKernels;
}

const BranchKernels& kKernels = kernels_for(wanted_instructions());

}  // namespace

namespace {

/// The nearest points of two axes that are not parallel.
void nearest_points(const JointAxis& a, const JointAxis& b, Vec3& on_a, Vec3& on_b) {
  const Vec3 n = cross(a.direction, b.direction), way = b.point - a.point;
  const double scale = 1 / dot(n, n);
  on_a = a.point + (scale * dot(way, cross(b.direction, n))) * a.direction;
  on_b = b.point + (scale * dot(way, cross(a.direction, n))) * b.direction;
}

/// The first three axes of an ideal arm as a Shoulder.
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

/// Uses the shoulder's point of axis 1 for the form.
void take_points(SixAxisForm& f, const ArmGeometry& arm) {
  f.first = f.shoulder.first;
  f.p34 = arm.axes[3].point - arm.axes[2].point;
}

/// The constants that parallel axes 2 to 4 do not change: heights along them.
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

namespace {

/// p turns about k; q is fixed.
Reach reach_of(const Vec3& p, const Vec3& q, const Vec3& k, double least) {
  Reach out;
  const double qk = dot(q, k), pk = dot(p, k);
  out.s = dot(q, cross(k, p));
  out.c = dot(q, p) - qk * pk;
  out.radius = std::hypot(out.s, out.c);
  out.half = 0.5 * (dot(p, p) + dot(q, q)) - qk * pk;
  out.least = least;
  return out;
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
  f.least_sine = wary ? 3e-5 + 30 * deviation : 1e-10;
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
    case ArmFamily::search_4_meets_5:
      f.shoulder = shoulder_of(arm, f.least_length);
      take_points(f, arm);
      f.to_56 = center - point(4);
      f.to_45 = point(4) - center;
      f.beside_5 = beside(f.h[4]);
      f.edge = 0;  // samples on either side keep solutions apart well enough
      break;
    default:
      break;
  }
  f.edge_slope = std::sqrt(f.edge / (1 - f.edge));
  f.near_edge = f.edge;
  f.elbow = reach_of(f.p34, -f.p23, f.h[2], f.least_length * norm(f.p23));
  f.axis_in_tool = f.from_tool_rotation * f.h[5];
  f.beside_in_tool = f.from_tool_rotation * f.beside_6;
  f.tool_rotation = arm.tool_rotation;
  f.square_wrist = std::abs(dot(f.h[3], f.h[4])) < 1e-15 && std::abs(dot(f.h[4], f.h[5])) < 1e-15;
  f.bend_s = dot(f.h[3], cross(f.h[4], f.h[5]));
  f.bend_c = dot(f.h[3], f.h[5]);
  return f;
}

bool takes_quick(const SixAxisClass& known) noexcept {
  return known.exact() && known.family != ArmFamily::none && !searched(known.family) &&
         known.family != ArmFamily::wrist && known.family != ArmFamily::parallel_234;
}

bool takes_quick(const QuickJob& job) noexcept {
  const ArmFamily family = job.form.family;
  const bool planar = family == ArmFamily::wrist_2_parallel_3 || family == ArmFamily::parallel_234_5_meets_6;
  return family != ArmFamily::none && (job.planar.usable || !planar);
}

SixAxisForm form_for_quick(const SixAxisClass& known) {
  SixAxisForm f = form_of(known, true);
  f.wary = true;
  // Above this, angles are known to 1e-13 in any order of summation.
  f.near_edge = 1e-6;
  f.least_sine = 1e-3;
  f.least_length = f.least_sine * known.ideal.size();
  return f;
}

JointWindow window_of(double lower, double upper, double weight) noexcept {
  constexpr double kHalf = 3.14159265358979324, kMargin = 1e-8;
  if (upper - lower < 2 * (kHalf + kMargin)) {
    const double middle = 0.5 * (lower + upper);
    return {middle, middle, 0, lower, upper, weight, std::sqrt(weight)};
  }
  return {lower + kHalf + kMargin, upper - kHalf - kMargin, 1e-9, lower, upper, weight, std::sqrt(weight)};
}

namespace {

/// Removes components that are only rounding errors of zero.
Vec3 without_noise(Vec3 v) {
  constexpr double kNothing = 5e-15;  // m, and of directions
  for (double* c : {&v.x, &v.y, &v.z})
    if (std::abs(*c) < kNothing) *c = 0;
  return v;
}

/// Fills in the faster form if all axes lie along those of `frame` (which maps to the world).
bool go_square(const ArmGeometry& arm, const Rotation& frame, LaneArm& out) {
  const Rotation back = transposed(frame);
  Vec3 at;
  for (std::size_t i = 0; i < arm.count; ++i) {
    const JointAxis& axis = arm.axes[i];
    const Vec3 h = without_noise(back * axis.direction);
    if (axis.slides || (h.x != 0) + (h.y != 0) + (h.z != 0) != 1) return false;
    // Any point of the axis is valid; the one level with the previous point gives an offset of zero.
    const Vec3 point = axis.point - dot(axis.point - at, axis.direction) * axis.direction;
    const Vec3 step = without_noise(back * (point - at));
    out.along[i] = {static_cast<std::uint8_t>(h.x != 0   ? 0
                                              : h.y != 0 ? 1
                                                         : 2),
                    h.x + h.y + h.z < 0, step != Vec3{}, step};
    at = point;
  }
  out.frame = frame;
  out.tool_x = without_noise(back * arm.tool_rotation.x);
  out.tool_y = without_noise(back * arm.tool_rotation.y);
  out.tool_step = without_noise(back * (arm.tool_position - at));
  return true;
}

/// Tries the world's axes, and those of axis 1 and the first axis perpendicular to it.
void find_square(const ArmGeometry& arm, LaneArm& out) {
  out.square = out.level = go_square(arm, {}, out);
  for (std::size_t i = 1; i < arm.count && !out.square; ++i) {
    const Vec3 &z = arm.axes[0].direction, &h = arm.axes[i].direction;
    if (std::abs(dot(z, h)) > 1e-9) continue;
    const Vec3 x = normalized(h - dot(z, h) * z);
    out.square = go_square(arm, {x, cross(z, x), z}, out);
  }
}

}  // namespace

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
  find_square(arm, out);
  return out;
}

void solve_branches(const BranchJob& job, Branches& out) noexcept {
  kKernels.solve(job, out);
}

void solve_branches_portably(const BranchJob& job, Branches& out) noexcept {
  lanes_portable::kBranchKernels.solve(job, out);
}

bool solve_quickly(const QuickJob& job, const LaneArm& arm, const Pose& target, const double* seed,
                   QuickAnswers& out) noexcept {
  return kKernels.quick(job, arm, target, seed, out);
}

void solve_together(const QuickJob& job, const LaneArm& arm, std::span<const Pose> targets,
                    std::span<const double> seed, std::span<IkSolution> out,
                    std::span<std::uint8_t> good) noexcept {
  kKernels.batch(job, arm, targets, seed, out.data(), good.data());
}

void solve_eight(const QuickJob& job, const LaneArm& arm, std::span<const Pose> targets, const double* seed,
                 QuickAnswers& out) noexcept {
  kKernels.nearest(job, arm, targets, seed, out);
}

void solve_eight(InstructionSet set, const QuickJob& job, const LaneArm& arm, std::span<const Pose> targets,
                 const double* seed, QuickAnswers& out) noexcept {
  kernels_for(set).nearest(job, arm, targets, seed, out);
}

std::size_t search_branches(const BranchJob& job, std::span<Branches> out) noexcept {
  return kKernels.search(job, out.data(), out.size());
}

void find_least_motions(const LaneArm& arm, const Branches& at, bool both, LeastMotions& out) noexcept {
  kKernels.motions(arm, at, both, out);
}

void polish_branches(const BranchJob& job, Branches& out) noexcept {
  kKernels.polish(job, out);
}

}  // namespace polyarm::kinematics
