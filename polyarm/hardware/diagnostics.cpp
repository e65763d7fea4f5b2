#include "polyarm/hardware/diagnostics.hpp"

#include "polyarm/base/text.hpp"
#include "polyarm/hardware/hosted.hpp"
#include "polyarm/hardware/life_cycle.hpp"

namespace polyarm::hardware {

HostedInfo Diagnostics::info(std::size_t i) const {
  const HostedComponent& hosted = *hosting_.all[i];
  HostedInfo out{hosted.name,
                 hosted.options.plugin,
                 hosted.options.type,
                 hosted.options.group,
                 hosted.state.load(std::memory_order_acquire),
                 hosted.divisor,
                 hosted.options.async,
                 hosted.own_clock ? hosted.own_clock->period() : 0,
                 thread_health(i) ? std::uint64_t{thread_health(i)->missed} : 0,
                 {},
                 {}};
  for (std::size_t k = 0; k < hosted.states; ++k)
    out.states.push_back(hosting_.table.state_names()[hosted.first_state + k]);
  for (std::size_t k = 0; k < hosted.commands; ++k)
    out.commands.push_back(hosting_.table.command_names()[hosted.first_command + k]);
  return out;
}

namespace {
/// The loop's finding as a sentence; empty if the component failed by itself.
std::string found(const HostedComponent& hosted, const InterfaceTable& table) {
  const StopCause cause = hosted.failed_by.load(std::memory_order_acquire);
  const int at = hosted.failed_at.load(std::memory_order_relaxed);
  if (cause == StopCause::late)
    return "its thread was late, or missed runs, " + std::to_string(hosted.options.late_after) +
           " times in a row";
  if (cause == StopCause::controller) return "a controller that works on it failed";
  if (at < 0) return {};
  const auto index = static_cast<std::size_t>(at);
  if (cause == StopCause::limits)
    return table.command_names()[index] + " is of a joint far outside its limits";
  const std::string& name = table.state_names()[index];
  if (cause == StopCause::not_a_number) return name + " became NaN or infinite";
  if (cause == StopCause::jump)
    return name + " changed by more between two reads than the joint can have moved";
  return name + " is more than " + format_number(hosted.following_error) + " from its command for " +
         format_number(seconds(kFollowingTime)) + " s";
}
}  // namespace

std::string Diagnostics::own_reason(std::size_t i) const {
  const HostedComponent& hosted = *hosting_.all[i];
  return hosted.pending ? hosted.reason_before : reason_of(*hosted.component);
}

std::string Diagnostics::blamed_interface(std::size_t i) const {
  const HostedComponent& hosted = *hosting_.all[i];
  const StopCause cause = hosted.failed_by.load(std::memory_order_acquire);
  const int at = hosted.failed_at.load(std::memory_order_relaxed);
  if (cause == StopCause::none || at < 0) return {};
  const auto& names =
      cause == StopCause::limits ? hosting_.table.command_names() : hosting_.table.state_names();
  return names[static_cast<std::size_t>(at)];
}

std::string Diagnostics::reason(std::size_t i) const {
  const HostedComponent& hosted = *hosting_.all[i];
  const std::string own = own_reason(i);
  const std::string what = found(hosted, hosting_.table);
  if (what.empty()) return own;
  const StopCause cause = hosted.failed_by.load(std::memory_order_relaxed);
  const bool of_others = cause == StopCause::controller || cause == StopCause::limits;
  return own.empty() || of_others ? what : what + " (" + own + ")";
}

std::vector<std::string> Diagnostics::summaries() const {
  std::vector<std::string> out;
  for (const auto& hosted : hosting_.all) {
    std::string text;
    if (hosted->pending) continue;
    try {
      text = hosted->component->summary();
    } catch (...) {
      text = "its information function threw: " + what_was_thrown();
    }
    if (!text.empty()) out.push_back(hosted->name + ": " + text);
  }
  return out;
}

const std::vector<std::string>& Diagnostics::world_names() const {
  return hosting_.world_names;
}

const realtime::ThreadHealth* Diagnostics::thread_health(std::size_t i) const noexcept {
  const HostedComponent& hosted = *hosting_.all[i];
  if (hosted.own_clock) return &hosted.own_clock->health();
  return hosted.runner ? &hosted.runner->health() : nullptr;
}

const realtime::ThreadOptions& Diagnostics::thread_options(std::size_t i) const {
  return hosting_.all[i]->options.thread;
}
WhenLate Diagnostics::when_late(std::size_t i) const {
  return hosting_.all[i]->options.when_late;
}
const realtime::PartHealth& Diagnostics::part_health(std::size_t i) const noexcept {
  return *hosting_.all[i]->part;
}
int Diagnostics::in_call() const noexcept {
  return hosting_.in_call.load(std::memory_order_relaxed);
}
bool Diagnostics::take_overrun(realtime::Overrun& out) {
  return hosting_.overruns.take(out);
}
bool Diagnostics::take_late(std::int32_t& who) {
  return hosting_.late.pop(who);
}

}  // namespace polyarm::hardware
