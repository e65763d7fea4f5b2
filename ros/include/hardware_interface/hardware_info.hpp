#pragma once
/// What the description says of a component, as plugins read it.
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "joint_limits/joint_limits.hpp"
#include "polyarm_ros/standard.hpp"

namespace hardware_interface {

struct InterfaceInfo {
  std::string name, min, max, initial_value;
  std::string data_type = "double";
  int size = 1;
  bool enable_limits = true;
  std::unordered_map<std::string, std::string> parameters;
};

enum class MimicAttribute { NOT_SET, TRUE, FALSE };
struct MimicJoint {
  std::size_t joint_index = 0, mimicked_joint_index = 0;
  double multiplier = 1.0, offset = 0.0;
};

struct ComponentInfo {
  std::string name, type;
  MimicAttribute is_mimic = MimicAttribute::NOT_SET;
  std::vector<InterfaceInfo> command_interfaces, state_interfaces;
  std::unordered_map<std::string, std::string> parameters;
};

struct JointInfo {
  std::string name;
  std::vector<std::string> state_interfaces, command_interfaces;
  std::string role;
  double mechanical_reduction = 1.0, offset = 0.0;
};
struct ActuatorInfo {
  std::string name;
  std::vector<std::string> state_interfaces, command_interfaces;
  std::string role;
  double mechanical_reduction = 1.0, offset = 0.0;
};
struct TransmissionInfo {
  std::string name, type;
  std::vector<JointInfo> joints;
  std::vector<ActuatorInfo> actuators;
  std::unordered_map<std::string, std::string> parameters;
};

/// The types of a handle; every value passes the border as a double, which holds all of them exactly.
class HandleDataType {
 public:
  enum Value : std::int8_t { UNKNOWN = -1, DOUBLE, FLOAT32, BOOL, UINT8, INT8, UINT16, INT16, UINT32, INT32 };
  HandleDataType() = default;
  constexpr HandleDataType(Value value) : value_(value) {}  // NOLINT: implicit in ROS
  HandleDataType(const std::string& name) {                 // NOLINT: implicit in ROS
    static const std::map<std::string, Value> known = {
        {"double", DOUBLE}, {"float", FLOAT32}, {"float32", FLOAT32}, {"bool", BOOL},     {"uint8", UINT8},
        {"int8", INT8},     {"uint16", UINT16}, {"int16", INT16},     {"uint32", UINT32}, {"int32", INT32}};
    const auto found = known.find(name);
    value_ = found == known.end() ? UNKNOWN : found->second;
  }
  operator Value() const { return value_; }
  bool is_castable_to_double() const { return value_ != UNKNOWN; }
  std::string to_string() const {
    static const char* names[] = {"double", "float32", "bool",   "uint8", "int8",
                                  "uint16", "int16",   "uint32", "int32"};
    return value_ == UNKNOWN ? "unknown" : names[static_cast<int>(value_)];
  }

 private:
  Value value_ = UNKNOWN;
};

struct InterfaceDescription {
  InterfaceDescription(const std::string& prefix, const InterfaceInfo& info)
      : prefix_name(prefix), interface_info(info), interface_name(prefix + "/" + info.name) {}
  std::string prefix_name;
  InterfaceInfo interface_info;
  std::string interface_name;
  std::string get_prefix_name() const { return prefix_name; }
  std::string get_interface_name() const { return interface_info.name; }
  std::string get_name() const { return interface_name; }
  const std::string& get_data_type_string() const { return interface_info.data_type; }
  HandleDataType get_data_type() const { return HandleDataType(interface_info.data_type); }
};

struct HardwareAsyncParams {
  int thread_priority = 50;
  std::string scheduling_policy = "synchronized";
  std::vector<int> cpu_affinity_cores;
  bool print_warnings = true;
};

struct HardwareInfo {
  std::string name, type, group;
  unsigned int rw_rate = 0;
  bool is_async = false;
  int thread_priority = 50;
  HardwareAsyncParams async_params;
  std::string hardware_plugin_name;
  std::string hardware_class_type;  ///< the same, under its name in Foxy
  std::unordered_map<std::string, std::string> hardware_parameters;
  std::vector<ComponentInfo> joints;
  std::vector<MimicJoint> mimic_joints;
  std::vector<ComponentInfo> sensors, gpios;
  std::vector<TransmissionInfo> transmissions;
  std::string original_xml;  ///< written from what Polyarm knows: without bodies and meshes
  std::unordered_map<std::string, joint_limits::JointLimits> limits;
  std::unordered_map<std::string, joint_limits::SoftJointLimits> soft_limits;
};

}  // namespace hardware_interface
