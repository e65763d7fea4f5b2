/// The part of the jog generator that keeps a TCP on a line.
#include <algorithm>
#include <cmath>

#include "polyarm/jog/jog_generator.hpp"

namespace polyarm::jog {

namespace {
/// Rate at which the TCP returns to its line, 1/s, and the farthest that it returns from, m.
constexpr double kBack = 5, kTooFar = 5e-4;
/// The TCP may be this far behind its place on the line, m or rad, before the place moves back.
constexpr double kBehind = 2e-4;
/// A motion has a direction up to this share of it.
constexpr double kAside = 1e-6;
/// Motion that closes in on a limit by less than this share of what the joints do there goes along it.
constexpr double kAlongIt = 1e-3;
/// Room that is left before barriers on the line, m; where less is left already, motion along them may take
/// kDips of it, down to kTight.
constexpr double kKeepOffAhead = 5e-4, kDips = 2e-4, kTight = 1e-4;

double size_of(const Twist& t) {
  return linear(t) > 0 ? linear(t) : angular(t);
}
Twist scaled(const Twist& t, double by) {
  Twist out = t;
  for (double& x : out) x *= by;
  return out;
}
double dot_of(const Twist& a, const Twist& b) {
  double out = 0;
  for (std::size_t k = 0; k < 6; ++k) out += a[k] * b[k];
  return out;
}
/// True if `t` is `along` times a number; that is `share`.
bool is_along(const Twist& t, const Twist& along, double& share) {
  share = dot_of(t, along) / dot_of(along, along);
  double off = 0;
  for (std::size_t k = 0; k < 6; ++k) off = std::max(off, std::abs(t[k] - share * along[k]));
  return off <= kAside * std::max(std::sqrt(dot_of(t, t)), 1e-3);
}
/// True if joint velocities bring a room with this gradient down; what hardly does goes along it.
bool is_closing(const JogValues& gradient, std::span<const double> rates) {
  double closing = 0, size = 0;
  for (std::size_t j = 0; j < rates.size(); ++j) {
    closing -= gradient[j] * rates[j];
    size += std::abs(gradient[j] * rates[j]);
  }
  return closing > kAlongIt * size + 1e-9;
}
}  // namespace

/// Where the joints on the line first come nearer to a barrier than they may, as it looks from here.
JogLine::Stop JogGenerator::barrier_ahead(std::span<const double> tangent) const noexcept {
  JogLine::Stop out;
  if (!barriers_) return out;
  const std::size_t n = axes_.size();
  const JogValues q = positions();
  for (std::size_t i = 0; i <= barriers_->count; ++i) {
    const double here = barriers_->room(i, {q.data(), n});
    if (!std::isfinite(here)) continue;
    if (i < barriers_->count && here <= kTight && is_closing(barriers_->all[i].gradient, tangent))
      return {0, JogHold::body, static_cast<std::size_t>(barriers_->which(i))};
    const double least =
        here < kTight + kDips / 2 ? here - kDips / 4 : std::clamp(here - kDips, kTight, kKeepOffAhead);
    double before = here, way = 0;
    for (std::size_t k = 0; k < line_.places(); ++k) {
      const double ahead = line_.ahead(k);
      if (ahead <= 0) continue;
      if (ahead > out.room) break;
      const double room = barriers_->room(i, line_.joints_at(k));
      if (room < least) {
        const double share = before > room ? std::clamp((before - least) / (before - room), 0.0, 1.0) : 1.0;
        out = {way + share * (ahead - way), JogHold::body, static_cast<std::size_t>(barriers_->which(i))};
        break;
      }
      before = room;
      way = ahead;
    }
  }
  return out;
}

/// How far the line may go on before the nearest limit, as it looks from here. `tangent`: of the joints.
JogLine::Stop JogGenerator::stop_ahead(std::span<const double> tangent) const noexcept {
  JogLine::Stop out = barrier_ahead(tangent);
  const JogValues q = positions();
  Limit limit;
  for (std::size_t i = barriers_ ? barriers_->count : 0; i < near_limits(); ++i) {
    if (!find_limit(i, q, limit)) continue;
    if (!is_closing(limit.gradient, tangent)) continue;
    const double room = std::max(0.0, limit.room) / closing_of(limit, tangent);
    if (room < out.room) out = {room, limit.hold, limit.which};
  }
  return out;
}

/// A line begins where the lead moves in its direction, or stands.
bool JogGenerator::begin_line(const JogSetpoint& wish, const Twist& wanted, double size) noexcept {
  const Twist unit = scaled(wanted, 1 / size);
  double speed = 0, slope = 0;
  if (!is_along(lead_.twist(), unit, speed) || !is_along(lead_.slope(), unit, slope) || speed < 0)
    return false;
  line_wish_ = scaled(wish.twist, 1 / size_of(wish.twist));
  line_of_tool_ = wish.tool_frame;
  const bool begins = line_.begin({soon_.data(), axes_.size()}, lead_.pose(), unit,
                                  wish.tool_frame && linear(wanted) > 0, speed, slope);
  if (!begins) note(JogHold::singularity, 0);
  return begins;
}

/// The joint velocities with which the TCP stays on its line. False if it has none.
bool JogGenerator::setpoint_on_line(const JogSetpoint& wish, const Twist& wanted, const JogLimits& limits,
                                    JogValues& rates) noexcept {
  const double size = size_of(wanted);
  const bool moves = wish.kind == JogSetpoint::Kind::tcp_velocity && size > 0;
  double goal = 0, share = 0;
  if (line_.on() && moves) {
    const bool same = is_along(scaled(wish.twist, 1 / size_of(wish.twist)), line_wish_, share) &&
                      (wish.tool_frame == line_of_tool_);
    if (same && share > 0)
      goal = size;
    else if (!same || line_.stands())
      line_.end();
  }
  if (!line_.on()) {
    if (!moves || !begin_line(wish, wanted, size)) return false;
    goal = size;
  }
  const std::span<const double> soon{soon_.data(), axes_.size()};
  JogValues tangent;
  // Before a singularity on the line it stands.
  const bool goes_on = line_.rates_for(line_.direction(), soon, solver_, tangent);
  line_.step(goes_on ? goal : 0, limits.joint_share, stop_ahead({tangent.data(), axes_.size()}));
  if (moves && !goes_on) note(JogHold::singularity, 0);
  if (moves) note(line_.hold(), line_.which());
  if (std::abs(dot_of(error_on_line(), line_.direction())) > kBehind) line_.fall_back(tcp(), twist_now());
  const Twist error = error_on_line();
  if (linear(error) > kTooFar || angular(error) > kTooFar / length_) {
    lead_.return_to(tcp());
    line_.end();
    solver_.at(soon);  // without the weights of the line
    return false;
  }
  rates_on_line(rates);
  return true;
}

/// From the TCP to its place on the line. An arm of four joints turns as far as it can; one of five has to
/// turn as it moves along.
Twist JogGenerator::error_on_line() const noexcept {
  Twist error = between(tcp(), line_.pose());
  if (solver_.columns() >= 6) return error;
  JogValues turning{};
  if (solver_.columns() < 5) solver_.exact({0, 0, 0, error[3], error[4], error[5]}, turning);
  const Twist can = solver_.twist_of({turning.data(), axes_.size()});
  for (std::size_t k = 3; k < 6; ++k) error[k] = can[k];
  return error;
}

/// Takes the lead to the place on the line, and the joints with it.
void JogGenerator::rates_on_line(JogValues& rates) noexcept {
  const Twist direction = line_.direction(), error = error_on_line();
  Twist twist = scaled(direction, line_.speed());
  lead_.set(line_.pose(), twist, scaled(direction, line_.slope()));
  for (std::size_t k = 0; k < 6; ++k) twist[k] += kBack * error[k];
  line_.rates_for(twist, {soon_.data(), axes_.size()}, solver_, rates);
}

/// The states when the motion brakes on its line in this cycle. False if it is on none.
bool JogGenerator::brake_on_line(const JogLimits& limits, States& out) noexcept {
  if (!line_.on()) return false;
  line_.brake_instead();
  JogValues rates;
  rates_on_line(rates);
  rates_ = rates_before_;
  follow(rates, limits, out);
  rates_ = rates;
  return true;
}

}  // namespace polyarm::jog
