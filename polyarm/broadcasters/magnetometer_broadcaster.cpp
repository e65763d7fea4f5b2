#include "polyarm/broadcasters/magnetometer_broadcaster.hpp"

#include <algorithm>

#include "polyarm/broadcasters/sensor_interfaces.hpp"

namespace polyarm::controllers {

CallbackReturn MagnetometerBroadcaster::on_configure(ControllerContext& context) {
  constexpr const char* kInterfaces[] = {"magnetic_field.x", "magnetic_field.y", "magnetic_field.z"};
  const FoundSensor sensor = read_sensor(context, kInterfaces, "a magnetometer");
  std::vector<std::string> fields;
  for (const char* interface : kInterfaces) {
    claim_state(sensor.whole + "/" + interface);
    fields.emplace_back(interface);
  }
  covariance_ = read_covariance(context.parameters, "static_covariance");
  add_covariance_fields(fields, "magnetic_field_covariance");
  field_ = &add_output("magnetic_field", "sensor_msgs/MagneticField", std::move(fields));
  field_->texts["frame_id"] = read_frame(context.parameters, sensor.name);
  return CallbackReturn::success;
}

ReturnType MagnetometerBroadcaster::update(const Cycle& cycle, const Verdict&) noexcept {
  std::vector<double>& out = field_->draft().values;
  for (std::size_t i = 0; i < 3; ++i) out[i] = state(i);
  std::copy(covariance_.begin(), covariance_.end(), out.begin() + 3);
  field_->publish(cycle.time);
  return ReturnType::ok;
}

}  // namespace polyarm::controllers
