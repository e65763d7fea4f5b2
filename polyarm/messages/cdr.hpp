#pragma once
/// Common data representation (CDR), as used by ROS 2 on the wire and in MCAP: XCDR version 1, plain.
///
/// A payload is a header of four bytes (0, byte order, two option bytes) followed by the fields. Each field
/// is aligned to its size, counted from the end of the header. A text is its length including the NUL, the
/// bytes, and NUL. A sequence is its length and the elements. Source: DDS-XTypes 1.3, 7.4.3; OMG
/// formal/2008-01-04 (DDSI-RTPS 2.1), 10.2.
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace polyarm::messages {

inline constexpr std::size_t kCdrHeader = 4;

/// Writes into memory of a fixed size, little-endian. Any thread; allocates nothing. Bytes that do not fit
/// are counted but not written.
class CdrWriter {
 public:
  /// `room` may be empty: the writer then only counts.
  explicit CdrWriter(std::span<std::byte> room) : room_{room} { header(); }

  /// Size of the payload so far, including the header and bytes that did not fit.
  std::size_t size() const { return at_; }
  bool fits() const { return at_ <= room_.size(); }

  template <class T>
  requires std::is_arithmetic_v<T>
  void write(T value) {
    align(sizeof(T));
    put(&value, sizeof(T));
  }
  void write(std::string_view text) {
    write(static_cast<std::uint32_t>(text.size() + 1));
    put(text.data(), text.size());
    const char end = '\0';
    put(&end, 1);
  }
  void write(const std::string& text) { write(std::string_view(text)); }
  void write(const char* text) { write(std::string_view(text)); }
  void write_length(std::size_t count) { write(static_cast<std::uint32_t>(count)); }
  /// Writes consecutive numbers without a length.
  template <class T>
  requires std::is_arithmetic_v<T>
  void write_all(std::span<const T> values) {
    if (values.empty()) return;
    align(sizeof(T));
    put(values.data(), values.size_bytes());
  }

 private:
  void header() {
    static constexpr std::array<std::uint8_t, kCdrHeader> bytes{0, 1, 0, 0};
    put(bytes.data(), bytes.size());
  }
  void align(std::size_t to) {
    static constexpr std::array<std::uint8_t, 8> nothing{};
    put(nothing.data(), (to - (at_ - kCdrHeader) % to) % to);
  }
  void put(const void* bytes, std::size_t count) {
    if (at_ <= room_.size() && count <= room_.size() - at_ && count > 0)
      std::memcpy(room_.data() + at_, bytes, count);
    at_ += count;
  }

  std::span<std::byte> room_;
  std::size_t at_ = 0;
};

/// Errors of a payload.
enum class CdrError {
  none,
  header,    ///< no header, or a representation that ROS 2 does not use
  short_,    ///< it ends within a field
  text,      ///< a text without its NUL
  boolean,   ///< a boolean that is neither 0 nor 1
  too_many,  ///< more elements than a bounded sequence allows
  trailing,  ///< more bytes after the last field than padding
};
const char* name(CdrError error);

/// Reads a payload of either byte order. Any thread. After the first error it reads nothing more: outputs
/// stay unchanged and `error()` reports the error. A wrong length cannot make it allocate more than the
/// payload could fill.
class CdrReader {
 public:
  explicit CdrReader(std::span<const std::byte> payload);

  CdrError error() const { return error_; }
  explicit operator bool() const { return error_ == CdrError::none; }
  void fail(CdrError error) {
    if (error_ == CdrError::none) error_ = error;
  }
  std::size_t left() const { return bytes_.size() - at_; }

  template <class T>
  requires(std::is_arithmetic_v<T> && !std::is_same_v<T, bool>) void read(T& value) {
    if (need(sizeof(T), sizeof(T))) value = take<T>();
  }
  void read(bool& value) {
    std::uint8_t byte = 0;
    read(byte);
    if (byte > 1) fail(CdrError::boolean);
    if (error_ == CdrError::none) value = byte == 1;
  }
  void read(std::string& text);
  /// The length of a sequence with elements of at least `least` bytes; 0 after an error.
  std::size_t read_length(std::size_t least, std::size_t most = SIZE_MAX);
  template <class T>
  requires(std::is_arithmetic_v<T> && !std::is_same_v<T, bool>) void read_all(std::span<T> values) {
    if (values.empty() || !need(sizeof(T), values.size_bytes())) return;
    if (!swapped_) {
      std::memcpy(values.data(), bytes_.data() + at_, values.size_bytes());
      at_ += values.size_bytes();
      return;
    }
    for (T& value : values) value = take<T>();
  }
  /// Call it at the end: up to three bytes of padding may follow the last field.
  void finish() {
    if (left() > 3) fail(CdrError::trailing);
  }

 private:
  bool need(std::size_t alignment, std::size_t count);
  template <class T>
  T take() {
    std::array<std::byte, sizeof(T)> raw;
    for (std::size_t i = 0; i < sizeof(T); ++i) raw[swapped_ ? sizeof(T) - 1 - i : i] = bytes_[at_ + i];
    at_ += sizeof(T);
    T value;
    std::memcpy(&value, raw.data(), sizeof(T));
    return value;
  }

  std::span<const std::byte> bytes_;
  std::size_t at_ = 0;
  bool swapped_ = false;
  CdrError error_ = CdrError::none;
};

/// Elements of sequences and arrays; for generated code.
template <class T>
void write_elements(CdrWriter& out, std::span<const T> values) {
  if constexpr (std::is_arithmetic_v<T>) {
    out.write_all(values);
  } else if constexpr (std::is_same_v<T, std::string>) {
    for (const T& value : values) out.write(value);
  } else {
    for (const T& value : values) write(out, value);
  }
}
template <class T>
void read_elements(CdrReader& in, std::span<T> values) {
  if constexpr (std::is_arithmetic_v<T>) {
    in.read_all(values);
  } else if constexpr (std::is_same_v<T, std::string>) {
    for (T& value : values) in.read(value);
  } else {
    for (T& value : values) read(in, value);
  }
}

/// The payload of a message, including the header.
template <class Message>
std::vector<std::byte> to_cdr(const Message& message) {
  CdrWriter counter({});
  write(counter, message);
  std::vector<std::byte> payload(counter.size());
  CdrWriter out(payload);
  write(out, message);
  return payload;
}

/// Writes into existing memory. Returns the number of bytes, or 0 if they do not fit. Allocates nothing.
template <class Message>
std::size_t to_cdr(const Message& message, std::span<std::byte> room) {
  CdrWriter out(room);
  write(out, message);
  return out.fits() ? out.size() : 0;
}

/// Reads a payload into `message` and reuses its memory. After an error the message may be partly filled.
template <class Message>
CdrError from_cdr(std::span<const std::byte> payload, Message& message) {
  CdrReader in(payload);
  read(in, message);
  in.finish();
  return in.error();
}

}  // namespace polyarm::messages
