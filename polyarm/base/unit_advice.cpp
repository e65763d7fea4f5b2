#include "polyarm/base/unit_advice.hpp"

#include <fmt/format.h>

#include <cmath>

namespace polyarm {

namespace {
struct Example {
  double value;
  const char* unit;
};
Example example_of(Dimension dimension) {
  switch (dimension) {
    case Dimension::none:
      return {3, ""};
    case Dimension::length:
      return {200, "mm"};
    case Dimension::angle:
      return {30, "deg"};
    case Dimension::time:
      return {2, "s"};
    case Dimension::mass:
      return {2, "kg"};
    case Dimension::force:
      return {20, "N"};
    case Dimension::torque:
      return {5, "Nm"};
    case Dimension::rate:
      return {10, "Hz"};
    case Dimension::speed:
      return {250, "mm/s"};
    case Dimension::angular_speed:
      return {30, "deg/s"};
    case Dimension::acceleration:
      return {2, "m/s2"};
    case Dimension::angular_acceleration:
      return {200, "deg/s2"};
  }
  return {1, ""};
}

/// The unit that a person most likely means: 200 is millimetres, 0.2 is metres.
const char* likely_unit(Dimension dimension, double value) {
  const bool is_si = std::abs(value) < 5 && value != std::floor(value);
  if (dimension == Dimension::length && is_si) return "m";
  if (dimension == Dimension::angle && is_si) return "rad";
  if (dimension == Dimension::speed && is_si) return "m/s";
  if (dimension == Dimension::acceleration && std::abs(value) >= 50) return "mm/s2";
  return example_of(dimension).unit;
}
}  // namespace

std::string unit_advice(Dimension wanted, std::optional<double> bare) {
  const Example example = example_of(wanted);
  if (!bare || wanted == Dimension::none)
    return fmt::format("write {} such as {:g}{}",
                       wanted == Dimension::none ? "a number without unit" : name(wanted), example.value,
                       example.unit);
  return fmt::format("{} needs a unit: write {:g}{}", name(wanted), *bare, likely_unit(wanted, *bare));
}

}  // namespace polyarm
