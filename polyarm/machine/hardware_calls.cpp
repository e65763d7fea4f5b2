#include "polyarm/machine/hardware_calls.hpp"

#include <algorithm>
#include <cmath>
#include <thread>

#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::cell {

void HardwareCalls::start(std::shared_ptr<hardware::Transition> transition) {
  // Detached, so a device that never answers cannot block the process. After a timeout the component is
  // abandoned.
  std::thread([transition = std::move(transition)] { transition->run(); }).detach();
}

void HardwareCalls::begin(const std::shared_ptr<hardware::Transition>& transition) {
  start(transition);
  if (waits_) await(*transition);
}

void HardwareCalls::report_waiting(const hardware::Transition& transition, Nanoseconds since, const char* end) {
  observer_.on_note("the hardware component " + transition.component() + " is being " +
                    hardware::done_word(transition.step()) + " for " +
                    format_number(std::round(seconds(since) * 10) / 10) + " s; " + end);
}

bool HardwareCalls::give_up(const hardware::Transition& transition, Nanoseconds waited) {
  if ((wait_limit_ < 0 || waited < wait_limit_) && !(asked_ && asked_())) return false;
  report_waiting(transition, waited, "the cell stops waiting for it, and leaves it as it is");
  return true;
}

bool HardwareCalls::await(const hardware::Transition& transition) {
  constexpr Nanoseconds kLook = 100'000'000;
  Nanoseconds waited = 0, next_report = kWorthReporting;
  for (;;) {
    Nanoseconds next = wait_limit_ < 0 ? next_report : std::min(next_report, wait_limit_);
    if (asked_) next = std::min(next, waited + kLook);
    if (transition.wait(next - waited)) return true;
    waited = next;
    if (give_up(transition, waited)) return false;
    if (waited < next_report) continue;
    report_waiting(transition, waited, "waiting for it");
    next_report *= 2;
  }
}

bool HardwareCalls::advance(hardware::Hardware& hardware, std::shared_ptr<hardware::Transition>& transition,
                            Nanoseconds now) {
  while (transition) {
    if (!transition->done()) {
      Since& since = since_.try_emplace(transition.get(), Since{now, kWorthReporting}).first->second;
      if (now - since.begun >= since.next_report) {
        report_waiting(*transition, now - since.begun, "the cell continues");
        since.next_report *= 2;
      }
      return false;
    }
    since_.erase(transition.get());
    const auto done = std::exchange(transition, nullptr);
    transition = hardware.finish(*done);
    if (transition) begin(transition);
  }
  return true;
}

void HardwareCalls::tick(hardware::Hardware& hardware, Nanoseconds now) {
  for (auto each = wanted_.begin(); each != wanted_.end();) {
    bool over = false;
    try {
      if (!each->running && !hardware.pending(each->component)) {
        each->running = hardware.begin(each->component, each->step);
        begin(each->running);
      }
      over = each->running && advance(hardware, each->running, now);
    } catch (const Error& e) {
      observer_.on_note(e.what());
      over = true;
    }
    each = over ? wanted_.erase(each) : std::next(each);
  }
}

}  // namespace polyarm::cell
