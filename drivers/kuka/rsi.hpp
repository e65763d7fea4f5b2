#pragma once
/// Datagrams of KUKA's Robot Sensor Interface: one of the controller in each cycle, and the answer to it.
/// Degrees and millimetres, as on the wire. Any thread.
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "drivers/wire/shaper.hpp"

namespace polyarm::kuka {

using wire::Six;

inline constexpr const char* kSenType = "Polyarm";  ///< SENTYPE of our configuration

/// What the controller sends; the configuration of its ETHERNET object says which of these.
struct RsiRobot {
  std::uint64_t ipoc = 0;       ///< its clock, ms; the answer has the same
  Six axes{};                   ///< measured (AIPos)
  std::optional<Six> setpoint;  ///< ASPos
  std::optional<Six> pose;      ///< X Y Z A B C of the tool in the base (RIst)
  std::optional<Six> target;    ///< the same, commanded (RSol)
  std::optional<int> delay;     ///< late answers in a row
  std::uint32_t inputs = 0;     ///< DiL, a bit each
};

struct RsiSensor {
  std::uint64_t ipoc = 0;
  Six correction{};   ///< degrees; absolute: away from where RSI began, relative: for this cycle
  bool stop = false;  ///< RSI ends
};

std::string encode(const RsiRobot& robot);
std::string encode(const RsiSensor& sensor, const std::string& type = kSenType);
/// Nothing for what is no such datagram, or has a number that is not finite.
std::optional<RsiRobot> decode_robot(std::string_view text) noexcept;
/// Also nothing for another type, as a controller ignores it.
std::optional<RsiSensor> decode_sensor(std::string_view text, std::string_view type = kSenType) noexcept;

}  // namespace polyarm::kuka
