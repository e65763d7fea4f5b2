#pragma once
/// The UBX protocol of u-blox receivers: 0xB5 0x62, class, number, length, payload, and two sums (8-bit
/// Fletcher over everything between the first two bytes and the sums). Numbers are little-endian.
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace polyarm::sensors {

inline constexpr std::size_t kUbxMaxPayload = 512;  ///< longer messages are ignored

/// Class and number of a message.
struct UbxId {
  std::uint8_t group = 0, number = 0;
  bool operator==(const UbxId&) const = default;
};
inline constexpr UbxId kNavPvt{0x01, 0x07}, kAckNak{0x05, 0x00}, kAckAck{0x05, 0x01}, kCfgMsg{0x06, 0x01},
    kCfgRate{0x06, 0x08}, kCfgValset{0x06, 0x8A}, kMonVer{0x0A, 0x04};

/// A message in a reader's memory; valid until the next byte.
struct UbxMessage {
  UbxId id;
  std::span<const std::uint8_t> payload;
};

/// Finds messages in a stream that also contains NMEA and garbage. A false start does not swallow or delay a
/// true message after it. Allocates nothing.
class UbxReader {
 public:
  struct Counts {
    std::uint64_t messages = 0;
    std::uint64_t bad_sums = 0;
    std::uint64_t skipped_bytes = 0;  ///< not part of any message, including NMEA
  };
  /// Takes one byte. True when a message is complete: call message(), then next() until that returns false.
  bool push(std::uint8_t byte) noexcept;
  /// Drops the message; true if another complete one follows in the bytes already read.
  bool next() noexcept;
  UbxMessage message() const noexcept;
  /// Takes bytes and calls `each` with every message.
  template <typename Each>
  void take(std::span<const std::uint8_t> bytes, Each each) noexcept {
    for (const std::uint8_t byte : bytes)
      for (bool ready = push(byte); ready; ready = next()) each(message());
  }
  const Counts& counts() const noexcept { return counts_; }
  void restart() noexcept { size_ = 0; }

 private:
  bool look() noexcept;
  bool ends_inside() noexcept;
  void drop(std::size_t count) noexcept;
  void skip(std::size_t count) noexcept;
  std::size_t length(std::size_t at = 0) const noexcept {
    return bytes_[at + 4] | static_cast<std::size_t>(bytes_[at + 5]) << 8;
  }
  bool sums_fit(std::size_t at) const noexcept;
  std::array<std::uint8_t, kUbxMaxPayload + 8> bytes_{};
  std::size_t size_ = 0;
  Counts counts_;
};

/// Adds sync bytes, header and sums to a payload.
std::vector<std::uint8_t> ubx_message(UbxId id, std::span<const std::uint8_t> payload);

/// The content of NAV-PVT, in SI units and degrees.
struct NavPvt {
  int fix_type = 0;     ///< 0 none, 1 dead reckoning, 2 two-dimensional, 3 three-dimensional, 4 GNSS and dead
                        ///< reckoning, 5 time only
  bool fix_ok = false;  ///< within the receiver's accuracy limits
  bool differential = false;  ///< corrections were applied
  int carrier = 0;            ///< 0 none, 1 floating, 2 fixed ambiguities
  bool invalid_position = false;
  int satellites = 0;
  double longitude = 0, latitude = 0;                               ///< °
  double height = 0;                                                ///< m above the ellipsoid
  double horizontal_accuracy = 0, vertical_accuracy = 0;            ///< m, one standard deviation
  double velocity_north = 0, velocity_east = 0, velocity_down = 0;  ///< m/s
  double speed_accuracy = 0;                                        ///< m/s
  std::uint32_t time_of_week = 0;                                   ///< ms, of the navigation epoch
};
/// Empty for a payload that is too short. It has 92 bytes since protocol version 15, 84 before.
std::optional<NavPvt> read_nav_pvt(std::span<const std::uint8_t> payload) noexcept;

/// "HPG 1.32" and "27.31" from MON-VER; empty if they are missing.
struct ReceiverVersion {
  std::string software, hardware, protocol;
};
ReceiverVersion read_mon_ver(std::span<const std::uint8_t> payload);

/// Sets the period in ms between fixes, for receivers up to generation 8.
std::vector<std::uint8_t> cfg_rate(std::uint16_t period_ms);
/// Sets how often a message is sent on the receiving port: once per `every` fixes.
std::vector<std::uint8_t> cfg_msg(UbxId message, std::uint8_t every);

enum class ReceiverPort : std::uint8_t { uart1, uart2, usb };
/// The same for generation 9 and later, in volatile memory only: NAV-PVT with every fix on the port, and NMEA
/// off there.
std::vector<std::uint8_t> cfg_valset(std::uint16_t period_ms, ReceiverPort port);

}  // namespace polyarm::sensors
