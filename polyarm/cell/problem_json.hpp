#pragma once
/// The one JSON form of a problem in answers and events. Any thread.
#include <nlohmann/json_fwd.hpp>

#include "polyarm/base/error.hpp"

namespace polyarm::cell {

/// {NAME: text or number}; texts are clipped to bounds::kErrorTextBytes, numbers that are not finite are left
/// out.
nlohmann::json facts_json(const Facts& facts);
/// {code, what, advice, where, facts?}; texts are clipped as above.
nlohmann::json problem_json(const Problem& problem);

}  // namespace polyarm::cell
