#pragma once
/// Fields of protocol buffers (version 2) in a frame. Any thread; the reader allocates nothing and goes no
/// deeper than its caller.
#include <bit>
#include <cstdint>
#include <string_view>
#include <vector>

#include "drivers/wire/bytes.hpp"

namespace polyarm::wire {

/// Builds a message. Allocates.
class ProtoWriter {
 public:
  ProtoWriter& number(std::uint32_t field, std::uint64_t value) {
    key(field, 0);
    varint(value);
    return *this;
  }
  ProtoWriter& f64(std::uint32_t field, double value) {
    key(field, 1);
    const auto bits = std::bit_cast<std::uint64_t>(value);
    for (int shift = 0; shift < 64; shift += 8) bytes_.push_back(static_cast<std::uint8_t>(bits >> shift));
    return *this;
  }
  ProtoWriter& text(std::uint32_t field, std::string_view value) {
    key(field, 2);
    varint(value.size());
    bytes_.insert(bytes_.end(), value.begin(), value.end());
    return *this;
  }
  ProtoWriter& message(std::uint32_t field, const ProtoWriter& inner) {
    key(field, 2);
    varint(inner.bytes_.size());
    bytes_.insert(bytes_.end(), inner.bytes_.begin(), inner.bytes_.end());
    return *this;
  }
  const std::vector<std::uint8_t>& bytes() const { return bytes_; }

 private:
  void key(std::uint32_t field, std::uint32_t type) { varint(field << 3 | type); }
  void varint(std::uint64_t value) {
    for (; value >= 0x80; value >>= 7) bytes_.push_back(static_cast<std::uint8_t>(value | 0x80));
    bytes_.push_back(static_cast<std::uint8_t>(value));
  }
  std::vector<std::uint8_t> bytes_;
};

/// Reads the fields of a message in their order:
///
///     while (in.next()) switch (in.field()) { case 1: seqno = in.number(); … }
///
/// A field that the caller does not ask for is passed over. A field of another type than the caller asks for,
/// and bytes that are not a message, clear ok().
class ProtoReader {
 public:
  enum class Type : std::uint8_t { number, fixed64, bytes, fixed32 };

  explicit ProtoReader(Bytes bytes) noexcept : rest_(bytes) {}
  bool ok() const noexcept { return ok_; }
  /// Goes to the next field; false at the end, and after an error.
  bool next() noexcept {
    if (!ok_ || rest_.empty()) return false;
    const std::uint64_t key = varint();
    field_ = static_cast<std::uint32_t>(key >> 3);
    if (!ok_ || field_ == 0 || key >> 3 > kMostField) return fail();
    switch (key & 7) {
      case 0:
        type_ = Type::number;
        number_ = varint();
        return ok_;
      case 1:
        type_ = Type::fixed64;
        number_ = fixed(8);
        return ok_;
      case 2:
        type_ = Type::bytes;
        bytes_ = take(varint());
        return ok_;
      case 5:
        type_ = Type::fixed32;
        number_ = fixed(4);
        return ok_;
      default:  // groups, which no message of today has
        return fail();
    }
  }
  std::uint32_t field() const noexcept { return field_; }
  Type type() const noexcept { return type_; }
  std::uint64_t number() noexcept { return expect(Type::number) ? number_ : 0; }
  double f64() noexcept { return expect(Type::fixed64) ? std::bit_cast<double>(number_) : 0; }
  float f32() noexcept {
    return expect(Type::fixed32) ? std::bit_cast<float>(static_cast<std::uint32_t>(number_)) : 0;
  }
  /// The bytes of an inner message.
  Bytes bytes() noexcept { return expect(Type::bytes) ? bytes_ : Bytes{}; }

 private:
  static constexpr std::uint64_t kMostField = (1u << 29) - 1;
  bool fail() noexcept {
    ok_ = false;
    rest_ = {};
    return false;
  }
  bool expect(Type type) noexcept { return type_ == type ? true : fail(); }
  std::uint64_t varint() noexcept {
    std::uint64_t value = 0;
    for (int shift = 0; shift < 64; shift += 7) {
      if (rest_.empty()) return fail();
      const std::uint8_t byte = rest_.front();
      rest_ = rest_.subspan(1);
      if (shift == 63 && byte > 1) return fail();
      value |= static_cast<std::uint64_t>(byte & 0x7F) << shift;
      if (byte < 0x80) return value;
    }
    return fail();
  }
  std::uint64_t fixed(std::size_t size) noexcept {
    const Bytes bytes = take(size);
    std::uint64_t value = 0;
    for (std::size_t i = bytes.size(); i > 0; --i) value = value << 8 | bytes[i - 1];
    return value;
  }
  Bytes take(std::uint64_t size) noexcept {
    if (size > rest_.size()) {
      fail();
      return {};
    }
    const Bytes out = rest_.first(static_cast<std::size_t>(size));
    rest_ = rest_.subspan(static_cast<std::size_t>(size));
    return out;
  }
  Bytes rest_, bytes_;
  std::uint64_t number_ = 0;
  std::uint32_t field_ = 0;
  Type type_ = Type::number;
  bool ok_ = true;
};

}  // namespace polyarm::wire
