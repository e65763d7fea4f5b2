#pragma once
/// What to write instead of a quantity without a unit, or with a wrong one.
#include <optional>
#include <string>

#include "polyarm/base/quantity.hpp"

namespace polyarm {

/// "a length needs a unit: write 200mm" for the bare number 200, "write a length such as 200mm" for anything
/// else.
std::string unit_advice(Dimension wanted, std::optional<double> bare = {});

}  // namespace polyarm
