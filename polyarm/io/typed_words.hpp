#pragma once
/// Parses lines that a person types at the console of a cell.
#include <optional>
#include <string>

#include "polyarm/protocol/request.hpp"

namespace polyarm::cell {

/// The request for "hold", "resume", "back", "discard", "recover" or "override 50%"; empty for any other
/// line.
std::optional<protocol::Request> typed_request(const std::string& line);

}  // namespace polyarm::cell
