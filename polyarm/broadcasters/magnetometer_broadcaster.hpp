#pragma once
#include <array>

#include "polyarm/controllers/controller.hpp"

namespace polyarm::controllers {

/// Publishes what a magnetometer measures, as ros2_control's MagnetometerBroadcaster does: output
/// `magnetic_field` (sensor_msgs/MagneticField, tesla).
class MagnetometerBroadcaster : public Controller {
 public:
  CallbackReturn on_configure(ControllerContext& context) override;
  ReturnType update(const Cycle& cycle, const Verdict& verdict) noexcept override;

 private:
  std::array<double, 9> covariance_{};
  Output* field_ = nullptr;
};

}  // namespace polyarm::controllers
