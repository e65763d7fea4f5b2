#pragma once
/// What a person types at the console of a cell, as a request.
#include <optional>
#include <string>

#include "polyarm/protocol/request.hpp"

namespace polyarm::cell {

/// "hold", "resume", "back", "discard", "recover", "override 50%"; nothing for any other line.
std::optional<protocol::Request> typed_request(const std::string& line);

}  // namespace polyarm::cell
