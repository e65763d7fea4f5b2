#include "polyarm/base/quantity.hpp"

#include <array>
#include <numbers>

#include "polyarm/base/text.hpp"

namespace polyarm {

namespace {
constexpr double kDegree = std::numbers::pi / 180;
constexpr std::array kUnits = {
    Unit{"mm/s2", Dimension::acceleration, 1e-3},
    Unit{"deg/s2", Dimension::angular_acceleration, kDegree},
    Unit{"rad/s2", Dimension::angular_acceleration, 1},
    Unit{"deg/s", Dimension::angular_speed, kDegree},
    Unit{"rad/s", Dimension::angular_speed, 1},
    Unit{"mm/s", Dimension::speed, 1e-3},
    Unit{"m/s2", Dimension::acceleration, 1},
    Unit{"m/s", Dimension::speed, 1},
    Unit{"deg", Dimension::angle, kDegree},
    Unit{"rad", Dimension::angle, 1},
    Unit{"min", Dimension::time, 60},
    Unit{"mm", Dimension::length, 1e-3},
    Unit{"cm", Dimension::length, 1e-2},
    Unit{"ms", Dimension::time, 1e-3},
    Unit{"kg", Dimension::mass, 1},
    Unit{"Nm", Dimension::torque, 1},
    Unit{"Hz", Dimension::rate, 1},
    Unit{"m", Dimension::length, 1},
    Unit{"s", Dimension::time, 1},
    Unit{"g", Dimension::mass, 1e-3},
    Unit{"N", Dimension::force, 1},
    Unit{"%", Dimension::none, 1e-2},
};
}  // namespace

const char* name(Dimension dimension) {
  switch (dimension) {
    case Dimension::none:
      return "a number";
    case Dimension::length:
      return "a length";
    case Dimension::angle:
      return "an angle";
    case Dimension::time:
      return "a time";
    case Dimension::mass:
      return "a mass";
    case Dimension::force:
      return "a force";
    case Dimension::torque:
      return "a torque";
    case Dimension::rate:
      return "a rate";
    case Dimension::speed:
      return "a speed";
    case Dimension::angular_speed:
      return "an angular speed";
    case Dimension::acceleration:
      return "an acceleration";
    case Dimension::angular_acceleration:
      return "an angular acceleration";
  }
  return "a quantity";
}

const Unit* find_unit(std::string_view text) {
  for (const Unit& unit : kUnits)
    if (unit.text == text) return &unit;
  return nullptr;
}

const Unit* longest_unit(std::string_view text) {
  const Unit* best = nullptr;
  for (const Unit& unit : kUnits)
    if (text.starts_with(unit.text) && (!best || unit.text.size() > best->text.size())) best = &unit;
  return best;
}

std::optional<double> parse_quantity(std::string_view text, Dimension dimension) {
  text = trim(text);
  if (const auto bare = parse_number(text)) return bare;
  // "m/s2" ends in a digit: try every place where a number could end.
  for (std::size_t at = 1; at < text.size(); ++at) {
    const auto number = parse_number(text.substr(0, at));
    if (!number) continue;
    const Unit* unit = find_unit(trim(text.substr(at)));
    if (unit && unit->dimension == dimension) return *number * unit->scale;
  }
  return std::nullopt;
}

}  // namespace polyarm
