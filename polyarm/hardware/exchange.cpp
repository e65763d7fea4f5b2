#include "polyarm/hardware/exchange.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "polyarm/base/pair.hpp"
#include "polyarm/hardware/hosted.hpp"

namespace polyarm::hardware {

namespace {
constexpr double kNoCommand = std::numeric_limits<double>::quiet_NaN();
/// For a joint without a velocity limit; finite, so products do not become NaN.
constexpr double kAnySpeed = 1e38;

bool due(const HostedComponent& hosted, const Cycle& cycle) noexcept {
  return hosted.divisor == 1 || cycle.index % hosted.divisor == 0;
}

StopCause cause_of(ReturnType result) noexcept {
  return result == ReturnType::deactivate ? StopCause::deactivated : StopCause::component;
}

void switch_off_component(HostedComponent& hosted, StopCause cause) noexcept {
  hosted.fallen = reported(cause);
  hosted.writing = false;
  hosted.reading = cause == StopCause::deactivated;  // an inactive component is still read
  if (hosted.own_clock && !hosted.reading) hosted.own_clock->close();
}

/// True if `other` fails together with `failed`: components of one group do. If the rest of the loop
/// continues, they are also deactivated together.
bool fails_with(const HostedComponent& other, const HostedComponent& failed, bool deactivated) noexcept {
  if (failed.options.group.empty() || other.options.group != failed.options.group) return false;
  return !deactivated || (failed.options.contained && other.writing);
}
}  // namespace

void Exchange::watch(const std::vector<WatchedJoint>& joints, Nanoseconds period) {
  following_cycles_ = static_cast<std::uint32_t>(kFollowingTime / period);
  for (const auto& hosted : hosting_.all) {
    hosted->watched = {};
    hosted->following.clear();
    for (const WatchedJoint& joint : joints)
      if (joint.state >= hosted->first_state && joint.state < hosted->first_state + hosted->states) {
        hosted->watched.state.push_back(static_cast<std::uint32_t>(joint.state));
        hosted->watched.speed.push_back(std::min(kJumpFactor * joint.velocity, kAnySpeed));
        hosted->following.push_back({joint.command});
      }
    hosted->watched.last.resize(hosted->watched.state.size());
    hosted->watched.forget();
  }
}

std::optional<bool> Exchange::await_cycle(Nanoseconds timeout) noexcept {
  if (hosting_.pacer < 0) return std::nullopt;
  HostedComponent& hosted = *hosting_.all[static_cast<std::size_t>(hosting_.pacer)];
  if (!hosted.writing) return std::nullopt;
  hosting_.in_call.store(hosting_.pacer, std::memory_order_relaxed);
  const bool came = hosted.component->await_cycle(timeout);
  hosting_.in_call.store(-1, std::memory_order_relaxed);
  return came;
}

// --- reading ----------------------------------------------------------------------------------------------

inline ReturnType Exchange::read_async(HostedComponent& hosted, std::span<double> states,
                                       Exchanged& exchanged) noexcept {
  if (!hosted.runner->idle() || !hosted.ran.load(std::memory_order_acquire)) return ReturnType::ok;
  exchanged = hosted.own_exchanged;
  std::copy(hosted.own_states.begin(), hosted.own_states.end(), states.begin());
  return hosted.own_result.exchange(ReturnType::ok, std::memory_order_acq_rel);  // a failure is reported once
}

inline ReturnType Exchange::read_one(std::size_t i, const Cycle& cycle, Exchanged& exchanged) noexcept {
  HostedComponent& hosted = *hosting_.all[i];
  const auto states = hosting_.table.states().subspan(hosted.first_state, hosted.states);
  if (hosted.own_clock) return hosted.own_clock->take(states, exchanged).value_or(ReturnType::ok);
  if (hosted.runner) return read_async(hosted, states, exchanged);
  Cycle longer = cycle;
  longer.period *= hosted.divisor;
  return hosting_.overruns.timed(hosted.budget, static_cast<std::int32_t>(i), "read", cycle.index,
                                 [&] { return hosted.component->read(longer, states); });
}

/// Longest possible time between the measurement of these states and of the previous ones, s.
inline double Exchange::between_reads(HostedComponent& hosted, const Cycle& cycle,
                                      const Exchanged& exchanged) noexcept {
  Nanoseconds longest = cycle.period * hosted.divisor;
  if (!hosted.has_thread())
    longest += skipped_ - std::exchange(hosted.skips_seen, skipped_);
  else if (exchanged.ended > 0)
    longest = std::max(hosted.own_clock ? hosted.own_clock->period() : longest,
                       exchanged.ended - std::exchange(hosted.exchange_began, exchanged.began));
  return seconds(longest);
}

/// Checks whether the new position is possible; reports a fault otherwise.
bool Exchange::judge_state(std::size_t i, std::size_t k, double between, FaultEvents& faults) noexcept {
  Watched& watched = hosting_.all[i]->watched;
  const std::uint32_t state = watched.state[k];
  const double now = hosting_.table.states()[state], last = watched.last[k];
  if (std::isfinite(now)) watched.last[k] = now;
  if (std::isnan(last) || std::abs(now - last) <= watched.speed[k] * between + kJumpFloor) return true;
  const StopCause cause = std::isfinite(now) ? StopCause::jump : StopCause::not_a_number;
  faults.push({cause, static_cast<std::int32_t>(i), static_cast<std::int32_t>(state), -1, now});
  return false;
}

/// Checks whether the new positions are possible; reports the first fault.
inline void Exchange::judge_states(std::size_t i, double between, FaultEvents& faults) noexcept {
  Watched& watched = hosting_.all[i]->watched;
  const double* const states = hosting_.table.states().data();
  const std::uint32_t* const state = watched.state.data();
  const double* const speed = watched.speed.data();
  double* const last = watched.last.data();
  const std::size_t n = watched.state.size();
  for (std::size_t k = 0; k < n; k += 2) {
    if (k + 1 < n) {
      const Pair now{states[state[k]], states[state[k + 1]]};
      const Pair most = load_pair(speed + k) * between + kJumpFloor;
      if (at_most(magnitude(now - load_pair(last + k)), most).both()) {
        store_pair(last + k, now);
        continue;
      }
    }
    for (std::size_t j = k; j < std::min(k + 2, n); ++j)
      if (!judge_state(i, j, between, faults)) return;
  }
}

/// Checks whether the component's thread is late for too long; reports it once until the component is
/// activated again.
inline void Exchange::judge_thread(std::size_t i, FaultEvents& faults) noexcept {
  HostedComponent& hosted = *hosting_.all[i];
  if (hosted.late_reported || !hosted.has_thread()) return;
  const unsigned in_a_row =
      hosted.own_clock ? hosted.own_clock->late_in_a_row()
                       : std::max(hosted.missed_in_a_row,
                                  hosted.runner->health().late_in_a_row.load(std::memory_order_relaxed));
  if (in_a_row < hosted.options.late_after) return;
  hosted.late_reported = true;
  hosting_.late.push(static_cast<std::int32_t>(i));
  faults.push({StopCause::late, static_cast<std::int32_t>(i)});
}

inline void Exchange::find_contacts(FaultEvents& faults) noexcept {
  const WorldState* seen = world();
  if (!seen) return;
  if (seen->finding_count > contacts_seen_) faults.push({StopCause::contact});
  contacts_seen_ = seen->finding_count;
}

void Exchange::read(const Cycle& cycle, FaultEvents& faults) noexcept {
  realtime::Laps laps(measuring_);
  for (std::size_t i = 0; i < hosting_.all.size(); ++i) {
    HostedComponent& hosted = *hosting_.all[i];
    if (!hosted.reading || !due(hosted, cycle)) continue;
    hosting_.in_call.store(static_cast<int>(i), std::memory_order_relaxed);
    Exchanged exchanged;
    const ReturnType result = read_one(i, cycle, exchanged);
    if (result == ReturnType::ok) judge_states(i, between_reads(hosted, cycle, exchanged), faults);
    hosted.read_at = laps.began();
    hosted.read_took = laps.next();
    judge_thread(i, faults);
    if (result != ReturnType::ok) faults.push({cause_of(result), static_cast<std::int32_t>(i)});
  }
  hosting_.in_call.store(-1, std::memory_order_relaxed);
  for (const ForcedValue& forced : hosting_.forced)
    if (forced.state) hosting_.table.states()[forced.index] = forced.value;
  find_contacts(faults);
}

// --- writing ----------------------------------------------------------------------------------------------

inline void Exchange::write_async(HostedComponent& hosted, const Cycle& cycle,
                                  std::span<const double> commands) noexcept {
  if (!hosted.runner->idle()) {
    ++hosted.missed_in_a_row;
    return hosted.runner->note_missed();
  }
  hosted.missed_in_a_row = 0;
  if (hosted.writing)
    std::copy(commands.begin(), commands.end(), hosted.own_commands.begin());
  else  // old commands must not be applied when it is activated again
    std::fill(hosted.own_commands.begin(), hosted.own_commands.end(), kNoCommand);
  hosted.own_cycle = cycle;
  hosted.own_cycle.period = cycle.period * hosted.divisor;
  hosted.runner->trigger();
}

inline ReturnType Exchange::write_one(std::size_t i, const Cycle& cycle) noexcept {
  HostedComponent& hosted = *hosting_.all[i];
  const auto commands = hosting_.table.commands().subspan(hosted.first_command, hosted.commands);
  if (hosted.own_clock) {
    hosted.own_clock->order(cycle, commands, hosted.writing);
  } else if (hosted.runner) {
    write_async(hosted, cycle, commands);
  } else if (hosted.writing) {
    return hosting_.overruns.timed(hosted.budget, static_cast<std::int32_t>(i), "write", cycle.index,
                                   [&] { return hosted.component->write(cycle, commands); });
  }
  return ReturnType::ok;
}

/// Checks whether all joints follow their commands; reports the first that is too far away for too long.
inline void Exchange::judge_following(std::size_t i, FaultEvents& faults) noexcept {
  HostedComponent& hosted = *hosting_.all[i];
  if (!hosted.writing || !std::isfinite(hosted.following_error)) return;
  for (std::size_t k = 0; k < hosted.following.size(); ++k) {
    Following& following = hosted.following[k];
    const std::uint32_t state = hosted.watched.state[k];
    if (following.command < 0) continue;
    const double wanted = hosting_.table.commands()[static_cast<std::size_t>(following.command)];
    const double measured = hosting_.table.states()[state];
    const bool far = std::abs(wanted - measured) > hosted.following_error;
    following.behind = far ? following.behind + 1 : 0;
    if (following.behind < following_cycles_) continue;
    return faults.push({StopCause::not_following, static_cast<std::int32_t>(i),
                        static_cast<std::int32_t>(state), -1, measured});
  }
}

void Exchange::write(const Cycle& cycle, FaultEvents& faults) noexcept {
  for (const ForcedValue& forced : hosting_.forced)
    if (!forced.state) hosting_.table.commands()[forced.index] = forced.value;
  realtime::Laps laps(measuring_);
  for (std::size_t i = 0; i < hosting_.all.size(); ++i) {
    HostedComponent& hosted = *hosting_.all[i];
    if (!hosted.reading || !due(hosted, cycle)) continue;
    hosting_.in_call.store(static_cast<int>(i), std::memory_order_relaxed);
    const ReturnType result = write_one(i, cycle);
    if (result == ReturnType::ok)
      judge_following(i, faults);
    else
      faults.push({cause_of(result), static_cast<std::int32_t>(i)});
    const Nanoseconds took = hosted.read_took + laps.next();
    if (laps.on() && !hosted.has_thread()) hosted.part->note(hosted.read_at, took);
  }
  hosting_.in_call.store(-1, std::memory_order_relaxed);
}

// --- switching components off and on ----------------------------------------------------------------------

std::span<const std::size_t> Exchange::switch_off_failed(const FaultEvent& event) noexcept {
  hosting_.off.clear();
  const auto failed = static_cast<std::size_t>(event.component);
  if (event.component < 0 || failed >= hosting_.all.size()) return hosting_.off;
  HostedComponent& hosted = *hosting_.all[failed];
  const bool deactivated = event.cause == StopCause::deactivated;
  if (!hosted.reading) return hosting_.off;
  if (event.cause != StopCause::component && !deactivated) {
    hosted.failed_at.store(event.interface, std::memory_order_relaxed);
    hosted.failed_by.store(event.cause, std::memory_order_release);
  }
  for (std::size_t i = 0; i < hosting_.all.size(); ++i) {
    HostedComponent& other = *hosting_.all[i];
    if (!other.reading || (i != failed && !fails_with(other, hosted, deactivated))) continue;
    hosting_.off.push_back(i);  // capacity is reserved
  }
  for (const std::size_t i : hosting_.off) switch_off_component(*hosting_.all[i], event.cause);
  return hosting_.off;
}

bool Exchange::take_restarted(CommandRange& out) noexcept {
  if (hosting_.restarted.empty()) return false;
  const HostedComponent& hosted = *hosting_.all[hosting_.restarted.back()];
  out = {hosted.first_command, hosted.commands};
  hosting_.restarted.pop_back();
  return true;
}

StopCause Exchange::fallen(std::size_t i) const noexcept {
  return hosting_.all[i]->fallen;
}

const WorldState* Exchange::world() const noexcept {
  return hosting_.world.load(std::memory_order_acquire);
}

}  // namespace polyarm::hardware
