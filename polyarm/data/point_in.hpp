#pragma once
/// Points in frames.
#include <memory>
#include <string>

#include "polyarm/data/value.hpp"

namespace polyarm::data {

/// The pose as a point in `frame`; empty: in the world. A tool is a pose in `tool0`, so that it cannot be
/// mistaken for a place in the world.
inline Point point_in(const Pose& pose, const std::string& frame) {
  Point out{pose, false};
  if (!frame.empty()) out.taught = std::make_shared<const Taught>(Taught{frame, {}, {}, {}});
  return out;
}

}  // namespace polyarm::data
