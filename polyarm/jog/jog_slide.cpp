/// The part of the jog generator that keeps motions off barriers and off the boundaries of the workspace, and
/// lets them slide along.
#include <algorithm>
#include <cmath>

#include "polyarm/jog/jog_generator.hpp"

namespace polyarm::jog {

namespace {
/// Room that is left before barriers and before boundaries of the workspace, m or rad, by slowing down.
constexpr double kKeepOff = 5e-4, kKeepFree = 2e-3;
/// Passes in which rates slide along them.
constexpr int kSlides = 6;
/// Motion that closes in on a barrier by less than this share of what the joints do there goes along it.
constexpr double kAlong = 1e-3;
}  // namespace

/// The rates may change by these shares of themselves per s and s².
JogGenerator::Pull JogGenerator::pull_of(std::span<const double> rates, Before before) const noexcept {
  Pull out{1e300, 1e300};
  for (std::size_t j = 0; j < axes_.size(); ++j) {
    const double r = std::max(std::abs(rates[j]), 1e-12);
    out.acceleration = std::min(out.acceleration, before.acceleration * axes_[j].acceleration / r);
    out.jerk = std::min(out.jerk, before.jerk * axes_[j].jerk / r);
  }
  return out;
}

JogValues JogGenerator::positions() const noexcept {
  JogValues out{};
  for (std::size_t j = 0; j < axes_.size(); ++j) out[j] = state_[j].position;
  return out;
}

/// False for a boundary that does not count in the present profile.
bool JogGenerator::find_limit(std::size_t i, const JogValues& q, Limit& out) const noexcept {
  const std::size_t n = axes_.size(), bodies = barriers_ ? barriers_->count : 0;
  if (i < bodies) {
    out.room = barriers_->room(i, {q.data(), n}) - kKeepOff;
    std::copy_n(barriers_->all[i].gradient.begin(), n, out.gradient.begin());
    out.hold = JogHold::body;
    out.which = static_cast<std::size_t>(barriers_->which(i));
    out.slides = barriers_->all[i].slides;
    out.turns = false;
    return true;
  }
  i -= bodies;
  if (!workspace_.counts(i, reduced_)) return false;
  const moves::Workspace::Distance d = workspace_.distance(i, tcp(), {q.data(), n});
  out.room = d.distance - kKeepFree;
  solver_.gradient_of({d.away.x, d.away.y, d.away.z, d.turn.x, d.turn.y, d.turn.z}, out.gradient);
  if (d.joint >= 0) out.gradient[static_cast<std::size_t>(d.joint)] += d.sign;
  out.hold = JogHold::workspace;
  out.which = workspace_.zone_of(i);
  out.slides = out.turns = d.joint < 0;
  return true;
}

double JogGenerator::closing_of(const Limit& limit, std::span<const double> rates) const noexcept {
  double out = 0;
  for (std::size_t j = 0; j < rates.size(); ++j) out -= limit.gradient[j] * rates[j];
  return out;
}

/// The share of `rates` with which the joints can still stop before a limit.
double JogGenerator::share_before(const Limit& limit, std::span<const double> rates, double a,
                                  double jerk) const noexcept {
  const double closing = closing_of(limit, rates);
  double size = 0;
  for (std::size_t j = 0; j < rates.size(); ++j) size += std::abs(limit.gradient[j] * rates[j]);
  if (closing <= kAlong * size + 1e-6) return 1;
  return stopping_speed(std::max(0.0, limit.room) / closing, a, jerk);
}

/// Joints of which the wish moves several go on along a limit: each is reduced by what it adds to closing in.
void JogGenerator::slide_joints(JogValues& rates) noexcept {
  const std::size_t n = axes_.size();
  const JogValues q = positions();
  Limit limit;
  for (int pass = 0; pass < kSlides; ++pass) {
    bool changed = false;
    for (std::size_t i = 0; i < near_limits(); ++i) {
      if (!find_limit(i, q, limit)) continue;
      const auto [a, jerk] = pull_of({rates.data(), n}, kFirmly);
      const double share = share_before(limit, {rates.data(), n}, a, jerk);
      if (share >= 1) continue;
      const double closing = closing_of(limit, {rates.data(), n});
      double adds = 0;
      for (std::size_t j = 0; j < n; ++j) adds += std::max(0.0, -limit.gradient[j] * rates[j]);
      const double keep = std::max(0.0, 1 - (1 - share) * closing / adds);
      for (std::size_t j = 0; j < n; ++j)
        if (-limit.gradient[j] * rates[j] > 0) rates[j] *= keep;
      note(limit.hold, limit.which);
      changed = true;
    }
    if (!changed) return;
  }
}

/// A twist that closes in on a limit along which it slides loses that part and keeps what goes along it. A
/// pure translation stays one. True if it loses anything.
bool JogGenerator::slide_tcp(Twist& wanted) noexcept {
  const std::size_t n = axes_.size();
  const double speed = linear(wanted), turning = angular(wanted);
  if (near_limits() == 0 || (speed == 0 && turning == 0)) return false;
  std::array<JogValues, 6> unit;  // joint velocities for each part of a twist
  for (std::size_t k = 0; k < 6; ++k) {
    Twist one{};
    one[k] = 1;
    solver_.reach(one, unit[k]);
  }
  const JogValues q = positions();
  JogValues rates;
  Limit limit;
  bool slides = false;
  for (int pass = 0; pass < kSlides; ++pass) {
    bool changed = false;
    for (std::size_t i = 0; i < near_limits(); ++i) {
      if (!find_limit(i, q, limit) || !((limit.slides && speed > 0) || (limit.turns && turning > 0)))
        continue;
      for (std::size_t j = 0; j < n; ++j) {
        rates[j] = 0;
        for (std::size_t k = 0; k < 6; ++k) rates[j] += wanted[k] * unit[k][j];
      }
      const auto [a, jerk] = pull_of({rates.data(), n}, kGently);
      const double share = share_before(limit, {rates.data(), n}, a, jerk);
      if (share >= 0.999) continue;
      Twist along{};  // how the room grows with each part of the twist, weighed
      double size = 0;
      for (std::size_t k = 0; k < 6; ++k) {
        const double weight = k < 3 ? (limit.slides && speed > 0 ? 1 : 0)
                                    : (limit.turns && turning > 0 ? 1 / (length_ * length_) : 0);
        const double grows = -closing_of(limit, {unit[k].data(), n});
        along[k] = weight * grows;
        size += weight * grows * grows;
      }
      if (size < 1e-6) continue;
      const double excess = (1 - share) * closing_of(limit, {rates.data(), n});
      for (std::size_t k = 0; k < 6; ++k) wanted[k] += along[k] * excess / size;
      note(limit.hold, limit.which);
      changed = slides = true;
    }
    if (!changed) break;
  }
  const double faster =
      std::max(speed > 0 ? linear(wanted) / speed : 1, turning > 0 ? angular(wanted) / turning : 1);
  if (faster > 1)
    for (double& x : wanted) x /= faster;
  return slides;
}

}  // namespace polyarm::jog
