#pragma once
/// What a cell and the process that speaks a link's protocol (`polyarm_link_KIND`) say to each other. The cell
/// asks, the process answers, one question at a time. The process parses bytes of strangers, so the cell checks
/// every length, index and value of an answer.
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "polyarm/process/packing.hpp"
#include "polyarm/signals/link.hpp"

namespace polyarm::signals {

/// The program of a kind of link, where modules lie: "polyarm_link_modbus".
inline std::string link_program(const std::string& kind) {
  return "polyarm_link_" + kind;
}

/// To the process.
enum class LinkOrder : std::uint8_t {
  begin,     ///< entry, known values; first, once
  open,      ///< connect, or listen
  exchange,  ///< now, patience, values to hand over
  close
};
/// From it, one for each order.
enum class LinkAnswer : std::uint8_t {
  done,    ///< of begin: whether exchange() waits for what comes
  failed,  ///< what
  news     ///< of exchange
};

/// Bytes of a text that says what happened; the rest is cut.
inline constexpr std::size_t kMostLinkWords = 1000;
/// Bytes of one message. A round of a port brings less (bounds::kLinkRoundBytes).
inline constexpr std::size_t kMostLinkMessage = std::size_t{32} << 20;

void pack(process::Packer& out, const LinkEntry& entry);
LinkEntry unpack_entry(process::Unpacker& in);

void pack(process::Packer& out, const std::vector<LinkValue>& values);
std::vector<LinkValue> unpack_values(process::Unpacker& in);

void pack(process::Packer& out, const LinkNews& news);
/// False where it cannot be: an unknown tag, a value that the tag cannot have, or that should have been refused.
/// Texts come printable.
bool unpack_news(process::Unpacker& in, const LinkEntry& entry, LinkNews& news);

}  // namespace polyarm::signals
