#pragma once
/// Reads `<ros2_control>` and `<transmission>` elements of a description. Private to this room.
#include "polyarm/description/robot_model.hpp"
#include "polyarm/description/xml_reader.hpp"

namespace polyarm::description {

/// Reads the elements without the joints of the robot; check_hardware() checks them against the joints.
class Ros2ControlReader : private XmlReader {
 public:
  Ros2ControlReader(const std::string& file, Problems& problems, Problems& warnings)
      : XmlReader(file, problems, warnings) {}

  HardwareInfo hardware(const Element& e);
  /// The form of ROS 1, a child of <robot>. Faults are warnings, because nothing depends on it.
  TransmissionInfo robot_transmission(const Element& e);

 private:
  void driver(const Element& e, HardwareInfo& out);
  void asynchronous(const Element& e, HardwareInfo& out);
  void async_properties(const Element& e, HardwareInfo& out);
  std::vector<int> affinity(const Element& e);
  ComponentInfo component(const Element& e);
  InterfaceInfo interface(const Element& e, bool limits_enabled);
  bool limits_enabled(const Element& e);
  void range(const Element& e, InterfaceInfo& info);
  void value(const Element& e, const InterfaceInfo& info, const char* name, std::optional<double>& out);
  TransmissionInfo transmission(const Element& e);
  TransmissionEnd transmission_end(const Element& e, bool role_needed);
  TransmissionEnd robot_transmission_end(const Element& e, const Element& transmission);
};

/// Checks the `<ros2_control>` blocks and transmissions against the joints of the robot: missing or fixed
/// joints, mimic joints with commands, duplicate names, transmissions of unknown joints.
void check_hardware(RobotModel& model, Problems& problems, Problems& warnings);

}  // namespace polyarm::description
