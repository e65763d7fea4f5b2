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
// Bit 4 of a high byte: the output is permanently on, or off. Off has priority.
constexpr std::uint8_t kFull = 0x10;
constexpr int kTicks = 4096;                ///< counts of one pulse period; a duty of 4096 is permanently on
constexpr double kOscillator = 25'000'000;  ///< Hz, internal oscillator
constexpr int kSmallestPrescale = 3;        ///< lower limit of the hardware
}  // namespace pca9685

/// The prescaler for a pulse frequency in Hz; empty if the chip cannot generate it (it can from about 24 to
/// 1743 Hz).
std::optional<std::uint8_t> prescale_for(double frequency);
/// The frequency of a prescaler, Hz.
double frequency_of(std::uint8_t prescale);

/// The failed step and its register.
struct ChipFailure {
  enum class Step : std::uint8_t { none, identify, off, start, verify, drive, check };
  Step step = Step::none;
  std::uint8_t where = 0;  ///< register
  std::uint8_t value = 0;  ///< the value read, if `error` is 0
  int error = 0;           ///< errno of the bus; 0: the chip answered, but with a wrong value
  explicit operator bool() const noexcept { return step != Step::none; }
};

/// Controls the chip. Only start() waits for more than the bus; nothing throws or allocates. One thread at a
/// time.
class Pca9685 {
 public:
  explicit Pca9685(I2cBus& bus) : bus_(bus) {}

  /// Reads only: checks that the device behaves like this chip.
  ChipFailure identify() noexcept;
  /// Switches every output off at the end of the running pulse, in one transaction and from any state.
  ChipFailure off() noexcept;
  /// Switches all outputs off, then: sleep (the prescaler can only be set in sleep), prescaler, output stage,
  /// wake up, and 5 ms for the oscillator (it needs 0.5 ms). The old pulses do not restart. Verifies the
  /// settings by reading them back.
  ChipFailure start(std::uint8_t prescale) noexcept;
  /// Sets one channel, 0 to 15: 0 is off, kTicks is on.
  ChipFailure set(int channel, int ticks) noexcept;
  /// Checks that the chip still has the settings of start(). It loses them without power, or if another
  /// master puts it to sleep.
  ChipFailure check() noexcept;
  /// Stops the oscillator; outputs then keep their level. Call it when all outputs are off and one pulse
  /// period has passed.
  ChipFailure sleep() noexcept;

 private:
  ChipFailure put(ChipFailure::Step step, std::uint8_t where, std::uint8_t value) noexcept;
  ChipFailure expect(ChipFailure::Step step, std::uint8_t where, std::uint8_t value) noexcept;
  I2cBus& bus_;
};

}  // namespace polyarm::drivers
