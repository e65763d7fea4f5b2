/// What a link does beside motion: errors and signals, over a connection of its own.
#include "drivers/xarm/link.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::xarm {

namespace {

constexpr Nanoseconds kRound = 50'000'000;

}  // namespace

bool Link::serve_round() {
  if (outputs_.fetch()) wanted_ = outputs_.value();
  const bool well =
      panel_.write(wanted_) && panel_.read_signals(current_panel_) && panel_.read_codes(current_panel_);
  if (well) panels_.write(current_panel_);
  if (!well && !fault_) note(panel_.failure().cause, panel_.failure().detail, panel_.failure().text);
  return well;
}

void Link::serve_services() {
  const std::unique_lock lock(services_mutex_, std::try_to_lock);
  if (lock && open_ && !fault_) serve_round();
}

void Link::run_services() {
  Nanoseconds due = realtime::monotonic_now();
  while (!quit_) {
    const Nanoseconds left = due - realtime::monotonic_now();
    if (left > 0 && wire::wait_readable(services_wake_.number(), left)) calm(services_wake_.number());
    if (quit_ || realtime::monotonic_now() < due) continue;
    due = realtime::monotonic_now() + kRound;
    serve_services();  // does nothing after a fault
  }
}

/// The controller does not take commands.
PanelPort::Why Link::explain_stop() {
  const std::lock_guard lock(services_mutex_);
  PanelPort::Why why = panel_.explain_stop(current_panel_);
  panels_.write(current_panel_);
  return why;
}

}  // namespace polyarm::xarm
