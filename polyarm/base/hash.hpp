#pragma once
/// Hash for traces and replay checks. Not for security.
#include <bit>
#include <cstdint>
#include <string>

namespace polyarm {

/// A running 64-bit hash over the bits of numbers. Each word is mixed by a multiplication and a shift of the
/// high half down (the round of a multiplicative hash).
class TraceHash {
 public:
  void add(std::uint64_t word) noexcept {
    state_ = (state_ ^ word) * 0x9e3779b97f4a7c15ULL;
    state_ ^= state_ >> 32;
  }
  void add(double value) noexcept { add(std::bit_cast<std::uint64_t>(value)); }
  std::uint64_t value() const noexcept { return state_; }
  /// 16 hexadecimal digits.
  std::string text() const {
    static constexpr char digits[] = "0123456789abcdef";
    std::string out(16, '0');
    for (int i = 0; i < 16; ++i) out[static_cast<std::size_t>(15 - i)] = digits[(state_ >> (4 * i)) & 0xf];
    return out;
  }

 private:
  std::uint64_t state_ = 0xcbf29ce484222325ULL;
};

}  // namespace polyarm
