/// How a link in forward mode begins and ends.
#include <algorithm>

#include "drivers/kuka/forward_link.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::kuka {

namespace {

constexpr Nanoseconds kLookAgain = 10'000'000;
constexpr Nanoseconds kEnd = 2'000'000'000;  // for a session to end

}  // namespace

ForwardLink::ForwardLink(ForwardSettings settings)
    : MoveLink({settings.frame, kMoveSlots}, {settings.stepped, settings.poll, settings.loop_silence},
               settings.host, settings.eki_port, settings.answer),
      settings_(std::move(settings)) {}

bool ForwardLink::open() {
  close();
  fault_.clear();
  refused_.clear();
  current_ = {};
  percent_before_.reset();
  if (!eki_.open()) return refuse_eki();
  const auto reply = eki_.ask(EkiDo::state);
  if (!reply) return refuse_eki();
  identity_ = reply->identity;
  if (!check_identity(identity_)) {
    eki_.close();
    return false;
  }
  take(*reply);
  if (fault_) {
    eki_.close();
    return false;
  }
  gone_ = false;
  run_thread();
  return true;
}

void ForwardLink::close() {
  stop();
  halt_thread();
  eki_.close();
}

/// A session that another connection left, or RSI.
bool ForwardLink::end_old_session(const EkiState& state) {
  if (!state.moves && !state.rsi) return true;
  const Nanoseconds deadline = realtime::monotonic_now() + kEnd;
  const EkiDo first = state.moves ? EkiDo::end : EkiDo::stop;
  for (EkiDo what = first;; what = EkiDo::state, wire::wait_readable(-1, kLookAgain)) {
    const auto reply = eki_.ask(what, 0, state.session);
    if (!reply) return refuse_eki();
    take(*reply);
    if (!reply->state.moves && !reply->state.rsi) return true;
    if (realtime::monotonic_now() > deadline)
      return refuse(Cause::start_refused, static_cast<int>(EkiResult::busy));
  }
}

/// The program has to be there: it stands where the robot stands, and waits for moves.
bool ForwardLink::await_session() {
  const Nanoseconds deadline = realtime::monotonic_now() + settings_.start_timeout;
  for (;; wire::wait_readable(-1, kLookAgain)) {
    const auto reply = eki_.ask(EkiDo::state);
    if (!reply) return refuse_eki();
    take(*reply);
    const EkiState& s = reply->state;
    int detail = 0;
    if (const Cause cause = safety_cause(s, detail); cause != Cause::none) return refuse(cause, detail);
    if (s.message) return refuse(Cause::message);
    if (s.moves && s.program == ProgramState::active) {
      session_ = s.session;
      return true;
    }
    if (realtime::monotonic_now() < deadline) continue;
    const Cause cause = program_cause(s);
    return cause == Cause::none ? refuse(Cause::start_refused, static_cast<int>(EkiResult::busy))
                                : refuse(cause);
  }
}

bool ForwardLink::start() {
  if (!runs()) return refuse(Cause::eki_closed);
  if (fault_) return false;
  refused_.clear();
  halt_thread();
  const auto begin = [this] {
    const auto reply = eki_.ask(EkiDo::state);
    if (!reply) return refuse_eki();
    take(*reply);
    const EkiState& s = reply->state;
    if (!check_panel(s, settings_.drives_on, settings_.start_timeout) || !end_old_session(s)) return false;
    if (!percent_before_) percent_before_ = s.speed_override;
    const auto begun = eki_.ask(EkiDo::begin, 0, settings_.watchdog_ms);
    if (!begun) return refuse_eki();
    if (begun->result != EkiResult::done)
      return refuse(Cause::start_refused, static_cast<int>(begun->result));
    return await_session();
  };
  const bool fine = begin();
  if (fine) {
    written_ = Outputs();
    end_asked_ = end_heard_ = false;
    percent_ = -1;
    begin_queue(report());
    begin_session();
  } else if (eki_.failure().cause == Cause::none) {
    eki_.ask(EkiDo::end);
  }
  if (eki_.failure().cause != Cause::none) {
    gone_ = true;
    note(eki_.failure().cause, 0, eki_.failure().text);
  }
  run_thread();
  return fine;
}

/// One more round than the end needs gives the override back, and reads where the robot stands.
void ForwardLink::stop() {
  if (phase_ != Phase::idle) finish(settings_.timeout);
}

}  // namespace polyarm::kuka
