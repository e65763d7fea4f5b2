/// The parameters of the differential drive.
#include "polyarm/wheels/diff_drive_controller.hpp"

namespace polyarm::controllers {

void DiffDriveController::read_size(Parameters& p) {
  double separation = 0, radius = 0, separation_factor = 1, left_factor = 1, right_factor = 1;
  p.read("wheel_separation", separation, {"m between the wheels of the two sides"});
  p.read("wheel_radius", radius, {"m, radius of a wheel"});
  p.read("wheel_separation_multiplier", separation_factor, {"corrects wheel_separation"});
  p.read("left_wheel_radius_multiplier", left_factor, {"corrects wheel_radius on the left"});
  p.read("right_wheel_radius_multiplier", right_factor, {"corrects wheel_radius on the right"});
  require_size(p, "wheel_separation", separation);
  require_size(p, "wheel_radius", radius);
  require_size(p, "wheel_separation_multiplier", separation_factor, true);
  require_size(p, "left_wheel_radius_multiplier", left_factor, true);
  require_size(p, "right_wheel_radius_multiplier", right_factor, true);
  separation_ = separation * separation_factor;
  left_radius_ = radius * left_factor;
  right_radius_ = radius * right_factor;
}

void DiffDriveController::read_wheels(ControllerContext& context) {
  Parameters& p = context.parameters;
  rename_key(p, "left_wheel", {"left_wheel_names"});
  rename_key(p, "right_wheel", {"right_wheel_names"});
  std::vector<std::string> left, right;
  p.read("left_wheel_names", left, {"the joints of the wheels on the left"});
  p.read("right_wheel_names", right, {"the joints of the wheels on the right, as many"});
  if (left.size() != right.size() || left.empty())
    p.problems().error("bad-value", place_in_file(p, "left_wheel_names"),
                       left.size() == right.size()
                           ? "it has no wheels"
                           : "there are " + std::to_string(left.size()) + " wheels on the left and " +
                                 std::to_string(right.size()) + " on the right; it needs as many on each",
                       "name joints in left_wheel_names and right_wheel_names");
  const std::string feedback = position_feedback() ? "/position" : "/velocity";
  const auto claim = [&](const std::string& key, const std::vector<std::string>& names,
                         std::vector<std::size_t>& commands, std::vector<std::size_t>& states) {
    commands.clear(), states.clear();
    for (const std::string& name : names) {
      const std::string joint = whole_wheel(context, name, "velocity", key);
      commands.push_back(claim_wheel(context, name, "velocity", key));
      if (!open_loop()) states.push_back(claim_state(joint + feedback));
    }
  };
  claim("left_wheel_names", left, left_, left_feedback_);
  claim("right_wheel_names", right, right_, right_feedback_);
}

CallbackReturn DiffDriveController::on_configure(ControllerContext& context) {
  Parameters& p = context.parameters;
  rename_key(p, "estimate_velocity_from_position", {"position_feedback"});
  rename_key(p, "publish_cmd", {"publish_limited_velocity"});
  rename_key(p, "wheel_radius_multiplier", {"left_wheel_radius_multiplier", "right_wheel_radius_multiplier"});
  p.superseded("publish_rate", "odometry is published every update");
  p.superseded("use_stamped_vel", "twists with and without stamp are both understood");
  p.superseded("wheels_per_side", "the wheels are counted");
  p.superseded("allow_multiple_cmd_vel_publishers", "the last command counts, whoever sends it");
  p.superseded("publish_wheel_joint_controller_state", "a joint_state_broadcaster publishes the wheels");
  read_base(context);
  read_size(p);
  collect(p.problems(), [&] { read_wheels(context); });
  const CallbackReturn result = finish_base(p);
  if (result == CallbackReturn::success)
    odometry_.configure(separation_, left_radius_, right_radius_, window());
  return result;
}

}  // namespace polyarm::controllers
