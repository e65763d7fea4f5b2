#include "polyarm/control/limits.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace polyarm::control {

using controllers::Limit;

namespace {
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
/// A planned step may touch its limit exactly; rounding must not count as a clamp.
constexpr double kSlack = 1 + 1e-6;

std::int32_t state_of(const hardware::InterfaceTable& table, const std::string& name) {
  const auto found = table.find_state(name);
  return found ? static_cast<std::int32_t>(*found) : -1;
}

/// Acceleration and jerk that nobody stated were assumed for planning and limit nothing here.
controllers::LimiterSettings settings_of(const controllers::JointFacts& joint) {
  controllers::LimiterSettings out;
  out.lower = joint.lower;
  out.upper = joint.upper;
  if (joint.states_velocity) out.velocity = joint.velocity * kSlack;
  if (joint.states_acceleration) out.acceleration = joint.acceleration * kSlack;
  if (joint.states_acceleration && joint.deceleration < controllers::kUnlimited)
    out.deceleration = joint.deceleration * kSlack;
  if (joint.states_jerk) out.jerk = joint.jerk * kSlack;
  out.effort = joint.effort;
  out.soft = joint.soft.has_value();
  if (joint.soft) out.soft_limits = *joint.soft;
  return out;
}
/// How far a velocity may take a joint that stands still, rad or m: what a controller needs that corrects.
constexpr double kStillBand = 0.02;

/// Does the velocity take a joint that stands still, and is `off` from where it stood, out of its band?
/// Without a measured position (NaN) any velocity does.
bool leads_away(double velocity, double off) noexcept {
  if (velocity == 0) return false;
  return !(std::abs(off) <= kStillBand) && !(velocity * off < 0);
}
}  // namespace

void CommandLimits::add(const hardware::InterfaceTable& table, const controllers::JointFacts& joint,
                        const char* quantity, Quantity kind) {
  const std::string whole = joint.name + "/" + quantity;
  const auto command = table.find_command(whole);
  if (!command) return;
  place_[*command] = static_cast<std::int32_t>(names_.size());
  names_.push_back(whole);
  const controllers::LimiterSettings settings = settings_of(joint);
  const auto index = static_cast<std::uint32_t>(*command);
  const std::int32_t position = state_of(table, joint.name + "/position");
  if (kind == Quantity::position && !settings.soft && settings.acceleration == controllers::kUnlimited)
    plain_.push_back({index, position, settings.lower, settings.upper, settings.velocity * dt_, kNone});
  else
    full_.push_back(
        {index, position, state_of(table, joint.name + "/velocity"), kind, settings, kNone, kNone, kNone});
}

void CommandLimits::build(const hardware::InterfaceTable& table,
                          const std::vector<controllers::JointFacts>& joints, Nanoseconds period) {
  plain_.clear();
  full_.clear();
  names_.clear();
  place_.assign(table.commands().size(), -1);
  still_ = false;
  dt_ = seconds(period);
  for (const controllers::JointFacts& joint : joints) {
    add(table, joint, "position", Quantity::position);
    add(table, joint, "velocity", Quantity::velocity);
    add(table, joint, "acceleration", Quantity::acceleration);
    add(table, joint, "effort", Quantity::effort);
  }
  faults_.clear();
  faults_.reserve(names_.size());
  records_ = std::make_unique<Record[]>(names_.size() * controllers::kLimits);
}

void CommandLimits::set_turns(const std::string& prefix, unsigned cycles) {
  const auto set = [&](auto& one) {
    if (names_[static_cast<std::size_t>(place_[one.command])].starts_with(prefix))
      one.turns = std::max(1u, cycles);
  };
  std::for_each(plain_.begin(), plain_.end(), set);
  std::for_each(full_.begin(), full_.end(), set);
}

void CommandLimits::note(std::uint64_t cycle, std::uint32_t command, Limit limit, double asked,
                         double given) noexcept {
  clamps_.store(clamps_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  Record& record = records_[static_cast<std::size_t>(place_[command]) * controllers::kLimits +
                            static_cast<std::size_t>(limit)];
  record.count.store(record.count.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  record.cycle.store(cycle, std::memory_order_relaxed);
  record.asked.store(asked, std::memory_order_relaxed);
  record.given.store(given, std::memory_order_relaxed);
}

void CommandLimits::one(Full& f, double share, std::span<double> commands, std::span<const double> states,
                        std::uint64_t cycle, bool still) noexcept {
  const double asked = commands[f.command];
  if (std::isnan(asked) && std::isnan(f.given)) return;  // never commanded
  const auto state = [&](std::int32_t place) {
    return place < 0 ? kNone : states[static_cast<std::size_t>(place)];
  };
  f.since = std::min(f.since + 1, f.turns);
  if (asked == f.given && f.since < f.turns && !still) return;  // it is not its turn
  const double dt = dt_ * f.since;
  const controllers::JointNow now{state(f.position), state(f.velocity)};
  controllers::LimiterSettings settings = f.settings;
  settings.velocity *= share;
  controllers::Allowed allowed{asked};
  switch (f.quantity) {
    case Quantity::position: {
      if (std::isnan(f.given)) {
        f.given = std::isfinite(now.position) ? now.position : asked;
        f.before = f.given;
      }
      const double speed = (f.given - f.before) / (dt_ * f.span);
      allowed = controllers::allow_position(settings, now, asked, f.given, speed, dt);
      if (still && allowed.value != f.given) allowed = {f.given, Limit::held, allowed.fault};
      break;
    }
    case Quantity::velocity:
      if (std::isnan(f.given)) f.given = std::isfinite(now.velocity) ? now.velocity : 0;
      allowed = controllers::allow_velocity(settings, now, asked, f.given, dt);
      if (still && leads_away(allowed.value, now.position - f.stood))
        allowed = {0, Limit::held, allowed.fault};
      break;
    case Quantity::acceleration:
      allowed = controllers::allow_acceleration(settings, now, asked, f.given, dt);
      break;
    case Quantity::effort:
      allowed = controllers::allow_effort(settings, now, asked);
      break;
  }
  judge(f.command, allowed.fault, f.outside);
  if (allowed.cause != Limit::none) note(cycle, f.command, allowed.cause, asked, allowed.value);
  f.before = f.given;
  f.span = std::exchange(f.since, 0u);
  commands[f.command] = f.given = allowed.value;
}

void CommandLimits::forget(std::size_t first, std::size_t count) noexcept {
  for (Plain& p : plain_)
    if (p.command >= first && p.command < first + count) p.given = kNone;
  for (Full& f : full_)
    if (f.command >= first && f.command < first + count) f.given = f.before = kNone;
}

void CommandLimits::one(Plain& p, double share, std::span<double> commands, std::span<const double> states,
                        std::uint64_t cycle, bool still) noexcept {
  const double asked = commands[p.command];
  if (std::isnan(asked) && std::isnan(p.given)) return;  // never commanded
  const double at = p.state >= 0 ? states[static_cast<std::size_t>(p.state)] : kNone;
  if (std::isnan(p.given)) p.given = std::isfinite(at) ? at : asked;
  judge(p.command, at > p.upper + controllers::kFaultBeyond || at < p.lower - controllers::kFaultBeyond,
        p.outside);
  double given = std::isfinite(asked) ? asked : p.given;
  const double inside = std::clamp(given, std::min(p.lower, p.given), std::max(p.upper, p.given));
  p.since = std::min(p.since + 1, p.turns);
  const double step = p.step * share * p.since;
  given = still ? p.given : std::clamp(inside, p.given - step, p.given + step);
  if (given != p.given) p.since = 0;
  if (given != asked)
    note(cycle, p.command,
         !std::isfinite(asked) ? Limit::not_a_number
         : still               ? Limit::held
         : given != inside     ? Limit::velocity
                               : Limit::position,
         asked, given);
  commands[p.command] = p.given = given;
}

void CommandLimits::restrict(std::span<double> commands, std::span<const double> states, std::uint64_t cycle,
                             bool still) noexcept {
  const double share = share_.load(std::memory_order_relaxed);
  faults_.clear();
  if (still && !still_)
    for (Full& f : full_) f.stood = f.position < 0 ? kNone : states[static_cast<std::size_t>(f.position)];
  still_ = still;
  for (Plain& p : plain_) one(p, share, commands, states, cycle, still);
  for (Full& f : full_) one(f, share, commands, states, cycle, still);
}

std::vector<Clamp> CommandLimits::report() const {
  std::vector<Clamp> out;
  for (std::size_t i = 0; i < names_.size(); ++i)
    for (std::size_t k = 0; k < controllers::kLimits; ++k) {
      const Record& record = records_[i * controllers::kLimits + k];
      if (record.count.load(std::memory_order_relaxed) == 0) continue;
      out.push_back({names_[i], static_cast<Limit>(k), record.asked.load(), record.given.load(),
                     record.count.load(), record.cycle.load()});
    }
  std::sort(out.begin(), out.end(), [](const Clamp& a, const Clamp& b) { return a.cycle > b.cycle; });
  return out;
}

}  // namespace polyarm::control
