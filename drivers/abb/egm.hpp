#pragma once
/// Externally Guided Motion of ABB: the datagrams of both directions, in protocol buffers. Field numbers of
/// the maker's egm.proto (version 1.1); moveIndex, collision and the force control flag are those of
/// RobotWare
/// 7. Degrees, millimetres, seconds. Any thread; decoding allocates nothing.
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "drivers/wire/bytes.hpp"

namespace polyarm::abb {

using wire::Bytes;

enum class MessageType : std::uint32_t { undefined, command, data, correction, path_correction };
enum class MotorState : std::uint32_t { undefined, on, off };
enum class EgmState : std::uint32_t { undefined, error, stopped, running };
enum class RapidState : std::uint32_t { undefined, stopped, running };

struct EgmHeader {
  std::uint32_t sequence = 0, time_ms = 0;
  MessageType type = MessageType::undefined;
};

/// Some values in a row: joints, external axes, speeds, forces.
struct Values {
  static constexpr std::size_t kMost = 12;
  std::array<double, kMost> value{};
  std::size_t count = 0;
  double operator[](std::size_t i) const { return value[i]; }
};

struct EgmPose {
  std::array<double, 3> position{};               ///< mm
  std::array<double, 4> orientation{1, 0, 0, 0};  ///< w, x, y, z
};

struct EgmClock {
  std::uint64_t s = 0, us = 0;
};

/// Where the robot is, or is planned to be.
struct EgmPosition {
  std::optional<Values> joints;  ///< degrees
  std::optional<EgmPose> pose;
  std::optional<Values> external;
  std::optional<EgmClock> time;
};

struct EgmRobot {
  EgmHeader header;
  std::optional<EgmPosition> feedback, planned;
  MotorState motors = MotorState::undefined;
  EgmState state = EgmState::undefined;
  RapidState rapid = RapidState::undefined;
  std::optional<bool> converged;
  std::optional<Values> force;  ///< N, N·m
  std::optional<double> utilization;
  std::optional<bool> collision;
};

struct EgmSensor {
  EgmHeader header;
  std::optional<EgmPosition> planned;
  std::optional<Values> joint_speed, external_speed;  ///< degrees/s
};

std::vector<std::uint8_t> encode(const EgmRobot& message);
std::vector<std::uint8_t> encode(const EgmSensor& message);
/// Empty: not a message, without a header, with more than Values::kMost values in a row, or with a number
/// that is not finite.
std::optional<EgmRobot> decode_robot(Bytes datagram) noexcept;
std::optional<EgmSensor> decode_sensor(Bytes datagram) noexcept;

}  // namespace polyarm::abb
