#pragma once
/// Switches controllers between two cycles and continues after the switch. Private to the room; cell thread.
#include "polyarm/inside/requests_work.hpp"

namespace polyarm::cell {

/// Switches controllers; retries if the loop has changed controllers by itself meanwhile. Throws Error if the
/// switch is refused.
Poll<control::SwitchPlan> switch_controllers(Machine& machine, control::SwitchRequest request);

}  // namespace polyarm::cell
