#pragma once
/// Finds the requests in the bytes of a Modbus TCP connection, before the library sees them. Source: Modbus
/// Messaging on TCP/IP Implementation Guide 1.0b, 3.1.3; Modbus Application Protocol 1.1b3, 6.
#include <cstddef>
#include <cstdint>
#include <span>

namespace polyarm::modbus {

/// The first request in the bytes received so far.
struct Frame {
  enum class Kind {
    unfinished,  ///< not complete yet
    request,     ///< the library may answer it
    refused,     ///< well formed, but must be answered with `exception`
    broken       ///< not Modbus, or inconsistent lengths; the start of the next request is unknown
  };
  Kind kind = Kind::unfinished;
  std::size_t length = 0;  ///< bytes, for request and refused
  int exception = 0;       ///< 1: unknown function; 3: invalid count or value
};

/// Largest frame, and bytes before the part that its header's length counts.
inline constexpr std::size_t kMostFrame = 260, kBeforeCount = 6;

namespace frame_detail {
struct Range {
  int least, most;
  bool has(int value) const { return least <= value && value <= most; }
};

/// Checks the function and its counts. `pdu`: the request, beginning with the function code.
inline Frame::Kind judge(std::span<const std::uint8_t> pdu, int& exception) {
  using Kind = Frame::Kind;
  const auto word = [&](std::size_t at) { return pdu[at] << 8 | pdu[at + 1]; };
  const auto counted = [&](bool good) {
    exception = 3;
    return good ? Kind::request : Kind::refused;
  };
  switch (pdu[0]) {
    case 0x01:
    case 0x02:
      return pdu.size() != 5 ? Kind::broken : counted(Range{1, 2000}.has(word(3)));
    case 0x03:
    case 0x04:
      return pdu.size() != 5 ? Kind::broken : counted(Range{1, 125}.has(word(3)));
    case 0x05:
      return pdu.size() != 5 ? Kind::broken : counted(word(3) == 0 || word(3) == 0xFF00);
    case 0x06:
      return pdu.size() != 5 ? Kind::broken : Kind::request;
    case 0x0F:
      return pdu.size() < 6 || pdu.size() != 6u + pdu[5]
                 ? Kind::broken
                 : counted(Range{1, 1968}.has(word(3)) && pdu[5] == (word(3) + 7) / 8);
    case 0x10:
      return pdu.size() < 6 || pdu.size() != 6u + pdu[5]
                 ? Kind::broken
                 : counted(Range{1, 123}.has(word(3)) && pdu[5] == 2 * word(3));
    case 0x16:
      return pdu.size() != 7 ? Kind::broken : Kind::request;
    case 0x17:
      return pdu.size() < 10 || pdu.size() != 10u + pdu[9]
                 ? Kind::broken
                 : counted(Range{1, 125}.has(word(3)) && Range{1, 121}.has(word(7)) && pdu[9] == 2 * word(7));
    default:
      exception = 1;
      return Kind::refused;
  }
}
}  // namespace frame_detail

inline Frame first_frame(std::span<const std::uint8_t> bytes) {
  constexpr std::size_t kLeastCounted = 2, kMostCounted = kMostFrame - kBeforeCount;  // unit, function
  constexpr std::size_t kProtocol = 2, kCount = 4, kPdu = 7;
  Frame out;
  // Errors in the header are reported before the rest has arrived.
  for (std::size_t i = kProtocol; i < kCount && i < bytes.size(); ++i)
    if (bytes[i] != 0) out.kind = Frame::Kind::broken;
  if (out.kind == Frame::Kind::broken || bytes.size() < kBeforeCount) return out;
  const std::size_t counted = static_cast<std::size_t>(bytes[kCount]) << 8 | bytes[kCount + 1];
  if (counted < kLeastCounted || counted > kMostCounted) {
    out.kind = Frame::Kind::broken;
    return out;
  }
  if (bytes.size() < kBeforeCount + counted) return out;
  out.length = kBeforeCount + counted;
  out.kind = frame_detail::judge(bytes.subspan(kPdu, counted - 1), out.exception);
  return out;
}

}  // namespace polyarm::modbus
