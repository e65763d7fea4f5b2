#pragma once
/// A running 64-bit hash of numbers (FNV-1a over their bytes), for traces and replay checks; not for security.
#include <bit>
#include <cstdint>
#include <span>
#include <string>

namespace polyarm {

class TraceHash {
 public:
  void add(std::uint64_t word) noexcept {
    for (int i = 0; i < 8; ++i) {
      state_ = (state_ ^ (word & 0xff)) * 0x100000001b3ULL;
      word >>= 8;
    }
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
