#pragma once
/// Switching controllers between two cycles, and going on when that has happened. Private to the room; cell thread.
#include "polyarm/inside/requests_work.hpp"

namespace polyarm::cell {

/// A switch; it begins again if the loop has changed controllers by itself meanwhile. Throws Error with why the switch
/// is refused.
Poll<control::SwitchPlan> switch_controllers(Machine& machine, control::SwitchRequest request);

}  // namespace polyarm::cell
