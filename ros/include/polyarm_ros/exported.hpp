#pragma once
/// Finds an exported class by the C++ type that a plugin description file names.
#include <algorithm>
#include <string>

#include "pluginlib/class_list_macros.hpp"

namespace polyarm_ros {

inline std::string plain_type(std::string name) {
  name.erase(std::remove(name.begin(), name.end(), ' '), name.end());
  return name.compare(0, 2, "::") == 0 ? name.substr(2) : name;
}
/// Also a class that was exported inside its namespace, under its last name alone. Null if there is none.
inline const ExportedClass* find_exported(const std::string& type) {
  const std::string wanted = plain_type(type);
  const ExportedClass* by_last_name = nullptr;
  for (const auto& [name, exported] : exported_classes()) {
    const std::string plain = plain_type(name);
    if (plain == wanted) return &exported;
    const auto tail = "::" + plain;
    if (wanted.size() > tail.size() && wanted.compare(wanted.size() - tail.size(), tail.size(), tail) == 0)
      by_last_name = &exported;
  }
  return by_last_name;
}
/// True if the base class `written` is `name`, with or without its namespace.
inline bool is_base(const char* written, const std::string& name) {
  const std::string plain = plain_type(written), tail = "::" + name;
  return plain == name ||
         (plain.size() > tail.size() && plain.compare(plain.size() - tail.size(), tail.size(), tail) == 0);
}

}  // namespace polyarm_ros
