#include "polyarm/ros_files/message_forms.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>

#include "polyarm/base/text.hpp"
#include "polyarm/ros_files/message_parts.hpp"
#include "polyarm/ros_files/trajectory_file.hpp"
#include "polyarm/yaml/yaml.hpp"

namespace polyarm::ros_files {

using controllers::Input;

namespace {

[[noreturn]] void refuse(const Yaml& at, std::string what, std::string advice = {}) {
  throw Error(Problem{"bad-message", at.where(), std::move(what), std::move(advice)});
}

}  // namespace

void check_keys(const Yaml& yaml, const std::vector<std::string>& known) {
  Problems problems;
  yaml.check_keys(known, problems);
  if (!problems.list().empty()) throw Error(problems.list());
}

double seconds_of(const Yaml& yaml, double fallback) {
  if (!yaml.defined()) return fallback;
  if (!yaml.is_map()) return yaml.number();
  check_keys(yaml, {"sec", "nanosec", "secs", "nsecs"});
  double out = 0;
  for (const auto& [whole, part] : {std::pair{"sec", "nanosec"}, {"secs", "nsecs"}}) {
    if (yaml.has(whole)) out += yaml[whole].number();
    if (yaml.has(part)) out += yaml[part].number() * 1e-9;
  }
  return out;
}

std::optional<Nanoseconds> stamp_of(const Yaml& header) {
  const double stamp = seconds_of(header["stamp"]);
  if (stamp == 0) return std::nullopt;
  if (!(stamp > 0 && stamp < 9e9)) refuse(header["stamp"], "the stamp is not a time", "0 means now");
  return nanoseconds(stamp);
}

namespace {

void require_map(const Yaml& yaml, const char* what, const char* example) {
  if (!yaml.is_map()) refuse(yaml, std::string("this is not a ") + what, std::string("write ") + example);
}

std::vector<controllers::JointTolerance> tolerances_of(const Yaml& yaml) {
  std::vector<controllers::JointTolerance> out;
  for (const Yaml& item : yaml.items()) {
    require_map(item, "tolerance", "{name: joint_1, position: 0.01}");
    check_keys(item, {"name", "position", "velocity", "acceleration"});
    out.push_back({item.required("name").text(), item["position"].number(Dimension::none, 0),
                   item["velocity"].number(Dimension::none, 0),
                   item["acceleration"].number(Dimension::none, 0)});
  }
  return out;
}

Input goal_of(const Yaml& given) {
  const Yaml yaml = given.has("goal") ? given["goal"] : given;
  if (yaml.has("joint_names")) return trajectory_of(yaml);  // a trajectory without a goal around it is
                                                            // accepted
  check_keys(yaml, {"trajectory", "path_tolerance", "goal_tolerance", "goal_time_tolerance",
                    "component_path_tolerance", "component_goal_tolerance", "multi_dof_trajectory"});
  controllers::TrajectoryMessage out = trajectory_of(yaml.required("trajectory"));
  out.path_tolerance = tolerances_of(yaml["path_tolerance"]);
  out.goal_tolerance = tolerances_of(yaml["goal_tolerance"]);
  if (yaml.has("goal_time_tolerance")) out.goal_time_tolerance = seconds_of(yaml["goal_time_tolerance"]);
  return out;
}

/// One point, for a controller that knows its joints.
Input point_of(const Yaml& yaml) {
  check_keys(yaml, {"positions", "velocities", "accelerations", "effort", "time_from_start"});
  controllers::TrajectoryMessage out;
  trajectory::TrajectoryPoint& point = out.points.emplace_back();
  const auto list = [&](const char* key) {
    return yaml.has(key) ? yaml[key].numbers() : std::vector<double>{};
  };
  point.positions = list("positions");
  point.velocities = list("velocities");
  point.accelerations = list("accelerations");
  if (point.positions.empty() && point.velocities.empty())
    refuse(yaml, "the point has no positions", "write {positions: [0.1, 0.2]}");
  return out;
}

Vec3 vector_of(const Yaml& yaml) {
  if (!yaml.defined()) return {};
  if (!yaml.is_map()) return yaml.vec3(Dimension::none);
  check_keys(yaml, {"x", "y", "z"});
  const auto axis = [&](const char* name) { return yaml[name].number(Dimension::none, 0); };
  return {axis("x"), axis("y"), axis("z")};
}

Input twist_of(const Yaml& yaml) {
  check_keys(yaml, {"header", "twist", "linear", "angular"});
  const Yaml twist = yaml.has("twist") ? yaml["twist"] : yaml;
  if (!twist.has("linear") && !twist.has("angular"))
    refuse(yaml, "the twist has neither linear nor angular", "write {linear: {x: 0.2}, angular: {z: 0.1}}");
  controllers::Twist out{vector_of(twist["linear"]), vector_of(twist["angular"]), {}};
  if (yaml.has("twist")) out.stamp = stamp_of(yaml["header"]).value_or(0);
  return out;
}

/// force.x … torque.z; a frame is one more name, "frame_id=NAME".
Input wrench_of(const Yaml& yaml) {
  check_keys(yaml, {"header", "wrench", "force", "torque"});
  const Yaml wrench = yaml.has("wrench") ? yaml["wrench"] : yaml;
  if (!wrench.has("force") && !wrench.has("torque"))
    refuse(yaml, "the wrench has neither force nor torque", "write {force: {z: -5}}");
  const Vec3 force = vector_of(wrench["force"]), torque = vector_of(wrench["torque"]);
  controllers::NamedValues out{{"force.x", "force.y", "force.z", "torque.x", "torque.y", "torque.z"},
                               {force.x, force.y, force.z, torque.x, torque.y, torque.z}};
  if (!yaml.has("header") || !yaml["header"].has("frame_id")) return out;
  const std::string frame = yaml["header"]["frame_id"].text();
  if (!frame.empty()) out.names.push_back("frame_id=" + frame), out.values.push_back(0);
  return out;
}

Input numbers_of(const Yaml& yaml) {
  if (!yaml.is_map()) return controllers::Numbers{yaml.numbers()};
  check_keys(yaml, {"layout", "data", "factor", "header"});
  const char* key = yaml.has("factor") ? "factor" : "data";
  if (!yaml.has(key)) refuse(yaml, "the message has no data", "write {data: [1.0, 2.0]}, or {data: 1.0}");
  return controllers::Numbers{yaml[key].numbers()};
}

/// The pose of a mobile robot: {x, y, yaw}.
Input place_of(const Yaml& yaml) {
  if (!yaml.is_map()) refuse(yaml, "this is not a place", "write {x: 0, y: 0, yaw: 0}");
  check_keys(yaml, {"x", "y", "z", "roll", "pitch", "yaw"});
  const auto at = [&](const char* key) { return yaml[key].number(Dimension::none, 0); };
  return controllers::Numbers{{at("x"), at("y"), at("yaw")}};
}

void require_as_many(const Yaml& at, std::size_t names, const std::string& of, std::size_t values,
                     const std::string& what) {
  if (names != values)
    refuse(at, std::to_string(names) + " " + of + " do not match " + std::to_string(values) + " " + what);
}

/// {joint_names, interface_values: [{interface_names, values}]}
Input dynamic_of(const Yaml& yaml) {
  check_keys(yaml, {"header", "joint_names", "interface_groups", "interface_values"});
  const char* key = yaml.has("joint_names") ? "joint_names" : "interface_groups";
  const std::vector<std::string> joints = yaml.required(key).texts();
  const std::vector<Yaml> groups = yaml.required("interface_values").items();
  require_as_many(yaml, joints.size(), key, groups.size(), "interface_values");
  controllers::NamedValues out;
  for (std::size_t i = 0; i < groups.size(); ++i) {
    check_keys(groups[i], {"interface_names", "values"});
    const std::vector<std::string> interfaces = groups[i]["interface_names"].texts();
    const std::vector<double> values = groups[i]["values"].numbers();
    require_as_many(groups[i], interfaces.size(), "interface_names", values.size(), "values");
    for (std::size_t k = 0; k < values.size(); ++k) {
      out.names.push_back(joints[i] + "/" + interfaces[k]);
      out.values.push_back(values[k]);
    }
  }
  return out;
}

/// {dof_names, values, values_dot}
Input dofs_of(const Yaml& yaml) {
  check_keys(yaml, {"header", "dof_names", "values", "values_dot"});
  const std::vector<std::string> names = yaml.required("dof_names").texts();
  controllers::NamedValues out;
  for (const auto& [key, ending] : {std::pair{"values", ""}, {"values_dot", "/dot"}}) {
    const std::vector<double> values = yaml[key].numbers();
    if (!values.empty()) require_as_many(yaml[key], names.size(), "dof_names", values.size(), key);
    for (std::size_t k = 0; k < values.size(); ++k) {
      out.names.push_back(names[k] + ending);
      out.values.push_back(values[k]);
    }
  }
  return out;
}

/// DynamicJointState or MultiDOFCommand, or a plain map of name to value.
Input named_of(const Yaml& yaml) {
  require_map(yaml, "message of named values", "{joint_1/position: 0.1}");
  if (yaml.has("interface_values") || yaml.has("joint_names") || yaml.has("interface_groups"))
    return dynamic_of(yaml);
  if (yaml.has("dof_names")) return dofs_of(yaml);
  controllers::NamedValues out;
  for (const std::string& key : yaml.keys()) {
    out.names.push_back(key);
    out.values.push_back(yaml[key].number());
  }
  return out;
}

Input gripper_of(const Yaml& given) {
  const Yaml outer = given.has("goal") ? given["goal"] : given;
  const Yaml yaml = outer.has("command") ? outer["command"] : outer;
  controllers::GripperCommand out;
  if (yaml["position"].is_list()) {  // ParallelGripperCommand: a JointState
    check_keys(yaml, {"header", "name", "position", "velocity", "effort"});
    const auto first = [&](const char* key) -> std::optional<double> {
      const std::vector<double> values = yaml[key].numbers();
      return values.empty() ? std::nullopt : std::optional(values.front());
    };
    const auto position = first("position");
    if (!position) refuse(yaml["position"], "the command has no position");
    out = {*position, first("velocity"), first("effort")};
    return out;
  }
  check_keys(yaml, {"position", "max_effort", "max_velocity"});
  out.position = yaml.required("position").number();
  if (yaml.has("max_effort")) out.max_effort = yaml["max_effort"].number();
  if (yaml.has("max_velocity")) out.max_velocity = yaml["max_velocity"].number();
  return out;
}

struct Form {
  const char* type;
  Input (*read)(const Yaml&);
};

constexpr Form kForms[] = {
    {"trajectory_msgs/JointTrajectory", [](const Yaml& y) -> Input { return trajectory_of(y); }},
    {"control_msgs/FollowJointTrajectory", goal_of},
    {"trajectory_msgs/JointTrajectoryPoint", point_of},
    {"geometry_msgs/WrenchStamped", wrench_of},
    {"geometry_msgs/Twist", twist_of},
    {"geometry_msgs/TwistStamped", twist_of},
    {"std_msgs/Float64MultiArray", numbers_of},
    {"std_msgs/Float64", numbers_of},
    {"control_msgs/SpeedScalingFactor", numbers_of},
    {"control_msgs/SetOdometry", place_of},
    {"std_srvs/Empty", [](const Yaml&) -> Input { return controllers::Numbers{}; }},
    {"control_msgs/DynamicJointState", named_of},
    {"control_msgs/DynamicInterfaceGroupValues", named_of},
    {"control_msgs/MultiDOFCommand", named_of},
    {"control_msgs/GripperCommand", gripper_of},
    {"control_msgs/ParallelGripperCommand", gripper_of},
};

nlohmann::json number(double value) {
  if (!std::isfinite(value)) return nullptr;
  return value;
}

/// "pose.position.x": value → {"pose": {"position": {"x": value}}}; "covariance[3]" → an array, filled with
/// zeros.
void put(nlohmann::json& out, const std::string& field, double value) {
  nlohmann::json* at = &out;
  const std::vector<std::string> words = split_words(field, ".");
  for (const std::string& word : words) {
    const bool last = &word == &words.back();
    const auto bracket = word.find('[');
    at = &(*at)[word.substr(0, bracket)];
    if (bracket == std::string::npos) continue;
    const double index = parse_number(word.substr(bracket + 1, word.size() - bracket - 2)).value_or(0);
    while (at->size() <= static_cast<std::size_t>(index))
      at->push_back(last ? nlohmann::json(0.0) : nlohmann::json::object());
    at = &(*at)[static_cast<std::size_t>(index)];
  }
  *at = number(value);
}

using Fields = std::vector<std::string>;
using Values = std::vector<double>;

/// Three fields per joint.
void joint_states(nlohmann::json& out, const Fields& fields, const Values& values) {
  for (const char* key : {"name", "position", "velocity", "effort"}) out[key] = nlohmann::json::array();
  for (std::size_t i = 0; i + 2 < fields.size(); i += 3) {
    out["name"].push_back(fields[i].substr(0, fields[i].rfind('/')));
    for (std::size_t k = 0; const char* quantity : {"position", "velocity", "effort"})
      out[quantity].push_back(number(values[i + k++]));
  }
}

/// "joint/interface" fields, grouped by joint.
void dynamic_joint_states(nlohmann::json& out, const Fields& fields, const Values& values) {
  nlohmann::json names = nlohmann::json::array(), groups = nlohmann::json::array();
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const auto slash = fields[i].rfind('/');
    const std::string joint = slash == std::string::npos ? "" : fields[i].substr(0, slash);
    const auto found = std::find(names.begin(), names.end(), joint);
    const auto place = static_cast<std::size_t>(found - names.begin());
    if (found == names.end()) {
      names.push_back(joint);
      groups.push_back({{"interface_names", nlohmann::json::array()}, {"values", nlohmann::json::array()}});
    }
    groups[place]["interface_names"].push_back(fields[i].substr(slash + 1));
    groups[place]["values"].push_back(number(values[i]));
  }
  out["joint_names"] = names;
  out["interface_values"] = groups;
}

void named_values(nlohmann::json& out, const Fields& fields, const Values& values) {
  out["names"] = fields;
  out["values"] = nlohmann::json::array();
  for (const double value : values) out["values"].push_back(number(value));
}

/// "<joint>.reference.position" … and "time_from_start", in the shape of JointTrajectoryControllerState: one
/// list per quantity. `output` holds the commands, one number per joint.
void trajectory_state(nlohmann::json& out, const Fields& fields, const Values& values) {
  const std::vector<std::pair<std::string, std::vector<const char*>>> lists = {
      {".reference.position", {"reference", "positions"}},
      {".reference.velocity", {"reference", "velocities"}},
      {".reference.acceleration", {"reference", "accelerations"}},
      {".feedback.position", {"feedback", "positions"}},
      {".feedback.velocity", {"feedback", "velocities"}},
      {".error.position", {"error", "positions"}},
      {".error.velocity", {"error", "velocities"}},
      {".output", {"output"}}};
  out["joint_names"] = nlohmann::json::array();
  for (std::size_t i = 0; i < fields.size(); ++i) {
    if (fields[i] == "time_from_start") out["reference"]["time_from_start"] = number(values[i]);
    for (const auto& [ending, path] : lists) {
      if (!fields[i].ends_with(ending)) continue;
      nlohmann::json* at = &out;
      for (const char* word : path) at = &(*at)[word];
      at->push_back(number(values[i]));
      if (ending == ".output")
        out["joint_names"].push_back(fields[i].substr(0, fields[i].size() - ending.size()));
    }
  }
}

struct Shape {
  const char* type;
  void (*write)(nlohmann::json& out, const Fields& fields, const Values& values);
};

constexpr Shape kShapes[] = {
    {"sensor_msgs/JointState", joint_states},
    {"control_msgs/DynamicJointState", dynamic_joint_states},
    {"control_msgs/Float64Values", named_values},
    {"control_msgs/JointTrajectoryControllerState", trajectory_state},
};

}  // namespace

Input read_message(const std::string& text, const std::string& name, const std::vector<std::string>& types) {
  const Yaml yaml = Yaml::parse(text, name);
  std::vector<std::string> known;
  std::optional<Error> first;
  for (const std::string& type : types)
    for (const Form& form : kForms) {
      if (type != form.type) continue;
      known.push_back(type);
      try {
        return form.read(yaml);
      } catch (const Error& e) {
        if (!first) first = e;
      }
    }
  if (first) throw *first;
  throw Error("bad-message", name + " cannot be read as " + join(types, " or "));
}

std::vector<std::string> message_types() {
  std::vector<std::string> out;
  for (const Form& form : kForms) out.emplace_back(form.type);
  return out;
}

std::string message_json(const controllers::Output& output) {
  nlohmann::json out;
  const Nanoseconds time = output.value().time;
  out["header"]["stamp"] = {{"sec", time / 1'000'000'000}, {"nanosec", time % 1'000'000'000}};
  const auto shape = std::find_if(std::begin(kShapes), std::end(kShapes),
                                  [&](const Shape& s) { return output.type() == s.type; });
  if (shape != std::end(kShapes))
    shape->write(out, output.fields(), output.value().values);
  else
    for (std::size_t i = 0; i < output.fields().size(); ++i)
      put(out, output.fields()[i], output.value().values[i]);
  for (const auto& [key, text] : output.texts) {
    if (key == "frame_id")
      out["header"][key] = text;
    else
      out[key] = text;
  }
  return out.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace polyarm::ros_files
