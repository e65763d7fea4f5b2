/// How a link begins and ends: version, options, modes, motors, the program that lets EGM move the robot.
#include <arpa/inet.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "drivers/abb/link.hpp"
#include "drivers/abb/rapid.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::abb {

namespace {

constexpr Nanoseconds kPause = 50'000'000;
constexpr Nanoseconds kMotors = 5'000'000'000;  // for the motors to be on

}  // namespace

Outputs::Outputs() noexcept : speed_ratio(std::numeric_limits<double>::quiet_NaN()) {
  digital.fill(std::numeric_limits<double>::quiet_NaN());
}

Link::Link(LinkSettings settings)
    : StreamLink("the controller at " + settings.rws.http.host),
      settings_(std::move(settings)),
      services_wake_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)),
      rws_(settings_.rws),
      shaper_(settings_.sampling_ms / 1000.0),
      pacer_(settings_.loop_silence) {}

bool Link::refuse_rws() {
  const Rws::Failure why = rws_.failure();
  return refuse(why.cause, why.detail, why.text);
}

bool Link::connect_services() {
  if (!rws_.identify(identity_)) {
    Rws::Failure why = rws_.failure();
    // An IRC5 has no TLS, and an OmniCore answers HTTP with a redirection or not at all.
    if (why.cause == Cause::rws_refused && (why.detail == 301 || why.detail == 302 || why.detail == 307))
      why = {Cause::other_version, 3 - settings_.rws.version, ""};
    return refuse(why.cause, why.detail, why.text);
  }
  fingerprint_ = rws_.http().fingerprint();
  in_addr address{};
  ::inet_pton(AF_INET, rws_.http().peer_address().c_str(), &address);
  controller_ = address.s_addr;
  return true;
}

bool Link::check_controller() {
  if (!identity_.recent()) return refuse(Cause::old_software, 0, identity_.software);
  if (!identity_.guided()) return refuse(Cause::no_option);
  return rws_.has_module(settings_.task, kModuleName) ? true : refuse_rws();
}

/// Only the interface that reaches the controller listens.
bool Link::bind_egm() {
  const std::string address =
      settings_.egm_address.empty() ? rws_.http().own_address() : settings_.egm_address;
  std::string why;
  egm_ = wire::bind_udp(address, settings_.egm_port, why);
  return egm_ ? true : refuse(Cause::port_taken, 0, why);
}

bool Link::open() {
  close();
  const std::lock_guard lock(rws_mutex_);
  fault_.clear();
  refused_.clear();
  asked_ = Sign::none;
  current_ = {};
  written_ = wanted_ = Outputs();
  current_panel_ = {};
  round_ = failures_ = 0;
  began_ = realtime::monotonic_now();
  bool fine = connect_services() && check_controller() && bind_egm();
  if (fine && !(read_signals(current_panel_) && read_all())) fine = refuse_rws();
  if (!fine) {
    rws_.close();
    egm_ = Descriptor();
    return false;
  }
  ++current_panel_.count;
  panels_.write(current_panel_);
  open_ = true;
  begin_session();
  run_egm();
  run_service_thread();
  return true;
}

void Link::close() {
  stop();
  halt_threads();
  const std::lock_guard lock(rws_mutex_);
  egm_ = Descriptor();
  if (std::exchange(open_, false)) rws_.log_out();
  rws_.close();
}

void Link::begin_session() {
  fresh_ = true;
  steady_ = behind_ = errors_ = 0;
  sign_ = Sign::none;
  asked_ = Sign::none;
  commanded_ = late_ = false;
  current_.behind = 0;
  stop_wanted_ = false;
  unusable_ = Cause::none;
  strange_ = false;
  sequence_ = 0;
  current_.count = answered_ = current_.strangers = 0;
  heard_ = realtime::monotonic_now();
}

void Link::run_egm() {
  quit_ = false;
  thread_ = std::thread([this] { run(); });
}

void Link::run_service_thread() {
  services_ = std::thread([this] { run_services(); });
}

void Link::halt_threads() {
  quit_ = true;
  wake();
  ::eventfd_write(services_wake_.number(), 1);
  if (thread_.joinable()) thread_.join();
  if (services_.joinable()) services_.join();
}

/// What a person has to change at the controller first.
bool Link::check_panel() {
  RwsState state;
  if (!rws_.read_state(state)) return refuse_rws();
  const Cause cause = cause_of_state(state.control, state.mode);
  if (cause == Cause::motors_off) return settings_.motors_on ? switch_motors_on() : refuse(cause);
  if (cause != Cause::none) return refuse(cause, 0, cause == Cause::manual_mode ? state.mode : "");
  if (state.program != "running") return true;
  return rws_.stop_program() ? true : refuse_rws();  // the program pointer moves only while it is stopped
}

bool Link::switch_motors_on() {
  if (!rws_.motors(true)) {
    const Rws::Failure why = rws_.failure();
    return why.cause == Cause::rws_refused ? refuse(Cause::motors_refused, 0, why.text) : refuse_rws();
  }
  const Nanoseconds deadline = realtime::monotonic_now() + std::min(kMotors, settings_.start_timeout);
  for (RwsState state;; wire::wait_readable(-1, kPause)) {
    if (!rws_.read_state(state)) return refuse_rws();
    if (state.control == "motoron") return true;
    if (realtime::monotonic_now() > deadline) return refuse(Cause::motors_refused, 0, state.control);
  }
}

bool Link::begin_program() {
  if (!rws_.reset_pointer()) return refuse_rws();
  if (rws_.start_program()) return true;
  const Rws::Failure why = rws_.failure();
  return why.cause == Cause::rws_refused || why.cause == Cause::forbidden
             ? refuse(Cause::start_refused, 0, why.text)
             : refuse_rws();
}

/// The event log first, then what is known.
bool Link::refuse_why(Cause otherwise) {
  const Rws::Failure why = find_why(Sign::silence);
  if (why.cause == Cause::none)
    return refuse(
        otherwise, 0,
        otherwise == Cause::no_packets ? rws_.http().own_address() + ":" + std::to_string(egm_port()) : "");
  return refuse(why.cause, why.detail, why.text);
}

bool Link::await_running() {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, std::chrono::nanoseconds(settings_.start_timeout),
                    [this] { return phase_ == Phase::streaming || fault_ || unusable_ != Cause::none; });
  if (phase_ == Phase::streaming) return true;
  lock.unlock();
  halt_threads();
  phase_ = Phase::idle;
  if (fault_) return false;
  if (unusable_ == Cause::egm_error) return refuse_why(unusable_);
  if (unusable_ != Cause::none) return refuse(unusable_, unusable_detail_);
  if (current_.count > 0) return refuse_why(Cause::not_running);
  return current_.strangers > 0 ? refuse(Cause::other_sender) : refuse_why(Cause::no_packets);
}

bool Link::start() {
  if (!thread_.joinable()) return refuse(Cause::silent);
  if (fault_) return false;
  refused_.clear();
  halt_threads();
  const std::lock_guard lock(rws_mutex_);
  round_ = 0;
  const auto events = rws_.events();
  bool fine = events ? true : refuse_rws();
  if (events) seen_event_ = events->empty() ? 0 : events->front().sequence;
  outputs_.fetch();  // what was wanted before counts no more
  written_ = wanted_ = Outputs();
  fine = fine && check_panel();
  begin_session();
  if (fine) {
    phase_ = Phase::starting;
    run_egm();
    fine = begin_program() && await_running();
  }
  if (!fine) {
    const auto why = refused_.value();
    const std::string said = text();
    halt_threads();
    phase_ = Phase::idle;
    rws_.stop_program();
    refuse(why.cause, why.detail, said);
    begin_session();
    run_egm();
  }
  run_service_thread();
  return fine;
}

void Link::stop() {
  if (phase_ == Phase::idle) return;
  stop_wanted_ = true;
  wake();
  {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, std::chrono::nanoseconds(settings_.start_timeout),
                      [this] { return phase_ == Phase::idle; });
  }
  halt_threads();
  phase_ = Phase::idle;
  {
    const std::lock_guard lock(rws_mutex_);
    rws_.stop_program();
    current_panel_.joints = current_.q;  // those of before the motion are old
    panels_.write(current_panel_);
    round_ = 0;
  }
  if (fault_) return;
  begin_session();
  run_egm();
  run_service_thread();
}

}  // namespace polyarm::abb
