#pragma once
/// Which robots of the catalogue are wanted: by maker, axes, reach, payload and mass.
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "polyarm/base/quantity.hpp"
#include "polyarm/description/catalogue.hpp"

namespace polyarm::description {

/// Values from `low` to `high`, ends included unless said.
struct Range {
  double low = -std::numeric_limits<double>::infinity(), high = std::numeric_limits<double>::infinity();
  bool without_low = false, without_high = false;  ///< ends that do not belong to it
  bool contains(double value) const;
};

/// What a bare number means: that value, or that and more.
enum class BareNumber { exactly, at_least };

/// A range as a person writes it: "6", "4..6", ">=1.2", "<500mm", "=6"; ends with or without a unit of
/// `dimension`. `what` names it in errors. Throws Error("bad-range").
Range parse_range(std::string_view text, const std::string& what, Dimension dimension, BareNumber bare);

/// Robots that do not state a figure are in no range of it.
struct CatalogueQuery {
  std::string text;   ///< part of the name or the model, case ignored; empty: any
  std::string maker;  ///< the maker or its folder, case, blanks and underscores ignored; empty: any
  std::optional<Range> axes, reach_m, payload_kg, mass_kg;
  std::string sort = "name";  ///< name, maker, axes, reach, payload or mass; "-" before it: largest first
};

/// Throws Error("unknown-maker" | "bad-sort") with the nearest name.
std::vector<CatalogueEntry> find_robots(std::vector<CatalogueEntry> all, const CatalogueQuery& query);

}  // namespace polyarm::description
