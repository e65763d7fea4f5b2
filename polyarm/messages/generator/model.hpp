#pragma once
/// The interfaces in interfaces.list, and their ROS 2 properties. For the build-time generator only.
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace polyarm::messages::generator {

enum class Shape { single, array, bounded, sequence };

struct Field {
  std::string type;  ///< "float64", or the full name of a message ("std_msgs/msg/Header")
  std::string name;
  Shape shape = Shape::single;
  std::uint32_t capacity = 0;
  std::string initial;              ///< value of a new message; empty: zero
  std::uint32_t text_capacity = 0;  ///< of a bounded string
};
struct Constant {
  std::string type, name, value;
};

/// A struct on the wire: a message, or a part of a service or action.
struct Type {
  std::string name;  ///< "sensor_msgs/msg/JointState", "std_srvs/srv/Trigger_Request"
  std::vector<Constant> constants;
  std::vector<Field> fields;
};

/// The types in the order of their use. For each distribution: the types that differ in it, and all types
/// that use them.
struct Interfaces {
  std::vector<Type> types;
  std::map<std::string, std::vector<Type>> of_distributions;
};

/// Throws std::runtime_error with line and reason.
Interfaces read_interfaces(const std::string& file);

bool is_primitive(const std::string& type);
/// The smallest size of a value of this type on the wire, bytes.
std::size_t least_bytes(const Type& type, const std::map<std::string, const Type*>& all);

/// The schema in the "ros2msg" format of MCAP and Foxglove.
std::string schema(const Type& type, const std::map<std::string, const Type*>& all);
/// "RIHS01_…": SHA-256 of the type's description as JSON (REP 2016).
std::string type_hash(const Type& type, const std::map<std::string, const Type*>& all);
/// As FieldKind of type_info.hpp.
int field_kind(const Field& field);

}  // namespace polyarm::messages::generator
