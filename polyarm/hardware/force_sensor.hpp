#pragma once
/// The force/torque sensors that physics measures, and how far their readings are wrong.
#include <algorithm>
#include <array>
#include <cstdint>
#include <string>

#include "polyarm/description/robot_model.hpp"

namespace polyarm::hardware {

/// The link at whose joint physics measures this `<sensor>` of a <ros2_control>: it has the state `force.x`
/// and names the link, which is not the root, as `frame_id`. -1: physics does not measure it.
inline int force_sensor_link(const description::RobotModel& model,
                             const description::ComponentInfo& component) {
  const auto frame = component.parameters.find("frame_id");
  const bool measures = std::any_of(component.state_interfaces.begin(), component.state_interfaces.end(),
                                    [](const auto& state) { return state.name == "force.x"; });
  if (component.kind != "sensor" || !measures || frame == component.parameters.end()) return -1;
  const int link = model.find_link(frame->second);
  return link == model.root ? -1 : link;
}

/// Errors of a simulated sensor. N and N m; the parameters of the `<sensor>` have these names.
struct ForceSensorErrors {
  double noise = 0, torque_noise = 0;  ///< standard deviation of each reading
  double drift = 0, torque_drift = 0;  ///< standard deviation of the change of the zero within a minute
  std::array<double, 6> bias{};        ///< of force x y z, then torque x y z
  std::uint32_t seed = 1;
  bool any() const {
    return noise > 0 || torque_noise > 0 || drift > 0 || torque_drift > 0 ||
           std::any_of(bias.begin(), bias.end(), [](double each) { return each != 0; });
  }
};

/// Reads and writes them as parameters. Throws Error("bad-value") that names the parameter.
ForceSensorErrors force_sensor_errors(const description::ComponentInfo& component);
void set_force_sensor_errors(const ForceSensorErrors& errors, description::ComponentInfo& component);

}  // namespace polyarm::hardware
