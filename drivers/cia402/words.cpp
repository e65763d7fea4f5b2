#include "drivers/cia402/words.hpp"

#include <fmt/format.h>

#include "drivers/cia402/drive.hpp"
#include "drivers/wire/words.hpp"

namespace polyarm::cia402 {

const char* name(Cause cause) {
  constexpr const char* kNames[] = {"none",
                                    "no_bus",
                                    "bus_gone",
                                    "bus_off",
                                    "bus_failed",
                                    "no_answer",
                                    "wrong_device",
                                    "no_position_mode",
                                    "setting_refused",
                                    "setting_lost",
                                    "wrong_answer",
                                    "emergency",
                                    "following_error",
                                    "drive_fault",
                                    "quick_stop",
                                    "switched_off",
                                    "wrong_mode",
                                    "silent",
                                    "all_silent",
                                    "no_heartbeat",
                                    "restarted",
                                    "not_operational",
                                    "other_master",
                                    "not_enabled",
                                    "no_watchdog",
                                    "watchdog",
                                    "loop_silent",
                                    "jump",
                                    "out_of_range",
                                    "wrong_rate"};
  return kNames[static_cast<std::size_t>(cause)];
}

namespace {

/// Before the bus works, and what ends all of it.
std::string of_bus(Cause cause, int detail, const std::string& bus, const std::string& text) {
  switch (cause) {
    case Cause::no_bus:
      return fmt::format("the bus {} cannot be used: {}", bus, text);
    case Cause::bus_gone:
      return fmt::format(
          "the CAN adapter of {} is gone, and with it every joint; drives that watch the heartbeat stop by "
          "themselves: plug it in, look at the arm, then configure it again",
          bus);
    case Cause::bus_off:
      return fmt::format(
          "the CAN adapter of {} cannot send: nobody acknowledges, or it is bus off; check that the drives "
          "have power, that all have the same bit rate, the 120 Ω at both ends, and CAN_H and CAN_L",
          bus);
    case Cause::bus_failed:
      return fmt::format("the system refuses to use {}: look at `dmesg`, and plug the adapter in again", bus);
    case Cause::all_silent:
      return fmt::format(
          "no drive on {} sends anything any more; check their power supply, the cable and its 120 Ω at both "
          "ends",
          bus);
    case Cause::other_master:
      return fmt::format(
          "another device or program on {} sends NMT, SYNC or heartbeats of the master ({}); end it, or set "
          "another `master`: one bus has one master",
          bus, text);
    case Cause::wrong_rate:
      return fmt::format(
          "the cycle of {} is {} Hz, and the cell has another rate: write `rate: {}` into the "
          "cell, or set `cycle_ms`, or `pace: false`",
          bus, detail, detail);
    default:
      return {};
  }
}

/// While the drives are introduced and enabled.
std::string of_start(Cause cause, int detail, const std::string& bus, const std::string& text) {
  switch (cause) {
    case Cause::no_answer:
      return fmt::format(
          "{} on {} does not answer: check its power, its cable, its node number and the bit rate; `polyarm "
          "setup cia402` lists the nodes that answer",
          text, bus);
    case Cause::wrong_device:
      return fmt::format(
          "{} on {} is no CiA 402 drive: its device type is of profile {}; check its node "
          "number with `polyarm setup cia402`",
          text, bus, detail);
    case Cause::no_position_mode:
      return fmt::format(
          "{} on {} has no cyclic synchronous position mode: this driver needs it; look for a "
          "newer firmware of the drive",
          text, bus);
    case Cause::setting_refused:
      return fmt::format(
          "{} on {}: see the manual of the drive for this object, and the parameter that sets "
          "it on the page of this driver",
          text, bus);
    case Cause::setting_lost:
      return fmt::format(
          "{} on {}: the drive keeps another value than was written; see its manual for this "
          "object, or choose the value that it keeps",
          text, bus);
    case Cause::wrong_answer:
      return fmt::format(
          "{} on {} sends SDO answers that do not fit the requests: check that no other "
          "program uses the bus, and no other device this node number",
          text, bus);
    case Cause::not_enabled:
      return fmt::format(
          "{} on {} does not reach \"operation enabled\" and stays in \"{}\": check its enable "
          "input, its safe torque off, and its power supply",
          text, bus, name(static_cast<DriveState>(detail)));
    case Cause::no_watchdog:
      return fmt::format("the joints on {} cannot be watched over: {}; `watchdog: off` does without", bus,
                         text);
    default:
      return {};
  }
}

/// What happens to a drive.
std::string of_drive(Cause cause, int detail, const std::string& bus, const std::string& text) {
  const auto code = static_cast<std::uint16_t>(detail);
  switch (cause) {
    case Cause::emergency:
      return fmt::format("{} on {} reports {}: remove the cause, then configure and activate it again", text,
                         bus, emergency_words(code));
    case Cause::following_error:
      return fmt::format(
          "{} on {} did not follow its target (following error): look for what blocks it, for a "
          "load that is too heavy, or lower the limits of the robot in the cell",
          text, bus);
    case Cause::drive_fault:
      return fmt::format("{} on {} is in fault{}: remove the cause; activating resets the fault", text, bus,
                         code ? ": " + emergency_words(code) : std::string(", and does not say why"));
    case Cause::quick_stop:
      return fmt::format(
          "{} on {} made a quick stop that nobody here ordered: look at its quick-stop input and "
          "its limit switches",
          text, bus);
    case Cause::switched_off:
      return fmt::format(
          "{} on {} was switched off and is \"{}\": look at its enable input, safe torque off, "
          "emergency stop and power supply",
          text, bus, name(static_cast<DriveState>(detail)));
    case Cause::wrong_mode:
      return fmt::format(
          "{} on {} is in mode {} instead of 8 (cyclic synchronous position): check that no "
          "other program sets it",
          text, bus, detail);
    case Cause::silent:
      return fmt::format("{} on {} sends no positions any more: check its power and its cable", text, bus);
    case Cause::no_heartbeat:
      return fmt::format("{} on {} sends no heartbeat any more: its firmware may hang; switch it off and on",
                         text, bus);
    case Cause::restarted:
      return fmt::format(
          "{} on {} has restarted: its power failed, or somebody reset it; check its supply, "
          "then configure it again",
          text, bus);
    case Cause::not_operational:
      return fmt::format(
          "{} on {} left the CANopen state \"operational\" and is \"{}\": check that no other "
          "program commands the bus",
          text, bus, name(static_cast<NmtState>(detail)));
    default:
      return {};
  }
}

}  // namespace

std::string sentence(Cause cause, int detail, const std::string& where, const std::string& text) {
  const std::string bus = wire::address_in(where);
  for (const auto& family : {of_bus, of_start, of_drive})
    if (std::string out = family(cause, detail, bus, text); !out.empty()) return out;
  switch (cause) {
    case Cause::watchdog:
      return fmt::format("on {}, {}", bus, text);
    case Cause::loop_silent:
      return wire::loop_silent_sentence(where);
    case Cause::jump:
      return wire::jump_sentence(detail, where);
    case Cause::out_of_range:
      return fmt::format(
          "the command for joint {} of {} is beyond what its drive can count; it was not sent: "
          "check `counts_per_turn`, `gear` and `offset`",
          detail + 1, where);
    default:
      return {};
  }
}

}  // namespace polyarm::cia402
