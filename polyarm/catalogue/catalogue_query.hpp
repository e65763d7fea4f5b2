#pragma once
/// Queries for robots of the catalogue: by maker, axes, reach, payload and mass. SI units. Any thread.
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "polyarm/base/quantity.hpp"
#include "polyarm/catalogue/catalogue.hpp"

namespace polyarm::description {

/// Values from `low` to `high`, including the ends unless excluded.
struct Range {
  double low = -std::numeric_limits<double>::infinity(), high = std::numeric_limits<double>::infinity();
  bool without_low = false, without_high = false;  ///< ends that are excluded
  bool contains(double value) const;
};

/// The meaning of a bare number: this value, or at least this value.
enum class BareNumber { exactly, at_least };

/// Parses a range: "6", "4..6", ">=1.2", "<500mm", "=6"; ends with or without a unit of `dimension`. `what`
/// names it in errors. Throws Error("bad-range").
Range parse_range(std::string_view text, const std::string& what, Dimension dimension, BareNumber bare);

/// A query for robots. A robot that does not state a figure never matches a range of it.
struct CatalogueQuery {
  std::string text;   ///< part of the name or the model, case-insensitive; empty: any
  std::string maker;  ///< the maker or its folder; case, blanks and underscores are ignored; empty: any
  std::optional<Range> axes, reach_m, payload_kg, mass_kg;
  std::string sort = "name";  ///< name, maker, axes, reach, payload or mass; "-" before it: largest first
};

/// Throws Error("unknown-maker" | "bad-sort") with the nearest name.
std::vector<CatalogueEntry> find_robots(std::vector<CatalogueEntry> all, const CatalogueQuery& query);

}  // namespace polyarm::description
