#pragma once
/// The ways of inverse kinematics as the benchmarks print them.
#include "polyarm/ik/inverse_kinematics.hpp"

namespace polyarm::ik {

inline const char* words(IkWay way) {
  switch (way) {
    case IkWay::closed_form:
      return "closed form";
    case IkWay::search:
      return "search";
    case IkWay::algebra:
      return "algebra";
    case IkWay::spare_axis:
      return "spare axis";
    case IkWay::descent:
      return "iteration";
    case IkWay::none:
      break;
  }
  return "none";
}

}  // namespace polyarm::ik
