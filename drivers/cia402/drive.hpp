#pragma once
/// The state machine of a CiA 402 drive, its objects, and its units. Pure functions; any thread; nothing
/// allocates.
/// Source: CiA 402-2 / IEC 61800-7-201: statusword, controlword, transitions 0 to 16, modes, option codes.
#include <cmath>
#include <numbers>

#include "drivers/cia402/canopen.hpp"

namespace polyarm::cia402 {

enum class DriveState : std::uint8_t {
  not_ready,
  switch_on_disabled,
  ready,
  switched_on,
  enabled,  ///< "operation enabled": the only one in which it follows targets
  quick_stop,
  fault_reaction,
  fault
};
inline constexpr int kDriveStates = 8;
/// "operation enabled"
const char* name(DriveState state);
DriveState state_of(std::uint16_t statusword) noexcept;

namespace status {
inline constexpr std::uint16_t kVoltage = 1 << 4, kWarning = 1 << 7, kRemote = 1 << 9, kLimit = 1 << 11,
                               kFollows = 1 << 12, kFollowingError = 1 << 13;
}
namespace control {
inline constexpr std::uint16_t kDisableVoltage = 0x00, kQuickStop = 0x02, kShutdown = 0x06, kSwitchOn = 0x07,
                               kEnable = 0x0F, kFaultReset = 0x80;
}
/// The controlword that brings a drive one transition closer to "operation enabled". From "fault" it is the
/// one that waits: a reset is an order of its own.
std::uint16_t towards_enabled(DriveState state) noexcept;
/// The controlword for a standstill: a quick stop if the drive moves its motor, else nothing that switches
/// on.
std::uint16_t towards_standstill(DriveState state) noexcept;

inline constexpr std::uint32_t kServoProfile = 402;  ///< low word of the device type
inline constexpr std::int8_t kPositionMode = 8;      ///< cyclic synchronous position
inline constexpr std::uint32_t kPositionModeBit = 1 << 7;

namespace object {
inline constexpr Object kDeviceType{0x1000}, kDeviceName{0x1008}, kHeartbeatOfMaster{0x1016, 1},
    kHeartbeat{0x1017}, kVendor{0x1018, 1}, kProduct{0x1018, 2}, kRevision{0x1018, 3}, kAbortOption{0x6007},
    kErrorCode{0x603F}, kControlword{0x6040}, kStatusword{0x6041}, kQuickStopOption{0x605A}, kMode{0x6060},
    kModeDisplay{0x6061}, kPosition{0x6064}, kFollowingWindow{0x6065}, kVelocity{0x606C}, kMaxTorque{0x6072},
    kRatedTorque{0x6076}, kTorque{0x6077}, kTarget{0x607A}, kMinPosition{0x607D, 1}, kMaxPosition{0x607D, 2},
    kMaxMotorSpeed{0x6080}, kPeriodValue{0x60C2, 1}, kPeriodExponent{0x60C2, 2}, kModes{0x6502};
}  // namespace object

/// An object in a PDO.
struct Mapped {
  Object object;
  std::uint8_t bits = 0;
  std::uint32_t entry() const noexcept {
    return static_cast<std::uint32_t>(object.index) << 16 | static_cast<std::uint32_t>(object.sub) << 8 |
           bits;
  }
};
inline constexpr std::array<Mapped, 2> kCommandPdo{{{object::kControlword, 16}, {object::kTarget, 32}}};
inline constexpr std::array<Mapped, 3> kStatePdo{
    {{object::kStatusword, 16}, {object::kPosition, 32}, {object::kModeDisplay, 8}}};
inline constexpr std::array<Mapped, 2> kFeedbackPdo{{{object::kVelocity, 32}, {object::kTorque, 16}}};

CanFrame command_pdo(int node, std::uint16_t controlword, std::int32_t target) noexcept;
struct StatePdo {
  std::uint16_t statusword = 0;
  std::int32_t position = 0;
  std::int8_t mode = 0;
};
/// Empty if the length is wrong.
std::optional<StatePdo> state_pdo(const CanFrame& frame) noexcept;
struct FeedbackPdo {
  std::int32_t velocity = 0;
  std::int16_t torque = 0;
};
std::optional<FeedbackPdo> feedback_pdo(const CanFrame& frame) noexcept;

/// Between counts of the drive and the angle of the joint: angle = offset + direction · 2π · counts /
/// (counts_per_turn · gear).
struct Scale {
  double counts_per_turn = 4096;  ///< of the motor's shaft
  double gear = 1;                ///< turns of the motor for one of the joint
  double offset = 0;              ///< rad, of the joint where the drive counts 0
  int direction = 1;
  double counts_per_rad() const noexcept {
    return direction * counts_per_turn * gear / (2 * std::numbers::pi);
  }
  double angle(double counts) const noexcept { return offset + counts / counts_per_rad(); }
  /// Not rounded.
  double counts(double angle) const noexcept { return (angle - offset) * counts_per_rad(); }
};

/// The interpolation time of a cycle: value · 10^exponent s. The value is at most 255; a cycle that needs
/// more digits is rounded up.
struct PeriodObject {
  std::uint8_t value = 1;
  std::int8_t exponent = -3;
};
PeriodObject period_object(Nanoseconds cycle) noexcept;

}  // namespace polyarm::cia402
