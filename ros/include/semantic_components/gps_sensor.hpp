#pragma once
#include "semantic_components/semantic_component_interface.hpp"
#include "sensor_msgs/msg/nav_sat_fix.hpp"

namespace semantic_components {

enum class GPSSensorOption { WithCovariance, WithoutCovariance };

template <GPSSensorOption option>
class GPSSensor : public SemanticComponentInterface<sensor_msgs::msg::NavSatFix> {
 public:
  explicit GPSSensor(const std::string& name)
      : SemanticComponentInterface(
            name, option == GPSSensorOption::WithCovariance
                      ? named(name, {"status", "service", "latitude", "longitude", "altitude",
                                     "latitude_covariance", "longitude_covariance", "altitude_covariance"})
                      : named(name, {"status", "service", "latitude", "longitude", "altitude"})) {}
  std::int8_t get_status() const { return static_cast<std::int8_t>(value(0)); }
  std::uint16_t get_service() const { return static_cast<std::uint16_t>(value(1)); }
  double get_latitude() const { return value(2); }
  double get_longitude() const { return value(3); }
  double get_altitude() const { return value(4); }
  template <GPSSensorOption same = option,
            typename = std::enable_if_t<same == GPSSensorOption::WithCovariance>>
  const std::array<double, 9>& get_covariance() {
    covariance_[0] = value(5), covariance_[4] = value(6), covariance_[8] = value(7);
    return covariance_;
  }
  bool get_values_as_message(sensor_msgs::msg::NavSatFix& out) {
    out.status.status = get_status(), out.status.service = get_service();
    out.latitude = get_latitude(), out.longitude = get_longitude(), out.altitude = get_altitude();
    if constexpr (option == GPSSensorOption::WithCovariance) out.position_covariance = get_covariance();
    return true;
  }

 private:
  std::array<double, 9> covariance_{};
};

}  // namespace semantic_components
