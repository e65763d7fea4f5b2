#pragma once
/// Type information of a message beyond its C++ struct. Constant: any thread.
#include <cstdint>
#include <span>
#include <string_view>

namespace polyarm::messages {

/// Numbered as in the type descriptions of ROS 2 (type_description_interfaces/FieldType).
enum class FieldKind : std::uint8_t {
  nested = 1,
  int8,
  uint8,
  int16,
  uint16,
  int32,
  uint32,
  int64,
  uint64,
  float32,
  float64,
  boolean = 15,
  byte,
  string,
};
enum class FieldShape : std::uint8_t { single, array, bounded, sequence };

struct TypeInfo;

struct FieldInfo {
  const char* name;
  FieldKind kind;
  FieldShape shape;
  std::uint32_t capacity;       ///< for an array or a bounded sequence
  std::uint32_t least;          ///< smallest size of one element on the wire, bytes
  std::uint32_t text_capacity;  ///< for a bounded text
  const TypeInfo* nested;       ///< for FieldKind::nested
};

struct TypeInfo {
  const char* name;      ///< "sensor_msgs/msg/JointState"
  const char* dds_name;  ///< "sensor_msgs::msg::dds_::JointState_"
  const char* hash;      ///< "RIHS01_…" (REP 2016)
  const char* schema;    ///< in the "ros2msg" format of MCAP and Foxglove: the fields, then those of every
                         ///< type used
  std::span<const FieldInfo> fields;
};

/// The type information of a generated struct.
template <class Message>
const TypeInfo& type_info();

/// Every type, in the order of the list; parts of services and actions have their own names
/// ("std_srvs/srv/Trigger_Request", "control_msgs/action/FollowJointTrajectory_SendGoal_Request").
std::span<const TypeInfo* const> types();
/// The ROS 2 distribution that defines the types; a type without its own form in a distribution is as in
/// Jazzy.
enum class Distribution { humble, jazzy, kilted };
/// The types that differ from Jazzy in Humble, and all types that use them.
std::span<const TypeInfo* const> humble_types();
std::span<const TypeInfo* const> kilted_types();

/// Finds a type by that name, also without the middle part ("sensor_msgs/JointState"); null if unknown.
const TypeInfo* find_type(std::string_view name, Distribution distribution = Distribution::jazzy);

}  // namespace polyarm::messages
