#include "polyarm/closed_form/srs_arm.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "polyarm/closed_form/eightfold_search.hpp"
#include "polyarm/closed_form/families.hpp"
#include "polyarm/closed_form/lane_polish.hpp"
#include "polyarm/simd/lane_turns.hpp"

#pragma GCC diagnostic ignored "-Wpsabi"

namespace polyarm::kinematics {

namespace {

constexpr double kPi = std::numbers::pi;
constexpr std::size_t kEven = 16;     // elbow angles tried whatever the limits
constexpr std::size_t kBorders = 24;  // six joints, two limits, two elbow angles at each
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

/// The rotation by the least angle from one direction to another; both unit vectors.
Rotation least_turn(const Vec3& from, const Vec3& to) noexcept {
  const Vec3 across = cross(from, to);
  const double sine = norm(across);
  if (sine > 1e-12) return rotation_about((1 / sine) * across, std::atan2(sine, dot(from, to)));
  return dot(from, to) > 0 ? Rotation{} : rotation_about(square_to(from), kPi);
}

}  // namespace

/// One target with the elbow on one side.
struct SrsQuestion {
  const SrsArm& arm;
  const LaneLimits& limits;
  const double* near;
  Vec3 line;              ///< unit vector from the shoulder to the wrist
  Vec3 axis_3, beside_3;  ///< axis 3 and what is beside it after the first three, elbow angle zero
  Vec3 axis_7, beside_7;  ///< the last axis and what is beside it, in the world
  Rotation before_wrist;  ///< of link 4, elbow angle zero
  Rotation before_elbow;  ///< of link 3, elbow angle zero
  Rotation turn;          ///< from zero to the target
  double elbow = 0, elbow_cost = 0;
  LaneAngle offered[7];

  bool ask(const PoseTarget& target, double side) noexcept;
  std::size_t borders(double* out) const noexcept;
  POLYARM_INLINE Lane triple(std::size_t first, const LaneVec& u, const LaneVec& w, const Vec3& beside,
                             Lane* value) const;
  POLYARM_INLINE Lane look(Lane angle, Lane* value) const;

 private:
  void add_borders(const Vec3& turned, double way, const Vec3& seen, double level, double* out,
                   std::size_t& count) const noexcept;
  bool bounded(std::size_t k) const noexcept { return limits.upper[k] - limits.lower[k] < 2 * kPi - 1e-9; }
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

SrsArm::SrsArm(const ArmGeometry& arm) noexcept {
  for (std::size_t k = 0; k < 7; ++k) h_[k] = arm.axes[k].direction;
  shoulder_ = between(arm.axes[0], arm.axes[1]);
  wrist_ = between(arm.axes[4], arm.axes[5]);
  to_elbow_ = arm.axes[3].point - shoulder_;
  from_elbow_ = wrist_ - arm.axes[3].point;
  from_tool_rotation_ = transposed(arm.tool_rotation);
  wrist_in_tool_ = from_tool_rotation_ * (wrist_ - arm.tool_position);
  beside_3_ = square_to(h_[2]);
  beside_7_ = square_to(h_[6]);
}

/// The law of cosines gives angle 4. False where shoulder and wrist are too far apart or too close.
bool SrsQuestion::ask(const PoseTarget& target, double side) noexcept {
  turn = target.rotation * arm.from_tool_rotation_;
  const Vec3 way = target.position + target.rotation * arm.wrist_in_tool_ - arm.shoulder_;
  const Vec3 &p = arm.from_elbow_, &q = arm.to_elbow_, &h = arm.h_[3];
  const Vec3 flat = p - dot(h, p) * h;
  const double c = dot(q, flat), s = dot(q, cross(h, p)), along = dot(h, p) * dot(h, q);
  const double wanted = 0.5 * (dot(way, way) - dot(p, p) - dot(q, q)) - along;
  const double reach = std::hypot(s, c), length = norm(way);
  if (std::abs(wanted) > reach * (1 + 1e-12) || length < 1e-9 * (norm(p) + norm(q))) return false;
  elbow = std::atan2(s, c) + side * std::acos(std::clamp(wanted / reach, -1.0, 1.0));
  elbow += 2 * kPi * std::round((near[3] - elbow) / (2 * kPi));
  if (elbow < limits.lower[3]) elbow += 2 * kPi;
  if (elbow > limits.upper[3]) elbow -= 2 * kPi;
  if (elbow < limits.lower[3] - 1e-10 || elbow > limits.upper[3] + 1e-10) return false;
  elbow_cost = limits.weight[3] * (elbow - near[3]) * (elbow - near[3]);
  line = (1 / length) * way;
  const Rotation r4 = rotation_about(h, elbow);
  before_elbow = least_turn(normalized(q + r4 * p), line);
  before_wrist = before_elbow * r4;
  axis_3 = before_elbow * arm.h_[2];
  beside_3 = before_elbow * arm.beside_3_;
  axis_7 = turn * arm.h_[6];
  beside_7 = turn * arm.beside_7_;
  for (std::size_t k = 0; k < 7; ++k) offered[k] = {splat(std::sin(near[k])), splat(std::cos(near[k]))};
  return true;
}

/// Elbow angles at which `turned`, taken along by them (or back: way -1), has `level` along `seen`.
void SrsQuestion::add_borders(const Vec3& turned, double way, const Vec3& seen, double level, double* out,
                              std::size_t& count) const noexcept {
  const Vec3 still = dot(line, turned) * line;
  const double a = way * dot(seen, cross(line, turned)), b = dot(seen, turned - still);
  const double size = std::hypot(a, b), wanted = level - dot(seen, still);
  if (!(std::abs(wanted) < size)) return;
  const double middle = std::atan2(a, b), half = std::acos(wanted / size);
  for (const double at : {middle - half, middle + half}) out[count++] = std::remainder(at, 2 * kPi);
}

/// Where joints come to their limits: axes that are square to their neighbours make each border the root of
/// a sin + b cos = c.
std::size_t SrsQuestion::borders(double* out) const noexcept {
  std::size_t count = 0;
  for (const std::size_t first : {std::size_t{0}, std::size_t{4}}) {
    const Vec3 &a = arm.h_[first], &b = arm.h_[first + 1], &c = arm.h_[first + 2];
    const bool wrist = first == 4;
    // What is turned by the elbow angle, and how it is seen: the last axis from the first, and back.
    const Vec3 last = wrist ? axis_7 : axis_3, start = wrist ? before_wrist * a : a;
    const auto from_first = [&](const Vec3& v) { return wrist ? before_wrist * v : v; };
    const auto from_last = [&](const Vec3& v) { return wrist ? turn * v : before_elbow * v; };
    const double way = wrist ? -1 : 1;
    for (const bool upper : {false, true}) {
      const auto limit = [&](std::size_t k) { return upper ? limits.upper[k] : limits.lower[k]; };
      if (bounded(first)) {
        const Vec3 f = rotation_about(a, limit(first)) * cross(a, cross(a, b));
        add_borders(last, way, from_first(f), 0, out, count);
      }
      if (bounded(first + 1)) {
        const double level = dot(a, rotation_about(b, limit(first + 1)) * c);
        add_borders(last, way, from_first(a), level, out, count);
      }
      if (bounded(first + 2)) {
        const Vec3 g = rotation_about(c, -limit(first + 2)) * cross(c, cross(b, c));
        add_borders(start, -way, from_last(g), 0, out, count);
      }
    }
  }
  return count;
}

/// Three angles that put their last axis along `u`, of both ways the one nearer to the seed within limits.
POLYARM_INLINE Lane SrsQuestion::triple(std::size_t first, const LaneVec& u, const LaneVec& w,
                                        const Vec3& beside, Lane* value) const {
  const Vec3 &a = arm.h_[first], &b = arm.h_[first + 1], &c = arm.h_[first + 2];
  const Edge edge{};
  Lane best = splat(kNowhere);
  for (const double side : {1.0, -1.0}) {
    LaneMask free{};
    LaneAngle q[3];
    q[1] = wrist_bend(a, b, c, u, splat(side), edge, free);
    q[0] = subproblem_1(turned(b, q[1], splat(c)), u, a, 1e-18, offered[first], free);
    q[2] =
        subproblem_1(splat(beside), turned(b, -q[1], turned(a, -q[0], w)), c, 1e-9, offered[first + 2], free);
    Lane cost{}, at[3];
    LaneMask inside = ~LaneMask{};
    for (std::size_t k = 0; k < 3; ++k) {
      at[k] = angle_of(q[k].s, q[k].c);
      inside &= bring_near(at[k], near[first + k], limits.lower[first + k], limits.upper[first + k], false);
      const Lane away = at[k] - near[first + k];
      cost += limits.weight[first + k] * away * away;
    }
    const LaneMask better = inside & below(cost, best);
    best = select(better, cost, best);
    for (std::size_t k = 0; k < 3; ++k) value[k] = select(better, at[k], value[k]);
  }
  return best;
}

/// Eight elbow angles: squared distances, and the angles of all joints but the elbow.
POLYARM_INLINE Lane SrsQuestion::look(Lane angle, Lane* value) const {
  const LaneAngle by = turn_by(angle);
  const Rotation back = transposed(before_wrist);
  for (std::size_t k = 0; k < 7; ++k) value[k] = splat(near[k]);
  const Lane upper =
      triple(0, turned(line, by, splat(axis_3)), turned(line, by, splat(beside_3)), arm.beside_3_, value);
  const Lane lower = triple(4, back * turned(line, -by, splat(axis_7)),
                            back * turned(line, -by, splat(beside_7)), arm.beside_7_, value + 4);
  value[3] = splat(elbow);
  return upper + lower;
}

namespace {

struct Best {
  double cost = kNowhere, angle = 0, width = 0;
  SrsArm::State state{};
};

POLYARM_INLINE void keep(const Lane* value, std::size_t lane, SrsArm::State& state) {
  for (std::size_t i = 0; i < 7; ++i) state[i] = value[i][lane];
}

/// One look into each stretch between borders.
POLYARM_INLINE void scan(const SrsQuestion& question, Best& best) {
  constexpr std::size_t kAll = kBorders + kEven;
  double ends[kAll + 1];
  std::size_t count = question.borders(ends);
  for (std::size_t k = 0; k < kEven; ++k) ends[count++] = kPi * (2.0 * static_cast<double>(k) / kEven - 1);
  std::sort(ends, ends + count);
  ends[count] = ends[0] + 2 * kPi;
  double angles[kAll + kLanes], widths[kAll + kLanes];
  for (std::size_t k = 0; k < count + kLanes; ++k) {
    const std::size_t at = std::min(k, count - 1);
    angles[k] = 0.5 * (ends[at] + ends[at + 1]);
    widths[k] = ends[at + 1] - ends[at];
  }
  for (std::size_t first = 0; first < count; first += kLanes) {
    Lane value[7];
    const Lane cost = question.look(load(angles + first), value) + question.elbow_cost;
    for (std::size_t k = 0; k < kLanes; ++k) {
      if (!(cost[k] < best.cost)) continue;
      best.cost = cost[k];
      best.angle = angles[first + k];
      best.width = widths[first + k];
      keep(value, k, best.state);
    }
  }
}

POLYARM_INLINE void refine(const SrsQuestion& question, Best& best) {
  constexpr double kFine = 1e-7;  // rad
  EightfoldSearch search(best.angle, best.cost, best.width);
  while (search.going(kFine)) {
    double angles[kLanes], costs[kLanes];
    for (std::size_t k = 0; k < kLanes; ++k)
      angles[k] = search.first() + static_cast<double>(k) * search.step();
    Lane value[7];
    store(question.look(load(angles), value) + question.elbow_cost, costs);
    if (const std::size_t k = search.see(costs); k < kLanes) keep(value, k, best.state);
  }
  best.cost = search.cost();
}

POLYARM_INLINE bool find_nearest(SrsQuestion& question, const PoseTarget& target, SrsArm::State& out) {
  double least = kNowhere;
  for (const double side : {1.0, -1.0}) {
    if (!question.ask(target, side)) continue;
    Best best;
    scan(question, best);
    if (best.cost < kNowhere) refine(question, best);
    if (!(best.cost < least)) continue;
    least = best.cost;
    out = best.state;
  }
  return least < kNowhere;
}

using Kernel = bool (*)(SrsQuestion&, const PoseTarget&, SrsArm::State&);

bool nearest_anywhere(SrsQuestion& question, const PoseTarget& target, SrsArm::State& out) {
  return find_nearest(question, target, out);
}
#if defined(__x86_64__)
__attribute__((target("avx2,fma"))) bool nearest_avx2(SrsQuestion& question, const PoseTarget& target,
                                                      SrsArm::State& out) {
  return find_nearest(question, target, out);
}
__attribute__((target("avx512f,avx512dq,avx512vl,avx2,fma"))) bool nearest_avx512(SrsQuestion& question,
                                                                                  const PoseTarget& target,
                                                                                  SrsArm::State& out) {
  return find_nearest(question, target, out);
}
#endif

Kernel kernel_here() {
#if defined(__x86_64__)
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl")) return nearest_avx512;
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return nearest_avx2;
#endif
  return nearest_anywhere;
}

const Kernel kKernel = kernel_here();

}  // namespace

bool SrsArm::nearest(const PoseTarget& target, const LaneLimits& limits, const double* near,
                     State& out) const noexcept {
  SrsQuestion question{*this, limits, near, {}, {}, {}, {}, {}, {}, {}, {}, 0, 0, {}};
  return kKernel(question, target, out);
}

}  // namespace polyarm::kinematics
