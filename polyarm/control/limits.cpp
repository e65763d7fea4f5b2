#include "polyarm/control/limits.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "polyarm/base/pair.hpp"

namespace polyarm::control {

using controllers::Limit;

namespace {
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
/// A planned step may reach its limit exactly; rounding must not count as a clamp.
constexpr double kSlack = 1 + 1e-6;

std::int32_t state_of(const hardware::InterfaceTable& table, const std::string& name) {
  const auto found = table.find_state(name);
  return found ? static_cast<std::int32_t>(*found) : -1;
}

/// Default values of acceleration and jerk, which planning assumes, do not limit commands here.
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
/// How far a velocity command may move a standing joint, rad or m; controllers that correct a position need
/// it.
constexpr double kStillBand = 0.02;

/// True if the velocity would move a standing joint, which is `off` from its place, out of its band. Without
/// a measured position (NaN) any velocity would.
bool leads_away(double velocity, double off) noexcept {
  if (velocity == 0) return false;
  return !(std::abs(off) <= kStillBand) && !(velocity * off < 0);
}
}  // namespace

void CommandLimits::add_plain(const controllers::LimiterSettings& settings, std::uint32_t command,
                              std::int32_t state) {
  plain_.lower.push_back(settings.lower);
  plain_.upper.push_back(settings.upper);
  plain_.step.push_back(settings.velocity * dt_);
  plain_.given.push_back(kNone);
  plain_.command.push_back(command);
  plain_.state.push_back(state);
  plain_.turns.push_back(1);
  plain_.since.push_back(1);
  plain_.outside.push_back(0);
}

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
    add_plain(settings, index, position);
  else
    full_.push_back(
        {index, position, state_of(table, joint.name + "/velocity"), kind, settings, kNone, kNone, kNone});
}

void CommandLimits::build(const hardware::InterfaceTable& table,
                          const std::vector<controllers::JointFacts>& joints, Nanoseconds period) {
  plain_ = {};
  plain_as_usual_ = false;
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
  records_ = std::make_unique<Record[]>(names_.size() * controllers::kLimits);
}

void CommandLimits::set_turns(const std::string& prefix, unsigned cycles) {
  const auto is_meant = [&](std::uint32_t command) {
    return names_[static_cast<std::size_t>(place_[command])].starts_with(prefix);
  };
  for (std::size_t i = 0; i < plain_.command.size(); ++i)
    if (is_meant(plain_.command[i])) plain_.turns[i] = std::max(1u, cycles);
  for (Full& f : full_)
    if (is_meant(f.command)) f.turns = std::max(1u, cycles);
  plain_as_usual_ = false;
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
                        std::uint64_t cycle, bool still, hardware::FaultEvents& faults) noexcept {
  const double asked = commands[f.command];
  if (std::isnan(asked) && std::isnan(f.given)) return;  // never commanded
  const auto state = [&](std::int32_t place) {
    return place < 0 ? kNone : states[static_cast<std::size_t>(place)];
  };
  f.since = std::min(f.since + 1, f.turns);
  if (asked == f.given && f.since < f.turns && !still) return;  // not its turn to change
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
  judge(f.command, now.position, allowed.fault, f.outside, faults);
  if (allowed.cause != Limit::none) note(cycle, f.command, allowed.cause, asked, allowed.value);
  f.before = f.given;
  f.span = std::exchange(f.since, 0u);
  commands[f.command] = f.given = allowed.value;
}

void CommandLimits::forget(std::size_t first, std::size_t count) noexcept {
  const auto is_meant = [=](std::uint32_t command) { return command >= first && command < first + count; };
  for (std::size_t i = 0; i < plain_.command.size(); ++i)
    if (is_meant(plain_.command[i])) plain_.given[i] = kNone;
  for (Full& f : full_)
    if (is_meant(f.command)) f.given = f.before = kNone;
}

void CommandLimits::one_plain(std::size_t i, double share, std::span<double> commands,
                              std::span<const double> states, std::uint64_t cycle, bool still,
                              hardware::FaultEvents& faults) noexcept {
  const std::uint32_t command = plain_.command[i];
  const double asked = commands[command], lower = plain_.lower[i], upper = plain_.upper[i];
  double& last = plain_.given[i];
  if (std::isnan(asked) && std::isnan(last)) return;  // never commanded
  const double at = plain_.state[i] >= 0 ? states[static_cast<std::size_t>(plain_.state[i])] : kNone;
  if (std::isnan(last)) last = std::isfinite(at) ? at : asked;
  judge(command, at, at > upper + controllers::kFaultBeyond || at < lower - controllers::kFaultBeyond,
        plain_.outside[i], faults);
  double given = std::isfinite(asked) ? asked : last;
  const double inside = std::clamp(given, std::min(lower, last), std::max(upper, last));
  unsigned& since = plain_.since[i];
  since = std::min(since + 1, plain_.turns[i]);
  const double step = plain_.step[i] * share * since;
  given = still ? last : std::clamp(inside, last - step, last + step);
  if (given != last) since = 0;
  if (given != asked)
    note(cycle, command,
         !std::isfinite(asked) ? Limit::not_a_number
         : still               ? Limit::held
         : given != inside     ? Limit::velocity
                               : Limit::position,
         asked, given);
  commands[command] = last = given;
}

/// True if both commands and both measured positions are within the limits. The usual case; false for NaN.
inline bool CommandLimits::pair_is_fine(std::size_t i, Pair asked, Pair at, double share) const noexcept {
  const Pair lower = load_pair(&plain_.lower[i]), upper = load_pair(&plain_.upper[i]);
  const Pair last = load_pair(&plain_.given[i]), step = load_pair(&plain_.step[i]) * share;
  const PairTest near = at_most(last - step, asked) & at_most(asked, last + step);
  const PairTest inside =
      (at_most(lower, asked) | at_most(last, asked)) & (at_most(asked, upper) | at_most(asked, last));
  const PairTest measured =
      at_most(at, upper + controllers::kFaultBeyond) & at_most(lower - controllers::kFaultBeyond, at);
  return (near & inside & measured).both();
}

/// Handles the usual case two joints at a time, while both commands are within their limits. Returns the
/// index at which that ends.
inline std::size_t CommandLimits::pass_pairs(std::size_t i, double share, const double* commands,
                                             const double* states) noexcept {
  const std::uint32_t* const command = plain_.command.data();
  const std::int32_t* const state = plain_.state.data();
  double* const given = plain_.given.data();
  for (const std::size_t n = plain_.command.size(); i + 2 <= n; i += 2) {
    const Pair asked{commands[command[i]], commands[command[i + 1]]};
    if (!pair_is_fine(i, asked, Pair{states[state[i]], states[state[i + 1]]}, share)) break;
    store_pair(given + i, asked);
  }
  return i;
}

void CommandLimits::limit_plain(double share, std::span<double> commands, std::span<const double> states,
                                std::uint64_t cycle, bool still, hardware::FaultEvents& faults) noexcept {
  const std::size_t n = plain_.command.size();
  const bool as_usual = plain_as_usual_ && !still;
  plain_as_usual_ = true;
  for (std::size_t i = 0; i < n;) {
    if (as_usual) i = pass_pairs(i, share, commands.data(), states.data());
    for (const std::size_t end = std::min(i + 2, n); i < end; ++i) {
      one_plain(i, share, commands, states, cycle, still, faults);
      if (plain_.state[i] < 0 || plain_.turns[i] != 1 || plain_.outside[i]) plain_as_usual_ = false;
    }
  }
}

void CommandLimits::restrict(std::span<double> commands, std::span<const double> states, std::uint64_t cycle,
                             bool still, hardware::FaultEvents& faults) noexcept {
  const double share = share_.load(std::memory_order_relaxed);
  if (still && !still_)
    for (Full& f : full_) f.stood = f.position < 0 ? kNone : states[static_cast<std::size_t>(f.position)];
  still_ = still;
  limit_plain(share, commands, states, cycle, still, faults);
  for (Full& f : full_) one(f, share, commands, states, cycle, still, faults);
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
