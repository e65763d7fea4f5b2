#pragma once
/// Frames of CANopen as a master needs them: NMT, SYNC, EMCY, PDO, SDO, heartbeat. Little-endian. Pure
/// functions; any thread; nothing here allocates but the words.
/// Sources: CiA 301 (frames, abort codes, classes of emergency codes), CiA 402 (emergency codes of drives).
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "drivers/cia402/can_bus.hpp"

namespace polyarm::cia402 {

inline constexpr std::uint16_t kNmt = 0x000, kSync = 0x080, kEmergency = 0x080, kTpdo1 = 0x180,
                               kRpdo1 = 0x200, kTpdo2 = 0x280, kSdoAnswer = 0x580, kSdoRequest = 0x600,
                               kHeartbeat = 0x700;
inline constexpr int kMostNode = 127;

enum class NmtCommand : std::uint8_t {
  start = 0x01,
  stop = 0x02,
  pre_operational = 0x80,
  reset_node = 0x81,
  reset_communication = 0x82
};
enum class NmtState : std::uint8_t {
  boot_up = 0x00,
  stopped = 0x04,
  operational = 0x05,
  pre_operational = 0x7F,
  unknown = 0xFF
};
const char* name(NmtState state);

/// `node` 0: all.
CanFrame nmt(NmtCommand command, int node) noexcept;
CanFrame sync() noexcept;
CanFrame heartbeat(int node, NmtState state) noexcept;
/// The node of a frame whose identifier is `base` + node; 0: another frame.
int node_of(const CanFrame& frame, std::uint16_t base) noexcept;
/// The state in a heartbeat. The toggle bit of node guarding is left out.
NmtState state_of_heartbeat(const CanFrame& frame) noexcept;

struct Emergency {
  std::uint16_t code = 0;  ///< 0: the error is gone
  std::uint8_t error_register = 0;
};
/// Empty if the frame is too short.
std::optional<Emergency> emergency_of(const CanFrame& frame) noexcept;
/// "continuous over-current (0x2310)". Codes that no standard names get the words of their class.
std::string emergency_words(std::uint16_t code);

/// An entry of a drive's object dictionary.
struct Object {
  std::uint16_t index = 0;
  std::uint8_t sub = 0;
  bool operator==(const Object&) const = default;
};
/// "0x1A00:1"
std::string text_of(Object object);

// --- numbers in frames and objects ---
void put(std::span<std::uint8_t> into, std::uint64_t value, std::size_t size) noexcept;
/// Bytes beyond the end count as 0.
std::uint64_t get(std::span<const std::uint8_t> from, std::size_t at, std::size_t size) noexcept;
inline std::int32_t get_i32(std::span<const std::uint8_t> from, std::size_t at) noexcept {
  return static_cast<std::int32_t>(get(from, at, 4));
}
inline std::int16_t get_i16(std::span<const std::uint8_t> from, std::size_t at) noexcept {
  return static_cast<std::int16_t>(get(from, at, 2));
}

// --- SDO ---
CanFrame upload_request(int node, Object object) noexcept;
CanFrame upload_segment_request(int node, bool toggle) noexcept;
/// `bytes`: one to four.
CanFrame download_request(int node, Object object, std::span<const std::uint8_t> bytes) noexcept;
/// For more than four bytes, which follow in segments.
CanFrame download_announcement(int node, Object object, std::uint32_t size) noexcept;
/// `bytes`: at most seven.
CanFrame download_segment(int node, bool toggle, bool last, std::span<const std::uint8_t> bytes) noexcept;
CanFrame sdo_abort(int node, Object object, std::uint32_t code) noexcept;

enum class SdoKind : std::uint8_t {
  wrong,       ///< no answer of an SDO server
  expedited,   ///< data() has the object
  announced,   ///< segments follow; `size` if it is known
  segment,     ///< `toggle`, `last`, data
  written,     ///< the download, or its announcement, was taken
  segment_ok,  ///< the segment was taken; `toggle`
  aborted      ///< `code`
};
struct SdoAnswer {
  SdoKind kind = SdoKind::wrong;
  Object object;           ///< not of segments
  std::uint32_t size = 0;  ///< bytes of `data`, or of the whole object; 0: not known
  std::uint32_t code = 0;
  bool toggle = false, last = false;
  std::array<std::uint8_t, 7> data{};
};
SdoAnswer read_answer(const CanFrame& frame) noexcept;

inline constexpr std::uint32_t kNoObject = 0x0602'0000, kNoSubIndex = 0x0609'0011, kWrongToggle = 0x0503'0000,
                               kTimedOut = 0x0504'0000, kUnknownCommand = 0x0504'0001,
                               kOutOfMemory = 0x0504'0005;
/// "the object does not exist (0x06020000)"
std::string abort_words(std::uint32_t code);

}  // namespace polyarm::cia402
