#include "drivers/dynamixel/protocol2.hpp"

#include <algorithm>
#include <array>

namespace polyarm::dynamixel {

using servo_bus::Bytes;
using servo_bus::Found;

namespace {
constexpr std::array<std::uint8_t, 4> kHeader{0xFF, 0xFF, 0xFD, 0x00};
constexpr std::uint8_t kStatus = 0x55;
constexpr std::size_t kBeforeLength = 7;  // header, id, length

constexpr std::array<std::uint16_t, 256> crc_table() {
  std::array<std::uint16_t, 256> table{};
  for (unsigned i = 0; i < 256; ++i) {
    unsigned value = i << 8;
    for (int bit = 0; bit < 8; ++bit) value = value & 0x8000 ? value << 1 ^ 0x8005 : value << 1;
    table[i] = static_cast<std::uint16_t>(value);
  }
  return table;
}
constexpr auto kTable = crc_table();

std::uint16_t number(Bytes bytes, std::size_t at) {
  return static_cast<std::uint16_t>(bytes[at] | bytes[at + 1] << 8);
}

/// Replaces FF FF FD FD by FF FF FD in place; returns the new length.
std::size_t take_out_stuffing(std::span<std::uint8_t> bytes) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    bytes[kept++] = bytes[i];
    const bool pattern =
        kept >= 3 && bytes[kept - 3] == 0xFF && bytes[kept - 2] == 0xFF && bytes[kept - 1] == 0xFD;
    if (pattern && i + 1 < bytes.size() && bytes[i + 1] == 0xFD) ++i;
  }
  return kept;
}

/// The position of a header, or of a possible start of one at the end.
std::size_t find_header(Bytes bytes) {
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    const std::size_t there = std::min(kHeader.size(), bytes.size() - at);
    if (std::equal(kHeader.begin(), kHeader.begin() + static_cast<std::ptrdiff_t>(there),
                   bytes.begin() + static_cast<std::ptrdiff_t>(at)))
      return at;
  }
  return bytes.size();
}
}  // namespace

std::uint16_t crc16(Bytes bytes, std::uint16_t crc) noexcept {
  for (const std::uint8_t byte : bytes)
    crc = static_cast<std::uint16_t>(crc << 8 ^ kTable[(crc >> 8 ^ byte) & 0xFF]);
  return crc;
}

std::size_t Protocol2::make(std::span<std::uint8_t> out, std::uint8_t id, servo_bus::Instruction instruction,
                            Bytes parameters) const noexcept {
  if (out.size() < kBeforeLength + 3) return 0;
  std::copy(kHeader.begin(), kHeader.end(), out.begin());
  out[4] = id;
  std::size_t at = kBeforeLength;
  out[at++] = static_cast<std::uint8_t>(instruction);
  for (const std::uint8_t byte : parameters) {
    if (at + 4 > out.size()) return 0;
    out[at++] = byte;
    if (byte == 0xFD && at - 3 >= kBeforeLength && out[at - 3] == 0xFF && out[at - 2] == 0xFF)
      out[at++] = 0xFD;
  }
  const std::size_t length = at + 2 - kBeforeLength;
  out[5] = static_cast<std::uint8_t>(length);
  out[6] = static_cast<std::uint8_t>(length >> 8);
  const std::uint16_t crc = crc16(Bytes(out).first(at));
  out[at++] = static_cast<std::uint8_t>(crc);
  out[at++] = static_cast<std::uint8_t>(crc >> 8);
  return at;
}

Found Protocol2::find(std::span<std::uint8_t> bytes, std::size_t longest) const noexcept {
  const std::size_t at = find_header(bytes);
  if (bytes.size() - at < kBeforeLength) return {Found::Kind::more, at};
  const std::size_t length = number(bytes, at + 5);
  // Stuffing can add a third to the data of an answer.
  if (length < 3 || length - 3 > longest + longest / 3 + 8) return {Found::Kind::other, at + 1};
  const std::size_t size = length + kBeforeLength;
  if (bytes.size() - at < size) return {Found::Kind::more, at};
  const Bytes raw = Bytes(bytes).subspan(at, size);
  if (number(raw, size - 2) != crc16(raw.first(size - 2))) return {Found::Kind::other, at + 1};
  if (raw[7] != kStatus || length < 4) return {Found::Kind::other, at + size};
  const std::size_t data = take_out_stuffing(bytes.subspan(at + 9, size - 11));
  return {Found::Kind::frame, at + size, raw[4], raw[8], raw, raw.subspan(9, data)};
}

bool Protocol2::split_fast(Bytes bytes, std::size_t servos, std::size_t length, Take take,
                           void* context) const noexcept {
  const std::size_t total = 8 + servos * (length + 4);
  for (std::size_t at = find_header(bytes); at < bytes.size();) {
    const Bytes rest = bytes.subspan(at);
    if (rest.size() < 8) return false;
    const bool head =
        rest[4] == servo_bus::kBroadcast && number(rest, 5) == total - kBeforeLength && rest[7] == kStatus;
    if (!head) {  // garbage, or the echo of the instruction
      at += 1 + find_header(rest.subspan(1));
      continue;
    }
    // Each servo adds error, id, data and the CRC of all previous bytes.
    for (std::size_t i = 0; i < servos; ++i) {
      const std::size_t from = 8 + i * (length + 4), crc_at = from + 2 + length;
      if (rest.size() < crc_at + 2 || number(rest, crc_at) != crc16(rest.first(crc_at))) return false;
      take(context, rest[from + 1], rest[from], rest.subspan(from + 2, length));
    }
    return true;
  }
  return false;
}

}  // namespace polyarm::dynamixel
