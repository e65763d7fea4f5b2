#pragma once
/// The classes that a module offers, by the names of their C++ types. The wrapper finds them here.
#include <map>
#include <string>

namespace polyarm_ros {

struct ExportedClass {
  const char* base;
  void* (*make)();  ///< returns a pointer to the base class
};
inline std::map<std::string, ExportedClass>& exported_classes() {
  static std::map<std::string, ExportedClass> all;
  return all;
}
struct Export {
  Export(const char* type, const char* base, void* (*make)()) { exported_classes()[type] = {base, make}; }
};

}  // namespace polyarm_ros

#define POLYARM_ROS_JOIN2_(a, b) a##b
#define POLYARM_ROS_JOIN_(a, b) POLYARM_ROS_JOIN2_(a, b)
#define POLYARM_ROS_EXPORT_(NUMBER, TYPE, BASE)                                                        \
  namespace {                                                                                          \
  [[maybe_unused]] const ::polyarm_ros::Export POLYARM_ROS_JOIN_(polyarm_ros_export_,                  \
                                                                 NUMBER)(#TYPE, #BASE, []() -> void* { \
    return static_cast<BASE*>(new TYPE);                                                               \
  });                                                                                                  \
  }
#define PLUGINLIB_EXPORT_CLASS(TYPE, BASE) POLYARM_ROS_EXPORT_(__COUNTER__, TYPE, BASE)
#define PLUGINLIB_EXPORT_CLASS_WITH_MESSAGE(TYPE, BASE, MESSAGE) POLYARM_ROS_EXPORT_(__COUNTER__, TYPE, BASE)
