#pragma once
#include "hardware_interface/handle.hpp"
#include "polyarm_ros/standard.hpp"

namespace transmission_interface {
/// A number of an actuator or joint that a transmission reads or writes.
class Handle : public hardware_interface::Handle {
 public:
  using hardware_interface::Handle::Handle;
};
class ActuatorHandle : public Handle {
 public:
  using Handle::Handle;
};
class JointHandle : public Handle {
 public:
  using Handle::Handle;
};
}  // namespace transmission_interface
