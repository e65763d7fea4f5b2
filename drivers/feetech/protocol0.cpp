#include "drivers/feetech/protocol0.hpp"

#include <algorithm>
#include <numeric>

namespace polyarm::feetech {

using servo_bus::Bytes;
using servo_bus::Found;

namespace {
std::uint8_t checksum(Bytes bytes) {
  return static_cast<std::uint8_t>(~std::accumulate(bytes.begin(), bytes.end(), 0u));
}
}  // namespace

std::size_t Protocol0::make(std::span<std::uint8_t> out, std::uint8_t id, servo_bus::Instruction instruction,
                            Bytes parameters) const noexcept {
  const std::size_t size = parameters.size() + 6;
  if (size > out.size() || parameters.size() > 250) return 0;
  out[0] = out[1] = 0xFF;
  out[2] = id;
  out[3] = static_cast<std::uint8_t>(parameters.size() + 2);
  out[4] = static_cast<std::uint8_t>(instruction);
  std::copy(parameters.begin(), parameters.end(), out.begin() + 5);
  out[size - 1] = checksum(Bytes(out).subspan(2, size - 3));
  return size;
}

Found Protocol0::find(std::span<std::uint8_t> bytes, std::size_t longest) const noexcept {
  std::size_t at = 0;
  // A third FF belongs to garbage before a header: no servo has that id.
  while (at + 2 < bytes.size() && !(bytes[at] == 0xFF && bytes[at + 1] == 0xFF && bytes[at + 2] != 0xFF))
    ++at;
  if (at + 4 > bytes.size()) {
    if (at + 2 >= bytes.size())  // keeps a possible start of a header
      while (at < bytes.size() && bytes[at] != 0xFF) ++at;
    return {Found::Kind::more, at};
  }
  const std::size_t length = bytes[at + 3];
  if (length < 2 || length - 2 > longest) return {Found::Kind::other, at + 1};
  const std::size_t size = length + 4;
  if (bytes.size() - at < size) return {Found::Kind::more, at};
  const Bytes raw = Bytes(bytes).subspan(at, size);
  if (raw.back() != checksum(raw.subspan(2, size - 3))) return {Found::Kind::other, at + 1};
  return {Found::Kind::frame, at + size, raw[2], raw[4], raw, raw.subspan(5, length - 2)};
}

}  // namespace polyarm::feetech
