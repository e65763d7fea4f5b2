/// How a link begins and ends: connections, errors, motors, servo mode.
#include <algorithm>
#include <utility>

#include "drivers/xarm/link.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::xarm {

namespace {

constexpr Nanoseconds kStanding = 1'000'000'000;  // for a robot to stand

}  // namespace

Link::Link(LinkSettings settings)
    : StreamLink("the controller at " + settings.host),
      settings_(std::move(settings)),
      services_wake_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)),
      motion_(settings_.host, settings_.command_port),
      services_port_(settings_.host, settings_.command_port),
      shaper_(settings_.period) {}

bool Link::refuse_port(const UxPort& port) {
  return refuse(port.failure().cause, 0, port.failure().text);
}

bool Link::refuse_panel() {
  return refuse(panel_.failure().cause, panel_.failure().detail, panel_.failure().text);
}

bool Link::identify() {
  const auto reply = panel_.ask(Register::version);
  if (!reply) return refuse_panel();
  version_ = parse_version(reply->data);
  const bool old = std::pair(version_.major, version_.minor) < std::pair(kLeastMajor, kLeastMinor);
  if (old) return refuse(Cause::old_firmware, 0, version_.firmware());
  if (version_.axes != 0 && version_.axes != static_cast<int>(settings_.axes))
    return refuse(Cause::wrong_axes, version_.axes);
  return true;
}

/// Waits for the first report.
bool Link::connect_reports() {
  std::string why;
  report_reader_ = ReportReader();
  report_socket_ = wire::connect_tcp(settings_.host, settings_.report_port, settings_.timeout, why);
  if (!report_socket_) return refuse(Cause::unreachable, 0, why);
  const Nanoseconds deadline = realtime::monotonic_now() + settings_.timeout;
  while (!has_report()) {
    take_reports(realtime::monotonic_now());
    if (fault_) return false;
    if (has_report()) return true;
    const Nanoseconds left = deadline - realtime::monotonic_now();
    if (left <= 0) return refuse(Cause::report_silent);
    wire::wait_readable(report_socket_.number(), left);
  }
  return true;
}

bool Link::open() {
  close();
  const std::lock_guard lock(services_mutex_);
  fault_.clear();
  refused_.clear();
  outputs_.fetch();  // what was wanted before counts no more
  wanted_ = Outputs();
  panel_.forget();
  current_ = {};
  current_panel_ = {};
  reports_seen_ = 0;
  still_reports_ = 0;
  const bool connected = services_port_.open(settings_.timeout) || refuse_port(services_port_);
  if (!connected || !identify() || !(motion_.open(settings_.timeout) || refuse_port(motion_)) ||
      !connect_reports() || !serve_round()) {
    motion_.close();
    services_port_.close();
    report_socket_ = Descriptor();
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
  motion_.close();
  services_port_.close();
  report_socket_ = Descriptor();
}

bool Link::await_report(Nanoseconds timeout, bool (Link::*seen)() const) {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, std::chrono::nanoseconds(timeout), [&] { return fault_ || (this->*seen)(); });
  return !fault_ && (this->*seen)();
}

bool Link::set(Register reg, unsigned value) {
  const std::lock_guard lock(services_mutex_);
  return panel_.set(reg, value) || refuse_panel();
}

/// Motors, mode and state, in the order in which the maker wants them.
bool Link::set_up_motion() {
  {
    const std::lock_guard lock(services_mutex_);
    if (!panel_.clear(settings_.clear_errors) || !panel_.enable_motors()) return refuse_panel();
  }
  if (!set(Register::set_mode, static_cast<unsigned>(Mode::servo))) return false;
  if (!await_report(settings_.start_timeout, &Link::in_servo_mode))
    return !fault_ && refuse(Cause::mode_refused, static_cast<int>(Mode::servo));
  if (!set(Register::set_state, 0)) return false;
  if (await_report(settings_.start_timeout, &Link::is_ready)) return true;
  if (fault_) return false;
  const std::lock_guard lock(services_mutex_);
  return panel_.fail_with_error(Cause::state_refused) || refuse_panel();
}

bool Link::start() {
  if (!thread_.joinable()) return refuse(Cause::report_silent);
  if (fault_) return false;
  refused_.clear();
  {
    const std::lock_guard lock(services_mutex_);
    outputs_.fetch();  // what was wanted before counts no more
    wanted_ = Outputs();
    panel_.forget();
  }
  if (!await_report(std::min(settings_.start_timeout, kStanding), &Link::stands_still))
    return !fault_ && refuse(Cause::moves);
  if (!set_up_motion()) return false;
  std::unique_lock lock(mutex_);
  renew(lock);
  phase_ = Phase::streaming;
  return true;
}

/// Where the controller stopped by itself, or somebody chose another mode, nothing is changed.
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
  const std::lock_guard lock(services_mutex_);
  if (stopped_ || !services_port_.is_open()) return;
  const auto tell = [this](Register reg, unsigned value) {
    return services_port_.ask(reg, UxData().u8(value), settings_.timeout).has_value();
  };
  if (tell(Register::set_state, static_cast<unsigned>(State::stopped)))
    tell(Register::set_mode, static_cast<unsigned>(Mode::position));
}

}  // namespace polyarm::xarm
