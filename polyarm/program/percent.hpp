#pragma once
/// Shares as messages show them.
#include <cmath>
#include <string>

#include "polyarm/base/text.hpp"

namespace polyarm::program {

/// "150%" for 1.5. Above 10 the plain number: a unit is missing.
inline std::string percent(double share) {
  return share > 10 ? format_number(share) : format_number(std::round(share * 1e6) / 1e4) + "%";
}

}  // namespace polyarm::program
