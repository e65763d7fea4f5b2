#pragma once
/// The common interface of protocols for serial bus servos: one master sends instructions, the addressed
/// servo answers.
#include <cstddef>
#include <cstdint>
#include <span>

namespace polyarm::servo_bus {

using Bytes = std::span<const std::uint8_t>;
constexpr std::uint8_t kBroadcast = 0xFE;

/// The numbers are equal in both protocols.
enum class Instruction : std::uint8_t {
  ping = 0x01,
  read = 0x02,
  write = 0x03,
  reboot = 0x08,
  sync_read = 0x82,
  sync_write = 0x83,
  fast_sync_read = 0x8A
};

/// The content at the front of received bytes.
struct Found {
  enum class Kind : std::uint8_t {
    more,   ///< incomplete; `used` bytes of garbage can be dropped
    frame,  ///< a complete answer with a correct checksum
    other   ///< complete or broken, but no answer; drop `used` bytes and continue
  } kind = Kind::more;
  std::size_t used = 0;
  std::uint8_t id = 0;
  std::uint8_t error = 0;  ///< as the servo sent it
  Bytes raw, data;         ///< the frame as received; its data
};

/// Frames of one protocol. Nothing here allocates or throws.
class Protocol {
 public:
  virtual ~Protocol() = default;
  /// Writes the bytes of an instruction to `out`; returns their number, 0 if there is not enough room.
  virtual std::size_t make(std::span<std::uint8_t> out, std::uint8_t id, Instruction instruction,
                           Bytes parameters) const noexcept = 0;
  /// Examines the front of the received bytes. Answers with more than `longest` bytes of data count as
  /// garbage. May change `bytes` (to remove stuffing).
  virtual Found find(std::span<std::uint8_t> bytes, std::size_t longest) const noexcept = 0;
  /// Size of an address and of a length in parameters, bytes: 1 or 2.
  virtual std::size_t address_size() const noexcept = 0;
  /// True if instructions have the same form as answers, so that an adapter's echo could be mistaken for one.
  virtual bool echo_looks_like_answer() const noexcept = 0;
  /// If the protocol supports it: parses the complete parts of the answer to a fast sync read. Calls
  /// `take(context, id, error, data)` for each servo; returns true when the last one was complete.
  using Take = void (*)(void* context, std::uint8_t id, std::uint8_t error, Bytes data);
  virtual bool split_fast(Bytes bytes, std::size_t servos, std::size_t length, Take take,
                          void* context) const noexcept {
    return false;
  }
};

}  // namespace polyarm::servo_bus
