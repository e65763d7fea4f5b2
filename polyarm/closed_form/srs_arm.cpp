#include "polyarm/closed_form/srs_arm.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "polyarm/closed_form/curve_dips.hpp"
#include "polyarm/closed_form/families.hpp"
#include "polyarm/closed_form/lane_polish.hpp"
#include "polyarm/simd/lane_turns.hpp"

#pragma GCC diagnostic ignored "-Wpsabi"

namespace polyarm::kinematics {

namespace {

constexpr double kPi = std::numbers::pi;
constexpr std::size_t kEven = 6;  // elbow angles that are always tried
constexpr double kNowhere = 1e300;

Vec3 square_to(const Vec3& h) noexcept {
  return normalized(cross(h, std::abs(h.z) < 0.8 ? Vec3{0, 0, 1} : Vec3{0, 1, 0}));
}

/// The point nearest to two axes that are not parallel.
Vec3 between(const JointAxis& a, const JointAxis& b) noexcept {
  const Vec3 n = cross(a.direction, b.direction), way = b.point - a.point;
  const double scale = 1 / dot(n, n);
  const double s = scale * dot(way, cross(b.direction, n)), t = scale * dot(way, cross(a.direction, n));
  return 0.5 * (a.point + s * a.direction + b.point + t * b.direction);
}

/// The rotation by the smallest angle from one unit vector to another.
Rotation least_turn(const Vec3& from, const Vec3& to) noexcept {
  const Vec3 across = cross(from, to);
  const double sine = norm(across);
  if (sine > 1e-12) return rotation_about((1 / sine) * across, std::atan2(sine, dot(from, to)));
  return dot(from, to) > 0 ? Rotation{} : rotation_about(square_to(from), kPi);
}

}  // namespace

/// The elbow on one side: the part that does not depend on the elbow angle, evaluated at zero.
struct SrsSide {
  bool there = false;
  Vec3 axis_3, beside_3;  ///< axis 3 and its perpendicular after the first three joints
  Rotation before_wrist;  ///< of link 4
  Rotation before_elbow;  ///< of link 3
  double elbow = 0, elbow_cost = 0;
};

/// One target.
struct SrsQuestion {
  const SrsArm& arm;
  const double* near;
  Vec3 line;              ///< unit vector from the shoulder to the wrist
  Vec3 axis_7, beside_7;  ///< the last axis and its perpendicular, in the world
  Rotation turn;          ///< from zero to the target
  SrsSide sides[2];
  LaneAngle offered[7];
  /// The wanted turn of each joint: within half a turn of the center, which is the middle of the limits, or
  /// the seed if the limits allow more than one turn.
  struct Window {
    double center = 0, half = 0;
  } windows[7];

  bool ask(const PoseTarget& target) noexcept;
  POLYARM_INLINE std::size_t borders(double (*out)[2 * SrsArm::kMostBorders], std::size_t* counts) const;
  POLYARM_INLINE Lane triple(std::size_t first, const LaneVec& u, const LaneVec& w, const Vec3& beside,
                             Lane* value) const;
  POLYARM_INLINE Lane look(Lane angle, LaneMask other_side, Lane* value) const;

 private:
  void bend(double elbow, const Rotation& before, SrsSide& out) const noexcept;
};

bool SrsArm::fits(const ArmGeometry& arm) noexcept {
  if (arm.count != 7) return false;
  for (std::size_t k = 0; k < 7; ++k)
    if (arm.axes[k].slides) return false;
  const double least = 1e-9 * arm.size();
  const auto off = [&](std::size_t k, const Vec3& point) {
    return norm(cross(point - arm.axes[k].point, arm.axes[k].direction));
  };
  for (const std::size_t first : {std::size_t{0}, std::size_t{4}}) {
    for (std::size_t k = first; k < first + 2; ++k)
      if (std::abs(dot(arm.axes[k].direction, arm.axes[k + 1].direction)) > 1e-9) return false;
    const Vec3 point = between(arm.axes[first], arm.axes[first + 1]);
    for (std::size_t k = first; k < first + 3; ++k)
      if (off(k, point) > least) return false;
    if (off(3, point) < 1e-3 * arm.size()) return false;
  }
  return true;
}

void SrsArm::add_borders(std::size_t first) noexcept {
  const Vec3 &a = h_[first], &b = h_[first + 1], &c = h_[first + 2];
  const bool wrist = first == 4;
  for (std::size_t k = 0; k < 3; ++k) {
    const double lower = limits_.lower[first + k], upper = limits_.upper[first + k];
    if (!(upper - lower < 2 * kPi - 1e-9)) continue;
    for (const double limit : {lower, upper}) {
      Border& out = borders_[border_count_++];
      out = {wrist, k == 2, {}, 0};
      if (k == 0) out.seen = rotation_about(a, limit) * cross(a, cross(a, b));
      if (k == 1) out.seen = a, out.level = dot(a, rotation_about(b, limit) * c);
      if (k == 2) out.seen = rotation_about(c, -limit) * cross(c, cross(b, c));
    }
  }
}

SrsArm::SrsArm(const ArmGeometry& arm, const LaneLimits& limits) noexcept : limits_(limits) {
  for (std::size_t k = 0; k < 7; ++k) h_[k] = arm.axes[k].direction;
  shoulder_ = between(arm.axes[0], arm.axes[1]);
  wrist_ = between(arm.axes[4], arm.axes[5]);
  to_elbow_ = arm.axes[3].point - shoulder_;
  from_elbow_ = wrist_ - arm.axes[3].point;
  from_tool_rotation_ = transposed(arm.tool_rotation);
  wrist_in_tool_ = from_tool_rotation_ * (wrist_ - arm.tool_position);
  beside_3_ = square_to(h_[2]);
  beside_7_ = square_to(h_[6]);
  for (const std::size_t first : {std::size_t{0}, std::size_t{4}}) {
    const Vec3 &a = h_[first], &b = h_[first + 1], &c = h_[first + 2];
    twice_straight_[first / 4] = 2 * std::atan2(dot(a, cross(b, c)), dot(a, c));
    add_borders(first);
  }
}

/// The elbow at this angle, moved into its limits.
void SrsQuestion::bend(double elbow, const Rotation& turn_to_line, SrsSide& out) const noexcept {
  const double lower = arm.limits_.lower[3], upper = arm.limits_.upper[3];
  out.elbow_cost = arm.limits_.weight[3] * (elbow - near[3]) * (elbow - near[3]);
  out.elbow = elbow;
  out.there = elbow >= lower - 1e-10 && elbow <= upper + 1e-10;
  out.before_elbow = turn_to_line;
  out.axis_3 = turn_to_line * arm.h_[2];
  out.beside_3 = turn_to_line * arm.beside_3_;
}

/// The law of cosines gives angle 4. False if shoulder and wrist are too far apart or too close, or if limits
/// exclude both sides of the elbow.
bool SrsQuestion::ask(const PoseTarget& target) noexcept {
  turn = target.rotation * arm.from_tool_rotation_;
  const Vec3 way = target.position + target.rotation * arm.wrist_in_tool_ - arm.shoulder_;
  const Vec3 &p = arm.from_elbow_, &q = arm.to_elbow_, &h = arm.h_[3];
  const Vec3 flat = p - dot(h, p) * h;
  const double c = dot(q, flat), s = dot(q, cross(h, p)), along = dot(h, p) * dot(h, q);
  const double wanted = 0.5 * (dot(way, way) - dot(p, p) - dot(q, q)) - along;
  const double reach = std::sqrt(s * s + c * c), length = norm(way);
  if (std::abs(wanted) > reach * (1 + 1e-12) || length < 1e-9 * (norm(p) + norm(q))) return false;
  line = (1 / length) * way;
  axis_7 = turn * arm.h_[6];
  beside_7 = turn * arm.beside_7_;
  const double middle = std::atan2(s, c), half = std::acos(std::clamp(wanted / reach, -1.0, 1.0));
  bool any = false;
  for (const std::size_t side : {0, 1}) {
    double elbow = middle + (side == 0 ? half : -half);
    elbow += 2 * kPi * std::round((near[3] - elbow) / (2 * kPi));
    if (elbow < arm.limits_.lower[3]) elbow += 2 * kPi;
    if (elbow > arm.limits_.upper[3]) elbow -= 2 * kPi;
    const Rotation r4 = rotation_about(h, elbow);
    bend(elbow, least_turn(normalized(q + r4 * p), line), sides[side]);
    sides[side].before_wrist = sides[side].before_elbow * r4;
    any |= sides[side].there;
  }
  for (std::size_t k = 0; k < 7; ++k) {
    offered[k] = {splat(std::sin(near[k])), splat(std::cos(near[k]))};
    constexpr double kAtLimit = 1e-10;  // rad beyond a limit: rounding
    const double lower = arm.limits_.lower[k], upper = arm.limits_.upper[k];
    if (upper - lower < 2 * kPi)
      windows[k] = {0.5 * (lower + upper), 0.5 * (upper - lower) + kAtLimit};
    else
      windows[k] = {std::clamp(near[k], lower + kPi, upper - kPi), 4};
  }
  return any;
}

/// Elbow angles at which joints reach their limits, for each side. Because axes are perpendicular to their
/// neighbours, each border is the root of a sin + b cos = c.
POLYARM_INLINE std::size_t SrsQuestion::borders(double (*out)[2 * SrsArm::kMostBorders],
                                                std::size_t* counts) const {
  constexpr std::size_t kAll = 2 * SrsArm::kMostBorders;
  alignas(64) double a[kAll], b[kAll], c[kAll], first[kAll], second[kAll];
  std::uint8_t side_of[kAll];
  std::size_t count = 0;
  for (const std::size_t side : {0, 1}) {
    const SrsSide& s = sides[side];
    counts[side] = 0;
    for (std::size_t k = 0; s.there && k < arm.border_count_; ++k, ++count) {
      const SrsArm::Border& border = arm.borders_[k];
      const Vec3& h = arm.h_[border.wrist ? 4 : 0];
      const Rotation *from_first = border.wrist ? &s.before_wrist : nullptr,
                     *from_last = border.wrist ? &turn : &s.before_elbow;
      // The vector that the elbow angle turns, and the view on it: the last axis from the first, or back.
      const Vec3 start = from_first ? *from_first * h : h, last = border.wrist ? axis_7 : s.axis_3;
      const Vec3 turned = border.from_last ? start : last;
      const Vec3 seen = border.from_last ? *from_last * border.seen
                        : from_first     ? *from_first * border.seen
                                         : border.seen;
      const double way = border.wrist != border.from_last ? -1 : 1;
      const Vec3 still = dot(line, turned) * line;
      a[count] = way * dot(seen, cross(line, turned));
      b[count] = dot(seen, turned - still);
      c[count] = border.level - dot(seen, still);
      side_of[count] = static_cast<std::uint8_t>(side);
    }
  }
  for (std::size_t from = 0; from < count; from += kLanes) {
    const Lane s = load(a + from), t = load(b + from), level = load(c + from);
    const Lane open = s * s + t * t - level * level;
    const Lane middle = angle_of(s, t), half = angle_of(root(most_of(open, Lane{})), level);
    const auto wrapped = [&](Lane at) { return at - 2 * kPi * rounded(at * (0.5 / kPi)); };
    store(select(below(Lane{}, open), wrapped(middle - half), splat(kNowhere)), first + from);
    store(wrapped(middle + half), second + from);
  }
  for (std::size_t k = 0; k < count; ++k) {
    if (!(first[k] < kNowhere)) continue;
    double* const to = out[side_of[k]] + counts[side_of[k]];
    to[0] = first[k], to[1] = second[k];
    counts[side_of[k]] += 2;
  }
  return count;
}

/// Three angles that turn their last axis to `u`: of both solutions the one within limits that is nearer to
/// the seed. As axes are perpendicular to their neighbours, the other solution mirrors the bend and adds half
/// a turn to the others.
POLYARM_INLINE Lane SrsQuestion::triple(std::size_t first, const LaneVec& u, const LaneVec& w,
                                        const Vec3& beside, Lane* value) const {
  const Vec3 &a = arm.h_[first], &b = arm.h_[first + 1], &c = arm.h_[first + 2];
  const Edge edge{};
  LaneMask free{};
  LaneAngle q[3];
  q[1] = wrist_bend(a, b, c, u, splat(1.0), edge, free);
  q[0] = subproblem_1(turned(b, q[1], splat(c)), u, a, 1e-18, offered[first], free);
  q[2] =
      subproblem_1(splat(beside), turned(b, -q[1], turned(a, -q[0], w)), c, 1e-9, offered[first + 2], free);
  Lane angle[3];
  for (std::size_t k = 0; k < 3; ++k) angle[k] = angle_of(q[k].s, q[k].c);
  Lane best = splat(kNowhere);
  const auto& weight = arm.limits_.weight;
  for (const bool mirrored : {false, true}) {
    Lane cost{};
    LaneMask inside = ~LaneMask{};
    for (std::size_t k = 0; k < 3; ++k) {
      if (mirrored) angle[k] = k == 1 ? arm.twice_straight_[first / 4] - angle[k] : angle[k] + kPi;
      const Window& window = windows[first + k];
      const Lane off = angle[k] - window.center, there = off - 2 * kPi * rounded(off * (0.5 / kPi));
      inside &= ~below(splat(window.half), magnitude(there));
      angle[k] = window.center + there;
      const Lane away = angle[k] - near[first + k];
      cost += weight[first + k] * away * away;
    }
    const LaneMask better = inside & below(cost, best);
    best = select(better, cost, best);
    for (std::size_t k = 0; k < 3; ++k) value[k] = select(better, angle[k], value[k]);
  }
  return best;
}

/// Eight elbow angles, each on one side of the elbow: squared distances, and the angles of all joints.
POLYARM_INLINE Lane SrsQuestion::look(Lane angle, LaneMask other_side, Lane* value) const {
  const LaneAngle by = turn_by(angle);
  const SrsSide &one = sides[0], &other = sides[1];
  const auto vec = [&](const Vec3& a, const Vec3& b) { return select(other_side, splat(b), splat(a)); };
  const LaneVec x = vec(one.before_wrist.x, other.before_wrist.x),
                y = vec(one.before_wrist.y, other.before_wrist.y),
                z = vec(one.before_wrist.z, other.before_wrist.z);
  const auto back = [&](const LaneVec& v) { return LaneVec{dot(x, v), dot(y, v), dot(z, v)}; };
  for (std::size_t k = 0; k < 7; ++k) value[k] = splat(near[k]);
  const Lane upper = triple(0, turned(line, by, vec(one.axis_3, other.axis_3)),
                            turned(line, by, vec(one.beside_3, other.beside_3)), arm.beside_3_, value);
  const Lane lower =
      triple(4, back(turned(line, -by, axis_7)), back(turned(line, -by, beside_7)), arm.beside_7_, value + 4);
  value[3] = select(other_side, splat(other.elbow), splat(one.elbow));
  return upper + lower + select(other_side, splat(other.elbow_cost), splat(one.elbow_cost));
}

namespace {

using SrsDips = Dips<SrsArm::kMostDips>;

/// Tries one angle in each sixth of a turn and in each interval between borders, on both sides of the elbow.
POLYARM_INLINE void find_dips(SrsQuestion& question, SrsDips& out) {
  constexpr std::size_t kOfSide = 2 * SrsArm::kMostBorders + kEven, kRoom = 2 * kOfSide + kLanes;
  double borders[2][2 * SrsArm::kMostBorders], ends[kOfSide + 1];
  std::size_t counts[2], from[2];
  alignas(64) double angles[kRoom], costs[kRoom], side_of[kRoom];
  question.borders(borders, counts);
  std::size_t count = 0;
  for (const std::size_t side : {0, 1}) {
    from[side] = count;
    if (!question.sides[side].there) continue;
    std::size_t n = counts[side];
    std::copy(borders[side], borders[side] + n, ends);
    for (std::size_t k = 0; k < kEven; ++k) ends[n++] = kPi * (2.0 * static_cast<double>(k) / kEven - 1);
    std::sort(ends, ends + n);
    ends[n] = ends[0] + 2 * kPi;
    for (std::size_t k = 0; k < n; ++k, ++count) {
      angles[count] = 0.5 * (ends[k] + ends[k + 1]);
      side_of[count] = static_cast<double>(side);
    }
  }
  for (std::size_t k = count; k < count + kLanes; ++k) angles[k] = angles[0], side_of[k] = side_of[0];
  alignas(64) double values[7][kRoom];
  for (std::size_t k = 0; k < count; k += kLanes) {
    Lane value[7];
    const LaneMask other = below(splat(0.5), load(side_of + k));
    store(question.look(load(angles + k), other, value), costs + k);
    for (std::size_t i = 0; i < 7; ++i) store(value[i], values[i] + k);
  }
  for (const std::size_t side : {0, 1}) {
    const std::size_t begin = from[side], end = side == 0 ? from[1] : count;
    SrsDips::Rows rows;
    for (std::size_t i = 0; i < 7; ++i) rows[i] = values[i] + begin;
    out.take_all(costs + begin, rows, end - begin, true);
  }
}

using Kernel = void (*)(SrsQuestion&, SrsDips&);

void dips_anywhere(SrsQuestion& question, SrsDips& out) {
  find_dips(question, out);
}
#if defined(__x86_64__)
__attribute__((target("avx2,fma"))) void dips_avx2(SrsQuestion& question, SrsDips& out) {
  find_dips(question, out);
}
__attribute__((target("avx512f,avx512dq,avx512vl,avx2,fma"))) void dips_avx512(SrsQuestion& question,
                                                                               SrsDips& out) {
  find_dips(question, out);
}
#endif

Kernel kernel_here() {
#if defined(__x86_64__)
  switch (wanted_instructions()) {
    case InstructionSet::avx512:
      return dips_avx512;
    case InstructionSet::avx2:
      return dips_avx2;
    case InstructionSet::portable:
      break;
  }
#endif
  return dips_anywhere;
}

const Kernel kKernel = kernel_here();

}  // namespace

std::size_t SrsArm::dips(const PoseTarget& target, const double* near,
                         std::span<State, kMostDips> out) const noexcept {
  SrsQuestion question{*this, near, {}, {}, {}, {}, {}, {}, {}};
  SrsDips found(out);
  if (question.ask(target)) kKernel(question, found);
  return found.count();
}

}  // namespace polyarm::kinematics
