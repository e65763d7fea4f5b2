/// How a link begins and ends: connections, errors, motors, servo mode.
#include <algorithm>
#include <limits>
#include <utility>

#include "drivers/xarm/link.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::xarm {

namespace {

constexpr int kAllJoints = 8;
constexpr Nanoseconds kStanding = 1'000'000'000;  // for a robot to stand

}  // namespace

Outputs::Outputs() noexcept {
  digital.fill(std::numeric_limits<double>::quiet_NaN());
}

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

/// Over the second connection.
std::optional<UxReply> Link::ask(Register reg, const std::vector<std::uint8_t>& data) {
  const std::lock_guard lock(services_mutex_);
  auto reply = services_port_.ask(reg, data, settings_.timeout);
  if (!reply) refuse_port(services_port_);
  return reply;
}

std::optional<Link::ErrorCodes> Link::ask_error() {
  const auto reply = ask(Register::get_error);
  if (!reply) return std::nullopt;
  if (reply->data.size() >= 2) return ErrorCodes{reply->data[0], reply->data[1]};
  refuse(Cause::bad_data);
  return std::nullopt;
}

bool Link::identify() {
  const auto reply = ask(Register::version);
  if (!reply) return false;
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
  written_ = wanted_ = Outputs();
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

/// An error that is still there comes back, and is named.
bool Link::clear_error() {
  auto codes = ask_error();
  if (!codes) return false;
  if (codes->error == 0 && codes->warning == 0) return true;
  if (codes->error != 0 && !settings_.clear_errors) return refuse(Cause::error_pending, codes->error);
  if (!ask(Register::clean_warning) || (codes->error != 0 && !ask(Register::clean_error))) return false;
  codes = ask_error();
  if (!codes) return false;
  return codes->error == 0 || refuse(cause_of_error(codes->error), codes->error);
}

bool Link::set(Register reg, unsigned value) {
  const auto reply = ask(reg, UxData().u8(value));
  if (!reply) return false;
  return !(reply->bits & kInvalidBit) || refuse(Cause::request_refused, static_cast<int>(reg));
}

/// Motors, mode and state, in the order in which the maker wants them.
bool Link::set_up_motion() {
  const auto enabled = ask(Register::motion_enable, UxData().u8(kAllJoints).u8(1));
  if (!enabled) return false;
  if (enabled->bits & (kErrorBit | kInvalidBit)) {
    const auto codes = ask_error();
    if (!codes) return false;
    return codes->error != 0 ? refuse(cause_of_error(codes->error), codes->error)
                             : refuse(Cause::enable_refused);
  }
  if (!set(Register::set_mode, static_cast<unsigned>(Mode::servo))) return false;
  if (!await_report(settings_.start_timeout, &Link::in_servo_mode))
    return !fault_ && refuse(Cause::mode_refused);
  if (!set(Register::set_state, 0)) return false;
  if (await_report(settings_.start_timeout, &Link::is_ready)) return true;
  if (fault_) return false;
  const auto codes = ask_error();
  if (!codes) return false;
  return codes->error != 0 ? refuse(cause_of_error(codes->error), codes->error)
                           : refuse(Cause::state_refused);
}

bool Link::start() {
  if (!thread_.joinable()) return refuse(Cause::report_silent);
  if (fault_) return false;
  refused_.clear();
  {
    const std::lock_guard lock(services_mutex_);
    outputs_.fetch();  // what was wanted before counts no more
    written_ = wanted_ = Outputs();
  }
  if (!await_report(std::min(settings_.start_timeout, kStanding), &Link::stands_still))
    return !fault_ && refuse(Cause::moves);
  if (!clear_error() || !set_up_motion()) return false;
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
