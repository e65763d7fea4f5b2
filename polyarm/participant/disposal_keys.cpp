#include "polyarm/participant/disposal_keys.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

namespace polyarm::ros2 {

namespace {

using Bytes = std::span<const std::uint8_t>;

constexpr std::size_t kMessageHeader = 20, kSubmessageHeader = 4, kGuid = 16;
constexpr std::uint8_t kData = 0x15;
constexpr std::uint8_t kLittleEndian = 0x01, kInlineQos = 0x02, kKeyOnly = 0x08;
/// DATA submessage after its header: extra flags, octets to inline QoS, reader, writer, sequence number.
constexpr std::size_t kToInlineQos = 4, kWriter = 8, kDataFields = 20;
/// The writers that announce participants, writers and readers.
constexpr std::array<std::array<std::uint8_t, 4>, 3> kDiscoveryWriters{
    {{0, 1, 0, 0xc2}, {0, 0, 3, 0xc2}, {0, 0, 4, 0xc2}}};
constexpr unsigned kSentinel = 0x01, kParticipantGuid = 0x50, kEndpointGuid = 0x5a;
constexpr unsigned kParameterListBig = 0x0002, kParameterListLittle = 0x0003;

unsigned number(Bytes at, bool little) {
  return little ? at[0] | at[1] << 8u : at[0] << 8u | at[1];
}

/// Length of the parameters including the sentinel; nullopt if there is no sentinel.
std::optional<std::size_t> length_of_parameters(Bytes list, bool little) {
  for (std::size_t at = 0; at + 4 <= list.size();) {
    const unsigned id = number(list.subspan(at), little);
    at += 4;
    if (id == kSentinel) return at;
    at += number(list.subspan(at - 2), little);
  }
  return {};
}

/// The GUID in a key that is a parameter list (after its encapsulation header).
std::optional<Bytes> guid_of(Bytes key) {
  if (key.size() < 4) return {};
  const unsigned encapsulation = number(key, false);
  if (encapsulation != kParameterListBig && encapsulation != kParameterListLittle) return {};
  const bool little = encapsulation == kParameterListLittle;
  for (std::size_t at = 4; at + 4 <= key.size();) {
    const unsigned id = number(key.subspan(at), little), length = number(key.subspan(at + 2), little);
    at += 4;
    if (id == kSentinel || at + length > key.size()) return {};
    if ((id == kParticipantGuid || id == kEndpointGuid) && length == kGuid) return key.subspan(at, kGuid);
    at += length;
  }
  return {};
}

/// Start of the discovery key in the body of a DATA submessage, if the key is longer than 16 bytes.
std::optional<std::size_t> long_key(Bytes body, std::uint8_t flags) {
  if ((flags & kKeyOnly) == 0 || body.size() < kDataFields) return {};
  const auto of_discovery = [&](const auto& writer) {
    return std::equal(writer.begin(), writer.end(), body.begin() + kWriter);
  };
  if (std::none_of(kDiscoveryWriters.begin(), kDiscoveryWriters.end(), of_discovery)) return {};
  const bool little = (flags & kLittleEndian) != 0;
  std::size_t at = kToInlineQos + number(body.subspan(2), little);
  if (at > body.size()) return {};
  if ((flags & kInlineQos) != 0) {
    const auto length = length_of_parameters(body.subspan(at), little);
    if (!length) return {};
    at += *length;
  }
  return at + kGuid < body.size() ? std::optional(at) : std::nullopt;
}

}  // namespace

bool with_plain_keys(std::span<const std::uint8_t> message, std::vector<std::uint8_t>& out) {
  bool changed = false;
  std::size_t copied = 0;  // bytes of the message already copied to `out`
  for (std::size_t at = kMessageHeader; at + kSubmessageHeader <= message.size();) {
    const std::uint8_t kind = message[at], flags = message[at + 1];
    const bool little = (flags & kLittleEndian) != 0;
    const unsigned stated = number(message.subspan(at + 2), little);
    const std::size_t begin = at + kSubmessageHeader;
    const std::size_t length = stated == 0 ? message.size() - begin : stated;  // 0: up to the end
    if (length > message.size() - begin) break;
    const Bytes body = message.subspan(begin, length);
    const auto key = kind == kData ? long_key(body, flags) : std::nullopt;
    if (const auto guid = key ? guid_of(body.subspan(*key)) : std::nullopt) {
      if (!std::exchange(changed, true)) out.clear();
      const auto copy = [&](Bytes bytes) { out.insert(out.end(), bytes.begin(), bytes.end()); };
      copy(message.subspan(copied, at + 2 - copied));
      const std::size_t shorter = *key + kGuid;
      const auto low = static_cast<std::uint8_t>(shorter), high = static_cast<std::uint8_t>(shorter >> 8u);
      out.push_back(little ? low : high);
      out.push_back(little ? high : low);
      copy(body.first(*key));
      copy(*guid);
      copied = begin + length;
    }
    at = begin + length;
  }
  if (changed) out.insert(out.end(), message.begin() + static_cast<std::ptrdiff_t>(copied), message.end());
  return changed;
}

}  // namespace polyarm::ros2
