#pragma once
/// Changes the life-cycle state of a hardware component. Private to the room; cell thread.
#include "polyarm/inside/requests_work.hpp"

namespace polyarm::cell {

/// The state that a component has reached, and the controllers that were stopped for the change.
struct Taken {
  std::string name, state;
  std::vector<std::string> stopped;
};
/// Stops the controllers that use the component, then changes its state to `wanted`. Throws Error if this is
/// refused.
Poll<Taken> take_to(Machine& machine, std::size_t component, hardware::LifecycleState wanted);

}  // namespace polyarm::cell
