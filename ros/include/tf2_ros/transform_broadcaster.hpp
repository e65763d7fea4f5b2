#pragma once
#include "tf2_ros/buffer.hpp"

namespace tf2_ros {
/// Sends to nobody.
class TransformBroadcaster {
 public:
  template <typename... Rest>
  explicit TransformBroadcaster(Rest&&...) {}
  template <typename Transforms>
  void sendTransform(const Transforms&) {}
};
using StaticTransformBroadcaster = TransformBroadcaster;
}  // namespace tf2_ros
