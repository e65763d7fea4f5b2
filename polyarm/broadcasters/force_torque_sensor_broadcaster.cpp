#include "polyarm/broadcasters/force_torque_sensor_broadcaster.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "polyarm/base/text.hpp"
#include "polyarm/broadcasters/sensor_interfaces.hpp"

namespace polyarm::controllers {

namespace {
constexpr double kNoWrench = std::numeric_limits<double>::quiet_NaN();

std::vector<std::string> wrench_fields() {
  std::vector<std::string> out;
  for (const char* axis : kForceTorqueInterfaces) out.push_back(std::string("wrench.") + axis);
  return out;
}

double positive(Parameters& p, const std::string& key, double fallback, const char* text) {
  double value = fallback;
  p.read(key, value, {text});
  if (std::isfinite(value) && value > 0) return value;
  p.problems().error("bad-value", place_of(p, key), "'" + key + "' must be a number above 0");
  return 1;
}
}  // namespace

void ForceTorqueSensorBroadcaster::claim_axis(ControllerContext& context, std::size_t axis,
                                              const std::string& whole, const std::string& told) {
  places_[axis] = static_cast<int>(claim_state(whole));
  exported_[axis] = static_cast<int>(export_state(context.name + "/" + told));
}

/// Returns the name of the sensor, for the frame.
std::string ForceTorqueSensorBroadcaster::read_interfaces(ControllerContext& context) {
  Parameters& p = context.parameters;
  places_.fill(-1);
  exported_.fill(-1);
  std::string first;
  for (std::size_t axis = 0; axis < 6; ++axis) {
    const std::string key = std::string("interface_names.") + kForceTorqueInterfaces[axis];
    std::string name;
    p.read(key, name, {"the state interface of this axis, in place of sensor_name"});
    if (name.empty()) continue;
    if (first.empty()) first = key;
    const std::string whole = context.whole_name(name);
    if (context.has_state(whole))
      claim_axis(context, axis, whole, name);
    else
      p.problems().error("unknown-interface", place_of(p, key),
                         "there is no state '" + name + "'" + did_you_mean(whole, context.state_names));
  }
  if (!first.empty() && p.has("sensor_name"))
    p.problems().error("bad-value", place_of(p, "sensor_name"),
                       "sensor_name and interface_names both define the source of the values",
                       "leave one of them out");
  if (!first.empty()) {
    std::string sensor;
    p.read("sensor_name", sensor, {"the sensor; may be omitted if there is only one"});
    const std::string written = p.text(first);
    return written.substr(0, written.rfind('/'));
  }
  const FoundSensor sensor = read_sensor(context, kForceTorqueInterfaces, "a force/torque sensor");
  for (std::size_t axis = 0; axis < 6; ++axis) {
    const std::string interface = std::string("/") + kForceTorqueInterfaces[axis];
    claim_axis(context, axis, sensor.whole + interface, sensor.name + interface);
  }
  return sensor.name;
}

void ForceTorqueSensorBroadcaster::read_corrections(Parameters& p) {
  offset_.fill(0);
  multiplier_.fill(1);
  for (std::size_t axis = 0; axis < 6; ++axis) {
    const std::string name = kForceTorqueInterfaces[axis];
    p.read("offset." + name, offset_[axis],
           {.text = "added to the measured value, N or N m", .changeable = true});
    p.read("multiplier." + name, multiplier_[axis], {.text = "times that", .changeable = true});
  }
}

bool ForceTorqueSensorBroadcaster::read_filter(ControllerContext& context, const std::string& prefix) {
  Parameters& p = context.parameters;
  std::string type, name;
  p.read(prefix + "type", type, {"control_filters/LowPassFilterWrench or …/ExponentialFilterWrench"});
  p.read(prefix + "name", name, {"what it is called"});
  FirstOrderFilter filter;
  if (type.find("LowPassFilter") != std::string::npos) {
    const double sampling =
        positive(p, prefix + "params.sampling_frequency", 1 / seconds(context.period), "Hz");
    const double damping = positive(p, prefix + "params.damping_frequency", 1, "Hz");
    double intensity = 0;
    p.read(prefix + "params.damping_intensity", intensity, {.text = "dB", .least = -300, .most = 300});
    filter = FirstOrderFilter::low_pass(sampling, damping, std::isnan(intensity) ? 0 : intensity);
  } else if (type.find("ExponentialFilter") != std::string::npos) {
    const double alpha = positive(p, prefix + "params.alpha", 0.5, "share of the newest value, to 1");
    if (alpha > 1)
      p.problems().error("bad-value", place_of(p, prefix + "params.alpha"), "alpha must not be above 1");
    filter = FirstOrderFilter::exponential(alpha);
  } else {
    p.problems().warning("unknown-filter", place_of(p, prefix + "type"),
                         "the filter " + type + " is not available; wrench_filtered is not published",
                         "there are LowPassFilterWrench and ExponentialFilterWrench");
    std::erase_if(p.entries, [&](const auto& entry) { return entry.first.starts_with(prefix); });
    return false;
  }
  filters_.emplace_back().fill(filter);
  return true;
}

CallbackReturn ForceTorqueSensorBroadcaster::on_configure(ControllerContext& context) {
  Parameters& p = context.parameters;
  const std::string sensor = read_interfaces(context);
  read_corrections(p);
  filters_.clear();
  bool complete = true;
  for (int n = 1; p.has("sensor_filter_chain.filter" + std::to_string(n) + ".type"); ++n)
    complete = read_filter(context, "sensor_filter_chain.filter" + std::to_string(n) + ".") && complete;
  const std::string frame = read_frame(p, sensor);
  wrench_ = &add_output("wrench", "geometry_msgs/WrenchStamped", wrench_fields());
  wrench_->texts["frame_id"] = frame;
  filtered_ = nullptr;
  if (filters_.empty() || !complete) return CallbackReturn::success;
  filtered_ = &add_output("wrench_filtered", "geometry_msgs/WrenchStamped", wrench_fields());
  filtered_->texts["frame_id"] = frame;
  return CallbackReturn::success;
}

CallbackReturn ForceTorqueSensorBroadcaster::on_activate(const Cycle&) noexcept {
  for (Axes& axes : filters_)
    for (FirstOrderFilter& filter : axes) filter.reset();
  return CallbackReturn::success;
}

ReturnType ForceTorqueSensorBroadcaster::update(const Cycle& cycle, const Verdict&) noexcept {
  std::array<double, 6> values;
  for (std::size_t axis = 0; axis < 6; ++axis) {
    const double measured = places_[axis] < 0 ? kNoWrench : state(static_cast<std::size_t>(places_[axis]));
    values[axis] = (measured + offset_[axis]) * multiplier_[axis];
    if (exported_[axis] >= 0) set_exported(static_cast<std::size_t>(exported_[axis]), values[axis]);
  }
  std::copy(values.begin(), values.end(), wrench_->draft().values.begin());
  wrench_->publish(cycle.time);
  if (!filtered_) return ReturnType::ok;
  for (Axes& axes : filters_)
    for (std::size_t axis = 0; axis < 6; ++axis) values[axis] = axes[axis].update(values[axis]);
  std::copy(values.begin(), values.end(), filtered_->draft().values.begin());
  filtered_->publish(cycle.time);
  return ReturnType::ok;
}

}  // namespace polyarm::controllers
