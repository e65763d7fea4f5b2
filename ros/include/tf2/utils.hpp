#pragma once
#include "tf2_geometry_msgs/tf2_geometry_msgs.hpp"

namespace tf2 {
template <typename Rotation>
double getYaw(const Rotation& rotation) {
  Quaternion q;
  fromMsg(rotation, q);
  double r = 0, p = 0, y = 0;
  Matrix3x3(q).getRPY(r, p, y);
  return y;
}
}  // namespace tf2

#include "tf2/convert.hpp"
