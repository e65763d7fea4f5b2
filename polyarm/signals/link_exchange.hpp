#pragma once
/// The protocol between a cell and the process of a link (`polyarm_link_KIND`). The cell sends an order and
/// the process answers, one at a time. The process parses untrusted input, so the cell checks every length,
/// index and value in an answer.
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "polyarm/process/packing.hpp"
#include "polyarm/signals/link.hpp"

namespace polyarm::signals {

/// File name of the program for a kind of link: "polyarm_link_modbus". It is in the modules folders.
inline std::string link_program(const std::string& kind) {
  return "polyarm_link_" + kind;
}

/// Orders of the cell.
enum class LinkOrder : std::uint8_t {
  begin,     ///< entry, known values; first order, once
  open,      ///< connect, or listen
  exchange,  ///< now, patience, values to send
  close
};
/// Answers of the process, one per order.
enum class LinkAnswer : std::uint8_t {
  done,    ///< for begin: whether exchange() waits for incoming data
  failed,  ///< the reason
  news     ///< for exchange
};

/// Longest text of a message, bytes; longer ones are cut.
inline constexpr std::size_t kMostLinkWords = 1000;
/// Largest message, bytes. One exchange of a port is smaller (bounds::kLinkRoundBytes).
inline constexpr std::size_t kMostLinkMessage = std::size_t{32} << 20;

void pack(process::Packer& out, const LinkEntry& entry);
LinkEntry unpack_entry(process::Unpacker& in);

void pack(process::Packer& out, const std::vector<LinkValue>& values);
std::vector<LinkValue> unpack_values(process::Unpacker& in);

void pack(process::Packer& out, const LinkReport& news);
/// Returns false for invalid content: an unknown tag, a value that the tag cannot have, or one that should
/// have been refused. Texts become printable.
bool unpack_reports(process::Unpacker& in, const LinkEntry& entry, LinkReport& news);

}  // namespace polyarm::signals
