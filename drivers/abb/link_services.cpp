/// What a link does over Robot Web Services while it is open: states, signals, and why the robot stopped.
#include <algorithm>
#include <cmath>

#include "drivers/abb/link.hpp"
#include "drivers/wire/six_axes.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::abb {

namespace {

constexpr Nanoseconds kRound = 50'000'000, kAgain = 100'000'000;
constexpr int kStateEvery = 4;    // rounds
constexpr int kMostFailures = 3;  // in a row
constexpr int kTries = 3;         // for the event log to show why

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

bool Link::read_signals(Panel& panel) {
  const auto read = [&](const std::vector<std::string>& names, std::array<bool, kMostSignals>& into) {
    for (std::size_t i = 0; i < names.size() && asked_ == Sign::none; ++i) {  // why it stopped comes first
      const auto value = rws_.signal(names[i]);
      if (!value) return false;
      into[i] = *value;
    }
    return true;
  };
  return read(settings_.inputs, panel.inputs) && read(settings_.outputs, panel.outputs);
}

bool Link::read_all() {
  RwsState state;
  if (!rws_.read_state(state)) return false;
  current_panel_.control = control_of(state.control);
  current_panel_.automatic = state.mode == "AUTO";
  current_panel_.running = state.program == "running";
  current_panel_.speed_ratio = state.speed_ratio;
  if (phase_ != Phase::idle) return true;
  const auto joints = rws_.joints();
  if (!joints) return false;
  for (std::size_t i = 0; i < 6; ++i) current_panel_.joints[i] = (*joints)[i] * wire::kRadians;
  return true;
}

/// Only what changed is written: somebody at the FlexPendant may have switched the others.
bool Link::write_outputs() {
  if (outputs_.fetch()) wanted_ = outputs_.value();
  const auto differs = [](double wanted, double written) {
    return std::isfinite(wanted) && !(std::abs(wanted - written) < 1e-3);
  };
  for (std::size_t i = 0; i < settings_.outputs.size(); ++i) {
    const double wanted =
        std::isfinite(wanted_.digital[i]) ? (wanted_.digital[i] > 0.5 ? 1.0 : 0.0) : wanted_.digital[i];
    if (!differs(wanted, written_.digital[i])) continue;
    if (!rws_.set_signal(settings_.outputs[i], wanted > 0.5)) return false;
    written_.digital[i] = wanted;
  }
  if (differs(wanted_.speed_ratio, written_.speed_ratio)) {
    if (!rws_.set_speed_ratio(wanted_.speed_ratio)) return false;
    written_.speed_ratio = wanted_.speed_ratio;
  }
  return true;
}

void Link::serve_round() {
  const bool states = round_++ % kStateEvery == 0;
  if (write_outputs() && read_signals(current_panel_) && (!states || read_all())) {
    failures_ = 0;
    ++current_panel_.count;
    panels_.write(current_panel_);
    return;
  }
  const Rws::Failure& why = rws_.failure();
  const bool refused = why.cause == Cause::signal_refused || why.cause == Cause::no_signal ||
                       why.cause == Cause::mastership || why.cause == Cause::forbidden;
  if (refused || ++failures_ >= kMostFailures) note(why.cause, why.detail, why.text);
}

void Link::serve_services() {
  const std::unique_lock lock(rws_mutex_, std::try_to_lock);
  if (lock && open_ && !fault_) serve_round();
}

/// What the controller itself says first, then what its event log says, then what EGM showed.
Rws::Failure Link::find_why(Sign sign) {
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
void Link::say_why() {
  const Sign sign = asked_;
  if (sign == Sign::none || fault_) return;
  Rws::Failure why;
  for (int i = 0; i < kTries; ++i) {
    const std::lock_guard lock(rws_mutex_);
    why = find_why(sign);
    const bool vague = why.cause == Cause::none || why.cause == Cause::motors_off ||
                       why.cause == Cause::program_stopped || why.cause == Cause::egm_stopped;
    if (!vague || quit_) break;
    if (i + 1 < kTries) wire::wait_readable(-1, kAgain);
  }
  if (why.cause == Cause::none) why.cause = strange_ ? Cause::other_sender : Cause::silent;
  note(why.cause, why.detail, why.text);
}

void Link::run_services() {
  Nanoseconds due = realtime::monotonic_now();
  while (!quit_) {
    const Nanoseconds left = settings_.stepped ? 1'000'000'000 : due - realtime::monotonic_now();
    if (left > 0 && wire::wait_readable(services_wake_.number(), left)) calm(services_wake_.number());
    say_why();
    if (quit_ || settings_.stepped || realtime::monotonic_now() < due) continue;
    due = realtime::monotonic_now() + kRound;
    if (!fault_) serve_services();
  }
}

}  // namespace polyarm::abb
