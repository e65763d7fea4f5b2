#include "drivers/xarm/ux.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "polyarm/base/text.hpp"

namespace polyarm::xarm {

namespace {

std::vector<std::uint8_t> frame(std::uint16_t transaction, std::uint16_t protocol, Bytes body) {
  return wire::Writer().u16(transaction).u16(protocol).u16(body.size()).append(body).bytes();
}

bool is_private(std::uint16_t protocol) {
  return protocol == kPrivateProtocol || protocol == kHeartbeatProtocol;
}

/// A number at the beginning of a text, at most three digits, and what is behind it.
std::optional<int> leading_number(std::string_view& text) {
  std::size_t digits = 0;
  int value = 0;
  while (digits < text.size() && digits < 3 && text[digits] >= '0' && text[digits] <= '9')
    value = value * 10 + (text[digits++] - '0');
  if (digits == 0) return std::nullopt;
  text.remove_prefix(digits);
  return value;
}

bool take(std::string_view& text, char wanted) {
  if (text.empty() || text.front() != wanted) return false;
  text.remove_prefix(1);
  return true;
}

/// The last "1.12.10" of the text.
void find_firmware(std::string_view text, Version& out) {
  const std::size_t at = text.find_last_of("vV");
  if (at == std::string_view::npos) return;
  text.remove_prefix(at + 1);
  const auto major = leading_number(text);
  const bool dot = take(text, '.');
  const auto minor = leading_number(text);
  const bool second = take(text, '.');
  const auto revision = leading_number(text);
  if (!major || !dot || !minor || !second || !revision) return;
  out.major = *major;
  out.minor = *minor;
  out.revision = *revision;
}

}  // namespace

std::vector<std::uint8_t> encode(const UxRequest& request) {
  std::vector<std::uint8_t> body{static_cast<std::uint8_t>(request.reg)};
  body.insert(body.end(), request.data.begin(), request.data.end());
  return frame(request.transaction, request.protocol, body);
}

std::vector<std::uint8_t> encode(const UxReply& reply) {
  std::vector<std::uint8_t> body{static_cast<std::uint8_t>(reply.reg), reply.bits};
  body.insert(body.end(), reply.data.begin(), reply.data.end());
  return frame(reply.transaction, reply.protocol, body);
}

std::optional<UxRequest> decode_request(const UxFrame& frame) {
  if (!is_private(frame.protocol) || frame.body.empty()) return std::nullopt;
  UxRequest out{frame.transaction, frame.protocol, static_cast<Register>(frame.body[0]), {}};
  out.data.assign(frame.body.begin() + 1, frame.body.end());
  return out;
}

std::optional<UxReply> decode_reply(const UxFrame& frame) {
  if (!is_private(frame.protocol) || frame.body.size() < 2) return std::nullopt;
  UxReply out{frame.transaction, static_cast<Register>(frame.body[0]), frame.body[1], {}, frame.protocol};
  out.data.assign(frame.body.begin() + 2, frame.body.end());
  return out;
}

std::size_t UxReader::length() const {
  return static_cast<std::size_t>(buffer_[4] << 8 | buffer_[5]);
}

/// The first frame of the buffer says how long it is.
bool UxReader::length_is_wrong() const {
  if (buffer_.size() < kUxHead) return false;
  return length() < 1 || length() > kLongestUx;
}

bool UxReader::feed(Bytes bytes) {
  if (length_is_wrong()) return false;
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
  return !length_is_wrong();
}

std::optional<UxFrame> UxReader::next() {
  if (buffer_.size() < kUxHead || length_is_wrong()) return std::nullopt;
  const std::size_t whole = kUxHead + length();
  if (buffer_.size() < whole) return std::nullopt;
  wire::Reader in(buffer_);
  UxFrame out;
  out.transaction = in.u16();
  out.protocol = in.u16();
  out.body.assign(buffer_.begin() + kUxHead, buffer_.begin() + static_cast<std::ptrdiff_t>(whole));
  buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(whole));
  return out;
}

UxData& UxData::u8(std::uint64_t value) {
  bytes_.push_back(static_cast<std::uint8_t>(value));
  return *this;
}

UxData& UxData::u16(std::uint64_t value) {
  return u8(value >> 8).u8(value);
}

UxData& UxData::u32(std::uint64_t value) {
  return u16(value >> 16).u16(value);
}

UxData& UxData::f32(double value) {
  const auto word = std::bit_cast<std::uint32_t>(static_cast<float>(value));
  for (int shift = 0; shift < 32; shift += 8) u8(word >> shift);
  return *this;
}

UxData& UxData::f32(std::span<const double> values) {
  for (const double value : values) f32(value);
  return *this;
}

UxData& UxData::text(const std::string& value, std::size_t size) {
  for (std::size_t i = 0; i < size; ++i) u8(i < value.size() ? static_cast<std::uint8_t>(value[i]) : 0);
  return *this;
}

float float_at(Bytes in, std::size_t at) noexcept {
  std::uint32_t word = 0;
  for (std::size_t i = 0; i < 4; ++i) word |= static_cast<std::uint32_t>(in[at + i]) << (8 * i);
  return std::bit_cast<float>(word);
}

std::optional<std::vector<double>> floats(Bytes in, std::size_t count) {
  if (in.size() < 4 * count) return std::nullopt;
  std::vector<double> out(count);
  for (std::size_t i = 0; i < count; ++i) {
    out[i] = float_at(in, 4 * i);
    if (!std::isfinite(out[i])) return std::nullopt;
  }
  return out;
}

std::string Version::firmware() const {
  return std::to_string(major) + "." + std::to_string(minor) + "." + std::to_string(revision);
}

Version parse_version(Bytes bytes) {
  Version out;
  for (const std::uint8_t byte : bytes.first(std::min<std::size_t>(bytes.size(), 80))) {
    if (byte == 0) break;
    if (byte >= 32 && byte < 127) out.text += static_cast<char>(byte);
  }
  out.text = std::string(trim(out.text));
  std::string_view rest = out.text;
  const auto axes = leading_number(rest);
  if (axes && take(rest, ',')) {
    out.axes = *axes;
    out.type = leading_number(rest).value_or(0);
  }
  find_firmware(out.text, out);
  return out;
}

}  // namespace polyarm::xarm
