#include "one_joint/bus.hpp"

#include <string>

one_joint_msgs::msg::Note one_joint::note(double value) {
  return one_joint_msgs::msg::Note().set__value(std::to_string(value)).set__o(value);
}
