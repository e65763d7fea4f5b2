#pragma once
/// The 41 error flags of a robot state: names of libfranka, what each one means and what to do. Const: any
/// thread.
#include <string>

#include "drivers/franka/fci.hpp"
#include "drivers/franka/words.hpp"

namespace polyarm::franka {

/// Flags that the simulated robot raises, and that the driver treats in a way of their own.
enum class ErrorFlag : std::uint8_t {
  joint_position_limits = 0,
  self_collision = 2,
  joint_velocity = 3,
  joint_reflex = 6,
  cartesian_reflex = 7,
  start_pose = 11,
  position_limits = 12,
  velocity_limits = 13,
  velocity_discontinuity = 14,
  acceleration_discontinuity = 15,
  communication = 25,
  power_limit = 26,
  instability = 35,
};

struct ErrorFacts {
  const char* name;   ///< of libfranka
  const char* words;  ///< "what it means: what to do"
  Cause cause;
};
/// `index` from 0 to 40; else an unknown error.
const ErrorFacts& error_facts(int index);
/// The first flag that is set, in the order of `most telling first`; -1 without one. Real-time.
int first_error(const ErrorFlags& flags) noexcept;
/// "joint_reflex, power_limit_violation"; empty without a flag.
std::string error_names(const ErrorFlags& flags);

}  // namespace polyarm::franka
