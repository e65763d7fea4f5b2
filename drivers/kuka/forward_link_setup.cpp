/// How a link in forward mode begins and ends.
#include <algorithm>
#include <chrono>

#include "drivers/kuka/forward_link.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::kuka {

namespace {

constexpr Nanoseconds kPause = 10'000'000;
constexpr Nanoseconds kEnd = 2'000'000'000;  // for a session to end

}  // namespace

ForwardLink::ForwardLink(ForwardSettings settings)
    : EkiLink(settings.host, settings.eki_port, settings.answer),
      settings_(std::move(settings)),
      moves_(settings_.frame, kMoveSlots) {}

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

void ForwardLink::run_thread() {
  quit_ = false;
  next_round_ = 0;
  thread_ = std::thread([this] { run(); });
}

void ForwardLink::halt_thread() {
  if (!thread_.joinable()) return;
  quit_ = true;
  wake();
  thread_.join();
}

/// A session that another connection left, or RSI.
bool ForwardLink::end_old_session(const EkiState& state) {
  if (!state.moves && !state.rsi) return true;
  const Nanoseconds deadline = realtime::monotonic_now() + kEnd;
  const EkiDo first = state.moves ? EkiDo::end : EkiDo::stop;
  for (EkiDo what = first;; what = EkiDo::state, wire::wait_readable(-1, kPause)) {
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
  for (;; wire::wait_readable(-1, kPause)) {
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
  if (!thread_.joinable()) return refuse(Cause::eki_closed);
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
    outputs_.fetch();  // what was wanted before counts no more
    wanted_ = written_ = Outputs();
    ordered_ = end_asked_ = end_heard_ = false;
    over_ = false;
    percent_ = -1;
    cycles_ = cycles_seen_ = 0;
    moves_.set_pace(0);
    moves_.begin(report());
    phase_ = Phase::active;
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

void ForwardLink::stop() {
  if (phase_ == Phase::idle) return;
  own_rounds_ = true;
  if (!fault_) phase_ = Phase::ending;
  wake();
  {
    std::unique_lock lock(mutex_);
    const auto end = std::chrono::steady_clock::now() + std::chrono::nanoseconds(settings_.timeout);
    while (!over_ && !gone_ && std::chrono::steady_clock::now() < end)
      changed_.wait_for(lock, std::chrono::milliseconds(5));
  }
  // One more round gives the override back, and reads where the robot stands.
  const std::uint64_t rounds = rounds_;
  for (const auto end = std::chrono::steady_clock::now() + std::chrono::nanoseconds(settings_.timeout);
       !gone_ && rounds_ < rounds + 2 && std::chrono::steady_clock::now() < end;) {
    wake();
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, std::chrono::milliseconds(5));
  }
  halt_thread();
  own_rounds_ = false;
  phase_ = Phase::idle;
  if (fault_ || gone_) return;
  run_thread();
}

}  // namespace polyarm::kuka
