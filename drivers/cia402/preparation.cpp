#include "drivers/cia402/preparation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace polyarm::cia402 {

namespace {
constexpr std::uint32_t kOff = 0x8000'0000;              // bit of a COB-ID: the PDO is not used
constexpr std::uint32_t kNoRemoteRequest = 0x4000'0000;  // bit of a COB-ID of a TPDO
constexpr std::uint8_t kEverySync = 1;
constexpr std::int16_t kQuickStopOnLoss = 3;  // abort connection option code
constexpr std::int16_t kHoldAfterQuickStop = 6, kOffAfterQuickStop = 2;
constexpr std::size_t kLongestName = 64;

std::uint64_t mask_of(std::size_t size) {
  return size >= 8 ? ~std::uint64_t{0} : (std::uint64_t{1} << (8 * size)) - 1;
}
}  // namespace

std::string who(const JointSettings& joint) {
  return fmt::format("{} (node {})", joint.name, joint.node);
}

Refusal refusal_of(const SdoDone& done, Object object, const std::string& who) {
  switch (done.result) {
    case SdoResult::ok:
      return {};
    case SdoResult::silent:
      return {Cause::no_answer, 0, who};
    case SdoResult::aborted:
      return {Cause::setting_refused, 0,
              fmt::format("object {} of {} is refused: {}", text_of(object), who, abort_words(done.code))};
    case SdoResult::wrong:
      return {Cause::wrong_answer, 0, who};
    case SdoResult::bus:
      break;
  }
  return {done.state == BusState::gone                                  ? Cause::bus_gone
          : done.state == BusState::off || done.state == BusState::full ? Cause::bus_off
                                                                        : Cause::bus_failed};
}

Refusal identify(SdoClient& sdo, int node, const std::string& who, DriveIdentity& out) {
  std::uint64_t value = 0;
  SdoDone done = sdo.read(node, object::kDeviceType, 4, value);
  if (!done) return refusal_of(done, object::kDeviceType, who);
  out.device_type = static_cast<std::uint32_t>(value);
  const auto optional = [&](Object object, std::uint32_t& into) {
    if (done = sdo.read(node, object, 4, value); done) into = static_cast<std::uint32_t>(value);
    return done || done.result == SdoResult::aborted;
  };
  const struct {
    Object object;
    std::uint32_t& into;
  } kAll[] = {{object::kVendor, out.vendor},
              {object::kProduct, out.product},
              {object::kRevision, out.revision},
              {object::kModes, out.modes}};
  for (const auto& one : kAll)
    if (!optional(one.object, one.into)) return refusal_of(done, one.object, who);
  out.tells_modes = static_cast<bool>(done);
  std::array<std::uint8_t, kLongestName> text{};
  done = sdo.upload(node, object::kDeviceName, text);
  if (done)
    for (std::size_t k = 0; k < done.size && text[k] >= ' ' && text[k] < 0x7F; ++k)
      out.name += static_cast<char>(text[k]);
  return done.result == SdoResult::silent || done.result == SdoResult::bus
             ? refusal_of(done, object::kDeviceName, who)
             : Refusal{};
}

/// Writes an object, and reads it back. An object that cannot be written may have the value already.
Refusal Preparation::set(const JointSettings& joint, Object object, std::size_t size, std::uint64_t value) {
  const SdoDone written = sdo_.write(joint.node, object, size, value);
  if (!written && written.result != SdoResult::aborted) return refusal_of(written, object, who(joint));
  std::uint64_t found = 0;
  const SdoDone read = sdo_.read(joint.node, object, size, found);
  if (read && found == (value & mask_of(size))) return {};
  if (!written) return refusal_of(written, object, who(joint));
  if (!read) return refusal_of(read, object, who(joint));
  return {Cause::setting_lost, 0,
          fmt::format("object {} of {} is {} instead of {}", text_of(object), who(joint), found,
                      value & mask_of(size))};
}

/// The PDO is switched off while its mapping changes.
template <std::size_t N>
Refusal Preparation::map_pdo(const JointSettings& joint, Object communication, std::uint16_t cob_id,
                             const std::array<Mapped, N>& objects) {
  const auto with_sub = [](Object object, std::size_t sub) {
    return Object{object.index, static_cast<std::uint8_t>(sub)};
  };
  const Object mapping{static_cast<std::uint16_t>(communication.index + 0x200), 0};
  const Object id = with_sub(communication, 1);
  const std::uint32_t on = cob_id + static_cast<std::uint32_t>(joint.node);
  const SdoDone off = sdo_.write(joint.node, id, 4, on | kOff);
  if (!off) return refusal_of(off, id, who(joint));
  if (Refusal no = set(joint, with_sub(communication, 2), 1, kEverySync)) return no;
  if (Refusal no = set(joint, mapping, 1, 0)) return no;
  for (std::size_t k = 0; k < N; ++k)
    if (Refusal no = set(joint, with_sub(mapping, k + 1), 4, objects[k].entry())) return no;
  if (Refusal no = set(joint, mapping, 1, N)) return no;
  const SdoDone done = sdo_.write(joint.node, id, 4, on);
  if (!done) return refusal_of(done, id, who(joint));
  std::uint64_t found = 0;
  const SdoDone read = sdo_.read(joint.node, id, 4, found);
  if (!read) return refusal_of(read, id, who(joint));
  // A drive may say that its PDO cannot be asked for with remote frames: nobody does.
  if ((found & ~std::uint64_t{kNoRemoteRequest}) == on) return {};
  return {Cause::setting_lost, 0,
          fmt::format("object {} of {} is 0x{:X} instead of 0x{:X}", text_of(id), who(joint), found, on)};
}

/// PDOs that this driver does not use would only take room on the bus. A drive may have fewer of them.
Refusal Preparation::switch_off_others(const JointSettings& joint) {
  for (const std::uint16_t index : {0x1401, 0x1402, 0x1403, 0x1802, 0x1803}) {
    const Object object{index, 1};
    std::uint64_t id = 0;
    const SdoDone read = sdo_.read(joint.node, object, 4, id);
    if (read.result == SdoResult::aborted || (read && id & kOff)) continue;
    if (!read) return refusal_of(read, object, who(joint));
    const SdoDone written = sdo_.write(joint.node, object, 4, id | kOff);
    if (!written && written.result != SdoResult::aborted) return refusal_of(written, object, who(joint));
  }
  return {};
}

/// The drive's own heartbeat, and that of this computer, at whose end the drive makes a quick stop.
Refusal Preparation::set_watch(const JointSettings& joint, bool& watches) {
  const auto time = static_cast<std::uint64_t>(settings_.heartbeat_ms);
  if (Refusal no = set(joint, object::kHeartbeat, 2, time / 2)) return no;
  // 0 first: an entry that is used may not change.
  SdoDone done = sdo_.write(joint.node, object::kHeartbeatOfMaster, 4, 0);
  if (done)
    done = sdo_.write(joint.node, object::kHeartbeatOfMaster, 4,
                      static_cast<std::uint64_t>(settings_.master) << 16 | time);
  if (done)
    done = sdo_.write(joint.node, object::kAbortOption, 2, static_cast<std::uint64_t>(kQuickStopOnLoss));
  if (done.result != SdoResult::ok && done.result != SdoResult::aborted)
    return refusal_of(done, object::kHeartbeatOfMaster, who(joint));
  watches = static_cast<bool>(done);
  if (settings_.quick_stop == QuickStop::as_set) return {};
  const auto option = static_cast<std::uint64_t>(
      settings_.quick_stop == QuickStop::hold ? kHoldAfterQuickStop : kOffAfterQuickStop);
  return set(joint, object::kQuickStopOption, 2, option);
}

/// A drive without the object finds the time between two targets by itself.
Refusal Preparation::set_period(const JointSettings& joint) {
  std::uint64_t value = 0;
  if (sdo_.read(joint.node, object::kPeriodValue, 1, value).missing()) return {};
  const PeriodObject period = period_object(settings_.cycle);
  if (Refusal no = set(joint, object::kPeriodValue, 1, period.value)) return no;
  return set(joint, object::kPeriodExponent, 1,
             static_cast<std::uint64_t>(static_cast<std::uint8_t>(period.exponent)));
}

Refusal Preparation::set_limits(const JointSettings& joint) {
  const auto counts = [&](double angle) {
    return static_cast<std::int32_t>(
        std::lround(std::clamp(joint.scale.counts(angle), -2147483647.0, 2147483647.0)));
  };
  const auto unsigned_of = [](std::int32_t value) {
    return static_cast<std::uint64_t>(static_cast<std::uint32_t>(value));
  };
  if (joint.max_torque)
    if (Refusal no = set(joint, object::kMaxTorque, 2,
                         static_cast<std::uint64_t>(std::lround(1000 * *joint.max_torque))))
      return no;
  if (joint.max_motor_speed)
    if (Refusal no = set(joint, object::kMaxMotorSpeed, 4,
                         static_cast<std::uint64_t>(std::lround(*joint.max_motor_speed))))
      return no;
  if (joint.following_error)
    if (Refusal no = set(joint, object::kFollowingWindow, 4,
                         static_cast<std::uint64_t>(
                             std::lround(std::abs(*joint.following_error * joint.scale.counts_per_rad())))))
      return no;
  if (!joint.min) return {};
  const auto [low, high] = std::minmax({counts(*joint.min), counts(*joint.max)});
  if (Refusal no = set(joint, object::kMinPosition, 4, unsigned_of(low))) return no;
  return set(joint, object::kMaxPosition, 4, unsigned_of(high));
}

/// The drive counts it in mN m.
Refusal Preparation::find_rated_torque(const JointSettings& joint, double& out) {
  out = std::numeric_limits<double>::quiet_NaN();
  if (joint.rated_torque) {
    out = *joint.rated_torque;
    return {};
  }
  std::uint64_t value = 0;
  const SdoDone done = sdo_.read(joint.node, object::kRatedTorque, 4, value);
  if (done && value > 0) out = static_cast<double>(value) / 1000;
  return done || done.result == SdoResult::aborted ? Refusal{}
                                                   : refusal_of(done, object::kRatedTorque, who(joint));
}

Refusal Preparation::prepare(std::size_t j, Prepared& out) {
  const JointSettings& joint = settings_.joints[j];
  bus_.send(nmt(NmtCommand::pre_operational, joint.node));  // a stopped one answers no SDO
  DriveIdentity identity;
  if (Refusal no = identify(sdo_, joint.node, who(joint), identity)) return no;
  if (identity.profile() != kServoProfile) return {Cause::wrong_device, identity.profile(), who(joint)};
  if (!identity.has_position_mode()) return {Cause::no_position_mode, 0, who(joint)};
  if (Refusal no = map_pdo(joint, {0x1400}, kRpdo1, kCommandPdo)) return no;
  if (Refusal no = map_pdo(joint, {0x1800}, kTpdo1, kStatePdo)) return no;
  if (Refusal no = map_pdo(joint, {0x1801}, kTpdo2, kFeedbackPdo)) return no;
  if (Refusal no = switch_off_others(joint)) return no;
  if (Refusal no = set(joint, object::kMode, 1, static_cast<std::uint64_t>(kPositionMode))) return no;
  if (Refusal no = set_period(joint)) return no;
  if (Refusal no = set_limits(joint)) return no;
  if (Refusal no = find_rated_torque(joint, out.rated_torque)) return no;
  return set_watch(joint, out.watches);
}

void Preparation::forget_heartbeat(std::size_t joint) {
  sdo_.write(settings_.joints[joint].node, object::kHeartbeatOfMaster, 4, 0);
}

}  // namespace polyarm::cia402
