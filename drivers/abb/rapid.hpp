#pragma once
/// The RAPID text that lets EGM move the robot, and the names that it shares with the configuration.
#include <string>

#include "drivers/abb/move_wire.hpp"

namespace polyarm::abb {

inline constexpr const char* kModuleName = "PolyarmEGM";
inline constexpr const char* kModuleFile = "PolyarmEGM.mod";
inline constexpr const char* kDeviceName = "Polyarm";

struct RapidSettings {
  int sampling_ms = 4;
  double comm_timeout = 0.5;             ///< s without a command, until the robot is stopped
  double max_speed = 60;                 ///< degrees/s, of each joint
  double filter = 20;                    ///< Hz
  double ramp_in = 0.1, ramp_out = 0.2;  ///< s
};

inline constexpr const char* kMovesModule = "PolyarmMoves";
inline constexpr const char* kMovesFile = "PolyarmMoves.mod";

/// A module with a main() that makes the moves of one client. `address`: of the controller, where it listens.
std::string rapid_moves_module(const std::string& address, int port);

/// A module with a main() that follows EGM once, and ends when commands stop.
std::string rapid_module(const RapidSettings& settings);
/// The entries of the configuration topic Communication (SIO.cfg) for the device of EGM.
std::string device_text(const std::string& own_address, int port);

}  // namespace polyarm::abb
