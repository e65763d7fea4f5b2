#pragma once
/// Prepares one drive by SDO before its first cycle: identity, mode, PDO mapping, heartbeats, limits. Every
/// object that is written is read back. Nothing here switches a drive on. May wait; one thread.
#include <functional>
#include <string>

#include "drivers/cia402/sdo.hpp"
#include "drivers/cia402/settings.hpp"
#include "drivers/cia402/words.hpp"

namespace polyarm::cia402 {

/// What a drive says of itself.
struct DriveIdentity {
  std::uint32_t device_type = 0, vendor = 0, product = 0, revision = 0, modes = 0;
  bool tells_modes = false;  ///< it has the optional object 0x6502
  std::string name;          ///< empty if it has none
  int profile() const noexcept { return static_cast<int>(device_type & 0xFFFF); }
  /// Of a drive that does not tell, the mode is checked when it is enabled.
  bool has_position_mode() const noexcept { return !tells_modes || (modes & kPositionModeBit); }
};

struct Prepared {
  double rated_torque = 0;  ///< N m of the motor; NaN: not known
  bool watches = false;     ///< it stops by itself when the heartbeat of this computer ends
};

/// Why a drive cannot be used; Cause::none if it can.
struct Refusal {
  Cause cause = Cause::none;
  int detail = 0;
  std::string text = {};
  explicit operator bool() const noexcept { return cause != Cause::none; }
};

/// Reads what a node says of itself. `who` is named in a refusal.
Refusal identify(SdoClient& sdo, int node, const std::string& who, DriveIdentity& out);
/// "elbow (node 3)"
std::string who(const JointSettings& joint);
/// The cause of a failed SDO.
Refusal refusal_of(const SdoDone& done, Object object, const std::string& who);

class Preparation {
 public:
  Preparation(CanBus& bus, const Settings& settings, std::function<void(const CanFrame&)> other)
      : bus_(bus), settings_(settings), sdo_(bus, settings.answer, std::move(other)) {}

  /// Leaves the drive in the CANopen state "pre-operational".
  Refusal prepare(std::size_t joint, Prepared& out);
  /// The drive no longer waits for heartbeats of this computer. It must stand.
  void forget_heartbeat(std::size_t joint);

 private:
  template <std::size_t N>
  Refusal map_pdo(const JointSettings& joint, Object communication, std::uint16_t cob_id,
                  const std::array<Mapped, N>& objects);
  Refusal switch_off_others(const JointSettings& joint);
  Refusal set_watch(const JointSettings& joint, bool& watches);
  Refusal set_limits(const JointSettings& joint);
  Refusal find_rated_torque(const JointSettings& joint, double& out);
  Refusal set_period(const JointSettings& joint);
  Refusal set(const JointSettings& joint, Object object, std::size_t size, std::uint64_t value);

  CanBus& bus_;
  const Settings& settings_;
  SdoClient sdo_;
};

}  // namespace polyarm::cia402
