#pragma once
/// Taking a hardware component through its life cycle. Private to the room; cell thread.
#include "polyarm/inside/requests_work.hpp"

namespace polyarm::cell {

/// Where a component has come to, and the controllers that were stopped for that.
struct Taken {
  std::string name, state;
  std::vector<std::string> stopped;
};
/// Stops the controllers that use the component, then takes it there. Throws Error where that is refused.
Poll<Taken> take_to(Machine& machine, std::size_t component, hardware::LifecycleState wanted);

}  // namespace polyarm::cell
