#include "drivers/sensors/wit.hpp"

#include <algorithm>
#include <numeric>

namespace polyarm::sensors {

namespace {
constexpr std::uint8_t kBegin = 0x55;

bool known_type(std::uint8_t byte) {
  return (byte >= 0x50 && byte <= 0x5A) || byte == 0x5F;
}

std::uint8_t sum(std::span<const std::uint8_t> bytes) {
  return std::accumulate(bytes.begin(), bytes.end(), std::uint8_t{0},
                         [](std::uint8_t a, std::uint8_t b) { return static_cast<std::uint8_t>(a + b); });
}
}  // namespace

void WitReader::drop_to_next_beginning() noexcept {
  std::size_t from = 1;
  while (from < size_ && (bytes_[from] != kBegin || (from + 1 < size_ && !known_type(bytes_[from + 1]))))
    ++from;
  std::copy(bytes_.begin() + static_cast<std::ptrdiff_t>(from),
            bytes_.begin() + static_cast<std::ptrdiff_t>(size_), bytes_.begin());
  size_ -= from;
  counts_.skipped_bytes += from;
}

bool WitReader::push(std::uint8_t byte) noexcept {
  bytes_[size_++] = byte;
  if (bytes_[0] != kBegin || (size_ >= 2 && !known_type(bytes_[1]))) drop_to_next_beginning();
  if (size_ < kWitFrameSize) return false;
  if (sum(std::span(bytes_).first(kWitFrameSize - 1)) != bytes_.back()) {
    ++counts_.bad_sums;
    drop_to_next_beginning();
    return false;
  }
  frame_.type = static_cast<WitType>(bytes_[1]);
  for (std::size_t i = 0; i < 4; ++i)
    frame_.values[i] = static_cast<std::int16_t>(
        static_cast<std::uint16_t>(bytes_[2 + 2 * i] | static_cast<unsigned>(bytes_[3 + 2 * i]) << 8));
  ++counts_.frames;
  size_ = 0;
  return true;
}

std::array<std::uint8_t, 5> wit_write(std::uint8_t address, std::uint16_t value) {
  return {0xFF, 0xAA, address, static_cast<std::uint8_t>(value & 0xFF),
          static_cast<std::uint8_t>(value >> 8)};
}

std::uint16_t wit_rate_code(double rate) {
  constexpr std::pair<double, std::uint16_t> kCodes[] = {{1, 0x03},  {2, 0x04},  {5, 0x05},   {10, 0x06},
                                                         {20, 0x07}, {50, 0x08}, {100, 0x09}, {200, 0x0B}};
  for (const auto& [hertz, code] : kCodes)
    if (hertz == rate) return code;
  return 0;
}

}  // namespace polyarm::sensors
