#include "polyarm_ros/controller.hpp"

#include "polyarm_ros/wrappers.hpp"

namespace polyarm_ros {
polyarm::controllers::Controller* make_controller(const char* type) {
  return new RosController(type);
}
}  // namespace polyarm_ros
