#pragma once
/// `<ros2_control>` and `<transmission>` of a description, private to the room.
#include "polyarm/description/robot_model.hpp"
#include "polyarm/description/xml_reader.hpp"

namespace polyarm::description {

/// Reads what stands in the file; what needs the joints of the robot is checked by check_hardware.
class Ros2ControlReader : private XmlReader {
 public:
  Ros2ControlReader(const std::string& file, Problems& problems, Problems& warnings)
      : XmlReader(file, problems, warnings) {}

  HardwareInfo hardware(const Element& e);
  /// The form of ROS 1, a child of <robot>. Odd ones are warnings: nothing has to use them.
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

/// Whether the `<ros2_control>` blocks and the transmissions fit the joints of the robot: joints that are not
/// there or do not move, mimic joints that are commanded, doubled names, transmissions of foreign joints.
void check_hardware(RobotModel& model, Problems& problems, Problems& warnings);

}  // namespace polyarm::description
