#pragma once
/// Nobody sends transforms to a plugin: every look-up throws tf2::LookupException.
#include <memory>
#include <string>

#include "geometry_msgs/msg/transform_stamped.hpp"
#include "rclcpp/clock.hpp"
#include "tf2/transform_datatypes.hpp"

namespace tf2_ros {
class Buffer {
 public:
  template <typename... Rest>
  explicit Buffer(const std::shared_ptr<rclcpp::Clock>&, Rest&&...) {}
  template <typename... Rest>
  geometry_msgs::msg::TransformStamped lookupTransform(const std::string& target, const std::string& source,
                                                       Rest&&...) const {
    throw tf2::LookupException("no transform from '" + source + "' to '" + target +
                               "': plugins of Polyarm get no transforms");
  }
  template <typename... Rest>
  bool canTransform(const std::string&, const std::string&, Rest&&...) const {
    return false;
  }
};
}  // namespace tf2_ros
