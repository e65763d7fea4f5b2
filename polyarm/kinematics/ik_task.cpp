#include "polyarm/kinematics/ik_task.hpp"

namespace polyarm::kinematics {

IkTask IkTask::position_only() noexcept {
  IkTask out;
  for (const std::size_t row : {3, 4, 5}) out.free(row);
  return out;
}

IkTask IkTask::orientation_only() noexcept {
  IkTask out;
  for (const std::size_t row : {0, 1, 2}) out.free(row);
  return out;
}

IkTask IkTask::free_spin(std::size_t axis) noexcept {
  IkTask out;
  out.free(3 + axis % 3);
  return out;
}

IkTask IkTask::axis_only(std::size_t axis) noexcept {
  IkTask out = orientation_only();
  out.free(3 + axis % 3);
  return out;
}

}  // namespace polyarm::kinematics
