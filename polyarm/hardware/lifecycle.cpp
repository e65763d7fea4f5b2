#include "polyarm/hardware/component.hpp"

namespace polyarm::hardware {

const char* name(LifecycleState state) {
  switch (state) {
    case LifecycleState::unconfigured:
      return "unconfigured";
    case LifecycleState::inactive:
      return "inactive";
    case LifecycleState::active:
      return "active";
    case LifecycleState::finalized:
      return "finalized";
  }
  return "unknown";
}

}  // namespace polyarm::hardware
