#pragma once
/// Big-endian numbers in a frame. Any thread; the reader allocates nothing.
#include <bit>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace polyarm::wire {

using Bytes = std::span<const std::uint8_t>;

/// Builds a frame. Allocates.
class Writer {
 public:
  Writer& u8(std::uint64_t value) { return put(value, 1); }
  Writer& u16(std::uint64_t value) { return put(value, 2); }
  Writer& u32(std::uint64_t value) { return put(value, 4); }
  Writer& u64(std::uint64_t value) { return put(value, 8); }
  Writer& i32(std::int32_t value) { return put(static_cast<std::uint32_t>(value), 4); }
  Writer& f32(float value) { return put(std::bit_cast<std::uint32_t>(value), 4); }
  Writer& f64(double value) { return put(std::bit_cast<std::uint64_t>(value), 8); }
  Writer& text(std::string_view value) {
    bytes_.insert(bytes_.end(), value.begin(), value.end());
    return *this;
  }
  Writer& append(Bytes value) {
    bytes_.insert(bytes_.end(), value.begin(), value.end());
    return *this;
  }
  const std::vector<std::uint8_t>& bytes() const { return bytes_; }

 private:
  Writer& put(std::uint64_t value, int size) {
    for (int shift = 8 * (size - 1); shift >= 0; shift -= 8)
      bytes_.push_back(static_cast<std::uint8_t>(value >> shift));
    return *this;
  }
  std::vector<std::uint8_t> bytes_;
};

/// Reads a frame from its beginning. A read beyond the end gives 0 and clears ok().
class Reader {
 public:
  explicit Reader(Bytes bytes) noexcept : bytes_(bytes) {}
  bool ok() const noexcept { return ok_; }
  std::size_t left() const noexcept { return bytes_.size(); }
  std::uint8_t u8() noexcept { return static_cast<std::uint8_t>(get(1)); }
  std::uint16_t u16() noexcept { return static_cast<std::uint16_t>(get(2)); }
  std::uint32_t u32() noexcept { return static_cast<std::uint32_t>(get(4)); }
  std::uint64_t u64() noexcept { return get(8); }
  std::int32_t i32() noexcept { return static_cast<std::int32_t>(u32()); }
  float f32() noexcept { return std::bit_cast<float>(u32()); }
  double f64() noexcept { return std::bit_cast<double>(u64()); }
  Bytes take(std::size_t size) noexcept {
    if (size > bytes_.size()) {
      ok_ = false;
      bytes_ = {};
      return {};
    }
    const Bytes out = bytes_.first(size);
    bytes_ = bytes_.subspan(size);
    return out;
  }
  Bytes rest() noexcept { return take(bytes_.size()); }
  /// Allocates.
  std::string text(std::size_t size) {
    const Bytes bytes = take(size);
    return {bytes.begin(), bytes.end()};
  }

 private:
  std::uint64_t get(std::size_t size) noexcept {
    std::uint64_t value = 0;
    for (const std::uint8_t byte : take(size)) value = value << 8 | byte;
    return value;
  }
  Bytes bytes_;
  bool ok_ = true;
};

}  // namespace polyarm::wire
