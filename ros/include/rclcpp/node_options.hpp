#pragma once
#include <string>
#include <utility>
#include <vector>

#include "rclcpp/parameter.hpp"
#include "rclcpp/qos.hpp"
#include "rclcpp/utilities.hpp"

namespace rclcpp {

class NodeOptions {
 public:
  NodeOptions() = default;
  NodeOptions& context(Context::SharedPtr) { return *this; }
  NodeOptions& arguments(const std::vector<std::string>& words) { return arguments_ = words, *this; }
  const std::vector<std::string>& arguments() const { return arguments_; }
  NodeOptions& parameter_overrides(const std::vector<Parameter>& all) { return overrides_ = all, *this; }
  std::vector<Parameter>& parameter_overrides() { return overrides_; }
  const std::vector<Parameter>& parameter_overrides() const { return overrides_; }
  template <typename T>
  NodeOptions& append_parameter_override(const std::string& name, const T& value) {
    return overrides_.emplace_back(name, ParameterValue(value)), *this;
  }
#define POLYARM_ROS_FLAG_(NAME) \
  NodeOptions& NAME(bool on) {  \
    return NAME##_ = on, *this; \
  }                             \
  bool NAME() const {           \
    return NAME##_;             \
  }                             \
  bool NAME##_ = false;
  POLYARM_ROS_FLAG_(allow_undeclared_parameters)
  POLYARM_ROS_FLAG_(automatically_declare_parameters_from_overrides)
  POLYARM_ROS_FLAG_(use_intra_process_comms)
  POLYARM_ROS_FLAG_(use_global_arguments)
  POLYARM_ROS_FLAG_(start_parameter_services)
  POLYARM_ROS_FLAG_(start_parameter_event_publisher)
  POLYARM_ROS_FLAG_(enable_rosout)
  POLYARM_ROS_FLAG_(enable_topic_statistics)
  POLYARM_ROS_FLAG_(enable_logger_service)
#undef POLYARM_ROS_FLAG_

 private:
  std::vector<std::string> arguments_;
  std::vector<Parameter> overrides_;
};

}  // namespace rclcpp
