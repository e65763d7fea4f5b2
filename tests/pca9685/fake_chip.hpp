#pragma once
/// A PCA9685 register by register, after the product data sheet (chapter 7 and table 4), without its pulses:
/// an output is a duty of 0 to 4096 ticks, which changes at STOP.
#include <array>
#include <cerrno>
#include <cstdint>
#include <span>

namespace polyarm::test {

class FakeChip {
 public:
  static constexpr int kChannels = 16;

  FakeChip() { power_on(); }

  void power_on() {
    registers_.fill(0);
    registers_[0x00] = 0x11;  // asleep, answers the all-call address
    registers_[0x01] = 0x04;
    registers_[0x02] = 0xE2;
    registers_[0x03] = 0xE4;
    registers_[0x04] = 0xE8;
    registers_[0x05] = 0xE0;
    for (int c = 0; c < kChannels; ++c) registers_[high(c)] = 0x10;  // full off
    registers_[0xFE] = 0x1E;
    outputs_.fill(0);
  }

  /// START, address, bytes, STOP. Returns 0 or the errno that a Linux bus reports for a missing acknowledge.
  int write(std::span<const std::uint8_t> bytes) {
    if (bytes.empty()) return 0;
    pointer_ = bytes[0];
    for (const std::uint8_t byte : bytes.subspan(1)) {
      if (reserved(pointer_)) return EREMOTEIO;
      store(pointer_, byte);
      advance();
    }
    stop();
    return 0;
  }
  int read(std::uint8_t first, std::span<std::uint8_t> into) {
    pointer_ = first;
    for (std::uint8_t& byte : into) {
      if (reserved(pointer_)) return EREMOTEIO;
      byte = pointer_ >= 0xFA && pointer_ <= 0xFD ? 0 : registers_[pointer_];
      advance();
    }
    return 0;
  }

  std::uint8_t at(int index) const { return registers_[static_cast<std::size_t>(index)]; }
  /// Ticks of 0 to 4096 that come out of a channel.
  int output(int channel) const { return outputs_[static_cast<std::size_t>(channel)]; }
  bool all_off() const { return outputs_ == std::array<int, kChannels>{}; }
  bool asleep() const { return (registers_[0] & kSleep) != 0; }

 private:
  static constexpr std::uint8_t kRestart = 0x80, kIncrement = 0x20, kSleep = 0x10;

  static std::size_t high(int channel) { return static_cast<std::size_t>(0x06 + 4 * channel + 3); }
  static bool reserved(std::uint8_t r) { return (r > 0x45 && r < 0xFA) || r == 0xFF; }

  void advance() {
    if ((registers_[0] & kIncrement) == 0) return;
    pointer_ = pointer_ == 0x45 || pointer_ == 0xFE ? 0 : static_cast<std::uint8_t>(pointer_ + 1);
  }

  bool any_pulses() const {
    for (int c = 0; c < kChannels; ++c)
      if (const int ticks = duty(c); ticks != 0 && ticks != 4096) return true;
    return false;
  }

  void store(std::uint8_t where, std::uint8_t value) {
    if (where == 0x00) return mode1(value);
    if (where == 0xFE) {
      if (asleep()) registers_[0xFE] = value < 3 ? 3 : value;
      return;
    }
    if (where == 0x01) value &= 0x1F;
    if (where >= 0xFA) {
      const int part = where - 0xFA;
      for (int c = 0; c < kChannels; ++c)
        registers_[static_cast<std::size_t>(0x06 + 4 * c + part)] = part % 2 ? value & 0x1F : value;
      pulses_written_ = true;
      return;
    }
    if (where >= 0x06 && where <= 0x45) {
      if ((where - 0x06) % 2 == 1) value &= 0x1F;
      pulses_written_ = true;
    }
    registers_[where] = value;
  }

  void mode1(std::uint8_t value) {
    const bool was_asleep = asleep();
    std::uint8_t restart = registers_[0] & kRestart;
    if ((value & kRestart) != 0 && !was_asleep) restart = 0;  // writing 1 clears it and pulses go on
    if (!was_asleep && (value & kSleep) != 0 && any_pulses()) restart = kRestart;
    registers_[0] = static_cast<std::uint8_t>((value & 0x7F) | restart);
  }

  void stop() {
    if (!asleep() && pulses_written_) registers_[0] &= 0x7F;  // that, too, ends a pending restart
    pulses_written_ = false;
    if (asleep() || (registers_[0] & kRestart) != 0) return;  // outputs stay as they are
    for (int c = 0; c < kChannels; ++c) outputs_[static_cast<std::size_t>(c)] = duty(c);
  }

  int duty(int channel) const {
    const auto first = static_cast<std::size_t>(0x06 + 4 * channel);
    if ((registers_[first + 3] & 0x10) != 0) return 0;
    if ((registers_[first + 1] & 0x10) != 0) return 4096;
    const int on = registers_[first] | (registers_[first + 1] & 0x0F) << 8;
    const int off = registers_[first + 2] | (registers_[first + 3] & 0x0F) << 8;
    return (off - on) & 0x0FFF;
  }

  std::array<std::uint8_t, 256> registers_{};
  std::array<int, kChannels> outputs_{};
  std::uint8_t pointer_ = 0;
  bool pulses_written_ = false;
};

}  // namespace polyarm::test
