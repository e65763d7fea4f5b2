#pragma once
/// Points that were converted from one frame into another, and poses beside them.
#include <memory>
#include <string>
#include <utility>

#include "polyarm/data/value.hpp"

namespace polyarm::data {

/// The axes along which offset() shifts the point: those of its frame, in the coordinates of its pose.
inline Quaternion axes_of(const Point& point) {
  return point.taught ? point.taught->axes : Quaternion{};
}

/// The point, whose pose was converted from a frame with these axes into `frame`.
inline Point converted(Point point, const std::string& frame, const Quaternion& axes) {
  Taught taught = point.taught ? *point.taught : Taught{};
  taught.frame = frame;
  taught.axes = axes;
  point.taught = std::make_shared<Taught>(std::move(taught));
  return point;
}

/// Another pose in the frame of `point`. It is no longer the pose that was taught.
inline Point in_frame_of(const Point& point, const Pose& pose) {
  Point out{pose, point.quaternion_given};
  if (point.frame().empty()) return out;
  return converted(std::move(out), point.frame(), axes_of(point));
}

}  // namespace polyarm::data
