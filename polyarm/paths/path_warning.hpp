#pragma once
/// A warning about one waypoint of a path.
#include <cstddef>

#include "polyarm/base/error.hpp"

namespace polyarm::paths {

struct PathWarning : Problem {
  std::size_t waypoint = 0;  ///< counted from 0, which is the start
};

}  // namespace polyarm::paths
