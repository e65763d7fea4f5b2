#include "polyarm/broadcasters/gps_sensor_broadcaster.hpp"

#include <algorithm>

#include "polyarm/broadcasters/sensor_interfaces.hpp"

namespace polyarm::controllers {

namespace {
constexpr double kDiagonalKnown = 2, kKnown = 3;  // sensor_msgs/NavSatFix, position_covariance_type
}

CallbackReturn GpsSensorBroadcaster::on_configure(ControllerContext& context) {
  Parameters& p = context.parameters;
  const FoundSensor sensor = read_sensor(context, kGpsInterfaces, "a satellite receiver");
  covariance_ = read_covariance(p, "static_position_covariance");
  measured_covariance_ = false;
  p.read("read_covariance_from_interface", measured_covariance_,
         {"the receiver reports its covariance; static_position_covariance is not used"});
  for (const char* interface : kGpsInterfaces) claim_state(sensor.whole + "/" + interface);
  if (measured_covariance_) {
    covariance_ = {};
    for (const char* interface : kGpsCovarianceInterfaces) claim_state(sensor.whole + "/" + interface);
  }
  std::vector<std::string> fields{"status.status", "status.service", "latitude", "longitude", "altitude"};
  add_covariance_fields(fields, "position_covariance");
  fields.emplace_back("position_covariance_type");
  fix_ = &add_output("gps/fix", "sensor_msgs/NavSatFix", std::move(fields));
  fix_->texts["frame_id"] = read_frame(p, sensor.name);
  return CallbackReturn::success;
}

ReturnType GpsSensorBroadcaster::update(const Cycle& cycle, const Verdict&) noexcept {
  std::vector<double>& out = fix_->draft().values;
  for (std::size_t i = 0; i < 5; ++i) out[i] = state(i);
  if (measured_covariance_)
    for (std::size_t i = 0; i < 3; ++i) covariance_[4 * i] = state(5 + i);
  std::copy(covariance_.begin(), covariance_.end(), out.begin() + 5);
  out.back() = measured_covariance_ ? kDiagonalKnown : kKnown;
  fix_->publish(cycle.time);
  return ReturnType::ok;
}

}  // namespace polyarm::controllers
