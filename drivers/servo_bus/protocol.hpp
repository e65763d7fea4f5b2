#pragma once
/// What the wires of serial bus servos have in common: one master asks, the servo with that id answers.
#include <cstddef>
#include <cstdint>
#include <span>

namespace polyarm::servo_bus {

using Bytes = std::span<const std::uint8_t>;
constexpr std::uint8_t kBroadcast = 0xFE;

/// The numbers are those of both wires.
enum class Instruction : std::uint8_t {
  ping = 0x01,
  read = 0x02,
  write = 0x03,
  reboot = 0x08,
  sync_read = 0x82,
  sync_write = 0x83,
  fast_sync_read = 0x8A
};

/// What stands at the front of received bytes.
struct Found {
  enum class Kind : std::uint8_t {
    more,   ///< nothing whole yet; `used` bytes of garbage can be dropped
    frame,  ///< a whole answer whose checksum is right
    other   ///< something whole or broken that is no answer; drop `used` bytes and look on
  } kind = Kind::more;
  std::size_t used = 0;
  std::uint8_t id = 0;
  std::uint8_t error = 0;  ///< as the servo sent it
  Bytes raw, data;         ///< the frame as it came; what it carries
};

/// Frames of one wire. Nothing here allocates or throws.
class Protocol {
 public:
  virtual ~Protocol() = default;
  /// The bytes of an instruction into `out`; how many, 0 when there is no room.
  virtual std::size_t make(std::span<std::uint8_t> out, std::uint8_t id, Instruction instruction,
                           Bytes parameters) const noexcept = 0;
  /// Looks at the front of what has come. Answers that carry more than `longest` bytes are taken for garbage.
  /// May change `bytes` (to take out stuffing).
  virtual Found find(std::span<std::uint8_t> bytes, std::size_t longest) const noexcept = 0;
  /// Bytes of an address and of a length in parameters: 1 or 2.
  virtual std::size_t address_size() const noexcept = 0;
  /// Are instructions formed like answers, so that the echo of an adapter could be taken for one?
  virtual bool echo_looks_like_answer() const noexcept = 0;
  /// Where the wire has it: takes the answer to a fast sync read apart, as far as it is whole. Calls
  /// `take(context, id, error, data)` for each servo; returns true when the last one was whole.
  using Take = void (*)(void* context, std::uint8_t id, std::uint8_t error, Bytes data);
  virtual bool split_fast(Bytes bytes, std::size_t servos, std::size_t length, Take take,
                          void* context) const noexcept {
    return false;
  }
};

}  // namespace polyarm::servo_bus
