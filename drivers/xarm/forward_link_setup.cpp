/// How a link in forward mode begins and ends.
#include <algorithm>
#include <utility>

#include "drivers/xarm/forward_link.hpp"
#include "drivers/xarm/watchdog.hpp"

namespace polyarm::xarm {

namespace {

constexpr Nanoseconds kToStandFirst = 1'000'000'000;    // for a robot to stand
constexpr Nanoseconds kBesideAnAnswer = 3'000'000'000;  // beside the time of an answer
constexpr int kForwardAxes = 6;

}  // namespace

ForwardLink::ForwardLink(ForwardSettings settings)
    : MoveLink({settings.frame, kMoveSlots, forward::MoveQueue::Paces::in_moves}, settings.times,
               "the controller at " + settings.host),
      settings_(std::move(settings)),
      port_(settings_.host, settings_.command_port),
      panel_(port_, settings_.signals, settings_.answer) {
  gone_ = true;
}

bool ForwardLink::refuse_panel() {
  return refuse(panel_.failure().cause, panel_.failure().detail, panel_.failure().text);
}

bool ForwardLink::identify() {
  const auto reply = panel_.ask(Register::version);
  if (!reply) return refuse_panel();
  version_ = parse_version(reply->data);
  forms_ = forms_of(version_);
  if (std::pair(version_.major, version_.minor) < std::pair(kLeastMajor, kLeastMinor))
    return refuse(Cause::old_firmware, 0, version_.firmware());
  return version_.axes == 0 || version_.axes == kForwardAxes || refuse(Cause::wrong_axes, version_.axes);
}

/// Until `seen()`, with reports that were made after this call. False: not in time, or a fault.
template <typename Seen>
bool ForwardLink::await_report(Nanoseconds timeout, Seen seen) {
  constexpr std::uint64_t kOnTheirWay = 2;
  const Nanoseconds deadline = realtime::monotonic_now() + timeout;
  take_reports();
  const std::uint64_t fresh = current_.count + kOnTheirWay;
  while (!fault_ && report_socket_) {
    if (current_.count >= fresh && seen()) return true;
    const Nanoseconds left = deadline - realtime::monotonic_now();
    if (left <= 0) return false;
    wire::wait_readable(report_socket_.number(), left);
    take_reports();
  }
  return false;
}

bool ForwardLink::connect_reports() {
  std::string why;
  report_reader_ = ReportReader();
  report_socket_ = wire::connect_tcp(settings_.host, settings_.report_port, settings_.timeout, why);
  if (!report_socket_) return refuse(Cause::unreachable, 0, why);
  return await_report(settings_.timeout, [] { return true; }) || (!fault_ && refuse(Cause::report_silent));
}

bool ForwardLink::open() {
  close();
  fault_.clear();
  refused_.clear();
  current_ = {};
  heard_ = 0;
  still_reports_ = foreign_reports_ = 0;
  panel_.forget();
  const bool connected =
      port_.open(settings_.timeout) || refuse(port_.failure().cause, 0, port_.failure().text);
  if (!connected || !identify() || !connect_reports() || !read_panel()) {
    port_.close();
    report_socket_ = Descriptor();
    return false;
  }
  samples_.write(current_);
  gone_ = false;
  run_thread();
  return true;
}

void ForwardLink::close() {
  stop();
  halt_thread();
  gone_ = true;
  port_.close();
  report_socket_ = Descriptor();
}

/// A state that the reports have to show; without it, an error of the controller, or this cause.
bool ForwardLink::becomes(bool seen, Cause otherwise) {
  if (seen || fault_) return seen;
  return panel_.fail_with_error(otherwise) || refuse_panel();
}

/// Motors, mode and state, in the order in which the maker wants them. The state "stopped" before them
/// empties the queue of an earlier session.
bool ForwardLink::begin() {
  const auto set = [this](Register reg, unsigned value) { return panel_.set(reg, value) || refuse_panel(); };
  still_reports_ = 0;
  if (!await_report(std::min(settings_.start_timeout, kToStandFirst), [this] { return has_stopped(); }))
    return !fault_ && refuse(Cause::moves);
  if (!panel_.clear(settings_.clear_errors) || !panel_.enable_motors()) return refuse_panel();
  if (!set(Register::set_state, static_cast<unsigned>(State::stopped)) ||
      !set(Register::set_mode, static_cast<unsigned>(Mode::position)) ||
      !becomes(
          await_report(settings_.start_timeout, [this] { return current_.report.mode == Mode::position; }),
          Cause::mode_refused))
    return false;
  if (!set(Register::set_state, 0)) return false;
  const auto ready = [this] {
    return current_.report.state <= State::standing && current_.report.queued == 0;
  };
  return becomes(await_report(settings_.start_timeout, ready), Cause::state_refused);
}

/// It is there before the first move.
bool ForwardLink::start_watchdog() {
  if (settings_.watchdog_ms == 0) return true;
  const WatchdogSettings words{settings_.host, settings_.command_port, settings_.watchdog_ms,
                               static_cast<int>(settings_.answer / 1'000'000)};
  watchdog::Health health = watchdog_.start(watchdog::find_program(kWatchdogProgram), words_of(words));
  if (health == watchdog::Health::fine) health = watchdog_.arm();
  return health == watchdog::Health::fine ||
         refuse(Cause::watchdog, static_cast<int>(health), std::to_string(settings_.watchdog_ms));
}

/// A connection that is lost while a session begins ends the link.
void ForwardLink::lose() {
  if (fault_ || (port_.is_open() && report_socket_)) return;
  gone_ = true;
  note(refused_ ? refused_.cause() : Cause::closed, 0, text());
}

bool ForwardLink::start() {
  if (!runs()) return refuse(Cause::report_silent);
  if (fault_) return false;
  refused_.clear();
  halt_thread();
  const bool fine = begin() && (read_panel() || refuse_panel()) && start_watchdog();
  if (fine) {
    panel_.forget();
    paused_ = forgotten_ = stop_sent_ = false;
    halt_ = Halt::none;
    put_ = ended_ = halting_ = halted_ = end_attempts_ = foreign_reports_ = 0;
    tool_set_.reset();
    changed_at_ = moved_at_ = time_;
    begin_session();
    begin_queue(report());
  } else {
    lose();
  }
  run_thread();
  return fine;
}

void ForwardLink::stop() {
  if (phase_ != Phase::idle) {
    finish(settings_.answer + kBesideAnAnswer);
    if (!stop_sent_) watchdog_.abandon();  // it stops the robot
  }
  watchdog_.stop();
}

}  // namespace polyarm::xarm
