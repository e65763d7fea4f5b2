#include "polyarm/broadcasters/sensor_interfaces.hpp"

#include <algorithm>

#include "polyarm/base/text.hpp"

namespace polyarm::controllers {

namespace {

/// Whole names of what has one of `interfaces`: those of `robot`, else all.
std::vector<std::string> sensors_with(const ControllerContext& context,
                                      std::span<const char* const> interfaces) {
  std::vector<std::string> own, all;
  for (const std::string& state : context.state_names) {
    const std::size_t slash = state.rfind('/');
    if (slash == std::string::npos) continue;
    const std::string interface = state.substr(slash + 1), sensor = state.substr(0, slash);
    if (std::none_of(interfaces.begin(), interfaces.end(), [&](const char* i) { return interface == i; }))
      continue;
    if (std::find(all.begin(), all.end(), sensor) != all.end()) continue;
    all.push_back(sensor);
    if (sensor.starts_with(context.robot + "/")) own.push_back(sensor);
  }
  return own.empty() ? all : own;
}

std::string without_robot(const std::string& whole) {
  return whole.substr(whole.find('/') + 1);
}

}  // namespace

Location place_of(const Parameters& parameters, const std::string& key) {
  const auto found = parameters.entries.find(key);
  return found == parameters.entries.end() ? Location{} : found->second.where;
}

FoundSensor read_sensor(ControllerContext& context, std::span<const char* const> interfaces,
                        const std::string& what, const std::string& key) {
  std::string written;
  context.parameters.read(key, written, {"the sensor; may be omitted if there is only one"});
  const std::vector<std::string> known = sensors_with(context, interfaces);
  for (const std::string& sensor : known)
    if (sensor == written || without_robot(sensor) == written) return {sensor, written};
  std::vector<std::string> names;
  for (const std::string& sensor : known) names.push_back(without_robot(sensor));
  const Location where = place_of(context.parameters, key);
  if (!written.empty())
    throw Error(Problem{
        "unknown-sensor", where,
        "there is no sensor '" + written + "' with the states of " + what + did_you_mean(written, names),
        names.empty() ? "" : "known are: " + join(names, ", ")});
  if (known.size() == 1) return {known.front(), names.front()};
  throw Error("unknown-sensor",
              "'" + context.name + "' has no " + key + ", and " +
                  (known.empty() ? "nothing has" : "several sensors have") + " the states of " + what,
              names.empty() ? "" : "name one as " + key + ": " + join(names, ", "));
}

std::string read_frame(Parameters& parameters, const std::string& sensor) {
  std::string frame;
  parameters.read("frame_id", frame, {"the frame of the values; default: the sensor's name"});
  return frame.empty() ? sensor : frame;
}

std::array<double, 9> read_covariance(Parameters& parameters, const std::string& key) {
  std::array<double, 9> out{};
  std::vector<double> values(9, 0.0);
  parameters.read(key, values, {"nine numbers, row by row"});
  if (values.size() == 9)
    std::copy(values.begin(), values.end(), out.begin());
  else
    parameters.problems().error(
        "bad-value", place_of(parameters, key),
        "'" + key + "' has " + std::to_string(values.size()) + " numbers, it needs 9");
  return out;
}

void add_covariance_fields(std::vector<std::string>& fields, const std::string& name) {
  for (int i = 0; i < 9; ++i) fields.push_back(name + "[" + std::to_string(i) + "]");
}

}  // namespace polyarm::controllers
