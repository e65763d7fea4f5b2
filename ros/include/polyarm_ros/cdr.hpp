#pragma once
/// Messages as payloads of ROS 2 and back: CDR, version 1, plain. For messages that `polyarm plugin` made
/// from their .msg, .srv and .action files; others have no type on the graph. In C++17, as code of packages
/// is.
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace polyarm_ros {

using Payload = std::vector<std::uint8_t>;
constexpr std::size_t kCdrHeader = 4;

/// True for messages that were made from a definition.
template <typename T, typename = void>
struct HasFields : std::false_type {};
template <typename T>
struct HasFields<T, std::void_t<decltype(T::polyarm_type())>> : std::true_type {};

/// Appends to a payload, little-endian.
class Encoder {
 public:
  explicit Encoder(Payload& out) : out_(out) { out_.insert(out_.end(), {0, 1, 0, 0}); }

  template <typename T>
  void operator()(const T& value) {
    if constexpr (std::is_same_v<T, bool>)
      number(static_cast<std::uint8_t>(value));
    else if constexpr (std::is_arithmetic_v<T>)
      number(value);
    else
      value.polyarm_fields(*this);
  }
  void operator()(const std::string& text) {
    number(static_cast<std::uint32_t>(text.size() + 1));
    bytes(text.c_str(), text.size() + 1);
  }
  void operator()(const std::u16string& text) {
    number(static_cast<std::uint32_t>(text.size()));
    for (const char16_t c : text) number(static_cast<std::uint32_t>(c));
  }
  template <typename T, std::size_t kSize>
  void operator()(const std::array<T, kSize>& values) {
    all(values);
  }
  template <typename T>
  void operator()(const std::vector<T>& values) {
    number(static_cast<std::uint32_t>(values.size()));
    all(values);
  }

 private:
  template <typename List>
  void all(const List& values) {
    using T = typename List::value_type;
    if constexpr (std::is_arithmetic_v<T> && !std::is_same_v<T, bool>) {
      if (values.empty()) return;
      align(sizeof(T));
      bytes(values.data(), values.size() * sizeof(T));
    } else {
      for (const T& value : values) (*this)(value);
    }
  }
  template <typename T>
  void number(T value) {
    align(sizeof(T));
    bytes(&value, sizeof value);
  }
  void align(std::size_t to) { out_.resize(out_.size() + (to - (out_.size() - kCdrHeader) % to) % to); }
  void bytes(const void* from, std::size_t size) {
    const auto* begin = static_cast<const std::uint8_t*>(from);
    out_.insert(out_.end(), begin, begin + size);
  }
  Payload& out_;
};

/// Reads a payload of either byte order. After the first error it reads nothing more. A wrong length makes it
/// allocate no more than the payload could fill.
class Decoder {
 public:
  explicit Decoder(const Payload& in) : in_(in), at_(kCdrHeader) {
    good_ = in.size() >= kCdrHeader && in[0] == 0 && in[1] <= 1;
    swapped_ = good_ && in[1] == 0;
  }
  /// True if the whole payload was a message: up to three bytes of padding may follow it.
  bool finish() const { return good_ && in_.size() - at_ <= 3; }

  template <typename T>
  void operator()(T& value) {
    if constexpr (std::is_same_v<T, bool>) {
      std::uint8_t byte = 0;
      number(byte);
      if (byte > 1) good_ = false;
      value = byte == 1;
    } else if constexpr (std::is_arithmetic_v<T>) {
      number(value);
    } else {
      value.polyarm_fields(*this);
    }
  }
  void operator()(std::string& text) {
    std::uint32_t size = 0;
    number(size);
    if (!good_ || !need(1, size)) return;
    if (size > 0 && in_[at_ + size - 1] != 0) good_ = false;
    if (good_) text.assign(reinterpret_cast<const char*>(in_.data() + at_), size > 0 ? size - 1 : 0);
    at_ += size;
  }
  void operator()(std::u16string& text) {
    const std::size_t size = length(4);
    text.assign(size, u'\0');
    for (char16_t& c : text) {
      std::uint32_t code = 0;
      number(code);
      c = static_cast<char16_t>(code);
    }
  }
  template <typename T, std::size_t kSize>
  void operator()(std::array<T, kSize>& values) {
    for (T& value : values) (*this)(value);
  }
  template <typename T>
  void operator()(std::vector<T>& values) {
    const std::size_t size = length(std::is_arithmetic_v<T> ? sizeof(T) : 1);
    values.clear();
    for (std::size_t i = 0; i < size && good_; ++i) {
      T value{};
      (*this)(value);
      values.push_back(std::move(value));
    }
  }

 private:
  std::size_t length(std::size_t least) {
    std::uint32_t size = 0;
    number(size);
    if (good_ && size > (in_.size() - at_) / least) good_ = false;
    return good_ ? size : 0;
  }
  bool need(std::size_t alignment, std::size_t size) {
    const std::size_t padding = (alignment - (at_ - kCdrHeader) % alignment) % alignment;
    if (good_ && (in_.size() - at_ < padding || in_.size() - at_ - padding < size)) good_ = false;
    if (good_) at_ += padding;
    return good_;
  }
  template <typename T>
  void number(T& value) {
    if (!good_ || !need(sizeof(T), sizeof(T))) return;
    std::uint8_t raw[sizeof(T)];
    for (std::size_t i = 0; i < sizeof(T); ++i) raw[swapped_ ? sizeof(T) - 1 - i : i] = in_[at_ + i];
    std::memcpy(&value, raw, sizeof(T));
    at_ += sizeof(T);
  }
  const Payload& in_;
  std::size_t at_;
  bool good_ = false, swapped_ = false;
};

template <typename Message>
void encode(const Message& message, Payload& out) {
  Encoder encoder(out);
  encoder(message);
}
/// False if the payload is not a message of this type; then `message` may be partly filled.
template <typename Message>
bool decode(const Payload& payload, Message& message) {
  Decoder decoder(payload);
  decoder(message);
  return decoder.finish();
}

}  // namespace polyarm_ros
