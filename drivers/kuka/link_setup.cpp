/// How a link begins and ends: versions, modes, drives, the program that runs RSI.
#include <arpa/inet.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "drivers/kuka/link.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::kuka {

namespace {

constexpr Nanoseconds kPause = 50'000'000;
constexpr Nanoseconds kRsiEnd = 2'000'000'000;  // for RSI to end

}  // namespace

Outputs::Outputs() noexcept : speed_override(std::numeric_limits<double>::quiet_NaN()) {
  digital.fill(std::numeric_limits<double>::quiet_NaN());
}

Link::Link(LinkSettings settings)
    : StreamLink(settings.host, settings.eki_port, settings.timeout),
      settings_(std::move(settings)),
      services_wake_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)),
      shaper_(settings_.cycle_ms / 1000.0) {
  if (settings_.rsi_host.empty()) settings_.rsi_host = settings_.host;
}

bool Link::connect_services() {
  identity_ = {};
  identity_.cycle_ms = settings_.cycle_ms;
  identity_.correction_limit = settings_.correction_limit;
  if (!settings_.eki) return true;
  if (!eki_.open()) return refuse_eki();
  const auto reply = eki_.ask(EkiDo::state);
  if (!reply) return refuse_eki();
  identity_ = reply->identity;
  if (!check_identity(identity_)) return false;
  settings_.cycle_ms = identity_.cycle_ms;
  settings_.relative = identity_.relative;
  return take_panel(reply->state);
}

/// Only the interface that reaches the controller's RSI network listens.
bool Link::bind_rsi() {
  std::string why;
  const Descriptor probe = wire::connect_udp(settings_.rsi_host, settings_.eki_port, why);
  if (!probe) return refuse(Cause::unreachable, 0, why);
  in_addr address{};
  ::inet_pton(AF_INET, wire::peer_address(probe.number()).c_str(), &address);
  sender_host_ = address.s_addr;
  own_address_ = settings_.rsi_address.empty() ? wire::local_address(probe.number()) : settings_.rsi_address;
  rsi_ = wire::bind_udp(own_address_, settings_.rsi_port, why);
  return rsi_ ? true : refuse(Cause::port_taken, 0, why);
}

bool Link::open() {
  close();
  const std::lock_guard lock(eki_mutex_);
  fault_.clear();
  refused_.clear();
  written_ = wanted_ = Outputs();
  current_panel_ = {};
  if (!connect_services() || !bind_rsi()) {
    eki_.close();
    rsi_ = Descriptor();
    return false;
  }
  open_ = true;
  quit_ = false;
  go_ = false;
  stands_ = false;
  renew_ = true;
  phase_ = settings_.eki ? Phase::idle : Phase::starting;
  thread_ = std::thread([this] { run(); });
  if (settings_.eki) services_ = std::thread([this] { run_services(); });
  return true;
}

void Link::close() {
  stop();
  quit_ = true;
  wake();
  ::eventfd_write(services_wake_.number(), 1);
  if (thread_.joinable()) thread_.join();
  if (services_.joinable()) services_.join();
  phase_ = Phase::idle;
  const std::lock_guard lock(eki_mutex_);
  open_ = false;
  rsi_ = Descriptor();
  eki_.close();
}

/// Until EthernetKRL says that RSI is off; without it, until its packets end.
bool Link::await_rsi_end(Nanoseconds timeout) {
  if (!settings_.eki) {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, std::chrono::nanoseconds(timeout), [this] { return quiet_.load(); });
    return true;
  }
  const Nanoseconds deadline = realtime::monotonic_now() + timeout;
  for (EkiDo what = EkiDo::stop;; what = EkiDo::state, wire::wait_readable(-1, kPause / 5)) {
    const auto reply = eki_.ask(what);
    if (!reply) return false;
    take_panel(reply->state);
    if (!reply->state.rsi) return true;
    if (realtime::monotonic_now() > deadline) return false;
  }
}

bool Link::end_old_session(bool runs) {
  if (!runs) return true;
  if (await_rsi_end(kRsiEnd)) return true;
  return eki_.failure().cause != Cause::none
             ? refuse_eki()
             : refuse(Cause::start_refused, static_cast<int>(EkiResult::busy));
}

bool Link::begin_program() {
  go_ = true;
  if (!settings_.eki) return true;
  {
    std::unique_lock lock(mutex_);
    renew(lock);
    phase_ = Phase::starting;
  }
  const auto reply = eki_.ask(EkiDo::start);
  if (!reply) return refuse_eki();
  return reply->result == EkiResult::done ? true
                                          : refuse(Cause::start_refused, static_cast<int>(reply->result));
}

bool Link::await_running() {
  const Nanoseconds deadline = realtime::monotonic_now() + settings_.start_timeout;
  const auto begun = [this] { return phase_ == Phase::streaming || fault_ || unusable_ != Cause::none; };
  for (;;) {
    Cause unusable = Cause::none;
    int unusable_detail = 0;
    {
      std::unique_lock lock(mutex_);
      changed_.wait_for(lock, std::chrono::nanoseconds(kPause), begun);
      if (phase_ == Phase::streaming) return true;
      unusable = unusable_;
      unusable_detail = unusable_detail_;
    }
    if (fault_) return false;
    if (unusable != Cause::none) return refuse(unusable, unusable_detail);
    const bool over = realtime::monotonic_now() > deadline;
    if (settings_.eki) {
      const auto reply = eki_.ask(EkiDo::state);
      if (!reply) return refuse_eki();
      take_panel(reply->state);
      int detail = 0;
      const Cause cause = cause_of(reply->state, detail);
      const bool may_come = cause == Cause::rsi_ended || cause == Cause::program_ended ||
                            cause == Cause::program_stopped || cause == Cause::drives_off;
      if (cause != Cause::none && (over || !may_come)) return refuse(cause, detail);
    }
    if (!over) continue;
    if (displaced_) return refuse(Cause::start_refused, static_cast<int>(EkiResult::busy));
    if (const std::string from = stranger(); !from.empty()) return refuse(Cause::other_sender, 0, from);
    return refuse(Cause::no_packets, 0, own_address_ + ":" + std::to_string(rsi_port()));
  }
}

/// RSI does not run when this returns, as far as the controller can be reached.
void Link::give_up_start() {
  const auto why = refused_.value();
  const std::string said = text();
  {
    const std::lock_guard lock(mutex_);
    if (phase_ != Phase::idle) phase_ = Phase::ending;
  }
  if (settings_.eki) await_rsi_end(kRsiEnd);
  rest();
  refuse(why.cause, why.detail, said);
}

bool Link::start() {
  if (!thread_.joinable()) return refuse(Cause::silent);
  if (fault_) return false;
  refused_.clear();
  const std::lock_guard lock(eki_mutex_);
  outputs_.fetch();  // what was wanted before counts no more
  written_ = wanted_ = Outputs();
  if (settings_.eki) {
    const auto reply = eki_.ask(EkiDo::state);
    if (!reply) return refuse_eki();
    take_panel(reply->state);
    if (!check_panel(reply->state, settings_.drives_on, settings_.start_timeout) ||
        !end_old_session(reply->state.rsi))
      return false;
  }
  if (begin_program() && await_running()) return true;
  give_up_start();
  return false;
}

void Link::stop() {
  if (phase_ == Phase::idle) return;
  {
    std::unique_lock lock(mutex_);
    phase_ = Phase::ending;
    wake();
    changed_.wait_for(lock, std::chrono::nanoseconds(settings_.start_timeout),
                      [this] { return stands_.load(); });
  }
  const std::lock_guard lock(eki_mutex_);
  await_rsi_end(kRsiEnd);
  rest();
}

/// Nothing runs; without EthernetKRL, the next packets are those of a program that a person starts.
void Link::rest() {
  const std::lock_guard lock(mutex_);
  go_ = false;
  renew_ = !settings_.eki;
  phase_ = settings_.eki ? Phase::idle : Phase::starting;
  wake();
}

}  // namespace polyarm::kuka
