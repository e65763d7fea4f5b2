#pragma once
/// The program that the driver sends to the controller, and the messages that it reads from the driver.
#include <array>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <string>
#include <utility>

#include "polyarm/base/time.hpp"

namespace polyarm::ur {

/// What a message asks for.
enum class Mode : std::int32_t { end = -1, hold = 0, position = 1, velocity = 2 };
/// What the program writes into the register kStateRegister.
enum class ScriptState : int { none = 0, running = 1, ended = 2, timed_out = 3, jumped = 4 };

/// Registers of the controller that the program writes; RTDE reports them.
inline constexpr int kSequenceRegister = 24, kStateRegister = 25;
/// A message is nine i32, big-endian: sequence, ms until the next one, Mode, six values (rad or rad/s) times
/// kScale.
inline constexpr std::size_t kMessageNumbers = 9, kMessageBytes = 4 * kMessageNumbers;
inline constexpr double kScale = 1e7;
inline constexpr const char* kSocketName = "polyarm_stream";

struct Message {
  std::int32_t sequence = 0, timeout_ms = 0;
  Mode mode = Mode::hold;
  std::array<double, 6> values{};
};
/// Values beyond ±210 rad or rad/s are limited; NaN becomes 0. Real-time.
std::array<std::uint8_t, kMessageBytes> encode(const Message& message) noexcept;
Message decode_message(std::span<const std::uint8_t, kMessageBytes> bytes) noexcept;

struct ScriptSettings {
  std::string host;  ///< of this computer, as the robot reaches it
  int port = 0;
  double lookahead = 0.03;       ///< s, of servoj: 0.03 to 0.2
  double gain = 2000;            ///< of servoj: 100 to 2000
  double stop_deceleration = 4;  ///< rad/s², of the stop when commands end
  double acceleration = 15;      ///< rad/s², of speedj
  double speed_limit = 6.3;      ///< rad/s, beyond which a target is refused
};
/// The program in URScript.
std::string program_text(const ScriptSettings& settings);
/// A program in which each `{NAME}` is replaced by its value.
std::string filled(std::string program, std::initializer_list<std::pair<const char*, std::string>> values);

}  // namespace polyarm::ur
