// Arms of three to five axes, solved as arms of six axes with some axes fixed.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "polyarm/ik/ik_arm.hpp"
#include "polyarm/kinematics/arm_length.hpp"

namespace polyarm::ik {

namespace {

/// The point nearest to two axes that are not parallel.
Vec3 nearest_point(const JointAxis& a, const JointAxis& b) noexcept {
  const Vec3 n = cross(a.direction, b.direction), way = b.point - a.point;
  const double scale = 1 / dot(n, n);
  const double s = scale * dot(way, cross(b.direction, n)), t = scale * dot(way, cross(a.direction, n));
  return 0.5 * (a.point + s * a.direction + b.point + t * b.direction);
}

/// An arm with fixed axes added, so that it has six.
struct Completed {
  ArmGeometry six;
  std::array<int, 6> to_arm;
};

using Attempts = std::array<Completed, 24>;

/// Adds axes through `point` at index `at`: along `directions`, then perpendicular to them and to each other.
Completed completed(const ArmGeometry& arm, std::size_t at, std::initializer_list<Vec3> directions,
                    const Vec3& point) {
  Completed out{arm, {}};
  for (std::size_t k = 0; k < arm.count; ++k) out.to_arm[k] = static_cast<int>(k);
  std::size_t place = at;
  for (const Vec3& direction : directions) {
    for (std::size_t k = out.six.count; k > place; --k) {
      out.six.axes[k] = out.six.axes[k - 1];
      out.to_arm[k] = out.to_arm[k - 1];
    }
    out.six.axes[place] = {normalized(direction), point};
    out.to_arm[place] = -1;
    ++out.six.count;
    ++place;
  }
  return out;
}

/// Other places for a sixth axis that make three neighbours meet or become parallel: beside an axis and
/// parallel to it (the elbow of both is square), radial (it lifts), or in front of all.
void add_elsewhere(const ArmGeometry& arm, Attempts& attempts, std::size_t& count) {
  const double size = length_between_axes(arm);
  const auto add = [&](std::size_t place, const Vec3& direction, const Vec3& point) {
    if (count < attempts.size() && norm(direction) > 1e-3)
      attempts[count++] = completed(arm, place, {direction}, point);
  };
  const auto meeting = [&](std::size_t i) {
    const JointAxis &a = arm.axes[i], &b = arm.axes[i + 1];
    return norm(cross(a.direction, b.direction)) < 0.02 ? b.point : nearest_point(a, b);
  };
  for (const std::size_t i : {std::size_t{1}, std::size_t{0}, std::size_t{2}, std::size_t{3}}) {
    const JointAxis& axis = arm.axes[i];
    const Vec3 aim = i + 2 < arm.count ? meeting(i + 1) : arm.axes[i + 1].point;
    const Vec3 way = aim - axis.point, v = way - dot(way, axis.direction) * axis.direction;
    if (norm(v) < 1e-3 * size) continue;
    const Vec3 aside = cross(axis.direction, v);
    add(i + 1, axis.direction, aim - 0.5 * v + 0.5 * aside);
    add(i + 1, v, aim + aside);
    add(i + 1, arm.axes[i + 1].direction, aim - 0.5 * v + 0.5 * aside);
  }
  const Vec3 aim = meeting(arm.count - 2), &h = arm.axes[0].direction;
  const Vec3 flat = std::abs(h.z) < 0.8 ? normalized(cross(h, {0, 0, 1})) : normalized(cross(h, {0, 1, 0}));
  add(0, flat, aim + 4 * size * cross(h, flat));
}

/// Adds axes at the tool that meet the last one, or one in a wrist whose other two axes meet, or elsewhere.
/// Returns the number of `attempts`.
std::size_t complete_to_six(const ArmGeometry& arm, Attempts& attempts) {
  const std::size_t n = arm.count;
  if (n < 3) return 0;
  const auto &four = arm.axes[n - 2], &last = arm.axes[n - 1];
  const Vec3 h = last.direction;
  const Vec3 foot = last.point + dot(h, arm.tool_position - last.point) * h;
  const Vec3 any = std::abs(h.z) < 0.8 ? cross(h, {0, 0, 1}) : cross(h, {0, 1, 0});
  const Vec3 square = cross(four.direction, h), along = cross(h, square), beside = cross(h, any);
  std::size_t count = 0;
  if (n == 5) {
    const bool slanted = norm(square) >= 0.1;
    attempts[count++] = completed(arm, 5, {slanted ? square : any}, foot);
    attempts[count++] = completed(arm, 5, {slanted ? along : beside}, foot);
    if (slanted) {
      attempts[count++] = completed(arm, 3, {square}, nearest_point(four, last));
      attempts[count++] = completed(arm, 3, {along}, nearest_point(four, last));
    }
    add_elsewhere(arm, attempts, count);
  } else if (n == 4) {
    attempts[count++] = completed(arm, 4, {any, beside}, foot);
  } else {
    attempts[count++] = completed(arm, 3, {any, beside, h}, arm.tool_position);
  }
  return count;
}

constexpr int kOwnStates = 6, kStatesOfNearly = 60;

}  // namespace

/// Treats three to five axes as six with some fixed. The true arm decides which solutions of the six axes are
/// valid.
void InverseKinematics::Arm::find_fewer() {
  const std::size_t n = geometry.count;
  report = fmt::format("no closed form for these {} axes", n);
  Attempts attempts;
  const std::size_t count = complete_to_six(geometry, attempts);
  int best = effort(ArmFamily::none);
  for (std::size_t k = 0; k < count; ++k) {
    if (best == 0) break;
    const SixAxisClass found = classify(attempts[k].six);
    if (effort(found.family) >= best) continue;
    if (n == 5) {
      // Added axes can make the six axes singular everywhere.
      const SixAxisClass before = known;
      const std::array<int, 6> before_axes = to_arm;
      worth_polishing = 0.1;
      settle(found, attempts[k].to_arm);
      // If the six axes fit only nearly, only some of the states may have a solution near enough.
      const int states = found.exact() ? kOwnStates : kStatesOfNearly;
      if (!searched(found.family) && found_of_own_states(states) < states) {
        if (before.family == ArmFamily::none)
          known = {};
        else
          restore(before, before_axes);
        continue;
      }
    } else {
      settle(found, attempts[k].to_arm);
    }
    best = effort(found.family);
    std::string still;
    for (std::size_t i = 0; i < 6; ++i)
      if (attempts[k].to_arm[i] < 0) still += fmt::format("{}{}", still.empty() ? "" : " and ", i + 1);
    report = fmt::format("{} axes, solved as six of which {} {} still: {}",
                         n == 5   ? "five"
                         : n == 4 ? "four"
                                  : "three",
                         n == 5 ? fmt::format("axis {}", still) : fmt::format("axes {}", still),
                         n == 5 ? "stands" : "stand", describe_known());
  }
  if (formed()) worth_polishing = n < 5 ? 10 : 0.1;
}

/// The same for an arm that is too far from ideal to find all branches: chooses the form that recovers most
/// of a few states of the arm.
void InverseKinematics::Arm::find_start_of_fewer() {
  constexpr int kStates = 8;
  Attempts attempts;
  const std::size_t count = complete_to_six(geometry, attempts);
  std::optional<IdealStart> best;
  int most = kStates / 2;
  for (std::size_t k = 0; k < count && most < kStates; ++k) {
    const SixAxisClass seen = classify(attempts[k].six, kWidestStart);
    if (seen.family == ArmFamily::none || searched(seen.family) || seen.exact()) continue;
    std::array<int, 6> axes = attempts[k].to_arm;
    if (seen.from_tool) std::reverse(axes.begin(), axes.end());
    start = start_of(seen, axes);
    const int found = states_found_from_start(kStates);
    if (found <= most) continue;
    most = found;
    best = start;
  }
  start = best;
}

}  // namespace polyarm::ik
