#include "polyarm/wheels/wheel_names.hpp"

namespace polyarm::controllers {

namespace {
constexpr const char* kWheelKeys[] = {
    // differential drives; the older names
    "left_wheel_names", "right_wheel_names", "left_wheel", "right_wheel",
    // steered bases; the older names, of wheels or of steering
    "traction_joints_names", "steering_joints_names", "front_wheels_names", "rear_wheels_names",
    // tricycles whose front wheel drives
    "traction_joint_name", "steering_joint_name",
    // mecanum and omni wheels
    "front_left_wheel_command_joint_name", "front_right_wheel_command_joint_name",
    "rear_right_wheel_command_joint_name", "rear_left_wheel_command_joint_name", "wheel_names"};
}  // namespace

std::vector<std::string> wheel_names(const Parameters& parameters) {
  std::vector<std::string> out;
  for (const char* key : kWheelKeys)
    if (const auto found = parameters.entries.find(key); found != parameters.entries.end())
      out.insert(out.end(), found->second.values.begin(), found->second.values.end());
  return out;
}

}  // namespace polyarm::controllers
