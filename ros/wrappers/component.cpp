#include "polyarm_ros/component.hpp"

#include "polyarm_ros/wrappers.hpp"

namespace polyarm_ros {
polyarm::hardware::Component* make_component(const char* name, const char* type, bool simulated) {
  return new RosComponent(name, type, simulated);
}
}  // namespace polyarm_ros
