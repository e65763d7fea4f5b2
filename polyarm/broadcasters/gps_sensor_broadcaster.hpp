#pragma once
#include <array>

#include "polyarm/controllers/controller.hpp"

namespace polyarm::controllers {

/// Tells where a satellite receiver is, as ros2_control's GPSSensorBroadcaster does: output `gps/fix`
/// (sensor_msgs/NavSatFix). The covariance is `static_position_covariance`, or with
/// `read_covariance_from_interface` the receiver's own three values.
class GpsSensorBroadcaster : public Controller {
 public:
  CallbackReturn on_configure(ControllerContext& context) override;
  ReturnType update(const Cycle& cycle, const Verdict& verdict) noexcept override;

 private:
  std::array<double, 9> covariance_{};
  bool measured_covariance_ = false;
  Output* fix_ = nullptr;
};

}  // namespace polyarm::controllers
