#include "drivers/pca9685/chip.hpp"

#include <chrono>
#include <cmath>
#include <thread>

namespace polyarm::drivers {

using namespace pca9685;
using Step = ChipFailure::Step;

std::optional<std::uint8_t> prescale_for(double frequency) {
  if (!(frequency > 0) || !std::isfinite(frequency)) return std::nullopt;
  const double value = std::floor(kOscillator / kTicks / frequency + 0.5) - 1;
  if (value < kSmallestPrescale || value > 255) return std::nullopt;
  return static_cast<std::uint8_t>(value);
}

double frequency_of(std::uint8_t prescale) {
  return kOscillator / kTicks / (prescale + 1.0);
}

ChipFailure Pca9685::put(Step step, std::uint8_t where, std::uint8_t value) noexcept {
  const std::array<std::uint8_t, 2> bytes = {where, value};
  if (const int error = bus_.write(bytes)) return {step, where, 0, error};
  return {};
}

ChipFailure Pca9685::expect(Step step, std::uint8_t where, std::uint8_t value) noexcept {
  std::uint8_t got = 0;
  if (const int error = bus_.read(where, {&got, 1})) return {step, where, 0, error};
  if (got != value) return {step, where, got, 0};
  return {};
}

ChipFailure Pca9685::identify() noexcept {
  // No register holds the chip's name; impossible values identify other chips.
  std::uint8_t mode2 = 0, prescale = 0;
  if (const int error = bus_.read(kMode2, {&mode2, 1})) return {Step::identify, kMode2, 0, error};
  if ((mode2 & 0xE0) != 0) return {Step::identify, kMode2, mode2, 0};
  if (const int error = bus_.read(kPrescale, {&prescale, 1})) return {Step::identify, kPrescale, 0, error};
  if (prescale < kSmallestPrescale) return {Step::identify, kPrescale, prescale, 0};
  return expect(Step::identify, kAllOffHigh, 0);  // write-only
}

ChipFailure Pca9685::off() noexcept {
  return put(Step::off, kAllOffHigh, kFull);
}

ChipFailure Pca9685::start(std::uint8_t prescale) noexcept {
  if (const ChipFailure f = off()) return f;
  if (const ChipFailure f = put(Step::start, kMode1, kAutoIncrement | kSleep)) return f;
  if (const ChipFailure f = put(Step::start, kPrescale, prescale)) return f;
  if (const ChipFailure f = put(Step::start, kMode2, kTotemPole)) return f;
  if (const ChipFailure f = put(Step::start, kMode1, kAutoIncrement)) return f;
  std::this_thread::sleep_for(std::chrono::milliseconds(5));
  // Writing 1 to a pending restart clears it; nothing restarts, because all channels are off.
  if (const ChipFailure f = put(Step::start, kMode1, kAutoIncrement | kRestart)) return f;
  if (const ChipFailure f = expect(Step::verify, kPrescale, prescale)) return f;
  if (const ChipFailure f = expect(Step::verify, kMode2, kTotemPole)) return f;
  return expect(Step::verify, kMode1, kAutoIncrement);
}

ChipFailure Pca9685::set(int channel, int ticks) noexcept {
  const auto first = static_cast<std::uint8_t>(kLed0 + 4 * channel);
  std::array<std::uint8_t, 5> bytes = {first, 0, 0, 0, 0};  // on from count 0 …
  if (ticks <= 0) {
    bytes[4] = kFull;
  } else if (ticks >= kTicks) {
    bytes[2] = kFull;
  } else {  // … off from there
    bytes[3] = static_cast<std::uint8_t>(ticks & 0xFF);
    bytes[4] = static_cast<std::uint8_t>(ticks >> 8);
  }
  if (const int error = bus_.write(bytes)) return {Step::drive, first, 0, error};
  return {};
}

ChipFailure Pca9685::check() noexcept {
  return expect(Step::check, kMode1, kAutoIncrement);
}

ChipFailure Pca9685::sleep() noexcept {
  return put(Step::off, kMode1, kAutoIncrement | kSleep);
}

}  // namespace polyarm::drivers
