#pragma once
#include "tf2_ros/buffer.hpp"

namespace tf2_ros {
class TransformListener {
 public:
  template <typename... Rest>
  explicit TransformListener(Buffer&, Rest&&...) {}
};
}  // namespace tf2_ros
