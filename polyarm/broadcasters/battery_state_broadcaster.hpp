#pragma once
#include <array>

#include "polyarm/controllers/controller.hpp"

namespace polyarm::controllers {

/// Publishes the state of batteries, as ros2_control's BatteryStateBroadcaster does: outputs `battery_state`
/// (sensor_msgs/BatteryState, all batteries in one) and `raw_battery_states` (control_msgs/BatteryStateArray,
/// each of them).
class BatteryStateBroadcaster : public Controller {
 public:
  CallbackReturn on_configure(ControllerContext& context) override;
  ReturnType update(const Cycle& cycle, const Verdict& verdict) noexcept override;

 private:
  /// The numbers of a message, in the order of its fields.
  enum Field {
    voltage,
    temperature,
    current,
    charge,
    capacity,
    design_capacity,
    percentage,
    status,
    health,
    technology,
    present
  };
  static constexpr std::size_t kFields = 11;
  using Values = std::array<double, kFields>;
  static constexpr int kNotMeasured = -1;
  struct Battery {
    std::array<int, kFields> states;  ///< kNotMeasured, or a claimed state
    double minimum = 0, maximum = 0;  ///< V; NaN: not known
    Values values;                    ///< what is known without measuring, and the newest of the rest
  };

  void read_battery(ControllerContext& context, const std::string& name);
  void read_old_sensor(ControllerContext& context, const std::string& name);
  void measure(Battery& battery) noexcept;
  Values together() const noexcept;
  static Values unknown();

  std::vector<Battery> batteries_;
  Output* all_ = nullptr;
  Output* each_ = nullptr;
};

}  // namespace polyarm::controllers
