#pragma once
/// Handlers of requests that make, check or run other cells. Private to the room.
#include <cstddef>
#include <vector>

#include "polyarm/inside/requests_work.hpp"

namespace polyarm::cell {

/// Bytes of a text that a request hands over.
constexpr std::size_t kLargestText = 900'000;

std::vector<Handler> cells_handlers();
std::vector<Handler> text_handlers();

}  // namespace polyarm::cell
