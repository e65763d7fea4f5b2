#pragma once
#include <array>

#include "polyarm/controllers/controller.hpp"

namespace polyarm::controllers {

/// Tells what an IMU measures, as ros2_control's IMUSensorBroadcaster and ros_control's ImuSensorController
/// do: output `imu` (sensor_msgs/Imu), and the same ten values as states `<name>/<sensor>/orientation.x` …
/// for other controllers. `rotation_offset` turns it into another frame. What the sensor does not measure at
/// all is NaN, with a covariance that begins with -1.
class ImuSensorBroadcaster : public Controller {
 public:
  CallbackReturn on_configure(ControllerContext& context) override;
  ReturnType update(const Cycle& cycle, const Verdict& verdict) noexcept override;

 private:
  void claim_group(ControllerContext& context, const std::string& sensor, std::size_t first,
                   std::size_t count, std::array<double, 9>& covariance);

  std::array<int, 10> places_{};  // of the states, or -1
  Quaternion rotation_;           // from the sensor's frame into that of the message
  std::array<double, 9> orientation_covariance_{}, velocity_covariance_{}, acceleration_covariance_{};
  Output* imu_ = nullptr;
};

}  // namespace polyarm::controllers
