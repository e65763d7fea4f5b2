#pragma once
/// Quantities as a person writes them: `40mm`, `30deg`, `50%`, `0.2`. Bare numbers are SI.
#include <optional>
#include <string>
#include <string_view>

namespace polyarm {

enum class Dimension {
  none,
  length,
  angle,
  time,
  mass,
  force,
  torque,
  rate,
  speed,
  angular_speed,
  acceleration,
  angular_acceleration
};

const char* name(Dimension dimension);

struct Unit {
  std::string_view text;
  Dimension dimension;
  double scale;  ///< factor from this unit to SI
};

/// The unit that `text` spells exactly, if there is one (mm cm m deg rad ms s min kg g N Nm Hz % mm/s …).
const Unit* find_unit(std::string_view text);
/// The longest unit that `text` starts with, if any.
const Unit* longest_unit(std::string_view text);

/// Parses a number with or without a unit of the requested dimension; returns SI. Empty if the text is not a
/// number or the unit has another dimension.
std::optional<double> parse_quantity(std::string_view text, Dimension dimension);

}  // namespace polyarm
