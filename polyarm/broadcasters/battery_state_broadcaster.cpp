#include "polyarm/broadcasters/battery_state_broadcaster.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "polyarm/base/text.hpp"
#include "polyarm/broadcasters/sensor_interfaces.hpp"

namespace polyarm::controllers {

namespace {
constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
constexpr const char* kFieldNames[] = {"voltage",
                                       "temperature",
                                       "current",
                                       "charge",
                                       "capacity",
                                       "design_capacity",
                                       "percentage",
                                       "power_supply_status",
                                       "power_supply_health",
                                       "power_supply_technology",
                                       "present"};
/// Of these the file says whether they are measured.
constexpr int kMeasurable[] = {1, 2, 3, 6, 7, 8, 10};

/// Whole numbers of a message; anything else counts as unknown.
double whole(double value, double most) noexcept {
  return value >= 0 && value <= most ? std::floor(value) : 0;
}
}  // namespace

BatteryStateBroadcaster::Values BatteryStateBroadcaster::unknown() {
  Values out;
  out.fill(kUnknown);
  out[status] = out[health] = out[technology] = 0;
  out[present] = 1;
  return out;
}

void BatteryStateBroadcaster::read_battery(ControllerContext& context, const std::string& name) {
  Parameters& p = context.parameters;
  Battery battery{.values = unknown()};
  battery.states.fill(kNotMeasured);
  const auto claim = [&](int field) {
    const std::string state = context.whole_name(name + "/battery_" + kFieldNames[field]);
    if (context.has_state(state))
      battery.states[static_cast<std::size_t>(field)] = static_cast<int>(claim_state(state));
    else
      p.problems().error("unknown-interface", place_of(p, "batteries"),
                         "there is no state '" + name + "/battery_" + kFieldNames[field] + "'" +
                             did_you_mean(state, context.state_names));
  };
  claim(voltage);
  for (const int field : kMeasurable) {
    bool measured = false;
    p.read("interfaces." + name + ".battery_" + kFieldNames[field], measured, {"it is measured"});
    if (measured) claim(field);
  }
  int kind = 0;
  p.read(name + ".minimum_voltage", battery.minimum = kUnknown, {"V when empty"});
  p.read(name + ".maximum_voltage", battery.maximum = kUnknown, {"V when full"});
  p.read(name + ".capacity", battery.values[capacity], {"Ah, of the last full charge"});
  p.read(name + ".design_capacity", battery.values[design_capacity], {"Ah, when new"});
  p.read(name + ".power_supply_technology", kind,
         {.text = "as in sensor_msgs/BatteryState", .least = 0, .most = 8});
  battery.values[technology] = kind;
  std::string text;
  for (const char* key : {".location", ".serial_number"}) {
    text.clear();
    p.read(name + key, text, {"part of the text of all batteries"});
    if (!text.empty()) all_->texts[key + 1] += text + ", ";
  }
  if (battery.minimum >= battery.maximum)
    p.problems().error("bad-value", place_of(p, name + ".maximum_voltage"),
                       "maximum_voltage of '" + name + "' is not above its minimum_voltage");
  batteries_.push_back(battery);
}

/// One battery under the name of an older release.
void BatteryStateBroadcaster::read_old_sensor(ControllerContext& context, const std::string& name) {
  Parameters& p = context.parameters;
  Battery battery{.minimum = kUnknown, .maximum = kUnknown, .values = unknown()};
  battery.states.fill(kNotMeasured);
  const std::string state = context.whole_name(name + "/voltage");
  if (!context.has_state(state))
    throw Error(Problem{"unknown-interface", place_of(p, "sensor_name"),
                        "there is no state '" + name + "/voltage'" + did_you_mean(state, context.state_names),
                        ""});
  battery.states[voltage] = static_cast<int>(claim_state(state));
  int kind = 0;
  p.read("design_capacity", battery.values[design_capacity], {"Ah, when new"});
  p.read("power_supply_technology", kind, {.text = "as in sensor_msgs/BatteryState", .least = 0, .most = 8});
  battery.values[technology] = kind;
  batteries_.push_back(battery);
}

CallbackReturn BatteryStateBroadcaster::on_configure(ControllerContext& context) {
  Parameters& p = context.parameters;
  batteries_.clear();
  std::vector<std::string> names, fields(std::begin(kFieldNames), std::end(kFieldNames)), every;
  std::string sensor;
  p.read("batteries", names, {"the batteries, each with the state battery_voltage"});
  p.read("sensor_name", sensor, {"an older name for one battery, with the state voltage"});
  if (names.empty() == sensor.empty())
    throw Error(
        Problem{"bad-value", place_of(p, "batteries"),
                names.empty() ? "it names no batteries" : "'batteries' and 'sensor_name' are both there",
                "write batteries: [NAME, …]"});
  all_ = &add_output("battery_state", "sensor_msgs/BatteryState", std::move(fields));
  for (const std::string& name : names) read_battery(context, name);
  if (!sensor.empty()) read_old_sensor(context, sensor);
  for (std::size_t i = 0; i < names.size(); ++i)
    for (const char* field : kFieldNames)
      every.push_back("battery_states[" + std::to_string(i) + "]." + field);
  each_ = &add_output("raw_battery_states", "control_msgs/BatteryStateArray", std::move(every));
  return p.problems().has_errors() ? CallbackReturn::failure : CallbackReturn::success;
}

void BatteryStateBroadcaster::measure(Battery& battery) noexcept {
  for (std::size_t i = 0; i < kFields; ++i)
    if (battery.states[i] != kNotMeasured)
      battery.values[i] = state(static_cast<std::size_t>(battery.states[i]));
  battery.values[status] = whole(battery.values[status], 4);
  battery.values[health] = whole(battery.values[health], 7);
  // Without a state of its own, a battery that has a voltage is there.
  const double seen = battery.values[battery.states[present] == kNotMeasured ? voltage : present];
  battery.values[present] = std::isfinite(seen) && seen != 0 ? 1 : 0;
  if (battery.states[percentage] == kNotMeasured)  // NaN where a voltage is not known
    battery.values[percentage] =
        100 * (battery.values[voltage] - battery.minimum) / (battery.maximum - battery.minimum);
}

/// Means of voltage, temperature, current and percentage over those that know them; sums of charge and
/// capacities; the worst status and health.
BatteryStateBroadcaster::Values BatteryStateBroadcaster::together() const noexcept {
  Values out = unknown();
  for (const Field field : {voltage, temperature, current, charge, percentage, capacity, design_capacity}) {
    double sum = 0, count = 0;
    for (const Battery& battery : batteries_)
      if (const double value = battery.values[field]; std::isfinite(value)) sum += value, ++count;
    const bool adds = field == charge || field == capacity || field == design_capacity;
    if (count > 0) out[field] = adds ? sum : sum / count;
  }
  out[technology] = batteries_.front().values[technology];
  out[present] = 0;
  for (const Battery& battery : batteries_) {
    out[status] = std::max(out[status], battery.values[status]);
    out[health] = std::max(out[health], battery.values[health]);
    if (battery.values[technology] != out[technology]) out[technology] = 0;
    if (battery.values[present] != 0) out[present] = 1;
  }
  return out;
}

ReturnType BatteryStateBroadcaster::update(const Cycle& cycle, const Verdict&) noexcept {
  for (Battery& battery : batteries_) measure(battery);
  const Values all = together();
  std::copy(all.begin(), all.end(), all_->draft().values.begin());
  all_->publish(cycle.time);
  auto out = each_->draft().values.begin();
  if (each_->fields().empty()) return ReturnType::ok;
  for (const Battery& battery : batteries_)
    out = std::copy(battery.values.begin(), battery.values.end(), out);
  each_->publish(cycle.time);
  return ReturnType::ok;
}

}  // namespace polyarm::controllers
