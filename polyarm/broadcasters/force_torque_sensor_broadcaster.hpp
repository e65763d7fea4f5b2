#pragma once
#include <array>

#include "polyarm/controllers/controller.hpp"
#include "polyarm/controllers/filters.hpp"

namespace polyarm::controllers {

/// Tells forces (N) and torques (N m), as ros2_control's ForceTorqueSensorBroadcaster and ros_control's
/// ForceTorqueSensorController do: (measured + offset) * multiplier as output `wrench`, and as states
/// `<name>/<sensor>/force.x` … for other controllers. With `sensor_filter_chain` also `wrench_filtered`.
/// The sensor is named by `sensor_name`, or its axes one by one by `interface_names.force.x` …; an axis
/// without a name is NaN. Offsets and multipliers are changeable.
class ForceTorqueSensorBroadcaster : public Controller {
 public:
  CallbackReturn on_configure(ControllerContext& context) override;
  CallbackReturn on_activate(const Cycle& cycle) noexcept override;
  ReturnType update(const Cycle& cycle, const Verdict& verdict) noexcept override;

 private:
  using Axes = std::array<FirstOrderFilter, 6>;
  std::string read_interfaces(ControllerContext& context);
  void claim_axis(ControllerContext& context, std::size_t axis, const std::string& whole,
                  const std::string& told);
  void read_corrections(Parameters& p);
  bool read_filter(ControllerContext& context, const std::string& prefix);

  std::array<int, 6> places_{};    // of the states, or -1
  std::array<int, 6> exported_{};  // or -1
  std::array<double, 6> offset_{}, multiplier_{};
  std::vector<Axes> filters_;
  Output* wrench_ = nullptr;
  Output* filtered_ = nullptr;  // null without filters
};

}  // namespace polyarm::controllers
