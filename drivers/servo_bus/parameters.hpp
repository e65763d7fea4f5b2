#pragma once
/// The parameters of a servo bus and its joints: one table for the reader of settings and the lists of
/// `polyarm drivers`. Constant.
#include <string_view>

#include "drivers/servo_bus/registers.hpp"
#include "polyarm/hardware/driver_facts.hpp"

namespace polyarm::servo_bus {

/// Parameters of a joint have names such as "JOINT.id".
inline constexpr std::string_view kOfJoint = "JOINT.";

const hardware::DriverFacts& facts_of(const Family& family);

}  // namespace polyarm::servo_bus
