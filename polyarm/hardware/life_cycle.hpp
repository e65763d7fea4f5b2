#pragma once
/// Helpers for calling components outside the loop. Private to the room.
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/hardware/component.hpp"

namespace polyarm::hardware {

struct HostedComponent;

/// The component's own reason; may be empty. If its function throws, that is the reason.
std::string reason_of(const Component& component);
/// ": " and the component's own reason, or empty.
std::string because(const Component& component);
/// Throws Error("busy") while the component is in a callback.
void require_idle(const HostedComponent& hosted);
/// Calls on_init; throws Error that begins with `which`.
void initialise(Component& component, const ComponentContext& context, const char* which);

/// The component's interfaces; `list` may throw.
template <typename List>
std::vector<InterfaceDescription> offered(const std::string& name, List list) {
  try {
    return list();
  } catch (...) {
    rethrow_as_error("component-failed",
                     "the hardware component '" + name + "', when asked for its interfaces,");
  }
}

}  // namespace polyarm::hardware
