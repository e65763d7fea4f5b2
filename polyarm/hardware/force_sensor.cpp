#include "polyarm/hardware/force_sensor.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "polyarm/base/error.hpp"
#include "polyarm/base/printable.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::hardware {

namespace {
constexpr std::pair<const char*, double ForceSensorErrors::*> kDeviations[] = {
    {"noise", &ForceSensorErrors::noise},
    {"torque_noise", &ForceSensorErrors::torque_noise},
    {"drift", &ForceSensorErrors::drift},
    {"torque_drift", &ForceSensorErrors::torque_drift}};

double number_of(const description::ComponentInfo& component, const std::string& name,
                 const std::string& text) {
  const auto number = parse_number(text);
  if (number && std::isfinite(*number)) return *number;
  throw Error("bad-value",
              "the parameter '" + name + "' of the sensor '" + component.name + "' is '" + shortened(text) +
                  "', a number was expected",
              "N for forces, N m for torques");
}
}  // namespace

ForceSensorErrors force_sensor_errors(const description::ComponentInfo& component) {
  ForceSensorErrors out;
  const auto& given = component.parameters;
  for (const auto& [name, member] : kDeviations) {
    const auto at = given.find(name);
    if (at == given.end()) continue;
    out.*member = number_of(component, name, at->second);
    if (out.*member < 0)
      throw Error(
          "bad-value",
          std::string("the parameter '") + name + "' of the sensor '" + component.name + "' is below zero",
          "it is a standard deviation");
  }
  if (const auto at = given.find("bias"); at != given.end()) {
    const std::vector<std::string> fields = split_words(at->second, " \t,");
    if (fields.size() != out.bias.size())
      throw Error("bad-value",
                  "the parameter 'bias' of the sensor '" + component.name + "' has " +
                      std::to_string(fields.size()) + " numbers, 6 were expected",
                  "write force x y z, then torque x y z");
    for (std::size_t i = 0; i < fields.size(); ++i) out.bias[i] = number_of(component, "bias", fields[i]);
  }
  if (const auto at = given.find("seed"); at != given.end()) {
    const double seed = number_of(component, "seed", at->second);
    if (seed < 0 || seed > 4294967295.0 || seed != std::floor(seed))
      throw Error("bad-value",
                  "the parameter 'seed' of the sensor '" + component.name + "' is not a whole number",
                  "write 0 to 4294967295");
    out.seed = static_cast<std::uint32_t>(seed);
  }
  return out;
}

void set_force_sensor_errors(const ForceSensorErrors& errors, description::ComponentInfo& component) {
  if (!errors.any()) return;
  for (const auto& [name, member] : kDeviations)
    component.parameters[name] = fmt::format("{}", errors.*member);
  component.parameters["bias"] = fmt::format("{}", fmt::join(errors.bias, " "));
  component.parameters["seed"] = std::to_string(errors.seed);
}

}  // namespace polyarm::hardware
