#pragma once
/// The PCA9685, a 16-channel, 12-bit pulse-width chip (NXP, product data sheet, revision 4, chapter 7).
#include <array>
#include <cstdint>
#include <optional>

#include "drivers/pca9685/i2c_bus.hpp"

namespace polyarm::drivers {

namespace pca9685 {
// Registers.
constexpr std::uint8_t kMode1 = 0x00, kMode2 = 0x01, kLed0 = 0x06, kAllOffHigh = 0xFD, kPrescale = 0xFE;
// Bits of MODE1.
constexpr std::uint8_t kRestart = 0x80, kExternalClock = 0x40, kAutoIncrement = 0x20, kSleep = 0x10;
// MODE2: both transistors of an output drive it; outputs change at STOP.
constexpr std::uint8_t kTotemPole = 0x04;
// Bit 4 of a high byte: the output is on, or off, all the time. Off goes before on.
constexpr std::uint8_t kFull = 0x10;
constexpr int kTicks = 4096;  ///< counts of one pulse period; a duty of 4096 is "on all the time"
constexpr double kOscillator = 25'000'000;  ///< Hz, the one inside
constexpr int kSmallestPrescale = 3;        ///< hardware takes no less
}  // namespace pca9685

/// The prescaler for a pulse frequency in Hz; nothing where the chip cannot make it (about 24 to 1743 Hz).
std::optional<std::uint8_t> prescale_for(double frequency);
/// What a prescaler makes, Hz.
double frequency_of(std::uint8_t prescale);

/// What failed, at which register.
struct ChipFailure {
  enum class Step : std::uint8_t { none, identify, off, start, verify, drive, check };
  Step step = Step::none;
  std::uint8_t where = 0;  ///< register
  std::uint8_t value = 0;  ///< what was read, where `error` is 0
  int error = 0;           ///< errno of the bus; 0: the chip answered, but not what it should
  explicit operator bool() const noexcept { return step != Step::none; }
};

/// Speaks to the chip. No call but start() waits for anything but the bus; none throws or allocates.
class Pca9685 {
 public:
  explicit Pca9685(I2cBus& bus) : bus_(bus) {}

  /// Reads only: is what answers such a chip?
  ChipFailure identify() noexcept;
  /// Every output off, from the end of the running pulse on: one transaction, whatever the chip did.
  ChipFailure off() noexcept;
  /// All off, then asleep (only then the prescaler can be set), prescaler, output stage, awake, and 5 ms for
  /// the oscillator (it needs 0.5 ms). The old pulses do not start again. Reads back what it set.
  ChipFailure start(std::uint8_t prescale) noexcept;
  /// One channel, 0 to 15: 0 is off, kTicks is on.
  ChipFailure set(int channel, int ticks) noexcept;
  /// Is the chip as start() left it? It is not after a loss of power, or when somebody sent it to sleep.
  ChipFailure check() noexcept;
  /// The oscillator stops, and outputs keep their level whatever is written. Call when all are off, and a
  /// pulse period has passed since.
  ChipFailure sleep() noexcept;

 private:
  ChipFailure put(ChipFailure::Step step, std::uint8_t where, std::uint8_t value) noexcept;
  ChipFailure expect(ChipFailure::Step step, std::uint8_t where, std::uint8_t value) noexcept;
  I2cBus& bus_;
};

}  // namespace polyarm::drivers
