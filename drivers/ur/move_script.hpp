#pragma once
/// Forward mode: the program that makes moves by itself, and the messages that it reads from the driver.
#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "drivers/ur/script.hpp"
#include "drivers/wire/shaper.hpp"

namespace polyarm::ur {

using wire::Six;

/// What a message asks for. `halt`: the robot stops, and the program forgets its moves; `tool`: `goal` is the
/// pose of the TCP in the flange as position and rotation vector.
enum class Work : std::int32_t { end = -1, keep = 0, joint = 1, line = 2, arc = 3, halt = 4, tool = 5 };

/// Registers of the controller that the program writes besides those of script.hpp: the number of the newest
/// move that ended, or that its blend took over from; and the number of the newest halt that is done.
inline constexpr int kEndedRegister = 26, kHaltRegister = 27;
/// Moves that the program holds at a time, with the one under way.
inline constexpr std::size_t kMoveSlots = 6;
/// A message is twenty i32, big-endian: sequence, ms until the next one, Work, number, then the values times
/// kMoveScale in the order of MoveMessage.
inline constexpr std::size_t kMoveNumbers = 20, kMoveBytes = 4 * kMoveNumbers;
inline constexpr double kMoveScale = 1e6;
inline constexpr const char* kMoveSocketName = "polyarm_moves";

struct MoveMessage {
  std::int32_t sequence = 0, timeout_ms = 0;
  Work work = Work::keep;
  std::int32_t number = 0;  ///< of a move or a halt; counts up
  Six goal{}, via{};        ///< joints, rad; `via`: of an arc
  double acceleration = 0;  ///< rad/s² of the joint that turns most, or m/s²
  double speed = 0;         ///< rad/s of that joint, or m/s
  double time = 0;          ///< s; above 0 it replaces speed and acceleration
  double blend = 0;         ///< m
};
/// Values beyond ±2100 are limited; NaN becomes 0. Real-time.
std::array<std::uint8_t, kMoveBytes> encode(const MoveMessage& message) noexcept;
MoveMessage decode_move(std::span<const std::uint8_t, kMoveBytes> bytes) noexcept;

/// The program in URScript. Uses host, port and stop_deceleration of the settings.
std::string move_program_text(const ScriptSettings& settings);

}  // namespace polyarm::ur
