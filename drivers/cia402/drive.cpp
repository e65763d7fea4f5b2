#include "drivers/cia402/drive.hpp"

namespace polyarm::cia402 {

const char* name(DriveState state) {
  constexpr const char* kNames[kDriveStates] = {
      "not ready to switch on", "switch on disabled", "ready to switch on",    "switched on",
      "operation enabled",      "quick stop active",  "fault reaction active", "fault"};
  return kNames[static_cast<std::size_t>(state)];
}

DriveState state_of(std::uint16_t word) noexcept {
  switch (word & 0x4F) {
    case 0x40:
      return DriveState::switch_on_disabled;
    case 0x0F:
      return DriveState::fault_reaction;
    case 0x08:
      return DriveState::fault;
    default:
      break;
  }
  switch (word & 0x6F) {
    case 0x21:
      return DriveState::ready;
    case 0x23:
      return DriveState::switched_on;
    case 0x27:
      return DriveState::enabled;
    case 0x07:
      return DriveState::quick_stop;
    default:
      return DriveState::not_ready;
  }
}

std::uint16_t towards_enabled(DriveState state) noexcept {
  switch (state) {
    case DriveState::switch_on_disabled:
      return control::kShutdown;  // transition 2
    case DriveState::ready:
      return control::kSwitchOn;  // transition 3
    case DriveState::switched_on:
    case DriveState::enabled:
    case DriveState::quick_stop:
      return control::kEnable;  // transitions 4 and 16
    case DriveState::not_ready:
    case DriveState::fault_reaction:
    case DriveState::fault:
      break;
  }
  return control::kDisableVoltage;
}

std::uint16_t towards_standstill(DriveState state) noexcept {
  switch (state) {
    case DriveState::enabled:
    case DriveState::quick_stop:
      return control::kQuickStop;  // transition 11; it stays there or goes on by its option code
    case DriveState::switched_on:
    case DriveState::ready:
      return control::kShutdown;
    case DriveState::switch_on_disabled:
    case DriveState::not_ready:
    case DriveState::fault_reaction:
    case DriveState::fault:
      break;
  }
  return control::kDisableVoltage;
}

CanFrame command_pdo(int node, std::uint16_t controlword, std::int32_t target) noexcept {
  CanFrame out;
  out.id = static_cast<std::uint16_t>(kRpdo1 + node);
  out.size = 6;
  put(out.data, controlword, 2);
  put(std::span(out.data).subspan(2), static_cast<std::uint32_t>(target), 4);
  return out;
}

std::optional<StatePdo> state_pdo(const CanFrame& frame) noexcept {
  if (frame.size != 7) return std::nullopt;
  return StatePdo{static_cast<std::uint16_t>(get(frame.data, 0, 2)), get_i32(frame.data, 2),
                  static_cast<std::int8_t>(frame.data[6])};
}

std::optional<FeedbackPdo> feedback_pdo(const CanFrame& frame) noexcept {
  if (frame.size != 6) return std::nullopt;
  return FeedbackPdo{get_i32(frame.data, 0), get_i16(frame.data, 4)};
}

/// Drives that have only one unit have milliseconds: these come first.
PeriodObject period_object(Nanoseconds cycle) noexcept {
  constexpr Nanoseconds kLargest = 255;
  Nanoseconds unit = 1'000'000;
  int exponent = -3;
  while (exponent > -6 && cycle % unit != 0 && (cycle + unit / 10 - 1) / (unit / 10) <= kLargest) {
    unit /= 10;
    --exponent;
  }
  const Nanoseconds value = (cycle + unit - 1) / unit;
  return {static_cast<std::uint8_t>(value > kLargest ? kLargest
                                    : value < 1      ? 1
                                                     : value),
          static_cast<std::int8_t>(exponent)};
}

}  // namespace polyarm::cia402
