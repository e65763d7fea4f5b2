#include "drivers/sensors/ubx.hpp"

#include <algorithm>

#include "polyarm/base/text.hpp"

namespace polyarm::sensors {

namespace {
constexpr std::uint8_t kBegin1 = 0xB5, kBegin2 = 0x62;
constexpr std::size_t kHead = 6, kSums = 2;

std::array<std::uint8_t, 2> sums(std::span<const std::uint8_t> bytes) {
  std::array<std::uint8_t, 2> out{};
  for (const std::uint8_t byte : bytes) {
    out[0] = static_cast<std::uint8_t>(out[0] + byte);
    out[1] = static_cast<std::uint8_t>(out[1] + out[0]);
  }
  return out;
}

std::uint32_t u4(std::span<const std::uint8_t> from, std::size_t at) {
  return from[at] | static_cast<std::uint32_t>(from[at + 1]) << 8 |
         static_cast<std::uint32_t>(from[at + 2]) << 16 | static_cast<std::uint32_t>(from[at + 3]) << 24;
}
double i4(std::span<const std::uint8_t> from, std::size_t at, double unit) {
  return static_cast<std::int32_t>(u4(from, at)) * unit;
}

void put(std::vector<std::uint8_t>& out, std::uint32_t value, int bytes) {
  for (int i = 0; i < bytes; ++i) out.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
}

/// A text in a field of fixed size, with a zero at the end if it is shorter; drops non-printable characters.
std::string field(std::span<const std::uint8_t> bytes) {
  std::string out;
  for (const std::uint8_t byte : bytes) {
    if (byte == 0) break;
    if (byte >= 0x20 && byte < 0x7F) out.push_back(static_cast<char>(byte));
  }
  return std::string(trim(out));
}
}  // namespace

void UbxReader::drop(std::size_t count) noexcept {
  std::copy(bytes_.begin() + static_cast<std::ptrdiff_t>(count),
            bytes_.begin() + static_cast<std::ptrdiff_t>(size_), bytes_.begin());
  size_ -= count;
}

void UbxReader::skip(std::size_t count) noexcept {
  counts_.skipped_bytes += count;
  drop(count);
}

/// True if the checksum of the complete message at `at` is correct.
bool UbxReader::sums_fit(std::size_t at) const noexcept {
  const std::size_t whole = kHead + length(at) + kSums;
  const auto expected = sums(std::span(bytes_).subspan(at + 2, whole - 4));
  return bytes_[at + whole - 2] == expected[0] && bytes_[at + whole - 1] == expected[1];
}

/// Called after an incomplete message start. True if the last byte completes a message that begins later; the
/// earlier start was then false.
bool UbxReader::ends_inside() noexcept {
  for (std::size_t at = 1; at + kHead + kSums <= size_; ++at) {
    if (bytes_[at] != kBegin1 || bytes_[at + 1] != kBegin2) continue;
    if (length(at) > kUbxMaxPayload || at + kHead + length(at) + kSums != size_ || !sums_fit(at)) continue;
    skip(at);
    ++counts_.messages;
    return true;
  }
  return false;
}

/// Drops bytes that cannot start a message; true if a complete message is at the front.
bool UbxReader::look() noexcept {
  for (;;) {
    std::size_t from = 0;
    while (from < size_ && (bytes_[from] != kBegin1 || (from + 1 < size_ && bytes_[from + 1] != kBegin2)))
      ++from;
    if (from > 0) skip(from);
    if (size_ < kHead) return false;
    if (length() <= kUbxMaxPayload) {
      if (size_ < kHead + length() + kSums) return ends_inside();
      if (sums_fit(0)) {
        ++counts_.messages;
        return true;
      }
      ++counts_.bad_sums;
    }
    skip(1);  // a false start, or a message that is too long
  }
}

bool UbxReader::push(std::uint8_t byte) noexcept {
  if (size_ == bytes_.size()) drop(1);  // only if next() was not called
  bytes_[size_++] = byte;
  return look();
}

bool UbxReader::next() noexcept {
  drop(kHead + length() + kSums);
  return look();
}

UbxMessage UbxReader::message() const noexcept {
  return {{bytes_[2], bytes_[3]}, std::span(bytes_).subspan(kHead, length())};
}

std::vector<std::uint8_t> ubx_message(UbxId id, std::span<const std::uint8_t> payload) {
  std::vector<std::uint8_t> out{kBegin1, kBegin2, id.group, id.number};
  put(out, static_cast<std::uint32_t>(payload.size()), 2);
  out.insert(out.end(), payload.begin(), payload.end());
  const auto ends = sums(std::span(out).subspan(2));
  out.insert(out.end(), ends.begin(), ends.end());
  return out;
}

std::optional<NavPvt> read_nav_pvt(std::span<const std::uint8_t> p) noexcept {
  if (p.size() < 84) return std::nullopt;
  NavPvt out;
  out.time_of_week = u4(p, 0);
  out.fix_type = p[20];
  out.fix_ok = p[21] & 0x01;
  out.differential = p[21] & 0x02;
  out.carrier = p[21] >> 6;
  out.satellites = p[23];
  out.longitude = i4(p, 24, 1e-7);
  out.latitude = i4(p, 28, 1e-7);
  out.height = i4(p, 32, 1e-3);
  out.horizontal_accuracy = u4(p, 40) * 1e-3;
  out.vertical_accuracy = u4(p, 44) * 1e-3;
  out.velocity_north = i4(p, 48, 1e-3);
  out.velocity_east = i4(p, 52, 1e-3);
  out.velocity_down = i4(p, 56, 1e-3);
  out.speed_accuracy = u4(p, 68) * 1e-3;
  out.invalid_position = p.size() >= 92 && (p[78] & 0x01);
  return out;
}

ReceiverVersion read_mon_ver(std::span<const std::uint8_t> payload) {
  ReceiverVersion out;
  if (payload.size() < 40) return out;
  out.software = field(payload.first(30));
  out.hardware = field(payload.subspan(30, 10));
  for (std::size_t at = 40; at + 30 <= payload.size(); at += 30) {
    const std::string text = field(payload.subspan(at, 30));
    for (const char* before : {"PROTVER=", "PROTVER "})
      if (text.starts_with(before)) out.protocol = std::string(trim(text.substr(8)));
    if (text.starts_with("FWVER=")) out.software = text.substr(6);
  }
  return out;
}

std::vector<std::uint8_t> cfg_rate(std::uint16_t period_ms) {
  std::vector<std::uint8_t> payload;
  put(payload, period_ms, 2);
  put(payload, 1, 2);  // a fix with every measurement
  put(payload, 1, 2);  // aligned to GPS time
  return ubx_message(kCfgRate, payload);
}

std::vector<std::uint8_t> cfg_msg(UbxId message, std::uint8_t every) {
  const std::uint8_t payload[] = {message.group, message.number, every};
  return ubx_message(kCfgMsg, payload);
}

std::vector<std::uint8_t> cfg_valset(std::uint16_t period_ms, ReceiverPort port) {
  constexpr std::uint32_t kRateMeasure = 0x30210001, kRateNavigate = 0x30210002;
  struct Keys {
    std::uint32_t nav_pvt, nmea;
  };
  constexpr Keys kKeys[] = {{0x20910007, 0x10740002}, {0x20910008, 0x10760002}, {0x20910009, 0x10780002}};
  const Keys& keys = kKeys[static_cast<std::size_t>(port)];
  constexpr std::uint8_t kWorkingMemory = 1;
  std::vector<std::uint8_t> payload{0, kWorkingMemory, 0, 0};
  put(payload, kRateMeasure, 4), put(payload, period_ms, 2);
  put(payload, kRateNavigate, 4), put(payload, 1, 2);
  put(payload, keys.nav_pvt, 4), put(payload, 1, 1);
  put(payload, keys.nmea, 4), put(payload, 0, 1);
  return ubx_message(kCfgValset, payload);
}

}  // namespace polyarm::sensors
