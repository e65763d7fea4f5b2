#include "polyarm/broadcasters/imu_sensor_broadcaster.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "polyarm/broadcasters/sensor_interfaces.hpp"

namespace polyarm::controllers {

namespace {

constexpr double kNoReading = std::numeric_limits<double>::quiet_NaN();

Quaternion read_rotation(Parameters& p) {
  double roll = 0, pitch = 0, yaw = 0;
  p.read("rotation_offset.roll", roll, {"rad, from the sensor's frame into frame_id"});
  p.read("rotation_offset.pitch", pitch, {"rad"});
  p.read("rotation_offset.yaw", yaw, {"rad; yaw first, then pitch, then roll"});
  if (!std::isfinite(roll + pitch + yaw)) {
    p.problems().error("bad-value", place_of(p, "rotation_offset.yaw"), "rotation_offset is not finite");
    return {};
  }
  return from_rpy(roll, pitch, yaw);
}

/// R C R^T, column by column and then row by row.
std::array<double, 9> turned(const Quaternion& q, const std::array<double, 9>& c) {
  std::array<double, 9> half{}, out{};
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 column = q * Vec3{c[k], c[3 + k], c[6 + k]};
    half[k] = column.x, half[3 + k] = column.y, half[6 + k] = column.z;
  }
  for (std::size_t k = 0; k < 9; k += 3) {
    const Vec3 row = q * Vec3{half[k], half[k + 1], half[k + 2]};
    out[k] = row.x, out[k + 1] = row.y, out[k + 2] = row.z;
  }
  return out;
}

std::vector<std::string> imu_fields() {
  std::vector<std::string> out;
  for (const std::size_t first : {0u, 4u, 7u}) {
    const std::size_t end = first == 0 ? 4 : first + 3;
    for (std::size_t i = first; i < end; ++i) out.emplace_back(kImuInterfaces[i]);
    const std::string group = kImuInterfaces[first];
    add_covariance_fields(out, group.substr(0, group.find('.')) + "_covariance");
  }
  return out;
}

}  // namespace

void ImuSensorBroadcaster::claim_group(ControllerContext& context, const std::string& sensor,
                                       std::size_t first, std::size_t count,
                                       std::array<double, 9>& covariance) {
  const auto name = [&](std::size_t i) { return sensor + "/" + kImuInterfaces[i]; };
  bool measured = false;
  for (std::size_t i = first; i < first + count; ++i) measured = measured || context.has_state(name(i));
  for (std::size_t i = first; i < first + count; ++i)
    places_[i] = measured ? static_cast<int>(claim_state(name(i))) : -1;
  if (!measured) covariance = {-1};
}

CallbackReturn ImuSensorBroadcaster::on_configure(ControllerContext& context) {
  Parameters& p = context.parameters;
  const FoundSensor sensor = read_sensor(context, kImuInterfaces, "an IMU");
  rotation_ = read_rotation(p);
  orientation_covariance_ = read_covariance(p, "static_covariance_orientation");
  velocity_covariance_ = turned(rotation_, read_covariance(p, "static_covariance_angular_velocity"));
  acceleration_covariance_ = turned(rotation_, read_covariance(p, "static_covariance_linear_acceleration"));
  claim_group(context, sensor.whole, 0, 4, orientation_covariance_);
  claim_group(context, sensor.whole, 4, 3, velocity_covariance_);
  claim_group(context, sensor.whole, 7, 3, acceleration_covariance_);
  for (const char* interface : kImuInterfaces)
    export_state(context.name + "/" + sensor.name + "/" + interface);
  imu_ = &add_output("imu", "sensor_msgs/Imu", imu_fields());
  imu_->texts["frame_id"] = read_frame(p, sensor.name);
  return CallbackReturn::success;
}

ReturnType ImuSensorBroadcaster::update(const Cycle& cycle, const Verdict&) noexcept {
  const auto read = [&](std::size_t i) {
    return places_[i] < 0 ? kNoReading : state(static_cast<std::size_t>(places_[i]));
  };
  // The attitude is that of the message's frame in the world, so that the offset is taken back from it.
  const Quaternion q = Quaternion{read(0), read(1), read(2), read(3)} * inverse(rotation_);
  const Vec3 v = rotation_ * Vec3{read(4), read(5), read(6)};
  const Vec3 a = rotation_ * Vec3{read(7), read(8), read(9)};
  const double values[] = {q.x, q.y, q.z, q.w, v.x, v.y, v.z, a.x, a.y, a.z};
  for (std::size_t i = 0; i < 10; ++i) set_exported(i, values[i]);
  auto out = imu_->draft().values.begin();
  out = std::copy(values, values + 4, out);
  out = std::copy(orientation_covariance_.begin(), orientation_covariance_.end(), out);
  out = std::copy(values + 4, values + 7, out);
  out = std::copy(velocity_covariance_.begin(), velocity_covariance_.end(), out);
  out = std::copy(values + 7, values + 10, out);
  std::copy(acceleration_covariance_.begin(), acceleration_covariance_.end(), out);
  imu_->publish(cycle.time);
  return ReturnType::ok;
}

}  // namespace polyarm::controllers
