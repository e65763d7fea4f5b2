#pragma once
/// Numbers in a frame whose byte order is known only at run time. Any thread; the reader allocates nothing.
#include "drivers/wire/bytes.hpp"

namespace polyarm::wire {

enum class ByteOrder : std::uint8_t { big, little };

/// A Writer in either order. Allocates.
class OrderedWriter {
 public:
  explicit OrderedWriter(ByteOrder order) : order_(order) {}
  OrderedWriter& u8(std::uint64_t value) { return writer_.u8(value), *this; }
  OrderedWriter& u16(std::uint64_t value) {
    const auto low = static_cast<std::uint16_t>(value);
    return writer_.u16(order_ == ByteOrder::big ? low : __builtin_bswap16(low)), *this;
  }
  OrderedWriter& u32(std::uint64_t value) {
    const auto low = static_cast<std::uint32_t>(value);
    return writer_.u32(order_ == ByteOrder::big ? low : __builtin_bswap32(low)), *this;
  }
  OrderedWriter& u64(std::uint64_t value) {
    return writer_.u64(order_ == ByteOrder::big ? value : __builtin_bswap64(value)), *this;
  }
  OrderedWriter& f64(double value) { return u64(std::bit_cast<std::uint64_t>(value)); }
  OrderedWriter& i32(std::int32_t value) { return u32(static_cast<std::uint32_t>(value)); }
  OrderedWriter& f32(float value) { return u32(std::bit_cast<std::uint32_t>(value)); }
  OrderedWriter& text(std::string_view value) { return writer_.text(value), *this; }
  OrderedWriter& append(Bytes value) { return writer_.append(value), *this; }
  const std::vector<std::uint8_t>& bytes() const { return writer_.bytes(); }

 private:
  ByteOrder order_;
  Writer writer_;
};

/// A Reader in either order. A read beyond the end gives 0 and clears ok().
class OrderedReader {
 public:
  OrderedReader(Bytes bytes, ByteOrder order) noexcept : order_(order), reader_(bytes) {}
  bool ok() const noexcept { return reader_.ok(); }
  std::size_t left() const noexcept { return reader_.left(); }
  std::uint8_t u8() noexcept { return reader_.u8(); }
  std::uint16_t u16() noexcept {
    const std::uint16_t value = reader_.u16();
    return order_ == ByteOrder::big ? value : __builtin_bswap16(value);
  }
  std::uint32_t u32() noexcept {
    const std::uint32_t value = reader_.u32();
    return order_ == ByteOrder::big ? value : __builtin_bswap32(value);
  }
  std::uint64_t u64() noexcept {
    const std::uint64_t value = reader_.u64();
    return order_ == ByteOrder::big ? value : __builtin_bswap64(value);
  }
  double f64() noexcept { return std::bit_cast<double>(u64()); }
  std::int32_t i32() noexcept { return static_cast<std::int32_t>(u32()); }
  float f32() noexcept { return std::bit_cast<float>(u32()); }
  Bytes take(std::size_t size) noexcept { return reader_.take(size); }
  Bytes rest() noexcept { return reader_.rest(); }

 private:
  ByteOrder order_;
  Reader reader_;
};

}  // namespace polyarm::wire
