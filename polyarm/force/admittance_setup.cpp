/// The parameters, interfaces and output of the admittance controller.
#include <algorithm>
#include <cmath>

#include "polyarm/base/text.hpp"
#include "polyarm/broadcasters/sensor_interfaces.hpp"
#include "polyarm/force/admittance_controller.hpp"

namespace polyarm::controllers {

namespace {

std::size_t place_among(const std::vector<std::string>& list, const std::string& name) {
  return static_cast<std::size_t>(std::find(list.begin(), list.end(), name) - list.begin());
}
bool has(const std::vector<std::string>& list, const char* name) {
  return std::find(list.begin(), list.end(), name) != list.end();
}

void require_known(Parameters& p, const std::string& key, const std::vector<std::string>& interfaces) {
  if (interfaces.empty())
    p.problems().error("bad-value", place_of(p, key), "'" + key + "' is empty",
                       "write " + key + ": [position]");
  for (const std::string& name : interfaces)
    if (name != "position" && name != "velocity")
      p.problems().error("bad-value", place_of(p, key), "'" + key + "' has '" + name + "'",
                         "position and velocity are supported");
}

std::array<double, 6> read_six(Parameters& p, const std::string& key, const char* text, double least,
                               double most) {
  std::vector<double> values;
  p.read(key, values, {text});
  std::array<double, 6> out;
  out.fill(1);
  const bool fits = values.size() == 6 && std::all_of(values.begin(), values.end(),
                                                      [&](double v) { return v >= least && v <= most; });
  if (fits)
    std::copy(values.begin(), values.end(), out.begin());
  else
    p.problems().error(
        "bad-value", place_of(p, key),
        "'" + key + "' is not six numbers from " + format_number(least) + " to " + format_number(most),
        "in the order x, y, z, rx, ry, rz");
  return out;
}

std::vector<std::string> six_of(const std::string& prefix) {
  std::vector<std::string> out;
  for (int i = 0; i < 6; ++i) out.push_back(prefix + "[" + std::to_string(i) + "]");
  return out;
}
std::vector<std::string> under(const std::string& prefix, std::initializer_list<const char*> names) {
  std::vector<std::string> out;
  for (const char* name : names) out.push_back(prefix + "." + name);
  return out;
}
std::vector<std::string> turn_of(const std::string& prefix) {
  return under(prefix, {"x", "y", "z", "w"});
}
std::vector<std::string> transform_of(const std::string& prefix) {
  std::vector<std::string> out = under(prefix + ".transform.translation", {"x", "y", "z"});
  for (const std::string& name : turn_of(prefix + ".transform.rotation")) out.push_back(name);
  return out;
}
std::vector<std::string> twist_of(const std::string& prefix) {
  return under(prefix, {"twist.linear.x", "twist.linear.y", "twist.linear.z", "twist.angular.x",
                        "twist.angular.y", "twist.angular.z"});
}

}  // namespace

void AdmittanceController::claim(ControllerContext& context, const std::vector<std::string>& command_joints) {
  Parameters& p = context.parameters;
  std::vector<std::string> commands, states, references{"position", "velocity"};
  p.read("command_interfaces", commands, {"interfaces to command: position, velocity"});
  p.read("state_interfaces", states, {"interfaces to read: position, optionally velocity"});
  p.read("chainable_command_interfaces", references, {"references for a controller before this one"});
  require_known(p, "command_interfaces", commands);
  require_known(p, "state_interfaces", states);
  require_known(p, "chainable_command_interfaces", references);
  if (!states.empty() && !has(states, "position"))
    p.problems().error("bad-value", place_of(p, "state_interfaces"), "'state_interfaces' has no position");
  if (p.problems().has_errors()) return;
  const auto whole = [&](std::size_t i, const std::string& interface) {
    const std::string known = context.whole_name(command_joints[i] + "/" + interface);
    return context.has_command(known)
               ? known
               : context.whole_joint(command_joints[i], "command_joints") + "/" + interface;
  };
  for (const std::string& interface : commands)
    for (std::size_t i = 0; i < joints_.size(); ++i)
      (interface == "position" ? joints_[i].position_command : joints_[i].velocity_command) =
          claim_command(whole(i, interface));
  for (const std::string& interface : states)
    for (JointPort& joint : joints_) {
      const std::size_t place = claim_state(joint.facts.name + "/" + interface);
      if (interface == "position") joint.position_state = place;
    }
  for (const std::string& interface : references)
    for (JointPort& joint : joints_) {
      const std::string name = joint.facts.name.substr(joint.facts.name.find('/') + 1);
      (interface == "position" ? joint.position_reference : joint.velocity_reference) =
          export_reference(context.name + "/" + name + "/" + interface);
    }
}

void AdmittanceController::read_joints(ControllerContext& context) {
  Parameters& p = context.parameters;
  std::vector<std::string> names, command_joints;
  p.read("joints", names, {"the joints, in the order of references and commands"});
  p.read("command_joints", command_joints, {"other names for the commands; empty: the joints"});
  if (names.empty()) refuse_no_joints(p);
  if (command_joints.empty()) command_joints = names;
  if (command_joints.size() != names.size())
    p.problems().error("bad-value", place_of(p, "command_joints"),
                       "'command_joints' has " + std::to_string(command_joints.size()) + " names for " +
                           std::to_string(names.size()) + " joints");
  if (p.problems().has_errors()) return;
  joints_.clear();
  for (const std::string& name : names) joints_.push_back({*context.find_joint(context.whole_joint(name))});
  claim(context, command_joints);
}

void AdmittanceController::read_sensor_ports(ControllerContext& context) {
  const FoundSensor sensor =
      read_sensor(context, kForceTorqueInterfaces, "a force/torque sensor", "ft_sensor.name");
  for (std::size_t i = 0; i < 6; ++i)
    sensor_[i] = claim_state(sensor.whole + "/" + kForceTorqueInterfaces[i]);
}

void AdmittanceController::read_axes(Parameters& p) {
  std::vector<std::string> axes;
  p.read("admittance.selected_axes", axes, {"true for each axis that yields: x, y, z, rx, ry, rz"});
  bool fits = axes.size() == 6;
  for (std::size_t i = 0; fits && i < 6; ++i) {
    fits = axes[i] == "true" || axes[i] == "false" || axes[i] == "True" || axes[i] == "False";
    parameters_.axes[i] = axes[i] == "true" || axes[i] == "True";
  }
  if (!fits)
    p.problems().error("bad-value", place_of(p, "admittance.selected_axes"),
                       "'admittance.selected_axes' is not six times true or false");
  parameters_.mass = read_six(p, "admittance.mass", "kg and kg m² for each axis", 1e-4, 1e6);
  parameters_.damping_ratio = read_six(p, "admittance.damping_ratio", "D / (2 √(M K)) for each axis", 0, 1e6);
  parameters_.stiffness = read_six(p, "admittance.stiffness", "N/m and N m/rad for each axis", 0, 1e8);
  p.read("admittance.joint_damping", joint_damping_ = 5,
         {.text = "1/s, damping of the joints' offsets", .changeable = true, .least = 0, .most = 1e6});
  p.read("ft_sensor.filter_coefficient", filter_ = 0.05,
         {.text = "share of the newest wrench; 1: no filter", .changeable = true, .least = 0, .most = 1});
  p.read("kinematics.alpha", parameters_.alpha = 0.01,
         {.text = "damping of the inverse Jacobian", .least = 0, .most = 1e6});
}

void AdmittanceController::read_gravity(Parameters& p) {
  std::vector<double> cog(3, 0.0);
  p.read("gravity_compensation.CoG.pos", cog, {"m, centre of the weight in the frame gravity_compensation"});
  if (cog.size() != 3)
    p.problems().error("bad-value", place_of(p, "gravity_compensation.CoG.pos"),
                       "'gravity_compensation.CoG.pos' is not three numbers");
  else
    parameters_.cog = {cog[0], cog[1], cog[2]};
  p.read(
      "gravity_compensation.CoG.force", weight_ = 0,
      {.text = "N, weight of everything behind the sensor", .changeable = true, .least = -1e6, .most = 1e6});
}

int AdmittanceController::link_of(Parameters& p, const description::RobotModel& model, const std::string& key,
                                  bool may_be_world) {
  std::string name;
  p.read(key, name, {"a link of the robot"});
  if (may_be_world && (name.empty() || name == "world") && model.find_link(name) < 0) return 0;
  const int link = model.find_link(name);
  std::vector<std::string> known;
  for (const description::Link& each : model.links) known.push_back(each.name);
  if (link < 0)
    p.problems().error(
        "bad-value", place_of(p, key),
        name.empty() ? "'" + key + "' is missing"
                     : "'" + key + "': the robot has no link '" + name + "'" + did_you_mean(name, known),
        name.empty() ? "name a link of the robot" : "");
  return link;
}

void AdmittanceController::make_rule(ControllerContext& context) {
  Parameters& p = context.parameters;
  const std::string robot = joints_.front().facts.name.substr(0, joints_.front().facts.name.find('/'));
  const auto found = models().find(robot);
  if (found == models().end())
    throw Error("no-robot", "nothing is known of the kinematics of the robot '" + robot + "'");
  const description::RobotModel& model = *found->second;
  std::string unused;
  for (const char* key : {"kinematics.plugin_name", "kinematics.plugin_package"})
    p.read(key, unused, {"no effect: the kinematics is that of the robot's description"});
  AdmittanceFrames frames;
  frames.base = link_of(p, model, "kinematics.base", true);
  link_of(p, model, "kinematics.tip", false);
  frames.sensor = link_of(p, model, "ft_sensor.frame.id", false);
  frames.control = link_of(p, model, "control.frame.id", false);
  frames.world = link_of(p, model, "fixed_world_frame.frame.id", true);
  frames.gravity = link_of(p, model, "gravity_compensation.frame.id", false);
  if (p.problems().has_errors()) return;
  base_frame_ = model.links[static_cast<std::size_t>(frames.base)].name;
  sensor_frame_ = model.links[static_cast<std::size_t>(frames.sensor)].name;
  std::vector<std::string> actuated;
  for (const int joint : model.actuated)
    actuated.push_back(robot + "/" + model.joints[static_cast<std::size_t>(joint)].name);
  std::vector<std::size_t> places;
  for (const JointPort& joint : joints_) {
    places.push_back(place_among(actuated, joint.facts.name));
    if (places.back() >= actuated.size())
      throw Error("bad-value", "the joint '" + joint.facts.name + "' is not of the robot '" + robot + "'",
                  "all joints of an admittance controller belong to one robot");
  }
  rule_ = std::make_unique<AdmittanceRule>(model, frames, std::move(places));
  rule_->set(parameters_);
}

void AdmittanceController::make_output() {
  std::vector<std::string> fields;
  const auto add = [&](const std::vector<std::string>& more) {
    fields.insert(fields.end(), more.begin(), more.end());
  };
  for (const char* list : {"mass.data", "damping.data", "stiffness.data", "selected_axes.data"})
    add(six_of(list));
  add(turn_of("rot_base_control"));
  add(transform_of("ref_trans_base_ft"));
  add(transform_of("admittance_position"));
  add(twist_of("admittance_acceleration"));
  add(twist_of("admittance_velocity"));
  add(under("wrench_base.wrench", {"force.x", "force.y", "force.z", "torque.x", "torque.y", "torque.z"}));
  for (const char* list : {"position", "velocity", "effort"})
    for (std::size_t i = 0; i < joints_.size(); ++i)
      fields.push_back(std::string("joint_state.") + list + "[" + std::to_string(i) + "]");
  status_ = &add_output("status", "control_msgs/AdmittanceControllerState", std::move(fields));
  status_->texts["frame_id"] = base_frame_;
}

CallbackReturn AdmittanceController::on_configure(ControllerContext& context) {
  Parameters& p = context.parameters;
  parameters_ = {};
  bool changes = true;
  p.read("enable_parameter_update_without_reactivation", changes,
         {"no effect: parameters marked changeable can always be changed"});
  p.superseded("robot_description", "the cell knows the robot");
  read_axes(p);
  read_gravity(p);
  collect(p.problems(), [&] { read_joints(context); });
  collect(p.problems(), [&] { read_sensor_ports(context); });
  if (!joints_.empty()) collect(p.problems(), [&] { make_rule(context); });
  if (p.problems().has_errors()) return CallbackReturn::failure;
  make_output();
  on_parameters_changed();
  for (auto* values : {&measured_, &reference_, &reference_velocity_, &last_command_})
    values->assign(joints_.size(), 0.0);
  points_inbox_.reset({});
  wrench_inbox_.reset({});
  return CallbackReturn::success;
}

}  // namespace polyarm::controllers
