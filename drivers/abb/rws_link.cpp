#include "drivers/abb/rws_link.hpp"

#include <arpa/inet.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "drivers/wire/six_axes.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::abb {

namespace {

constexpr Nanoseconds kRound = 50'000'000, kAgain = 100'000'000;
constexpr int kStateEvery = 4;    // rounds
constexpr int kMostFailures = 3;  // in a row
constexpr int kTries = 3;         // for the event log to show why
constexpr Nanoseconds kPause = 50'000'000;
constexpr Nanoseconds kMotors = 5'000'000'000;  // for the motors to be on

Panel::Control control_of(const std::string& text) {
  if (text == "motoron") return Panel::Control::motors_on;
  if (text == "motoroff") return Panel::Control::motors_off;
  if (text == "guardstop") return Panel::Control::guard_stop;
  if (text.starts_with("emergencystop")) return Panel::Control::emergency_stop;
  return text == "sysfail" ? Panel::Control::failure : Panel::Control::other;
}

/// Causes that a person must see before any other one.
bool is_plain(Cause cause) {
  return cause == Cause::none || cause == Cause::motors_off || cause == Cause::event;
}

}  // namespace

Outputs::Outputs() noexcept : speed_ratio(std::numeric_limits<double>::quiet_NaN()) {
  digital.fill(std::numeric_limits<double>::quiet_NaN());
}

RwsLink::RwsLink(ControllerSettings settings, bool stepped, Nanoseconds start_timeout)
    : LinkBase("the controller at " + settings.rws.http.host),
      rws_(settings.rws),
      controller_settings_(std::move(settings)),
      stepped_(stepped),
      start_timeout_(start_timeout),
      services_wake_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {}

// --- before the robot moves -----------------------------------------------------------------------------

bool RwsLink::refuse_rws() {
  const Rws::Failure why = rws_.failure();
  return refuse(why.cause, why.detail, why.text);
}

bool RwsLink::connect_services() {
  if (!rws_.identify(identity_)) {
    Rws::Failure why = rws_.failure();
    // An IRC5 has no TLS, and an OmniCore answers HTTP with a redirection or not at all.
    if (why.cause == Cause::rws_refused && (why.detail == 301 || why.detail == 302 || why.detail == 307))
      why = {Cause::other_version, 3 - controller_settings_.rws.version, ""};
    return refuse(why.cause, why.detail, why.text);
  }
  fingerprint_ = rws_.http().fingerprint();
  in_addr address{};
  ::inet_pton(AF_INET, rws_.http().peer_address().c_str(), &address);
  controller_ = address.s_addr;
  return true;
}

bool RwsLink::read_first() {
  asked_ = Sign::none;
  written_ = wanted_ = Outputs();
  current_panel_ = {};
  round_ = failures_ = 0;
  if (!read_signals(current_panel_) || !read_all()) return refuse_rws();
  ++current_panel_.count;
  show(current_panel_);
  return true;
}

bool RwsLink::check_panel() {
  RwsState state;
  if (!rws_.read_state(state)) return refuse_rws();
  const Cause cause = cause_of_state(state.control, state.mode);
  if (cause == Cause::motors_off) return controller_settings_.motors_on ? switch_motors_on() : refuse(cause);
  if (cause != Cause::none) return refuse(cause, 0, cause == Cause::manual_mode ? state.mode : "");
  if (state.program != "running") return true;
  return rws_.stop_program() ? true : refuse_rws();  // the program pointer moves only while it is stopped
}

bool RwsLink::switch_motors_on() {
  if (!rws_.motors(true)) {
    const Rws::Failure why = rws_.failure();
    return why.cause == Cause::rws_refused ? refuse(Cause::motors_refused, 0, why.text) : refuse_rws();
  }
  const Nanoseconds deadline = realtime::monotonic_now() + std::min(kMotors, start_timeout_);
  for (RwsState state;; wire::wait_readable(-1, kPause)) {
    if (!rws_.read_state(state)) return refuse_rws();
    if (state.control == "motoron") return true;
    if (realtime::monotonic_now() > deadline) return refuse(Cause::motors_refused, 0, state.control);
  }
}

bool RwsLink::begin_program(bool forever) {
  if (!rws_.reset_pointer()) return refuse_rws();
  if (rws_.start_program(forever)) return true;
  const Rws::Failure why = rws_.failure();
  return why.cause == Cause::rws_refused || why.cause == Cause::forbidden
             ? refuse(Cause::start_refused, 0, why.text)
             : refuse_rws();
}

bool RwsLink::refuse_why(Cause otherwise, const std::string& text) {
  const Rws::Failure why = find_why(Sign::silence);
  return why.cause == Cause::none ? refuse(otherwise, 0, text) : refuse(why.cause, why.detail, why.text);
}

bool RwsLink::begin_services() {
  round_ = 0;
  const auto events = rws_.events();
  if (events) seen_event_ = events->empty() ? 0 : events->front().sequence;
  outputs_.fetch();
  written_ = wanted_ = Outputs();
  return events ? true : refuse_rws();
}

// --- while it is open -----------------------------------------------------------------------------------

bool RwsLink::read_signals(Panel& panel) {
  const auto read = [&](const std::vector<std::string>& names, std::array<bool, kMostSignals>& into) {
    for (std::size_t i = 0; i < names.size() && asked_ == Sign::none; ++i) {  // why it stopped comes first
      const auto value = rws_.signal(names[i]);
      if (!value) return false;
      into[i] = *value;
    }
    return true;
  };
  return read(controller_settings_.inputs, panel.inputs) && read(controller_settings_.outputs, panel.outputs);
}

bool RwsLink::read_all() {
  RwsState state;
  if (!rws_.read_state(state)) return false;
  current_panel_.control = control_of(state.control);
  current_panel_.automatic = state.mode == "AUTO";
  current_panel_.running = state.program == "running";
  current_panel_.speed_ratio = state.speed_ratio;
  if (guided()) return true;
  const auto joints = rws_.joints();
  if (!joints) return false;
  for (std::size_t i = 0; i < 6; ++i) current_panel_.joints[i] = (*joints)[i] * wire::kRadians;
  return true;
}

/// Only what changed is written: somebody at the FlexPendant may have switched the others.
bool RwsLink::write_outputs() {
  if (outputs_.fetch()) wanted_ = outputs_.value();
  const auto differs = [](double wanted, double written) {
    return std::isfinite(wanted) && !(std::abs(wanted - written) < 1e-3);
  };
  for (std::size_t i = 0; i < controller_settings_.outputs.size(); ++i) {
    const double wanted =
        std::isfinite(wanted_.digital[i]) ? (wanted_.digital[i] > 0.5 ? 1.0 : 0.0) : wanted_.digital[i];
    if (!differs(wanted, written_.digital[i])) continue;
    if (!rws_.set_signal(controller_settings_.outputs[i], wanted > 0.5)) return false;
    written_.digital[i] = wanted;
  }
  if (differs(wanted_.speed_ratio, written_.speed_ratio)) {
    if (!rws_.set_speed_ratio(wanted_.speed_ratio)) return false;
    written_.speed_ratio = wanted_.speed_ratio;
  }
  return true;
}

void RwsLink::serve_round() {
  const bool states = round_++ % kStateEvery == 0;
  if (write_outputs() && read_signals(current_panel_) && (!states || read_all())) {
    failures_ = 0;
    ++current_panel_.count;
    show(current_panel_);
    return;
  }
  const Rws::Failure& why = rws_.failure();
  const bool refused = why.cause == Cause::signal_refused || why.cause == Cause::no_signal ||
                       why.cause == Cause::mastership || why.cause == Cause::forbidden;
  if (refused || ++failures_ >= kMostFailures) note(why.cause, why.detail, why.text);
}

void RwsLink::serve_services() {
  const std::unique_lock lock(rws_mutex_, std::try_to_lock);
  if (lock && open_ && !fault_) serve_round();
}

Rws::Failure RwsLink::find_why(Sign sign) {
  RwsState state;
  if (!rws_.read_state(state)) return rws_.failure();
  const Cause shown = cause_of_state(state.control, state.mode);
  Rws::Failure out{shown, 0, ""};
  if (sign == Sign::restart && shown == Cause::none) return {Cause::restarted, 0, ""};
  const auto events = rws_.events(seen_event_);
  if (!events) return rws_.failure();
  for (auto event = events->rbegin(); event != events->rend(); ++event) {  // the oldest first
    const Cause cause = cause_of_event(event->code);
    if (cause == shown && cause != Cause::none) out.text = event->title;
    if (!is_plain(out.cause)) continue;
    if (cause != Cause::none && (!is_plain(cause) || out.cause == Cause::none))
      out = {cause, event->code, event->title};
    if (cause == Cause::none && event->kind == 3 && out.cause == Cause::none)
      out = {Cause::event, event->code, event->title};
  }
  if (out.cause != Cause::none) return out;
  if (state.program == "stopped") return {Cause::program_stopped, 0, ""};
  switch (sign) {
    case Sign::error:
      return {Cause::egm_error, 0, ""};
    case Sign::silence:
      return {Cause::none, 0, ""};
    default:
      return {Cause::egm_stopped, 0, ""};
  }
}

/// The robot stopped: the controller is asked why, and has a moment to write it into its event log.
void RwsLink::say_why() {
  const Sign sign = asked_;
  if (sign == Sign::none || fault_) return;
  Rws::Failure why;
  for (int i = 0; i < kTries; ++i) {
    const std::lock_guard lock(rws_mutex_);
    why = find_why(sign);
    const bool vague = why.cause == Cause::none || why.cause == Cause::motors_off ||
                       why.cause == Cause::program_stopped || why.cause == Cause::egm_stopped;
    if (!vague || services_quit_) break;
    if (i + 1 < kTries) wire::wait_readable(-1, kAgain);
  }
  if (why.cause == Cause::none) why.cause = vague_cause();
  note(why.cause, why.detail, why.text);
}

void RwsLink::run_services() {
  Nanoseconds due = realtime::monotonic_now();
  while (!services_quit_) {
    const Nanoseconds left = stepped_ ? 1'000'000'000 : due - realtime::monotonic_now();
    if (left > 0 && wire::wait_readable(services_wake_.number(), left)) calm(services_wake_.number());
    say_why();
    if (services_quit_ || stepped_ || realtime::monotonic_now() < due) continue;
    if (!fault_) serve_services();
    due = realtime::monotonic_now() + kRound;  // behind the round: others get the client in between
  }
}

void RwsLink::run_service_thread() {
  services_quit_ = false;
  services_ = std::thread([this] { run_services(); });
}

void RwsLink::halt_service_thread() {
  services_quit_ = true;
  ::eventfd_write(services_wake_.number(), 1);
  if (services_.joinable()) services_.join();
}

void RwsLink::ask_why(Sign sign) {
  if (asked_.exchange(sign) != sign) ::eventfd_write(services_wake_.number(), 1);
}

}  // namespace polyarm::abb
