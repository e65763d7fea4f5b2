/// The parameters, interfaces and outputs of the differential drive.
#include <algorithm>
#include <cmath>

#include "polyarm/wheels/diff_drive_controller.hpp"

namespace polyarm::controllers {

namespace {

Location where(const Parameters& p, const std::string& key) {
  const auto found = p.entries.find(key);
  return found == p.entries.end() ? Location{} : found->second.where;
}

/// Moves what stands under the name of an older release to today's name, unless that is there too.
void rename(Parameters& p, const std::string& old, const std::vector<std::string>& today) {
  const auto found = p.entries.find(old);
  if (found == p.entries.end()) return;
  const Parameters::Entry entry = found->second;
  p.entries.erase(found);
  for (const std::string& name : today) p.entries.try_emplace(name, entry);
  p.problems().warning("superseded-key", entry.where,
                       "'" + old + "' is an older release's name of '" + today.front() + "'",
                       "write " + today.front());
}

/// `has_…_limits: false` switched a kind of limit off, whatever its numbers were.
void heed_switch(Parameters& p, const std::string& key, const std::vector<std::string>& numbers) {
  if (!p.has(key)) return;
  if (p.boolean(key, true)) return p.superseded(key, "a limit holds where its number stands");
  p.problems().warning("superseded-key", where(p, key),
                       "'" + key + ": false' is an older release's way to switch a limit off",
                       "leave out its numbers instead");
  p.entries.erase(key);
  for (const std::string& number : numbers) p.entries.erase(number);
}

/// A brake that never brakes is taken as not stated.
void refuse_zero(Parameters& p, const std::string& key, double& value) {
  if (value != 0) return;
  value = SpeedLimits::kFree;
  p.problems().warning("no-effect", where(p, key), "'" + key + ": 0' would never let it stop",
                       "write how fast it may slow down, or leave the line out");
}

void read_diagonal(Parameters& p, const std::string& key, std::array<double, 6>& out) {
  std::vector<double> values(6, 0.0);
  p.read(key, values, {"six numbers for x, y, z, roll, pitch, yaw: the covariance that odometry tells"});
  if (values.size() != 6)
    return p.problems().error("bad-value", where(p, key),
                              "'" + key + "' has " + std::to_string(values.size()) + " numbers, it needs 6");
  std::copy(values.begin(), values.end(), out.begin());
}

std::vector<std::string> with(const std::string& prefix, std::vector<std::string> names) {
  for (std::string& name : names) name.insert(0, prefix);
  return names;
}

}  // namespace

void DiffDriveController::read_size(Parameters& p) {
  double separation = 0, radius = 0, separation_factor = 1, left_factor = 1, right_factor = 1;
  p.read("wheel_separation", separation, {"m between the wheels of the two sides"});
  p.read("wheel_radius", radius, {"m, radius of a wheel"});
  p.read("wheel_separation_multiplier", separation_factor, {"corrects wheel_separation"});
  p.read("left_wheel_radius_multiplier", left_factor, {"corrects wheel_radius on the left"});
  p.read("right_wheel_radius_multiplier", right_factor, {"corrects wheel_radius on the right"});
  const auto positive = [&](const char* key, double value, bool most) {
    if (std::isfinite(value) && value != 0 && (!most || value > 0)) return;
    p.problems().error("bad-value", where(p, key),
                       std::string(key) + (most ? " must be a number above 0" : " must not be 0"),
                       most ? std::string("write ") + key + " in metres" : "");
  };
  positive("wheel_separation", separation, true);
  positive("wheel_radius", radius, true);
  positive("wheel_separation_multiplier", separation_factor, false);
  positive("left_wheel_radius_multiplier", left_factor, false);
  positive("right_wheel_radius_multiplier", right_factor, false);
  separation_ = separation * separation_factor;
  left_radius_ = radius * left_factor;
  right_radius_ = radius * right_factor;
}

void DiffDriveController::read_wheels(ControllerContext& context) {
  Parameters& p = context.parameters;
  rename(p, "left_wheel", {"left_wheel_names"});
  rename(p, "right_wheel", {"right_wheel_names"});
  std::vector<std::string> left, right;
  p.read("left_wheel_names", left, {"the joints of the wheels on the left"});
  p.read("right_wheel_names", right, {"the joints of the wheels on the right, as many"});
  if (left.size() != right.size() || left.empty())
    p.problems().error("bad-value", where(p, "left_wheel_names"),
                       left.size() == right.size()
                           ? "it has no wheels"
                           : "there are " + std::to_string(left.size()) + " wheels on the left and " +
                                 std::to_string(right.size()) + " on the right; it needs as many on each",
                       "name joints in left_wheel_names and right_wheel_names");
  const std::string feedback = position_feedback_ ? "/position" : "/velocity";
  const auto claim = [&](const std::string& key, const std::vector<std::string>& names,
                         std::vector<std::size_t>& commands, std::vector<std::size_t>& states) {
    for (const std::string& name : names) {
      const std::string known = context.whole_name(name + "/velocity");
      const std::string joint =
          context.has_command(known) ? known.substr(0, known.rfind('/')) : context.whole_joint(name, key);
      const std::size_t before = command_interfaces().size();
      commands.push_back(claim_command(joint + "/velocity"));
      if (command_interfaces().size() == before)
        p.problems().error("bad-value", where(p, key), "the wheel '" + name + "' is named twice");
      if (!open_loop_) states.push_back(claim_state(joint + feedback));
    }
  };
  left_.clear(), right_.clear(), left_feedback_.clear(), right_feedback_.clear();
  claim("left_wheel_names", left, left_, left_feedback_);
  claim("right_wheel_names", right, right_, right_feedback_);
}

void DiffDriveController::read_limits(Parameters& p, const std::string& axis, SpeedLimits& l) {
  heed_switch(p, axis + "has_velocity_limits", with(axis, {"max_velocity", "min_velocity"}));
  heed_switch(p, axis + "has_acceleration_limits",
              with(axis, {"max_acceleration", "min_acceleration", "max_deceleration",
                          "max_acceleration_reverse", "max_deceleration_reverse"}));
  heed_switch(p, axis + "has_jerk_limits", with(axis, {"max_jerk", "min_jerk"}));
  rename(p, axis + "min_acceleration", with(axis, {"max_deceleration", "max_acceleration_reverse"}));
  l = {};
  const auto read = [&](const char* key, double& value, const char* text, int sign) {
    ParameterNote note{.text = text, .changeable = true};
    (sign > 0 ? note.least : note.most) = 0;
    p.read(axis + key, value, note);
  };
  read("max_velocity", l.max_velocity, "fastest forwards, m/s or rad/s; .nan: no limit", 1);
  read("min_velocity", l.min_velocity, "fastest backwards; .nan: -max_velocity", -1);
  read("max_acceleration", l.max_acceleration, "getting faster forwards, m/s² or rad/s²; .nan: no limit", 1);
  read("max_deceleration", l.max_deceleration, "slowing down forwards; .nan: max_acceleration_reverse", -1);
  read("max_acceleration_reverse", l.max_acceleration_reverse,
       "getting faster backwards; .nan: -max_acceleration", -1);
  read("max_deceleration_reverse", l.max_deceleration_reverse,
       "slowing down backwards; .nan: -max_deceleration", 1);
  read("max_jerk", l.max_jerk, "m/s³ or rad/s³, while getting faster; .nan: no limit", 1);
  read("min_jerk", l.min_jerk, "the same backwards; .nan: -max_jerk", -1);
  refuse_zero(p, axis + "max_deceleration", l.max_deceleration);
  refuse_zero(p, axis + "max_deceleration_reverse", l.max_deceleration_reverse);
  const auto alone = [&](const char* key, double value, const char* needed, double present) {
    if (std::isnan(value) || !std::isnan(present)) return;
    p.problems().warning("no-effect", where(p, axis + key),
                         "'" + axis + key + "' has no effect without " + needed,
                         std::string("write ") + needed + " too");
  };
  alone("min_velocity", l.min_velocity, "max_velocity", l.max_velocity);
  alone("max_deceleration", l.max_deceleration, "max_acceleration", l.max_acceleration);
  alone("max_deceleration_reverse", l.max_deceleration_reverse, "max_acceleration", l.max_acceleration);
  alone("max_acceleration_reverse", l.max_acceleration_reverse, "max_acceleration", l.max_acceleration);
  alone("min_jerk", l.min_jerk, "max_jerk", l.max_jerk);
}

void DiffDriveController::read_behaviour(Parameters& p) {
  rename(p, "estimate_velocity_from_position", {"position_feedback"});
  rename(p, "publish_cmd", {"publish_limited_velocity"});
  rename(p, "wheel_radius_multiplier", {"left_wheel_radius_multiplier", "right_wheel_radius_multiplier"});
  p.superseded("publish_rate", "odometry is told every update");
  p.superseded("use_stamped_vel", "twists with and without stamp are both understood");
  p.superseded("wheels_per_side", "the wheels are counted");
  p.superseded("allow_multiple_cmd_vel_publishers", "the last command counts, whoever sends it");
  p.superseded("publish_wheel_joint_controller_state", "a joint_state_broadcaster tells the wheels");
  open_loop_ = false, position_feedback_ = true, tell_tf_ = true, tell_limited_ = false;
  window_ = 10;
  double& timeout = command_watch().timeout;
  timeout = 0.5;
  p.read("open_loop", open_loop_, {"odometry from what is commanded, not from what the wheels do"});
  p.read("position_feedback", position_feedback_,
         {"odometry from the positions of the wheels; false: from their velocities"});
  p.read("velocity_rolling_window_size", window_,
         {.text = "updates over which the told velocity is a mean", .least = 1, .most = 10000});
  p.read("cmd_vel_timeout", timeout,
         {.text = "s after which a command no longer counts; 0: never", .changeable = true, .least = 0});
  if (std::isnan(timeout))
    p.problems().error("bad-value", where(p, "cmd_vel_timeout"), "cmd_vel_timeout is not a number");
  p.read("publish_limited_velocity", tell_limited_,
         {.text = "tell the speeds after the limits as cmd_vel_out", .changeable = true});
  p.read("enable_odom_tf", tell_tf_,
         {.text = "tell the place of the base as a transform", .changeable = true});
  read_diagonal(p, "pose_covariance_diagonal", pose_covariance_);
  read_diagonal(p, "twist_covariance_diagonal", twist_covariance_);
}

namespace {

/// "~" is the name space of the controller: that of its robot, where there are several.
std::string frame_prefix(ControllerContext& context) {
  std::string prefix;
  bool enabled = true;
  context.parameters.read("tf_frame_prefix", prefix,
                          {"before the names of frames; ~ or nothing: the robot, where there are several"});
  context.parameters.read("tf_frame_prefix_enable", enabled, {"false: no prefix"});
  if (!enabled) return {};
  const bool several =
      std::any_of(context.joints.begin(), context.joints.end(),
                  [&](const JointFacts& joint) { return !joint.name.starts_with(context.robot + "/"); });
  const std::string robot = several ? context.robot : "";
  if (prefix.empty()) prefix = "~";
  if (const std::size_t at = prefix.find('~'); at != std::string::npos) prefix.replace(at, 1, robot);
  while (prefix.starts_with('/')) prefix.erase(0, 1);
  if (!prefix.empty() && !prefix.ends_with('/')) prefix += '/';
  return prefix;
}

std::vector<std::string> odometry_fields() {
  std::vector<std::string> out =
      with("pose.pose.", {"position.x", "position.y", "position.z", "orientation.x", "orientation.y",
                          "orientation.z", "orientation.w"});
  for (const std::string& field :
       with("twist.twist.", {"linear.x", "linear.y", "linear.z", "angular.x", "angular.y", "angular.z"}))
    out.push_back(field);
  for (const char* side : {"pose.covariance[", "twist.covariance["})
    for (int i = 0; i < 6; ++i) out.push_back(side + std::to_string(7 * i) + "]");
  return out;
}

}  // namespace

void DiffDriveController::make_outputs(ControllerContext& context) {
  std::string odom_frame = "odom", base_frame = "base_link";
  context.parameters.read("odom_frame_id", odom_frame, {"the frame in which odometry is told"});
  context.parameters.read("base_frame_id", base_frame, {"the frame of the base"});
  const std::string prefix = frame_prefix(context);
  odom_ = &add_output("odom", "nav_msgs/Odometry", odometry_fields());
  tf_ = &add_output("tf", "geometry_msgs/TransformStamped",
                    with("transform.", {"translation.x", "translation.y", "translation.z", "rotation.x",
                                        "rotation.y", "rotation.z", "rotation.w"}));
  limited_ = &add_output(
      "cmd_vel_out", "geometry_msgs/TwistStamped",
      with("twist.", {"linear.x", "linear.y", "linear.z", "angular.x", "angular.y", "angular.z"}));
  limited_->texts["frame_id"] = prefix + base_frame;
  for (Output* output : {odom_, tf_}) {
    output->texts["frame_id"] = prefix + odom_frame;
    output->texts["child_frame_id"] = prefix + base_frame;
  }
}

CallbackReturn DiffDriveController::on_configure(ControllerContext& context) {
  Parameters& p = context.parameters;
  read_behaviour(p);
  read_size(p);
  for (const auto& [axis, limits] :
       {std::pair{"linear.x.", &linear_limits_}, {"angular.z.", &angular_limits_}})
    collect(p.problems(), [&] { read_limits(p, axis, *limits); });
  collect(p.problems(), [&] { read_wheels(context); });
  export_reference(context.name + "/linear/velocity");
  export_reference(context.name + "/angular/velocity");
  make_outputs(context);
  if (p.problems().has_errors()) return CallbackReturn::failure;
  odometry_.configure(separation_, left_radius_, right_radius_, static_cast<std::size_t>(window_));
  on_parameters_changed();
  commands_inbox_.reset({});
  place_inbox_.reset({});
  return CallbackReturn::success;
}

std::string DiffDriveController::refuse_changes(const std::vector<ParameterChange>& changes) const {
  SpeedLimits linear = linear_limits_, angular = angular_limits_;
  for (const ParameterChange& change : changes) {
    if (change.key == "cmd_vel_timeout" && std::isnan(change.value)) return "cmd_vel_timeout is not a number";
    for (const auto& [now, wanted] : {std::pair{&linear_limits_, &linear}, {&angular_limits_, &angular}}) {
      const auto* first = reinterpret_cast<const char*>(now);
      const auto* cell = static_cast<const char*>(change.cell);
      if (cell < first || cell >= first + sizeof(SpeedLimits)) continue;
      *reinterpret_cast<double*>(reinterpret_cast<char*>(wanted) + (cell - first)) = change.value;
    }
  }
  for (const SpeedLimits& limits : {linear, angular})
    if (const auto why = check(limits)) return *why;
  return {};
}

}  // namespace polyarm::controllers
