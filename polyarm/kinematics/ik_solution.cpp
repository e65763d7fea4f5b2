#include "polyarm/kinematics/ik_solution.hpp"

namespace polyarm::kinematics {

const char* name(IkOutcome outcome) {
  switch (outcome) {
    case IkOutcome::solved:
      return "solved";
    case IkOutcome::immovable:
      return "immovable";
    case IkOutcome::malformed:
      return "malformed";
    case IkOutcome::unreachable:
      return "unreachable";
    case IkOutcome::limits:
      return "limits";
  }
  return "";
}

}  // namespace polyarm::kinematics
