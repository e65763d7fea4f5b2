#include "polyarm/joint_control/joint_limiters.hpp"

namespace polyarm::controllers {

const char* name(Limit limit) {
  constexpr const char* kNames[kLimits] = {"none",          "not a number", "position", "velocity",
                                           "acceleration",  "deceleration", "jerk",     "effort",
                                           "soft position", "out of range", "held"};
  return kNames[static_cast<std::size_t>(limit)];
}

}  // namespace polyarm::controllers
