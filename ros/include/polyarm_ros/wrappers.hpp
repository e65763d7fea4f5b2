#pragma once
/// Makes the components and the controllers of a module. Their code knows no package, so it is compiled once
/// for all of them: ros/wrappers, ros/cmake/wrappers.cmake.
#include "polyarm/controllers/controller.hpp"
#include "polyarm/hardware/component.hpp"
#include "polyarm/hardware/plugin.hpp"

namespace polyarm_ros {
/// The hardware of the class `type`, under the name `name`. Throws std::runtime_error if the module exports
/// no such class. The texts must outlive it.
polyarm::hardware::Component* make_component(const char* name, const char* type, bool simulated);
polyarm::controllers::Controller* make_controller(const char* type);
}  // namespace polyarm_ros
