#pragma once
/// Handlers of requests that create, check or run other cells. Private to this room.
#include <cstddef>
#include <vector>

#include "polyarm/inside/requests_work.hpp"

namespace polyarm::cell {

/// Size limit of a text inside a request, bytes.
constexpr std::size_t kLargestText = 900'000;

std::vector<Handler> cells_handlers();
std::vector<Handler> text_handlers();

}  // namespace polyarm::cell
