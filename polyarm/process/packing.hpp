#pragma once
/// Packs numbers, texts and bytes in sequence, for messages between two processes on one machine. The reader
/// trusts nothing: missing data is read as zeros or empty, and `good()` is false afterwards.
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace polyarm::process {

class Packer {
 public:
  /// Writes to `room` from its beginning and reuses its memory.
  explicit Packer(std::vector<std::byte>& room) : out_{room} { out_.clear(); }

  template <class T>
  requires std::is_arithmetic_v<T> Packer& number(T value) { return bytes(&value, sizeof value); }
  template <std::size_t N>
  Packer& array(const std::array<std::uint8_t, N>& value) {
    return bytes(value.data(), N);
  }
  Packer& text(std::string_view text) {
    number(static_cast<std::uint32_t>(text.size()));
    return bytes(text.data(), text.size());
  }
  /// Appends the rest of the message, without a length.
  Packer& rest(std::span<const std::byte> rest) { return bytes(rest.data(), rest.size()); }

 private:
  Packer& bytes(const void* from, std::size_t count) {
    const auto* begin = static_cast<const std::byte*>(from);
    out_.insert(out_.end(), begin, begin + count);
    return *this;
  }
  std::vector<std::byte>& out_;
};

class Unpacker {
 public:
  explicit Unpacker(std::span<const std::byte> message) : left_{message} {}

  bool good() const { return good_; }
  template <class T>
  requires(std::is_arithmetic_v<T> && !std::is_same_v<T, bool>) T number() {
    T value{};
    bytes(&value, sizeof value);
    return value;
  }
  bool truth() { return number<std::uint8_t>() != 0; }
  template <std::size_t N>
  std::array<std::uint8_t, N> array() {
    std::array<std::uint8_t, N> value{};
    bytes(value.data(), N);
    return value;
  }
  /// Fails and returns an empty text if it is longer than `most`.
  std::string text(std::size_t most) {
    const auto size = number<std::uint32_t>();
    if (!good_ || size > most || size > left_.size()) {
      good_ = false;
      return {};
    }
    std::string out(reinterpret_cast<const char*>(left_.data()), size);
    left_ = left_.subspan(size);
    return out;
  }
  /// The next bytes; empty if there are fewer.
  std::span<const std::byte> take(std::size_t count) {
    if (!good_ || left_.size() < count) {
      good_ = false;
      return {};
    }
    const auto out = left_.first(count);
    left_ = left_.subspan(count);
    return out;
  }
  std::span<const std::byte> rest() const { return good_ ? left_ : std::span<const std::byte>{}; }

 private:
  void bytes(void* to, std::size_t count) {
    if (!good_ || left_.size() < count) {
      good_ = false;
      return;
    }
    std::memcpy(to, left_.data(), count);
    left_ = left_.subspan(count);
  }
  std::span<const std::byte> left_;
  bool good_ = true;
};

}  // namespace polyarm::process
