#pragma once
/// Overall equipment effectiveness, from the counters of a cell. Pure.
#include <nlohmann/json_fwd.hpp>
#include <optional>

namespace polyarm::fleet {

/// Shares in [0, 1]; nothing if the counters do not say it.
struct Oee {
  std::optional<double> availability;  ///< time that the program works / time that the cell exists
  std::optional<double> performance;   ///< ideal cycle × passes / time that the program works; at most 1
  std::optional<double> quality;       ///< good parts / all parts
  std::optional<double> whole;         ///< product of the three
};

/// `summary`: as a cell sends it, or as a stranger does. `ideal_cycle_s`: 0 if unknown.
Oee oee_of(const nlohmann::json& summary, double ideal_cycle_s);

}  // namespace polyarm::fleet
