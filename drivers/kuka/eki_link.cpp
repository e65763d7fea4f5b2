#include "drivers/kuka/eki_link.hpp"

#include <algorithm>

#include "polyarm/realtime/periodic.hpp"

namespace polyarm::kuka {

namespace {

constexpr Nanoseconds kAskAgain = 50'000'000;
constexpr Nanoseconds kDrives = 5'000'000'000;  // for the drives to be on
constexpr int kOldestRsi = 3;

}  // namespace

bool EkiLink::refuse_eki() {
  return refuse(eki_.failure().cause, 0, eki_.failure().text);
}

bool EkiLink::check_identity(const EkiIdentity& identity) {
  if (identity.version != kProgramVersion) return refuse(Cause::program_version, identity.version);
  if (identity.rsi < kOldestRsi) return refuse(Cause::old_rsi, identity.rsi);
  return identity.axes == 6 ? true : refuse(Cause::axes, identity.axes);
}

Cause EkiLink::safety_cause(const EkiState& state, int& detail) {
  if (state.emergency_stop) return Cause::emergency_stop;
  if (state.guard_stop) return Cause::guard_stop;
  if (state.mode != OperatingMode::t1 && state.mode != OperatingMode::t2) return Cause::none;
  detail = static_cast<int>(state.mode);
  return Cause::manual_mode;
}

Cause EkiLink::program_cause(const EkiState& state) {
  if (state.message) return Cause::message;
  if (!state.drives) return Cause::drives_off;
  if (state.program == ProgramState::stopped) return Cause::program_stopped;
  return state.program == ProgramState::active ? Cause::none : Cause::program_ended;
}

bool EkiLink::check_panel(const EkiState& state, bool drives_on, Nanoseconds timeout) {
  int detail = 0;
  if (const Cause cause = safety_cause(state, detail); cause != Cause::none) return refuse(cause, detail);
  if (state.message) return refuse(Cause::message);
  if (!state.drives) return drives_on ? switch_drives_on(timeout) : refuse(Cause::drives_off);
  return true;
}

bool EkiLink::switch_drives_on(Nanoseconds timeout) {
  const Nanoseconds deadline = realtime::monotonic_now() + std::min(kDrives, timeout);
  for (EkiDo what = EkiDo::drives_on;; what = EkiDo::state, wire::wait_readable(-1, kAskAgain)) {
    const auto reply = eki_.ask(what);
    if (!reply) return refuse_eki();
    if (reply->state.drives) return true;
    if (reply->result != EkiResult::done || realtime::monotonic_now() > deadline)
      return refuse(Cause::drives_refused);
  }
}

}  // namespace polyarm::kuka
