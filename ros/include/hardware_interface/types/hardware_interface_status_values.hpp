#pragma once
#include <cstdint>

namespace hardware_interface {
/// The state of a component before life cycles (ROS 2 Foxy).
enum class status : std::uint8_t { UNKNOWN = 0, CONFIGURED = 1, STARTED = 2, STOPPED = 3 };
}  // namespace hardware_interface
