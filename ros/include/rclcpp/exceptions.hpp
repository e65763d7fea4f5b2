#pragma once
#include <stdexcept>
#include <string>

#include "polyarm_ros/standard.hpp"

namespace rclcpp::exceptions {

#define POLYARM_ROS_EXCEPTION_(NAME)         \
  class NAME : public std::runtime_error {   \
   public:                                   \
    using std::runtime_error::runtime_error; \
  };
struct RCLErrorBase {
  std::string message, formatted_message;
};
POLYARM_ROS_EXCEPTION_(RCLError)
POLYARM_ROS_EXCEPTION_(InvalidNodeError)
POLYARM_ROS_EXCEPTION_(NameValidationError)
POLYARM_ROS_EXCEPTION_(InvalidParametersException)
POLYARM_ROS_EXCEPTION_(InvalidParameterValueException)
POLYARM_ROS_EXCEPTION_(InvalidParameterTypeException)
POLYARM_ROS_EXCEPTION_(ParameterAlreadyDeclaredException)
POLYARM_ROS_EXCEPTION_(ParameterNotDeclaredException)
POLYARM_ROS_EXCEPTION_(ParameterImmutableException)
POLYARM_ROS_EXCEPTION_(ParameterUninitializedException)
#undef POLYARM_ROS_EXCEPTION_

}  // namespace rclcpp::exceptions
