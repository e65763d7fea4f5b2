#include "polyarm/hardware/hardware.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/hardware/life_cycle.hpp"

namespace polyarm::hardware {

Hardware::~Hardware() {
  shut_down();
}

void Hardware::add(std::unique_ptr<Component> component, const ComponentContext& context,
                   HostOptions options) {
  initialise(*component, context, "the hardware component");
  const std::vector<InterfaceDescription> states =
      offered(context.name, [&] { return component->state_interfaces(); });
  const std::vector<InterfaceDescription> commands =
      offered(context.name, [&] { return component->command_interfaces(); });
  if (component->blocks()) options.async = true;
  if (component->real()) options.following_error = kRealFollowingError;
  if (const auto stated = context.parameters.find("following_error"); stated != context.parameters.end()) {
    const auto value = parse_number(stated->second);
    if (!value || !(*value > 0))
      throw Error("bad-value",
                  "following_error of '" + context.name + "' is '" + stated->second + "', not above zero",
                  "write how far a joint may be from its command, rad or m");
    options.following_error = *value;
  }
  auto hosted = std::make_unique<Hosted>();
  hosted->name = context.name;
  hosted->component = std::move(component);
  hosted->options = std::move(options);
  hosted->options.divisor = std::max(1u, hosted->options.divisor);
  hosted->first_state = table_.states().size();
  for (const InterfaceDescription& d : states) table_.add_state(d.name, d.initial);
  hosted->states = table_.states().size() - hosted->first_state;
  hosted->first_command = table_.commands().size();
  for (const InterfaceDescription& d : commands) table_.add_command(d.name);
  hosted->commands = table_.commands().size() - hosted->first_command;
  if (hosted->options.async) make_runner(*hosted, context.period);
  if (hosted->component->paces()) {
    if (pacer_ >= 0)
      throw Error("two-clocks",
                  "'" + hosted->name + "' and '" + hosted_[static_cast<std::size_t>(pacer_)]->name +
                      "' both pace the control loop",
                  "run them in two cells: a loop has one clock");
    pacer_ = static_cast<int>(hosted_.size());
  }
  hosted_.push_back(std::move(hosted));
}

void Hardware::make_runner(Hosted& hosted, Nanoseconds loop_period) {
  const auto states = table_.states().subspan(hosted.first_state, hosted.states);
  if (hosted.options.period > 0) {
    hosted.options.divisor = 1;
    hosted.own_clock =
        std::make_unique<OwnClock>(hosted.component, states, hosted.commands, hosted.options.period,
                                   hosted.options.lock_step, hosted.options.thread);
    return;
  }
  hosted.own_states.assign(states.begin(), states.end());
  hosted.own_commands.assign(hosted.commands, std::numeric_limits<double>::quiet_NaN());
  Hosted* own = &hosted;
  hosted.runner = std::make_unique<realtime::AsyncRunner>(
      [own] {
        const auto clock = [own] {
          return own->options.lock_step ? own->own_cycle.time : realtime::monotonic_now();
        };
        own->own_exchanged.began = clock();
        ReturnType result = own->component->write(own->own_cycle, own->own_commands);
        if (result == ReturnType::ok) result = own->component->read(own->own_cycle, own->own_states);
        own->own_exchanged.ended = clock();
        own->own_result.store(result, std::memory_order_release);
        own->ran.store(true, std::memory_order_release);
      },
      hosted.options.lock_step, hosted.options.thread, loop_period * hosted.options.divisor);
}

void Hardware::force(const std::string& interface_name, double value) {
  const auto state = table_.find_state(interface_name);
  const auto command = table_.find_command(interface_name);
  if (!state && !command) {
    std::vector<std::string> names = table_.state_names();
    names.insert(names.end(), table_.command_names().begin(), table_.command_names().end());
    throw Error("unknown-interface",
                "there is no interface '" + interface_name + "'" + did_you_mean(interface_name, names),
                "interfaces are named robot/joint/interface, for example arm/tool/vacuum");
  }
  std::erase_if(forced_, [&](const ForcedValue& forced) {
    return forced.state ? state && *state == forced.index : command && *command == forced.index;
  });
  if (std::isnan(value)) return;
  if (state) forced_.push_back({true, *state, value});
  if (command) forced_.push_back({false, *command, value});
}

void Hardware::take_off(Hosted& hosted, Fall fall, FaultKind kind) noexcept {
  if (!hosted.reading) return;
  hosted.newly_failed = fall;
  hosted.fallen = kind;
  hosted.writing = false;
  hosted.reading = fall == Fall::deactivated;
  if (hosted.own_clock && !hosted.reading) hosted.own_clock->close();
}

Fault Hardware::fail(std::size_t i, ReturnType result, FaultKind kind) noexcept {
  Hosted& hosted = *hosted_[i];
  const bool deactivated = result == ReturnType::deactivate;
  const Fall fall = deactivated ? Fall::deactivated : Fall::error;
  if (deactivated) kind = FaultKind::component_deactivated;
  take_off(hosted, fall, kind);
  // A group fails together. Where the rest of the loop goes on, it is also deactivated together.
  if (!hosted.options.group.empty() && (!deactivated || hosted.options.contained))
    for (const auto& other : hosted_)
      if (other != hosted_[i] && other->options.group == hosted.options.group &&
          (!deactivated || other->writing))
        take_off(*other, fall, kind);
  return {kind, static_cast<std::int32_t>(i)};
}

void Hardware::fail_for(std::size_t i, FaultKind kind, std::int32_t what) noexcept {
  if (!hosted_[i]->reading) return;
  hosted_[i]->bad_state.store(what, std::memory_order_relaxed);
  hosted_[i]->bad_kind.store(kind, std::memory_order_release);
  fail(i, ReturnType::error, kind);
}

ReturnType Hardware::read_async(Hosted& hosted, std::span<double> states, Exchanged& exchanged) noexcept {
  if (!hosted.runner->idle() || !hosted.ran.load(std::memory_order_acquire)) return ReturnType::ok;
  exchanged = hosted.own_exchanged;
  std::copy(hosted.own_states.begin(), hosted.own_states.end(), states.begin());
  return hosted.own_result.exchange(ReturnType::ok, std::memory_order_acq_rel);  // a failure is told once
}

void Hardware::write_async(Hosted& hosted, const Cycle& cycle, std::span<const double> commands) noexcept {
  if (!hosted.runner->idle()) {
    ++hosted.missed_in_a_row;
    return hosted.runner->note_missed();
  }
  hosted.missed_in_a_row = 0;
  if (hosted.writing)
    std::copy(commands.begin(), commands.end(), hosted.own_commands.begin());
  else  // what it was told last must not lead when it is activated again
    std::fill(hosted.own_commands.begin(), hosted.own_commands.end(),
              std::numeric_limits<double>::quiet_NaN());
  hosted.own_cycle = cycle;
  hosted.own_cycle.period = cycle.period * hosted.options.divisor;
  hosted.runner->trigger();
}

std::optional<bool> Hardware::await_cycle(Nanoseconds timeout) noexcept {
  if (pacer_ < 0) return std::nullopt;
  Hosted& hosted = *hosted_[static_cast<std::size_t>(pacer_)];
  if (!hosted.writing) return std::nullopt;
  in_call_.store(pacer_, std::memory_order_relaxed);
  const bool came = hosted.component->await_cycle(timeout);
  in_call_.store(-1, std::memory_order_relaxed);
  return came;
}

/// Of a joint whose velocity nobody limits; still less than infinite.
constexpr double kAnySpeed = 1e38;

void Hardware::watch(const std::vector<WatchedJoint>& joints, Nanoseconds period) {
  following_cycles_ = static_cast<std::uint32_t>(kFollowingTime / period);
  for (const auto& hosted : hosted_) {
    hosted->watched.clear();
    hosted->following.clear();
    for (const WatchedJoint& joint : joints)
      if (joint.state >= hosted->first_state && joint.state < hosted->first_state + hosted->states) {
        hosted->watched.push_back({std::numeric_limits<double>::quiet_NaN(),
                                   static_cast<float>(std::min(kJumpFactor * joint.velocity, kAnySpeed)),
                                   static_cast<std::uint32_t>(joint.state)});
        hosted->following.push_back({joint.command});
      }
  }
}

/// The most time that may lie between where the states were measured and where those before were, s.
double Hardware::between_reads(Hosted& hosted, const Cycle& cycle, const Exchanged& exchanged) noexcept {
  Nanoseconds most = cycle.period * hosted.options.divisor;
  if (!hosted.own_clock && !hosted.runner)
    most += skipped_ - std::exchange(hosted.skips_seen, skipped_);
  else if (exchanged.ended > 0)
    most = std::max(hosted.own_clock ? hosted.own_clock->period() : most,
                    exchanged.ended - std::exchange(hosted.exchange_began, exchanged.began));
  return seconds(most);
}

/// What was just read of a component: is it possible?
FaultKind Hardware::judge_states(Hosted& hosted, double between) noexcept {
  const std::span<const double> states = table_.states();
  for (Watch& watch : hosted.watched) {
    const double now = states[watch.state];
    if (std::abs(now - watch.last) <= watch.speed * between + kJumpFloor) {  // nearly always
      watch.last = now;
      continue;
    }
    const bool first = std::isnan(watch.last);
    if (std::isfinite(now)) watch.last = now;
    if (first) continue;
    const FaultKind kind = std::isfinite(now) ? FaultKind::jump : FaultKind::not_a_number;
    hosted.bad_kind.store(kind, std::memory_order_relaxed);
    hosted.bad_state.store(static_cast<int>(watch.state), std::memory_order_release);
    return kind;
  }
  return FaultKind::none;
}

/// Are all joints near where they are commanded to be?
bool Hardware::follows(Hosted& hosted) noexcept {
  for (std::size_t k = 0; k < hosted.following.size(); ++k) {
    Following& following = hosted.following[k];
    const std::uint32_t state = hosted.watched[k].state;
    if (following.command < 0) continue;
    const double wanted = table_.commands()[static_cast<std::size_t>(following.command)];
    const bool far = std::abs(wanted - table_.states()[state]) > hosted.options.following_error;
    following.behind = far ? following.behind + 1 : 0;
    if (following.behind < following_cycles_) continue;
    hosted.bad_kind.store(FaultKind::not_following, std::memory_order_relaxed);
    hosted.bad_state.store(static_cast<int>(state), std::memory_order_release);
    return false;
  }
  return true;
}

/// Is its thread late for longer than is allowed, for the first time since it was let in?
bool Hardware::newly_late(Hosted& hosted, std::size_t i) noexcept {
  if (hosted.late_told || (!hosted.own_clock && !hosted.runner)) return false;
  const unsigned in_a_row =
      hosted.own_clock ? hosted.own_clock->late_in_a_row()
                       : std::max(hosted.missed_in_a_row,
                                  hosted.runner->health().late_in_a_row.load(std::memory_order_relaxed));
  if (in_a_row < hosted.options.late_after) return false;
  hosted.late_told = true;
  late_.push(static_cast<std::int32_t>(i));
  return true;
}

Fault Hardware::read(const Cycle& cycle) noexcept {
  Fault fault;
  const std::span<double> states = table_.states();
  realtime::Laps laps(measuring_);
  for (std::size_t i = 0; i < hosted_.size(); ++i) {
    Hosted& hosted = *hosted_[i];
    if (!hosted.reading || !due(hosted, cycle)) continue;
    const auto own = states.subspan(hosted.first_state, hosted.states);
    ReturnType result;
    Exchanged exchanged;
    in_call_.store(static_cast<int>(i), std::memory_order_relaxed);
    if (hosted.own_clock) {
      result = hosted.own_clock->take(own, exchanged).value_or(ReturnType::ok);
    } else if (hosted.runner) {
      result = read_async(hosted, own, exchanged);
    } else {
      Cycle longer = cycle;
      longer.period *= hosted.options.divisor;
      result = overruns_.timed(hosted.options.budget, static_cast<std::int32_t>(i), "read", cycle.index,
                               [&] { return hosted.component->read(longer, own); });
    }
    FaultKind impossible = result == ReturnType::ok
                               ? judge_states(hosted, between_reads(hosted, cycle, exchanged))
                               : FaultKind::none;
    hosted.read_at = laps.began();
    hosted.read_took = laps.next();
    if (newly_late(hosted, i)) {
      hold_ = hold_ || hosted.options.when_late == WhenLate::hold;
      if (hosted.options.when_late == WhenLate::fault && impossible == FaultKind::none) {
        impossible = FaultKind::late;
        hosted.bad_kind.store(FaultKind::late, std::memory_order_release);
      }
    }
    if (result == ReturnType::ok && impossible == FaultKind::none) continue;
    const Fault failed = impossible != FaultKind::none ? fail(i, ReturnType::error, impossible)
                                                       : fail(i, result, FaultKind::component_read);
    if (!fault) fault = failed;
  }
  in_call_.store(-1, std::memory_order_relaxed);
  for (const ForcedValue& forced : forced_)
    if (forced.state) states[forced.index] = forced.value;
  return fault;
}

Fault Hardware::write(const Cycle& cycle) noexcept {
  Fault fault;
  const std::span<double> commands = table_.commands();
  for (const ForcedValue& forced : forced_)
    if (!forced.state) commands[forced.index] = forced.value;
  realtime::Laps laps(measuring_);
  for (std::size_t i = 0; i < hosted_.size(); ++i) {
    Hosted& hosted = *hosted_[i];
    if (!hosted.reading || !due(hosted, cycle)) continue;
    const auto own = commands.subspan(hosted.first_command, hosted.commands);
    ReturnType result = ReturnType::ok;
    in_call_.store(static_cast<int>(i), std::memory_order_relaxed);
    if (hosted.own_clock)
      hosted.own_clock->order(cycle, own, hosted.writing);
    else if (hosted.runner)
      write_async(hosted, cycle, own);
    else if (hosted.writing)
      result = overruns_.timed(hosted.options.budget, static_cast<std::int32_t>(i), "write", cycle.index,
                               [&] { return hosted.component->write(cycle, own); });
    const bool behind = result == ReturnType::ok && hosted.writing &&
                        std::isfinite(hosted.options.following_error) && !follows(hosted);
    const Nanoseconds took = hosted.read_took + laps.next();
    if (laps.on() && !hosted.own_clock && !hosted.runner) hosted.part.note(hosted.read_at, took);
    if (result == ReturnType::ok && !behind) continue;
    const Fault failed = behind ? fail(i, ReturnType::error, FaultKind::not_following)
                                : fail(i, result, FaultKind::component_write);
    if (!fault) fault = failed;
  }
  in_call_.store(-1, std::memory_order_relaxed);
  return fault;
}

std::string Hardware::own_reason(std::size_t i) const {
  std::string own = hosted_[i]->pending ? "" : because(*hosted_[i]->component);
  if (!own.empty()) own.erase(0, 2);  // ": "
  return own;
}

std::string Hardware::blamed_interface(std::size_t i) const {
  const int state = hosted_[i]->bad_state.load(std::memory_order_acquire);
  const FaultKind kind = hosted_[i]->bad_kind.load(std::memory_order_relaxed);
  if (state < 0 || kind == FaultKind::late || kind == FaultKind::controller) return {};
  const auto& names = kind == FaultKind::outside ? table_.command_names() : table_.state_names();
  return names[static_cast<std::size_t>(state)];
}

std::string Hardware::reason(std::size_t i) const {
  const Hosted& hosted = *hosted_[i];
  const int state = hosted.bad_state.load(std::memory_order_acquire);
  const std::string own = own_reason(i);
  if (hosted.bad_kind.load(std::memory_order_acquire) == FaultKind::late)
    return "its thread was late, or missed its turn, " + std::to_string(hosted.options.late_after) +
           " times in a row" + (own.empty() ? "" : " (" + own + ")");
  if (hosted.bad_kind.load(std::memory_order_relaxed) == FaultKind::controller)
    return "a controller that works on it failed";
  if (state < 0) return own;
  if (hosted.bad_kind.load(std::memory_order_relaxed) == FaultKind::outside)
    return table_.command_names()[static_cast<std::size_t>(state)] + " is of a joint far outside its limits";
  const std::string& name = table_.state_names()[static_cast<std::size_t>(state)];
  const FaultKind kind = hosted.bad_kind.load(std::memory_order_relaxed);
  std::string seen = kind == FaultKind::not_a_number ? name + " was measured and is no number any more"
                     : kind == FaultKind::jump
                         ? name + " changed by more between two reads than the joint can have moved"
                         : name + " is more than " + format_number(hosted.options.following_error) +
                               " from its command for " + format_number(seconds(kFollowingTime)) + " s";
  return own.empty() ? seen : seen + " (" + own + ")";
}

bool Hardware::offers(const Hosted& hosted, std::span<const std::string> commands) const {
  return std::any_of(commands.begin(), commands.end(), [&](const std::string& command) {
    const auto index = table_.find_command(command);
    return index && *index >= hosted.first_command && *index < hosted.first_command + hosted.commands;
  });
}

bool Hardware::prepare_mode_switch(std::span<const std::string> start, std::span<const std::string> stop) {
  for (const auto& hosted : hosted_) {
    if (hosted->pending) {
      if (offers(*hosted, start) || offers(*hosted, stop)) require_idle(*hosted);
      continue;
    }
    try {
      if (hosted->component->prepare_command_mode_switch(start, stop) != ReturnType::ok) return false;
    } catch (...) {
      rethrow_as_error("mode-refused", "the hardware component '" + hosted->name +
                                           "', asked whether it takes the commands of the switch,");
    }
  }
  return true;
}

bool Hardware::perform_mode_switch(std::span<const std::string> start,
                                   std::span<const std::string> stop) noexcept {
  bool all = true;
  for (const auto& hosted : hosted_)
    if (!hosted->busy.load(std::memory_order_acquire) &&
        hosted->component->perform_command_mode_switch(start, stop) != ReturnType::ok)
      all = false;
  return all;
}

HostedInfo Hardware::info(std::size_t i) const {
  const Hosted& hosted = *hosted_[i];
  HostedInfo out{hosted.name,
                 hosted.options.plugin,
                 hosted.options.type,
                 hosted.options.group,
                 state_of(i),
                 hosted.options.divisor,
                 hosted.options.async,
                 hosted.own_clock ? hosted.own_clock->period() : 0,
                 thread_health(i) ? std::uint64_t{thread_health(i)->missed} : 0,
                 {},
                 {}};
  for (std::size_t k = 0; k < hosted.states; ++k)
    out.states.push_back(table_.state_names()[hosted.first_state + k]);
  for (std::size_t k = 0; k < hosted.commands; ++k)
    out.commands.push_back(table_.command_names()[hosted.first_command + k]);
  return out;
}

const realtime::ThreadHealth* Hardware::thread_health(std::size_t i) const noexcept {
  const Hosted& hosted = *hosted_[i];
  if (hosted.own_clock) return &hosted.own_clock->health();
  return hosted.runner ? &hosted.runner->health() : nullptr;
}

int Hardware::component_of_state(std::size_t index) const {
  for (std::size_t i = 0; i < hosted_.size(); ++i)
    if (index >= hosted_[i]->first_state && index < hosted_[i]->first_state + hosted_[i]->states)
      return static_cast<int>(i);
  return -1;
}

int Hardware::component_of_command(std::size_t index) const {
  for (std::size_t i = 0; i < hosted_.size(); ++i)
    if (index >= hosted_[i]->first_command && index < hosted_[i]->first_command + hosted_[i]->commands)
      return static_cast<int>(i);
  return -1;
}

int Hardware::find(std::string_view name) const {
  for (std::size_t i = 0; i < hosted_.size(); ++i)
    if (hosted_[i]->name == name) return static_cast<int>(i);
  return -1;
}

std::vector<std::string> Hardware::summaries() const {
  std::vector<std::string> out;
  for (const auto& hosted : hosted_) {
    std::string text;
    if (hosted->pending) continue;
    try {
      text = hosted->component->summary();
    } catch (...) {
      text = "asked what it is it threw: " + what_was_thrown();
    }
    if (!text.empty()) out.push_back(hosted->name + ": " + text);
  }
  return out;
}

}  // namespace polyarm::hardware
