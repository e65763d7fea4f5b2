/// How a link begins and ends: connections, modes, servos, the job that lets MotoROS move the robot.
#include <algorithm>
#include <limits>
#include <utility>

#include "drivers/yaskawa/link.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::yaskawa {

namespace {

constexpr Nanoseconds kStanding = 1'000'000'000;  // for a robot to stand, beside the buffer

}  // namespace

Outputs::Outputs() noexcept {
  digital.fill(std::numeric_limits<double>::quiet_NaN());
}

Link::Link(LinkSettings settings)
    : LinkBase("the controller at " + settings.host),
      settings_(std::move(settings)),
      services_wake_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)),
      state_(settings_.host, settings_.state_port),
      motion_(settings_.host, settings_.motion_port),
      io_(settings_.host, settings_.io_port),
      hses_(settings_.host, settings_.hses_port, settings_.timeout),
      stream_(settings_.point_ms, settings_.lead_ms, settings_.cycles) {}

bool Link::refuse_port(const MotoPort& port) {
  return refuse(port.failure().cause, 0, port.failure().text);
}

/// Its first state shows the byte order.
bool Link::connect_moto() {
  if (!state_.open(settings_.timeout, std::nullopt)) return refuse_port(state_);
  const Nanoseconds deadline = realtime::monotonic_now() + settings_.timeout;
  while (!has_state()) {
    const Nanoseconds now = realtime::monotonic_now();
    const bool well = state_.receive();
    while (const auto message = state_.next()) take_state(*message, now);
    if (fault_) return false;
    if (!well) return refuse_port(state_);
    if (without_feedback_ >= 3) return refuse(Cause::no_group, settings_.group);
    if (has_state()) break;
    if (now > deadline) return refuse(Cause::state_silent);
    wire::wait_readable(state_.descriptor(), deadline - now);
  }
  if (!motion_.open(settings_.timeout, state_.order())) return refuse_port(motion_);
  if (!motion_.control(MotoCommand::check_ready, settings_.group, settings_.timeout))
    return refuse_port(motion_);
  const bool signals = settings_.inputs.count + settings_.outputs.count > 0;
  return !signals || io_.open(settings_.timeout, state_.order()) || refuse_port(io_);
}

bool Link::connect_hses() {
  system_.clear();
  if (!settings_.hses) return true;
  if (hses_.open() && hses_.status()) {
    const std::string version = hses_.system(kFirstRobot, 1), model = hses_.system(kFirstRobot, 2);
    system_ = model + (model.empty() || version.empty() ? "" : ", ") + version;
    return true;
  }
  return refuse(hses_.failure().cause, hses_.failure().detail, hses_.failure().text);
}

bool Link::open() {
  close();
  const std::lock_guard lock(services_mutex_);
  fault_.clear();
  refused_.clear();
  outputs_.fetch();  // what an earlier session wanted counts no more
  written_ = wanted_ = Outputs();
  current_ = {};
  current_panel_ = {};
  states_seen_ = 0;
  still_states_ = without_feedback_ = 0;
  fresh_feedback_ = false;
  if (!connect_hses() || !connect_moto() || !serve_round()) {
    for (MotoPort* port : {&state_, &motion_, &io_}) port->close();
    hses_.close();
    return false;
  }
  open_ = true;
  quit_ = false;
  thread_ = std::thread([this] { run(); });
  if (!settings_.stepped) services_ = std::thread([this] { run_services(); });
  return true;
}

void Link::close() {
  stop();
  quit_ = true;
  wake();
  ::eventfd_write(services_wake_.number(), 1);
  if (thread_.joinable()) thread_.join();
  if (services_.joinable()) services_.join();
  const std::lock_guard lock(services_mutex_);
  open_ = false;
  for (MotoPort* port : {&state_, &motion_, &io_}) port->close();
  hses_.close();
}

/// What a person has to change at the controller first. MotoROS would reset an alarm by itself: not here.
bool Link::check_ready() {
  const auto reply = motion_.control(MotoCommand::check_ready, settings_.group, settings_.timeout);
  if (!reply) return refuse_port(motion_);
  if (reply->result == MotoResult::success) return true;
  const Why why = why_not(static_cast<int>(MotoResult::not_ready), reply->subcode);
  switch (why.cause) {
    case Cause::servo_off:
      return settings_.servo_on || refuse(why.cause);
    case Cause::not_started:
    case Cause::waiting_ros:
    case Cause::increment_refused:
    case Cause::skill_send:
    case Cause::pfl:
    case Cause::not_ready:
      return true;
    default:
      const Explained more = explain(why.cause, why.detail);
      return refuse(why.cause, more.detail, more.text);
  }
}

bool Link::await_state(Nanoseconds timeout, bool (Link::*seen)() const) {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, std::chrono::nanoseconds(timeout), [&] { return fault_ || (this->*seen)(); });
  return !fault_ && (this->*seen)();
}

/// Points of another client may still be in the buffer.
bool Link::await_standing() {
  const Nanoseconds patience = std::min(settings_.start_timeout, kStanding);
  const Nanoseconds deadline = realtime::monotonic_now() + patience;
  for (;;) {
    const auto reply = motion_.control(MotoCommand::check_queue, settings_.group, settings_.timeout);
    if (!reply) return refuse_port(motion_);
    if (reply->subcode <= 0 && await_state(patience, &Link::stands_still)) return true;
    if (fault_) return false;
    if (realtime::monotonic_now() > deadline) return refuse(Cause::moves);
  }
}

bool Link::start_job() {
  const auto reply = motion_.control(MotoCommand::start_trajectory, settings_.group, settings_.start_timeout);
  if (!reply) return refuse_port(motion_);
  if (reply->result != MotoResult::success) {
    Why why = why_not(static_cast<int>(MotoResult::not_ready), reply->subcode);
    if (why.cause == Cause::servo_off) why.cause = Cause::servo_refused;
    const Explained more = explain(why.cause, why.detail);
    return refuse(why.cause, more.detail, more.text);
  }
  if (await_state(settings_.start_timeout, &Link::may_move)) return true;
  return !fault_ && refuse(Cause::moves);
}

bool Link::start() {
  if (!thread_.joinable()) return refuse(Cause::state_silent);
  if (fault_) return false;
  refused_.clear();
  if (!motion_.is_open() && !motion_.open(settings_.timeout, state_.order())) return refuse_port(motion_);
  {
    const std::lock_guard lock(services_mutex_);
    outputs_.fetch();  // what was wanted before counts no more
    written_ = wanted_ = Outputs();
  }
  if (!check_ready() || !await_standing() || !start_job()) return false;
  std::unique_lock lock(mutex_);
  renew_ = true;
  wake();
  changed_.wait(lock, [this] { return !renew_; });
  phase_ = Phase::streaming;
  return true;
}

void Link::stop() {
  if (phase_ == Phase::idle) return;
  {
    std::unique_lock lock(mutex_);
    phase_ = Phase::ending;
    wake();
    changed_.wait_for(lock, std::chrono::nanoseconds(settings_.start_timeout),
                      [this] { return stands_.load(); });
    stands_ = true;  // the connection for motion is this thread's
    phase_ = Phase::idle;
  }
  if (lost_) return motion_.close();
  const auto stopped = motion_.control(MotoCommand::stop_trajectory, settings_.group, settings_.timeout);
  if (!stopped || stopped->result == MotoResult::success) return;
  motion_.control(MotoCommand::stop_motion, settings_.group, settings_.timeout);
  motion_.control(MotoCommand::stop_trajectory, settings_.group, settings_.timeout);
}

}  // namespace polyarm::yaskawa
