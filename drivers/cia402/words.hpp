#pragma once
/// Why the link to the drives ended or was refused, and the sentences for it. Any thread.
#include <cstdint>
#include <string>

namespace polyarm::cia402 {

enum class Cause : std::uint8_t {
  none,
  no_bus,            ///< the device cannot be opened; `text` has the sentence
  bus_gone,          ///< the adapter was unplugged
  bus_off,           ///< the adapter cannot send
  bus_failed,        ///< system error
  no_answer,         ///< a drive does not answer SDO
  wrong_device,      ///< detail: the low word of its device type
  no_position_mode,  ///< it has no cyclic synchronous position
  setting_refused,   ///< `text`: object, drive and the reason
  setting_lost,      ///< an object reads back differently
  wrong_answer,      ///< SDO answers that do not fit
  emergency,         ///< detail: code
  following_error,
  drive_fault,      ///< detail: error code 0x603F, 0: not known
  quick_stop,       ///< a drive made a quick stop that was not ordered
  switched_off,     ///< a drive left "operation enabled"; detail: state
  wrong_mode,       ///< detail: its mode
  silent,           ///< its PDOs are missing
  all_silent,       ///< those of all drives
  no_heartbeat,     ///< PDOs come, heartbeats do not
  restarted,        ///< it sent a boot-up message
  not_operational,  ///< detail: NMT state
  other_master,     ///< somebody else sends NMT, SYNC or the heartbeat of this computer
  not_enabled,      ///< it does not reach "operation enabled"; detail: state
  no_watchdog,      ///< `text` has the sentence
  watchdog,         ///< it has stopped the drives; `text` has the sentence
  loop_silent,
  jump,          ///< detail: joint from 0
  out_of_range,  ///< a command that is no 32-bit position; detail: joint from 0
  wrong_rate     ///< detail: Hz of the bus
};
/// "following_error"
const char* name(Cause cause);
/// `where`: "the drives on can0"; `text`: mostly "elbow (node 3)". Names the device, and says what to do.
std::string sentence(Cause cause, int detail, const std::string& where, const std::string& text);

}  // namespace polyarm::cia402
