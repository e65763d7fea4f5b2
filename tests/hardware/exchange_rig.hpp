#pragma once
/// The loop's part in tests of hardware: what fails is taken off, as the supervisor decides by default.
#include "polyarm/hardware/hardware.hpp"

namespace polyarm::hardware {

/// Takes off what the events name, and returns the first event that is more than a report of a late thread.
inline FaultEvent settle(Hardware& hardware, const FaultEvents& faults) {
  FaultEvent first;
  for (const FaultEvent& event : faults.list()) {
    const WhenLate late = event.cause == StopCause::late
                              ? hardware.diagnostics().when_late(static_cast<std::size_t>(event.component))
                              : WhenLate::fault;
    if (!first && late != WhenLate::report) first = event;
    if (late == WhenLate::fault) hardware.exchange().switch_off_failed(event);
  }
  return first;
}
inline FaultEvent read(Hardware& hardware, const Cycle& cycle = {}) {
  FaultEvents faults;
  hardware.exchange().read(cycle, faults);
  return settle(hardware, faults);
}
inline FaultEvent write(Hardware& hardware, const Cycle& cycle = {}) {
  FaultEvents faults;
  hardware.exchange().write(cycle, faults);
  return settle(hardware, faults);
}

}  // namespace polyarm::hardware
