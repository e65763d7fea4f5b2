#pragma once
#include "polyarm/controllers/controller.hpp"

namespace polyarm::controllers {

/// Publishes what a distance sensor measures, as ros2_control's RangeSensorBroadcaster does: output `range`
/// (sensor_msgs/Range, m).
class RangeSensorBroadcaster : public Controller {
 public:
  CallbackReturn on_configure(ControllerContext& context) override;
  ReturnType update(const Cycle& cycle, const Verdict& verdict) noexcept override;

 private:
  double field_of_view_ = 0, min_range_ = 0, max_range_ = 0, variance_ = 0;  // rad, m, m, m²
  int radiation_type_ = 0;
  Output* range_ = nullptr;
};

}  // namespace polyarm::controllers
