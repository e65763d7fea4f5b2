/// What a link does over EthernetKRL while it is open: states, outputs, and why the robot stopped.
#include <algorithm>
#include <cmath>

#include "drivers/kuka/link.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::kuka {

namespace {

constexpr Nanoseconds kRound = 50'000'000;
constexpr double kNearLimit = 0.95;  // of the limit: a correction that the context of RSI ended

}  // namespace

bool Link::take_panel(const EkiState& state) {
  current_panel_.state = state;
  ++current_panel_.count;
  panels_.write(current_panel_);
  rsi_off_ = !state.rsi;
  return true;
}

/// Only what changed is written: somebody at the smartPAD may have switched the others.
bool Link::write_outputs() {
  if (outputs_.fetch()) wanted_ = outputs_.value();
  const auto write = [&](EkiDo what, int number, double wanted, double& written) {
    if (!std::isfinite(wanted) || wanted == written) return true;
    const auto reply = eki_.ask(what, number, static_cast<int>(wanted));
    if (!reply) return false;
    if (reply->result != EkiResult::done) note(Cause::output_refused, number);
    written = wanted;
    return reply->result == EkiResult::done;
  };
  for (int i = 0; i < settings_.outputs.count; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const double wanted = wanted_.digital[at];
    if (!write(EkiDo::output, settings_.outputs.first + i,
               std::isfinite(wanted) ? (wanted > 0.5 ? 1.0 : 0.0) : wanted, written_.digital[at]))
      return false;
  }
  const double percent = std::round(std::clamp(wanted_.speed_override, 0.0, 1.0) * 100);
  return write(EkiDo::speed_override, 0, percent, written_.speed_override);
}

/// What the controller shows first, then what RSI showed last; rsi_ended: nothing else is known.
Cause Link::cause_of(const EkiState& state, int& detail) const {
  if (state.rsi) return Cause::none;
  if (const Cause cause = safety_cause(state, detail); cause != Cause::none) return cause;
  detail = late_answers_;
  if (detail + 1 >= identity_.late_limit) return Cause::late_answers;
  detail = most_axis_;
  if (most_correction_ >= kNearLimit * identity_.correction_limit) return Cause::correction_limit;
  detail = state.rsi_return;
  if (detail != 0) return Cause::rsi_refused;
  const Cause cause = program_cause(state);
  return cause == Cause::none ? Cause::rsi_ended : cause;
}

void Link::judge_panel(const EkiState& state) {
  if (phase_ != Phase::streaming || fault_) return;
  int detail = 0;
  const Cause cause = cause_of(state, detail);
  if (cause != Cause::none) return note(cause, detail);
  if (!silent_) return;
  const std::string from = stranger();
  if (from.empty())
    note(Cause::silent);
  else
    note(Cause::other_sender, 0, from);
}

bool Link::serve_round() {
  const auto reply = write_outputs() ? eki_.ask(EkiDo::state) : std::nullopt;
  if (!reply) {
    if (!fault_) note(eki_.failure().cause, 0, eki_.failure().text);
    return false;
  }
  take_panel(reply->state);
  judge_panel(reply->state);
  return true;
}

void Link::serve_services() {
  const std::unique_lock lock(eki_mutex_, std::try_to_lock);
  if (lock && open_ && settings_.eki && !fault_) serve_round();
}

void Link::run_services() {
  Nanoseconds due = realtime::monotonic_now();
  while (!quit_) {
    const Nanoseconds left = settings_.stepped ? 1'000'000'000 : due - realtime::monotonic_now();
    if (left > 0 && wire::wait_readable(services_wake_.number(), left)) calm(services_wake_.number());
    if (quit_ || (!silent_ && (settings_.stepped || realtime::monotonic_now() < due))) continue;
    due = realtime::monotonic_now() + kRound;
    serve_services();  // does nothing after a fault
  }
}

}  // namespace polyarm::kuka
