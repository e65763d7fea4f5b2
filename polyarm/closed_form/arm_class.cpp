#include "polyarm/closed_form/arm_class.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "polyarm/kinematics/arm_length.hpp"

namespace polyarm::kinematics {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Axes nearer to parallel than this neither meet nor form a wrist, rad.
constexpr double kLeastAngle = 0.02;
/// For axes that need not meet but simplify the solution if they do: in units of the arm's size.
constexpr double kMeetsForSure = 1e-7;

double sine_between(const JointAxis& a, const JointAxis& b) {
  return norm(cross(a.direction, b.direction));
}

double distance_to(const JointAxis& axis, const Vec3& point) {
  return norm(cross(point - axis.point, axis.direction));
}

/// The point nearest to several axes (least squares: the sum of I - h h^T, Cramer's rule).
Vec3 nearest_point(std::initializer_list<const JointAxis*> axes) {
  Vec3 rows[3]{}, right{};
  for (const JointAxis* axis : axes) {
    const Vec3& h = axis->direction;
    const Vec3 foot = axis->point - dot(h, axis->point) * h;
    rows[0] = rows[0] + Vec3{1 - h.x * h.x, -h.x * h.y, -h.x * h.z};
    rows[1] = rows[1] + Vec3{-h.y * h.x, 1 - h.y * h.y, -h.y * h.z};
    rows[2] = rows[2] + Vec3{-h.z * h.x, -h.z * h.y, 1 - h.z * h.z};
    right = right + foot;
  }
  const double det = dot(rows[0], cross(rows[1], rows[2]));
  return (1 / det) * (right.x * cross(rows[1], rows[2]) + right.y * cross(rows[2], rows[0]) +
                      right.z * cross(rows[0], rows[1]));
}

/// The largest distance of these axes from their common point; infinite if neighbours are parallel.
double gap(std::initializer_list<const JointAxis*> axes) {
  for (auto axis = axes.begin(); axis + 1 != axes.end(); ++axis)
    if (sine_between(**axis, **(axis + 1)) < kLeastAngle) return kInfinity;
  const Vec3 point = nearest_point(axes);
  double worst = 0;
  for (const JointAxis* axis : axes) worst = std::max(worst, distance_to(*axis, point));
  return worst;
}

/// One attempt to find a family in an arm. Queries note how far off the arm is; corrections idealise it. Axes
/// are numbered from 1.
class Look {
 public:
  /// `length` is length_between_axes() of the arm.
  Look(const ArmGeometry& arm, double tolerance, double length)
      : arm_(arm), angle_(tolerance), length_(tolerance * length) {}

  bool meet(int a, int b) const { return gap({&axis(a), &axis(b)}) <= length_; }
  bool meet(int a, int b, int c) const { return gap({&axis(a), &axis(b), &axis(c)}) <= length_; }
  bool parallel(int a, int b) const { return sine_between(axis(a), axis(b)) <= angle_; }
  bool slanted(int a, int b) const { return sine_between(axis(a), axis(b)) >= kLeastAngle; }
  /// True if two parallel axes do not coincide.
  bool apart(int a, int b) const { return distance_to(axis(a), axis(b).point) > length_; }
  /// True if `point` is off axis `a`.
  bool off(int a, const Vec3& point) const { return distance_to(axis(a), point) > length_; }
  Vec3 meeting(int a, int b) const { return nearest_point({&axis(a), &axis(b)}); }
  Vec3 meeting(int a, int b, int c) const { return nearest_point({&axis(a), &axis(b), &axis(c)}); }

  const JointAxis& axis(int a) const { return arm_.axes[static_cast<std::size_t>(a - 1)]; }

 private:
  const ArmGeometry& arm_;
  double angle_, length_;
};

/// Moves axes of the ideal arm and records how far.
class Idealiser {
 public:
  explicit Idealiser(SixAxisClass& out) : out_(out) {}

  void meet(std::initializer_list<int> numbers, const Vec3& at) {
    for (const int a : numbers) {
      out_.worst_gap = std::max(out_.worst_gap, distance_to(axis(a), at));
      axis(a).point = at;
    }
  }
  void align(std::initializer_list<int> numbers) {
    const Vec3 first = axis(*numbers.begin()).direction;
    Vec3 sum{};
    for (const int a : numbers) sum = sum + side(first, a) * axis(a).direction;
    const Vec3 mean = normalized(sum);
    for (const int a : numbers) {
      const Vec3 direction = side(first, a) * mean;
      out_.worst_angle = std::max(out_.worst_angle, norm(cross(axis(a).direction, direction)));
      axis(a).direction = direction;
    }
  }

 private:
  JointAxis& axis(int a) { return out_.ideal.axes[static_cast<std::size_t>(a - 1)]; }
  double side(const Vec3& first, int a) { return dot(first, axis(a).direction) < 0 ? -1.0 : 1.0; }
  SixAxisClass& out_;
};

/// The position part of a wrist's family: the relation of the first three axes.
ArmFamily shoulder_of(const Look& look, const Vec3& wrist) {
  if (look.parallel(2, 3) && look.apart(2, 3) && look.slanted(1, 2) && look.off(3, wrist))
    return ArmFamily::wrist_2_parallel_3;
  if (look.parallel(1, 2) && look.apart(1, 2) && look.slanted(2, 3) && look.off(3, wrist))
    return ArmFamily::wrist_1_parallel_2;
  if (look.meet(1, 2) && look.slanted(2, 3) && look.off(3, look.meeting(1, 2)) && look.off(3, wrist))
    return ArmFamily::wrist_1_meets_2;
  if (look.meet(2, 3) && look.slanted(1, 2) && look.off(1, look.meeting(2, 3)) && look.off(3, wrist))
    return ArmFamily::wrist_2_meets_3;
  if (look.slanted(1, 2) && look.slanted(2, 3) && look.off(3, wrist)) return ArmFamily::wrist;
  return ArmFamily::none;
}

bool three_parallel(const Look& look, int a, int b, int c) {
  return look.parallel(a, b) && look.parallel(b, c) && look.parallel(a, c) && look.apart(a, b) &&
         look.apart(b, c);
}

/// True if the first three axes can move a point in three dimensions.
bool places_points(const Look& look) {
  const bool first = look.slanted(1, 2) || (look.parallel(1, 2) && look.apart(1, 2));
  const bool second = look.slanted(2, 3) || (look.parallel(2, 3) && look.apart(2, 3));
  return first && second && (look.slanted(1, 2) || look.slanted(2, 3));
}

ArmFamily family_of(const Look& look) {
  if (look.meet(4, 5, 6)) {
    const ArmFamily family = shoulder_of(look, look.meeting(4, 5, 6));
    if (family != ArmFamily::none) return family;
  }
  if (three_parallel(look, 2, 3, 4) && look.slanted(1, 2) && look.slanted(4, 5))
    if (look.meet(5, 6)) return ArmFamily::parallel_234_5_meets_6;
  if (three_parallel(look, 2, 3, 4) && look.slanted(1, 2) && look.slanted(4, 5) && look.slanted(5, 6))
    return ArmFamily::parallel_234;
  if (three_parallel(look, 1, 2, 3) && look.slanted(3, 4) && look.meet(5, 6) &&
      look.off(4, look.meeting(5, 6)))
    return ArmFamily::parallel_123_5_meets_6;
  if (look.meet(5, 6) && places_points(look) && look.off(4, look.meeting(5, 6)))
    return ArmFamily::search_5_meets_6;
  return ArmFamily::none;
}

/// Chooses the axis to search along, and the end to start from. The first three axes reach for the point
/// where two axes meet; that point moves on a circle about the search axis. A smaller circle gives a smoother
/// error function, and less of it is out of reach.
void choose_search(const Look& from_base, const Look& from_tool, ArmFamily& family, bool& turn_round) {
  constexpr double kClearly = 0.9;
  double least = kInfinity;
  for (const bool last : {false, true})
    for (const bool turned : {false, true}) {
      const Look& look = turned ? from_tool : from_base;
      const int first = last ? 4 : 5, along = last ? 6 : 4;  // of the two axes that meet
      if (!look.meet(first, first + 1) || !places_points(look)) continue;
      const Vec3 at = look.meeting(first, first + 1);
      if (!look.off(along, at) || (last && !look.off(3, at))) continue;
      const double lever = distance_to(look.axis(along), at);
      if (!(lever < kClearly * least)) continue;
      least = lever;
      family = last ? ArmFamily::search_4_meets_5 : ArmFamily::search_5_meets_6;
      turn_round = turned;
    }
}

void idealise(SixAxisClass& out) {
  const ArmGeometry seen = out.ideal;
  const Look look(seen, kLooseTolerance, 0);  // used for positions and directions only
  Idealiser ideal(out);
  switch (out.family) {
    case ArmFamily::wrist_2_parallel_3:
      ideal.align({2, 3});
      break;
    case ArmFamily::wrist_1_parallel_2:
      ideal.align({1, 2});
      break;
    case ArmFamily::wrist_1_meets_2:
      ideal.meet({1, 2}, look.meeting(1, 2));
      break;
    case ArmFamily::wrist_2_meets_3:
      ideal.meet({2, 3}, look.meeting(2, 3));
      break;
    case ArmFamily::parallel_234_5_meets_6:
      ideal.align({2, 3, 4});
      ideal.meet({5, 6}, look.meeting(5, 6));
      return;
    case ArmFamily::parallel_123_5_meets_6:
      ideal.align({1, 2, 3});
      ideal.meet({5, 6}, look.meeting(5, 6));
      return;
    case ArmFamily::parallel_234:
      ideal.align({2, 3, 4});
      return;
    case ArmFamily::search_5_meets_6:
    case ArmFamily::search_4_meets_5:
      if (out.family == ArmFamily::search_5_meets_6)
        ideal.meet({5, 6}, look.meeting(5, 6));
      else
        ideal.meet({4, 5}, look.meeting(4, 5));
      if (look.parallel(1, 2)) ideal.align({1, 2});
      if (Look(seen, kMeetsForSure, length_between_axes(seen)).meet(1, 2))
        ideal.meet({1, 2}, look.meeting(1, 2));
      return;
    default:
      break;
  }
  ideal.meet({4, 5, 6}, look.meeting(4, 5, 6));
}

}  // namespace

bool quartic(ArmFamily family) noexcept {
  return family == ArmFamily::wrist || family == ArmFamily::parallel_234;
}

bool searched(ArmFamily family) noexcept {
  return family == ArmFamily::search_5_meets_6 || family == ArmFamily::search_4_meets_5;
}

const char* describe(ArmFamily family) {
  switch (family) {
    case ArmFamily::wrist_2_parallel_3:
      return "a spherical wrist, axes 2 and 3 parallel";
    case ArmFamily::wrist_1_parallel_2:
      return "a spherical wrist, axes 1 and 2 parallel";
    case ArmFamily::wrist_1_meets_2:
      return "a spherical wrist, axes 1 and 2 meet";
    case ArmFamily::wrist_2_meets_3:
      return "a spherical wrist, axes 2 and 3 meet";
    case ArmFamily::wrist:
      return "a spherical wrist on three axes of any kind";
    case ArmFamily::parallel_234_5_meets_6:
      return "axes 2, 3 and 4 parallel, axes 5 and 6 meet";
    case ArmFamily::parallel_234:
      return "axes 2, 3 and 4 parallel";
    case ArmFamily::parallel_123_5_meets_6:
      return "axes 1, 2 and 3 parallel, axes 5 and 6 meet";
    case ArmFamily::search_5_meets_6:
      return "axes 5 and 6 meet, solved for one value of axis 4 after another";
    case ArmFamily::search_4_meets_5:
      return "axes 4 and 5 meet, solved for one value of axis 6 after another";
    case ArmFamily::none:
      return "no three neighbouring axes meet or are parallel";
  }
  return "";
}

int effort(ArmFamily family) noexcept {
  return family == ArmFamily::none ? 3 : searched(family) ? 2 : quartic(family) ? 1 : 0;
}

SixAxisClass classify(const ArmGeometry& arm, double tolerance) {
  SixAxisClass out;
  out.ideal = arm;
  if (arm.count != 6) return out;
  for (std::size_t i = 0; i < arm.count; ++i)
    if (arm.axes[i].slides) return out;
  const Look from_base(arm, tolerance, length_between_axes(arm));
  const ArmFamily forward = family_of(from_base);
  if (effort(forward) == 0) return seen_as(arm, forward, false);
  const ArmGeometry from_tool = reversed(arm);
  const Look turned(from_tool, tolerance, length_between_axes(from_tool));
  const ArmFamily backward = family_of(turned);
  bool turn_round = effort(backward) < effort(forward);
  ArmFamily family = turn_round ? backward : forward;
  if (searched(family)) choose_search(from_base, turned, family, turn_round);
  return seen_as(arm, family, turn_round);
}

SixAxisClass seen_as(const ArmGeometry& arm, ArmFamily family, bool from_tool) noexcept {
  SixAxisClass out;
  out.family = family;
  out.from_tool = from_tool;
  out.ideal = from_tool ? reversed(arm) : arm;
  if (family != ArmFamily::none) idealise(out);
  return out;
}

std::string why_no_family(const ArmGeometry& arm) {
  if (arm.count != 6) return fmt::format("{} axes", arm.count);
  std::string out;
  for (std::size_t i = 0; i + 2 < arm.count; ++i) {
    const JointAxis &a = arm.axes[i], &b = arm.axes[i + 1], &c = arm.axes[i + 2];
    const double miss = gap({&a, &b, &c});
    const double turn = std::max(sine_between(a, b), sine_between(b, c));
    out += out.empty() ? "" : "; ";
    out += fmt::format("axes {}, {} and {} ", i + 1, i + 2, i + 3);
    out += std::isfinite(miss) ? fmt::format("miss a common point by {:.1f} mm", 1000 * miss)
                               : fmt::format("are neither all parallel ({:.2g} rad) nor meet", turn);
  }
  return out;
}

}  // namespace polyarm::kinematics
