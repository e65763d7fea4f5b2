#pragma once
/// What SystemInterface, ActuatorInterface and SensorInterface are made of. POLYARM_ROS_FOXY: a package of
/// the module overrides configure, start and stop of the interface itself, as in the first releases of Foxy.
/// `polyarm plugin build` sets it for the whole module.
#include "hardware_interface/base_interface.hpp"
#include "hardware_interface/hardware_component_interface.hpp"

namespace hardware_interface {
#ifdef POLYARM_ROS_FOXY
using HardwareBase = BaseInterface<HardwareComponentInterface>;
#else
using HardwareBase = HardwareComponentInterface;
#endif
}  // namespace hardware_interface
