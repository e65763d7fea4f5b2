/// The parameters, references and outputs that all wheeled bases have.
#include <algorithm>
#include <cmath>

#include "polyarm/wheels/base_controller.hpp"

namespace polyarm::controllers {

Location place_in_file(const Parameters& p, const std::string& key) {
  const auto found = p.entries.find(key);
  return found == p.entries.end() ? Location{} : found->second.where;
}

void require_size(Parameters& p, const std::string& key, double value, bool any_sign) {
  if (std::isfinite(value) && value != 0 && (any_sign || value > 0)) return;
  p.problems().error("bad-value", place_in_file(p, key),
                     key + (any_sign ? " must not be 0" : " must be a number above 0"),
                     any_sign ? "" : "write " + key + " in metres");
}

void rename_key(Parameters& p, const std::string& old, const std::vector<std::string>& today) {
  const auto found = p.entries.find(old);
  if (found == p.entries.end()) return;
  const Parameters::Entry entry = found->second;
  p.entries.erase(found);
  for (const std::string& name : today) p.entries.try_emplace(name, entry);
  p.problems().warning("superseded-key", entry.where,
                       "'" + old + "' is an older release's name of '" + today.front() + "'",
                       "write " + today.front());
}

namespace {

/// `has_…_limits: false` switched a kind of limit off, whatever its numbers were.
void heed_switch(Parameters& p, const std::string& key, const std::vector<std::string>& numbers) {
  if (!p.has(key)) return;
  if (p.boolean(key, true)) return p.superseded(key, "a limit applies if its number is given");
  p.problems().warning("superseded-key", place_in_file(p, key),
                       "'" + key + ": false' is an older release's way to switch a limit off",
                       "leave out its numbers instead");
  p.entries.erase(key);
  for (const std::string& number : numbers) p.entries.erase(number);
}

/// A brake that never brakes is ignored.
void refuse_zero(Parameters& p, const std::string& key, double& value) {
  if (value != 0) return;
  value = SpeedLimits::kFree;
  p.problems().warning("no-effect", place_in_file(p, key), "'" + key + ": 0' would never let it stop",
                       "write how fast it may slow down, or leave the line out");
}

void read_diagonal(Parameters& p, const std::string& key, std::array<double, 6>& out) {
  std::vector<double> values(out.begin(), out.end());
  p.read(key, values, {"six numbers for x, y, z, roll, pitch, yaw: the covariance that odometry reports"});
  if (values.size() != 6)
    return p.problems().error("bad-value", place_in_file(p, key),
                              "'" + key + "' has " + std::to_string(values.size()) + " numbers, it needs 6");
  std::copy(values.begin(), values.end(), out.begin());
}

std::vector<std::string> with(const std::string& prefix, std::vector<std::string> names) {
  for (std::string& name : names) name.insert(0, prefix);
  return names;
}

/// "~" is the name space of the controller: that of its robot, where there are several.
std::string frame_prefix(ControllerContext& context) {
  std::string prefix;
  bool enabled = true;
  context.parameters.read("tf_frame_prefix", prefix,
                          {"prefix of the names of frames; ~ or nothing: the robot, if there are several"});
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

std::vector<std::string> twist_fields(const std::string& prefix) {
  return with(prefix, {"linear.x", "linear.y", "linear.z", "angular.x", "angular.y", "angular.z"});
}

std::vector<std::string> odometry_fields() {
  std::vector<std::string> out =
      with("pose.pose.", {"position.x", "position.y", "position.z", "orientation.x", "orientation.y",
                          "orientation.z", "orientation.w"});
  for (const std::string& field : twist_fields("twist.twist.")) out.push_back(field);
  for (const char* side : {"pose.covariance[", "twist.covariance["})
    for (int i = 0; i < 6; ++i) out.push_back(side + std::to_string(7 * i) + "]");
  return out;
}

}  // namespace

std::string BaseController::whole_wheel(const ControllerContext& context, const std::string& written,
                                        const std::string& interface, const std::string& key) {
  const std::string known = context.whole_name(written + "/" + interface);
  return context.has_command(known) || context.has_state(known) ? known.substr(0, known.rfind('/'))
                                                                : context.whole_joint(written, key);
}

double BaseController::steering_limit(const ControllerContext& context,
                                      const std::vector<std::string>& joints) {
  double out = kUnlimited;
  for (const std::string& name : joints)
    for (const std::string& whole : {name, context.robot + "/" + name})
      if (const JointFacts* joint = context.find_joint(whole); joint && !joint->continuous)
        out = std::min({out, -joint->lower, joint->upper});
  return out;
}

std::size_t BaseController::claim_wheel(ControllerContext& context, const std::string& written,
                                        const std::string& interface, const std::string& key) {
  const std::size_t before = command_interfaces().size();
  const std::size_t place = claim_command(whole_wheel(context, written, interface, key) + "/" + interface);
  if (command_interfaces().size() == before)
    context.parameters.problems().error("bad-value", place_in_file(context.parameters, key),
                                        "the wheel '" + written + "' is named twice");
  return place;
}

void BaseController::read_limits(Parameters& p, const std::string& axis, SpeedLimits& l) {
  heed_switch(p, axis + "has_velocity_limits", with(axis, {"max_velocity", "min_velocity"}));
  heed_switch(p, axis + "has_acceleration_limits",
              with(axis, {"max_acceleration", "min_acceleration", "max_deceleration",
                          "max_acceleration_reverse", "max_deceleration_reverse"}));
  heed_switch(p, axis + "has_jerk_limits", with(axis, {"max_jerk", "min_jerk"}));
  rename_key(p, axis + "min_acceleration", with(axis, {"max_deceleration", "max_acceleration_reverse"}));
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
    p.problems().warning("no-effect", place_in_file(p, axis + key),
                         "'" + axis + key + "' has no effect without " + needed,
                         std::string("write ") + needed + " too");
  };
  alone("min_velocity", l.min_velocity, "max_velocity", l.max_velocity);
  alone("max_deceleration", l.max_deceleration, "max_acceleration", l.max_acceleration);
  alone("max_deceleration_reverse", l.max_deceleration_reverse, "max_acceleration", l.max_acceleration);
  alone("max_acceleration_reverse", l.max_acceleration_reverse, "max_acceleration", l.max_acceleration);
  alone("min_jerk", l.min_jerk, "max_jerk", l.max_jerk);
}

void BaseController::read_behaviour(Parameters& p) {
  open_loop_ = false, position_feedback_ = style_.position_feedback, report_limited_ = false;
  publish_tf_ = style_.transform;
  window_ = style_.has_window ? 10 : 1;
  double& timeout = command_watch().timeout;
  timeout = style_.timeout;
  if (style_.has_open_loop)
    p.read("open_loop", open_loop_, {"odometry from the commands, not from the wheels"});
  if (style_.has_position_feedback)
    p.read("position_feedback", position_feedback_,
           {"odometry from the positions of the wheels; false: from their velocities"});
  if (style_.has_window)
    p.read("velocity_rolling_window_size", window_,
           {.text = "updates over which the reported velocity is a mean", .least = 1, .most = 10000});
  if (style_.milliseconds) {
    int ms = static_cast<int>(timeout * 1000);
    p.read(style_.timeout_key, ms,
           {.text = "ms after which a command expires; 0: never", .least = 0, .most = 1e6});
    timeout = ms / 1000.0;
  } else {
    p.read(style_.timeout_key, timeout,
           {.text = style_.zero_timeout_is_once ? "s after which a command expires; 0: after one update"
                                                : "s after which a command expires; 0: never",
            .changeable = true,
            .least = 0});
  }
  if (std::isnan(timeout))
    p.problems().error("bad-value", place_in_file(p, style_.timeout_key),
                       std::string(style_.timeout_key) + " is not a number");
  p.read("publish_limited_velocity", report_limited_,
         {.text = "publish the speeds after the limits as cmd_vel_out", .changeable = true});
  p.read("enable_odom_tf", publish_tf_,
         {.text = "publish the pose of the base as a transform", .changeable = true});
  pose_covariance_ = twist_covariance_ = style_.covariance;
  read_diagonal(p, style_.pose_covariance, pose_covariance_);
  read_diagonal(p, style_.twist_covariance, twist_covariance_);
}

void BaseController::make_outputs(ControllerContext& context) {
  std::string odom_frame = "odom", base_frame = "base_link";
  context.parameters.read("odom_frame_id", odom_frame, {"the frame in which odometry is reported"});
  context.parameters.read("base_frame_id", base_frame, {"the frame of the base"});
  const std::string prefix = frame_prefix(context);
  odom_ = &add_output(style_.odometry, "nav_msgs/Odometry", odometry_fields());
  tf_ = &add_output(style_.transforms, "geometry_msgs/TransformStamped",
                    with("transform.", {"translation.x", "translation.y", "translation.z", "rotation.x",
                                        "rotation.y", "rotation.z", "rotation.w"}));
  limited_ = &add_output("cmd_vel_out", "geometry_msgs/TwistStamped", twist_fields("twist."));
  limited_->texts["frame_id"] = prefix + base_frame;
  for (Output* output : {odom_, tf_}) {
    output->texts["frame_id"] = prefix + odom_frame;
    output->texts["child_frame_id"] = prefix + base_frame;
  }
}

void BaseController::export_references(const std::string& name) {
  if (!style_.chains) return;
  if (!style_.lateral) {
    export_reference(name + "/linear/velocity");
    export_reference(name + "/angular/velocity");
    return;
  }
  for (const char* axis : {"/linear/x", "/linear/y", "/angular/z"})
    export_reference(name + axis + "/velocity");
}

void BaseController::read_base(ControllerContext& context) {
  Parameters& p = context.parameters;
  read_behaviour(p);
  limits_ = {};
  const auto limits = [&](bool has, const char* axis, SpeedLimits& of) {
    if (has) collect(p.problems(), [&] { read_limits(p, axis, of); });
  };
  limits(style_.limits_speed, "linear.x.", limits_[0]);
  limits(style_.limits_speed && style_.lateral, "linear.y.", limits_[1]);
  limits(style_.limits_turning, "angular.z.", limits_[2]);
  export_references(context.name);
  make_outputs(context);
}

CallbackReturn BaseController::finish_base(Parameters& p) {
  if (p.problems().has_errors()) return CallbackReturn::failure;
  BaseController::on_parameters_changed();
  commands_inbox_.reset({});
  place_inbox_.reset({});
  return CallbackReturn::success;
}

std::string BaseController::refuse_changes(const std::vector<ParameterChange>& changes) const {
  std::array<SpeedLimits, 3> wanted = limits_;
  for (const ParameterChange& change : changes) {
    if (change.key == style_.timeout_key && std::isnan(change.value))
      return std::string(style_.timeout_key) + " is not a number";
    const auto* first = reinterpret_cast<const char*>(limits_.data());
    const auto* cell = static_cast<const char*>(change.cell);
    if (cell < first || cell >= first + sizeof(limits_)) continue;
    *reinterpret_cast<double*>(reinterpret_cast<char*>(wanted.data()) + (cell - first)) = change.value;
  }
  for (const SpeedLimits& limits : wanted)
    if (const auto why = check(limits)) return *why;
  return {};
}

}  // namespace polyarm::controllers
