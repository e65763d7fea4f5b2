#pragma once
/// Frames of WitMotion's serial inertial sensors (WIT standard protocol; WT901, HWT905, JY901 and others):
/// eleven bytes: 0x55, a type, four little-endian 16-bit numbers, and the sum of the ten bytes before.
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace polyarm::sensors {

inline constexpr std::size_t kWitFrameSize = 11;

enum class WitType : std::uint8_t {
  time = 0x50,
  acceleration = 0x51,      ///< x y z, full scale 16 g; temperature, 1/100 °C
  angular_velocity = 0x52,  ///< x y z, full scale 2000 °/s; the fourth differs by model
  angle = 0x53,             ///< roll pitch yaw, full scale 180°
  magnetic = 0x54,
  quaternion = 0x59,  ///< w x y z, full scale 1
  gnss_accuracy = 0x5A,
  register_value = 0x5F,  ///< answer to a read: four registers from the requested one
};

struct WitFrame {
  WitType type{};
  std::array<std::int16_t, 4> values{};
};

/// Finds frames in a stream. Other bytes are skipped, and a false start does not swallow a true frame after
/// it. Allocates nothing.
class WitReader {
 public:
  struct Counts {
    std::uint64_t frames = 0;
    std::uint64_t bad_sums = 0;       ///< frames with a wrong sum
    std::uint64_t skipped_bytes = 0;  ///< not part of any frame
  };
  /// Takes one byte; true when it completes a frame, which is then in frame().
  bool push(std::uint8_t byte) noexcept;
  const WitFrame& frame() const noexcept { return frame_; }
  /// Takes bytes and calls `each` with every frame.
  template <typename Each>
  void take(std::span<const std::uint8_t> bytes, Each each) noexcept {
    for (const std::uint8_t byte : bytes)
      if (push(byte)) each(frame_);
  }
  const Counts& counts() const noexcept { return counts_; }
  /// Drops a partial frame.
  void restart() noexcept { size_ = 0; }

 private:
  void drop_to_next_beginning() noexcept;
  std::array<std::uint8_t, kWitFrameSize> bytes_{};
  std::size_t size_ = 0;
  WitFrame frame_;
  Counts counts_;
};

/// The five bytes that write `value` to a register.
std::array<std::uint8_t, 5> wit_write(std::uint8_t address, std::uint16_t value);

// Registers, and their values.
inline constexpr std::uint8_t kWitSave = 0x00, kWitContent = 0x02, kWitRate = 0x03, kWitReadAddress = 0x27,
                              kWitVersion = 0x2E, kWitKey = 0x69;
inline constexpr std::uint16_t kWitUnlock = 0xB588;
inline constexpr std::uint16_t kWitContentAcceleration = 1 << 1, kWitContentVelocity = 1 << 2,
                               kWitContentAngle = 1 << 3, kWitContentQuaternion = 1 << 9;
/// The code of an output rate in Hz (1, 2, 5, 10, 20, 50, 100, 200); 0 for any other rate.
std::uint16_t wit_rate_code(double rate);

}  // namespace polyarm::sensors
