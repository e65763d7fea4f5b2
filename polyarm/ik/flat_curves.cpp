// Curves of joint states along which the tool hardly moves. Near such a curve the solutions can lie anywhere
// along it, so it is searched as a whole.
#include <algorithm>
#include <cmath>
#include <utility>

#include "polyarm/ik/ik_arm.hpp"

namespace polyarm::ik {

namespace {

constexpr double kStillFlat = 0.03;  // the same limit while walking
constexpr double kCrossing = 0.02;   // where a second direction moves the tool by less, two curves cross
constexpr double kOff = 3e-3;        // in lengths of the arm and rad: farther from the pose the curve ends
constexpr double kStride = 0.4;      // rad, in eight places
constexpr double kLeastStride = 0.02;
constexpr int kMostStrides = 44;  // in each direction: once around for most curves
constexpr std::size_t kMostCurves = 4;
constexpr int kComingNear = 4;      // steps of descent
constexpr double kMember2 = 1e-18;  // m^2 and rad^2
constexpr std::size_t kEnough = 12;
constexpr double kClose = 1.2;  // of the distance between neighbours
constexpr double kPassed = 0.03;
constexpr double kTurnsBack = 4;       // ratio of actual to intended distance between places
constexpr double kAtCrossing = 0.003;  // rad: the smallest circle

/// The shortest change from one angle to another; faster than std::remainder.
double way_to(double from, double to) {
  const double way = to - from;
  return way - kTurn * std::nearbyint(way / kTurn);
}
double apart(double a, double b) {
  return std::abs(way_to(a, b));
}
double furthest_apart(const AxisValues& a, const AxisValues& b, std::size_t axes) {
  double out = 0;
  for (std::size_t i = 0; i < axes; ++i) out = std::max(out, apart(a[i], b[i]));
  return out;
}

}  // namespace

/// The two perpendicular directions that move the tool least, and by how much.
struct FlatWays {
  AxisValues way{}, next_way{};
  double least = 0, next = 0;

  FlatWays() = default;
  FlatWays(const LeastMotions& of, std::size_t lane) noexcept : least(of.least[lane]), next(of.next[lane]) {
    for (std::size_t i = 0; i < 6; ++i) way[i] = of.way[i][lane], next_way[i] = of.next_way[i][lane];
  }
};

struct FlatCurve {
  struct Begin {
    AxisValues at;
    FlatWays ways;
  };
  static constexpr std::size_t kMostCrossings = 3;
  std::array<Begin, kMostCrossings> crossings;  ///< places where another curve crosses, with its direction
  std::size_t crossed = 0, taken = 0;           ///< taken: those already walked from
  AxisValues start, here, way;
  double stride = kStride, travelled = 0;
  std::array<bool, IkSolutions::kCapacity> passed{};  ///< solutions on this curve
  WaitingStates waiting;

  /// Keeps the flattest of several sightings of one crossing.
  void note(const Begin& one, std::size_t axes) noexcept {
    for (std::size_t c = 0; c < crossed; ++c) {
      if (furthest_apart(crossings[c].at, one.at, axes) > kStride) continue;
      if (c >= taken && one.ways.next < crossings[c].ways.next) crossings[c] = one;
      return;
    }
    if (crossed < crossings.size()) crossings[crossed++] = one;
  }
};

/// The eight places of one stride.
struct FlatStride {
  Branches relaxed, stepped;
  LeastMotions flat;         ///< at the relaxed places
  double part = 0, gap = 0;  ///< step between places: in total, and of the held axis
  std::size_t held = 0;
};

/// Along the tangent: fixes the axis that moves most; the others descend as near to the pose as they can.
void InverseKinematics::Arm::stride_along(const BranchJob& asked, const FlatCurve& curve,
                                          FlatStride& out) const noexcept {
  for (std::size_t i = 0; i < geometry.count; ++i)
    if (std::abs(curve.way[i]) > std::abs(curve.way[out.held])) out.held = i;
  BranchJob relaxing = whatever_the_error(asked, kComingNear);
  for (int& axis : relaxing.to_arm)
    if (axis == static_cast<int>(out.held)) axis = -1;
  relaxing.all_move = false;
  out.part = curve.stride / kBranches;
  out.gap = out.part * std::abs(curve.way[out.held]);
  for (std::size_t k = 0; k < kBranches; ++k)
    for (std::size_t i = 0; i < geometry.count; ++i)
      out.relaxed.value[i][k] = curve.here[i] + out.part * static_cast<double>(k + 1) * curve.way[i];
  out.relaxed.free = 0;
  polish_branches(relaxing, out.relaxed);
  find_least_motions(lanes, out.relaxed, true, out.flat);
  out.stepped = out.relaxed;
  polish_branches(whatever_the_error(asked, 1), out.stepped);
}

/// One stride. Where a step of all axes stays close, descends to the end. False if the curve ends or closes.
bool InverseKinematics::Arm::go_along(const BranchJob& asked, std::size_t since, FlatCurve& curve,
                                      Gathered& out) const noexcept {
  const std::size_t n = geometry.count;
  FlatStride stride;
  stride_along(asked, curve, stride);
  const auto& [relaxed, stepped, flat, part, gap, held] = stride;
  AxisValues last = curve.here, crossing{};
  std::size_t good = 0, flattest = kBranches;
  bool ends = false;
  for (; good < kBranches; ++good) {
    const double off2 =
        relaxed.position_error2[good] / (lanes.size * lanes.size) + relaxed.orientation_error2[good];
    AxisValues next{};
    double turned = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const double change = way_to(last[i], relaxed.value[i][good]);
      turned = std::max(turned, std::abs(change));
      next[i] = last[i] + change;
    }
    ends = off2 > kOff * kOff;
    if (ends || turned > kTurnsBack * part) break;
    last = next;
    if (flat.next[good] < (flattest < kBranches ? flat.next[flattest] : kCrossing))
      flattest = good, crossing = last;
    for (std::size_t c = since; c < out.count; ++c)
      curve.passed[c] |= furthest_apart(out.all[c].value, last, n) < kPassed;
    if (apart(stepped.value[held][good], relaxed.value[held][good]) > kClose * gap) continue;
    // A few members represent a family that is continuous within tolerances.
    const bool member =
        relaxed.position_error2[good] < kMember2 && relaxed.orientation_error2[good] < kMember2;
    if (member && (good % 4 != 0 || out.count > kEnough)) continue;
    WaitingStates& waiting = curve.waiting;
    for (std::size_t i = 0; i < n; ++i) waiting.branches.value[i][waiting.count] = stepped.value[i][good];
    if (++waiting.count == kBranches) descend_all(asked, waiting, since, out);
  }
  if (flattest < kBranches) {
    const FlatWays ways(flat, flattest);
    search_all_directions(asked, crossing, ways, kAtCrossing, since, out);
    curve.note({crossing, ways}, n);
  }
  if (ends) return false;
  if (good == 0) {
    curve.stride /= 4;
    return curve.stride > kLeastStride;
  }
  if (flat.least[good - 1] > kStillFlat) return false;
  double along = 0;
  for (std::size_t i = 0; i < n; ++i) along += flat.way[i][good - 1] * (last[i] - curve.here[i]);
  for (std::size_t i = 0; i < n; ++i)
    curve.way[i] = along < 0 ? -flat.way[i][good - 1] : flat.way[i][good - 1];
  curve.here = last;
  curve.travelled += part * static_cast<double>(good);
  curve.stride = good == kBranches ? std::min(kStride, 2 * curve.stride) : 0.5 * curve.stride;
  return curve.travelled < 1 || furthest_apart(last, curve.start, n) > curve.stride;
}

/// In both directions.
void InverseKinematics::Arm::walk(const BranchJob& asked, const AxisValues& from, const FlatWays& ways,
                                  std::size_t since, FlatCurve& curve, Gathered& out) const noexcept {
  curve.start = from;
  for (const double side : {1.0, -1.0}) {
    curve.here = from;
    for (std::size_t i = 0; i < geometry.count; ++i) curve.way[i] = side * ways.way[i];
    curve.stride = kStride;
    curve.travelled = 0;
    int strides = 0;
    while (go_along(asked, since, curve, out) && ++strides < kMostStrides) {
    }
  }
  descend_all(asked, curve.waiting, since, out);
}

/// From each solution that is singular enough, and from each crossing with another curve.
void InverseKinematics::Arm::along_curves(const BranchJob& asked, std::size_t since,
                                          Gathered& out) const noexcept {
  const std::size_t known_before = out.count;
  FlatCurve curve;
  LeastMotions flat;
  std::size_t walked = 0;
  for (std::size_t c = since; c < known_before && walked < kMostCurves; ++c) {
    if (curve.passed[c]) continue;
    const AxisValues at = out.all[c].value;
    see_motions({&at, 1}, true, flat);
    const FlatWays ways(flat, 0);
    if (ways.least > kFlatCurve) continue;
    if (ways.next < kCrossing / 4) search_all_directions(asked, at, ways, 10 * ways.next, since, out);
    walk(asked, at, ways, since, curve, out);
    ++walked;
    while (curve.taken < curve.crossed) {
      FlatCurve::Begin begin = curve.crossings[curve.taken++];
      std::swap(begin.ways.way, begin.ways.next_way);
      walk(asked, begin.at, begin.ways, since, curve, out);
    }
  }
}

/// Where two directions hardly move the tool, up to four solutions are near: descends from circles in the
/// plane of both directions.
void InverseKinematics::Arm::search_all_directions(const BranchJob& asked, const AxisValues& at,
                                            const FlatWays& ways, double least_radius, std::size_t since,
                                            Gathered& out) const noexcept {
  constexpr int kCircles = 3;
  constexpr double kWider = 5;
  double radius = std::clamp(least_radius, 1e-4, 0.02);
  for (int circle = 0; circle < kCircles; ++circle, radius *= kWider) {
    WaitingStates waiting;
    for (; waiting.count < kBranches; ++waiting.count) {
      const double angle = kTurn / kBranches * (static_cast<double>(waiting.count) + 0.3 * circle);
      const double c = radius * std::cos(angle), s = radius * std::sin(angle);
      for (std::size_t i = 0; i < geometry.count; ++i)
        waiting.branches.value[i][waiting.count] = at[i] + c * ways.way[i] + s * ways.next_way[i];
    }
    descend_all(asked, waiting, since, out);
  }
}

}  // namespace polyarm::ik
