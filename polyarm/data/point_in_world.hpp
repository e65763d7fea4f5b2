#pragma once
/// Places of points whose frames are points of data files.
#include <string>

#include "polyarm/base/error.hpp"
#include "polyarm/base/pose.hpp"
#include "polyarm/data/value.hpp"

namespace polyarm::data {

/// The pose of the point `name` in the world. `find` gives the value with a name, or nullptr. `base`: the
/// base of the robot, for the frame "base"; null: not known. Throws Error("unknown-frame") for a frame that
/// no value is, such as one on a robot.
template <class Find>
Pose pose_in_world(const Point& point, const std::string& name, const Find& find, const Pose* base) {
  constexpr int kDeepest = 16;
  Pose out = point.pose;
  std::string frame = point.frame();
  for (int depth = 0; !frame.empty() && frame != "world"; ++depth) {
    if (depth > kDeepest)
      throw Error("unknown-frame", "the frame '" + frame + "' of '" + name + "' is in itself",
                  "one frame of the chain must be in the world or on a robot");
    const Value* value = find(frame);
    const Point* outer = value ? value->as_point() : nullptr;
    if (!outer && frame == "base" && base) return *base * out;
    if (!outer)
      throw Error("unknown-frame",
                  "'" + name + "' is in the frame '" + frame + "', whose place is not known here",
                  "use a point in the world, or in a frame of the same files");
    out = outer->pose * out;
    frame = outer->frame();
  }
  return out;
}

}  // namespace polyarm::data
