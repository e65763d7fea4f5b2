#include "polyarm/io/typed_words.hpp"

#include "polyarm/base/text.hpp"
#include "polyarm/protocol/motion.hpp"

namespace polyarm::cell {

std::optional<protocol::Request> typed_request(const std::string& line) {
  if (line == "hold") return protocol::ControlHold{};
  if (line == "resume") return protocol::ControlResume{};
  if (line == "back") return protocol::ControlBack{};
  if (line == "discard") return protocol::ControlDiscard{};
  if (line == "recover") return protocol::ControlRecover{};
  if (!line.starts_with("override ")) return std::nullopt;
  std::string percent = line.substr(line.find(' ') + 1);
  if (percent.ends_with('%')) percent.pop_back();
  const auto number = parse_number(percent);
  if (!number) return std::nullopt;
  protocol::ControlOverride request;
  request.percent = *number;
  return request;
}

}  // namespace polyarm::cell
