/// Reads robots/<maker>/<model>.yaml into a model.
#include <algorithm>
#include <cmath>

#include "polyarm/base/text.hpp"
#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/catalogue/kinematic_table.hpp"
#include "polyarm/description/look.hpp"
#include "polyarm/description/model_builder.hpp"
#include "polyarm/yaml/yaml.hpp"

namespace polyarm::description {

namespace fs = std::filesystem;

namespace {

JointType type_of(const Yaml& yaml) {
  const std::string text = yaml.text();
  for (const JointType type :
       {JointType::fixed, JointType::revolute, JointType::continuous, JointType::prismatic})
    if (text == name(type)) return type;
  throw Error(Problem{"bad-value", yaml.where(), "'" + text + "' is not a joint type",
                      "fixed, revolute, continuous or prismatic"});
}

std::optional<double> optional_number(const Yaml& yaml, Dimension dimension) {
  if (!yaml.defined()) return std::nullopt;
  return yaml.number(dimension);
}

/// The same for values that must be positive.
std::optional<double> optional_positive(const Yaml& yaml, Dimension dimension) {
  const auto value = optional_number(yaml, dimension);
  if (value && !(*value > 0))
    throw Error(Problem{"bad-value", yaml.where(), "'" + yaml.text() + "' must be above zero", {}});
  return value;
}

/// A position. It must be within a kilometre, so that nothing overflows later.
Vec3 place(const Yaml& yaml) {
  const Vec3 out = yaml.vec3();
  if (!(std::max({std::abs(out.x), std::abs(out.y), std::abs(out.z)}) < 1000))
    throw Error(Problem{"bad-value", yaml.where(), "a robot is smaller than a kilometre", "write metres"});
  return out;
}

Vec3 read_axis(const Yaml& yaml) {
  const Vec3 given = yaml.vec3(Dimension::none);
  const double length = std::hypot(given.x, given.y, given.z);
  if (!(length > 1e-9) || !std::isfinite(length))
    throw Error(Problem{"zero-axis", yaml.where(), "the axis has no direction", "write [0, 0, 1]"});
  return normalized(Vec3{given.x / length, given.y / length, given.z / length});
}

JointLimits read_limits(const Yaml& yaml, bool slides) {
  const Dimension place = slides ? Dimension::length : Dimension::angle;
  JointLimits out;
  out.lower = optional_number(yaml["lower"], place);
  out.upper = optional_number(yaml["upper"], place);
  if (out.lower && out.upper && !(*out.lower < *out.upper))
    throw Error(Problem{
        "bad-limit",
        yaml["lower"].where(),
        "the lower limit " + yaml["lower"].text() + " is not below the upper limit " + yaml["upper"].text(),
        {}});
  out.velocity = optional_positive(yaml["velocity"], slides ? Dimension::speed : Dimension::angular_speed);
  out.effort = optional_positive(yaml["effort"], slides ? Dimension::force : Dimension::torque);
  out.acceleration = optional_positive(yaml["acceleration"],
                                       slides ? Dimension::acceleration : Dimension::angular_acceleration);
  out.jerk = optional_positive(yaml["jerk"], Dimension::none);
  return out;
}

/// Reads the data of a joint apart from its position.
void read_joint_facts(const Yaml& yaml, Joint& joint) {
  joint.limits = read_limits(yaml, joint.type == JointType::prismatic);
  joint.damping = yaml["damping"].number(Dimension::none, 0);
  joint.friction = yaml["friction"].number(Dimension::none, 0);
}

const std::vector<std::string> kJointFacts{"name",   "type",         "lower", "upper",   "velocity",
                                           "effort", "acceleration", "jerk",  "damping", "friction"};

NamedJoint read_joint(const Yaml& yaml, Problems& problems) {
  std::vector<std::string> known = kJointFacts;
  known.insert(known.end(), {"parent", "child", "xyz", "rpy", "axis"});
  yaml.check_keys(known, problems);
  NamedJoint out;
  out.where = yaml.where();
  out.joint.name = yaml.required("name").text();
  out.joint.type = type_of(yaml.required("type"));
  out.parent = yaml.required("parent").text();
  out.child = yaml.required("child").text();
  out.joint.origin = yaml.pose();
  if (yaml.has("rpy")) {
    const std::vector<Yaml> angles = yaml["rpy"].items();  // pose() has checked that they are three
    Vec3 rpy{angles[0].number(Dimension::angle), angles[1].number(Dimension::angle),
             angles[2].number(Dimension::angle)};
    if (settle_angles(rpy)) out.joint.origin.rotation = from_rpy(rpy.x, rpy.y, rpy.z);
  }
  if (yaml.has("xyz")) place(yaml["xyz"]);
  if (yaml.has("axis")) out.joint.axis = read_axis(yaml["axis"]);
  read_joint_facts(yaml, out.joint);
  return out;
}

/// Adds a link that a table implies, if it does not exist.
void imply_link(RobotModel& model, const std::string& name) {
  if (model.find_link(name) >= 0) return;
  model.links.emplace_back();
  model.links.back().name = name;
}

void add_fixed(std::vector<NamedJoint>& joints, const std::string& parent, const std::string& child,
               const Pose& origin, const Location& where) {
  NamedJoint out;
  out.where = where;
  out.joint.name = parent + "-" + child;
  out.parent = parent;
  out.child = child;
  out.joint.origin = origin;
  joints.push_back(std::move(out));
}

/// Reads the joints and links of a Denavit-Hartenberg or screw table. Adds flange and tool0 at its end.
std::vector<NamedJoint> read_table_joints(const Yaml& yaml, RobotModel& model, Problems& problems) {
  const TableKind kind = table_kind(yaml["kinematics"]);
  const Yaml rows = yaml.required("joints");
  std::vector<NamedJoint> out;
  const KinematicTable table = read_table(kind, rows, yaml["flange"], problems);
  if (problems.has_errors()) return out;
  std::vector<std::string> known = kJointFacts;
  known.emplace_back("link");
  known.insert(known.end(), table_keys(kind).begin(), table_keys(kind).end());
  std::string parent = yaml["base"].text("base_link");
  imply_link(model, parent);
  for (const Yaml& row : rows.items()) {
    row.check_keys(known, problems);
    const std::string number = std::to_string(out.size() + 1);
    NamedJoint joint;
    joint.where = row.where();
    joint.joint.name = row["name"].text("joint_" + number);
    joint.joint.type = table.joints[out.size()].type;
    joint.joint.origin = table.joints[out.size()].origin;
    joint.joint.axis = table.joints[out.size()].axis;
    joint.parent = parent;
    joint.child = parent = row["link"].text("link_" + number);
    read_joint_facts(row, joint.joint);
    imply_link(model, parent);
    out.push_back(std::move(joint));
  }
  for (const char* frame : {"flange", "tool0"}) {
    imply_link(model, frame);
    add_fixed(out, parent, frame, table.flange, yaml["joints"].where());
  }
  return out;
}

Shape capsule_between(const Vec3& from, const Vec3& to, double radius) {
  Shape out;
  out.kind = ShapeKind::capsule;
  out.radius = radius;
  out.length = norm(to - from);
  out.pose.position = 0.5 * (from + to);
  if (out.length > 1e-9) out.pose.rotation = rotation_between({0, 0, 1}, (1 / out.length) * (to - from));
  return out;
}

Inertial read_inertial(const Yaml& yaml) {
  Inertial out;
  out.mass = *optional_positive(yaml["mass"], Dimension::mass);
  if (yaml.has("com")) out.center = place(yaml["com"]);
  const std::vector<double> tensor = yaml["inertia"].numbers();
  if (!tensor.empty() && tensor.size() != out.inertia.size())
    throw Error(Problem{"bad-value", yaml["inertia"].where(),
                        "an inertia has six numbers, here are " + std::to_string(tensor.size()),
                        "write [ixx, ixy, ixz, iyy, iyz, izz]"});
  std::copy(tensor.begin(), tensor.end(), out.inertia.begin());
  return out;
}

Outline read_outline(const Yaml& yaml, Problems& problems) {
  yaml.check_keys({"from", "to"}, problems);
  const Outline out{place(yaml.required("from")), place(yaml.required("to"))};
  const Vec3 size = out.upper - out.lower;
  if (!(std::min({size.x, size.y, size.z}) >= 0))
    throw Error(Problem{"bad-value", yaml.where(), "the box ends before it begins",
                        "write the smaller of each pair of coordinates in 'from'"});
  return out;
}

Link read_link(const Yaml& yaml, Problems& problems) {
  yaml.check_keys({"name", "mass", "com", "inertia", "capsule", "box"}, problems);
  Link out;
  out.name = yaml.required("name").text();
  if (yaml.has("mass")) out.inertial = read_inertial(yaml);
  if (const Yaml capsule = yaml["capsule"]; capsule.defined()) {
    capsule.check_keys({"from", "to", "radius"}, problems);
    capsule.required("radius");
    out.collisions.push_back(capsule_between(place(capsule.required("from")), place(capsule.required("to")),
                                             *optional_positive(capsule["radius"], Dimension::length)));
    out.visuals = out.collisions;
  }
  if (yaml.has("box")) out.outline = read_outline(yaml["box"], problems);
  return out;
}

void read_provenance(const Yaml& yaml, RobotModel& model) {
  Provenance& p = model.provenance;
  p.maker = yaml["maker"].text("");
  p.model = yaml["model"].text("");
  p.source = yaml["source"].text("");
  p.licence = yaml["licence"].text("");
  p.payload_kg = optional_number(yaml["payload"], Dimension::mass);
  p.reach_m = optional_number(yaml["reach"], Dimension::length);
  p.notes = yaml["notes"].texts();
}

/// Reads a joint's value; it must be within the joint's limits.
double read_joint_value(const Yaml& yaml, const Joint& joint) {
  const double value = yaml.number(joint.type == JointType::prismatic ? Dimension::length : Dimension::angle);
  if (value < joint.limits.lower.value_or(value) || value > joint.limits.upper.value_or(value))
    throw Error(Problem{
        "beyond-limit", yaml.where(), joint.name + ": " + yaml.text() + " is beyond the joint's limits", {}});
  return value;
}

void read_named_states(const Yaml& yaml, RobotModel& model, Problems& problems) {
  const std::vector<std::string> names = model.joint_names();
  for (const std::string& state : yaml.keys()) {
    std::vector<double> values(names.size(), 0.0);
    for (const std::string& joint : yaml[state].keys()) {
      const auto found = std::find(names.begin(), names.end(), joint);
      if (found == names.end()) {
        problems.error("unknown-joint", yaml[state].key_location(joint),
                       "there is no joint '" + joint + "'" + did_you_mean(joint, names));
        continue;
      }
      const auto at = static_cast<std::size_t>(found - names.begin());
      values[at] =
          read_joint_value(yaml[state][joint], model.joints[static_cast<std::size_t>(model.actuated[at])]);
    }
    model.named_states[state] = values;
  }
}

/// The actuated joint `name`; -1 and a problem if there is none.
int actuated_joint(const std::string& name, const Location& where, const RobotModel& model,
                   Problems& problems) {
  const std::vector<std::string> names = model.joint_names();
  const auto found = std::find(names.begin(), names.end(), name);
  if (found != names.end()) return static_cast<int>(found - names.begin());
  problems.error("unknown-joint", where,
                 "there is no joint '" + name + "' with a value of its own" + did_you_mean(name, names));
  return -1;
}

ControllerAxis read_controller_axis(const Yaml& yaml, bool slides, const RobotModel& model,
                                    Problems& problems) {
  yaml.check_keys({"sign", "offset", "coupling"}, problems);
  ControllerAxis out;
  out.sign = yaml["sign"].number(Dimension::none, 1);
  if (std::abs(out.sign) != 1)
    throw Error(Problem{"bad-value", yaml["sign"].where(), "a sign is 1 or -1", {}});
  out.offset = yaml["offset"].number(slides ? Dimension::length : Dimension::angle, 0);
  for (const Yaml::Entry& entry : yaml["coupling"].entries())
    out.coupling.push_back(
        {actuated_joint(entry.key, entry.where, model, problems), entry.value.number(Dimension::none)});
  return out;
}

/// Reads how the maker's controller displays the joints. Joints that `display` does not name show their own
/// value.
void read_controller_axes(const Yaml& yaml, RobotModel& model, Problems& problems) {
  if (!yaml.defined()) return;
  yaml.check_keys({"source", "display"}, problems);
  model.provenance.controller_axes = yaml.required("source").text();
  model.controller_axes.resize(model.actuated.size());
  for (const Yaml::Entry& entry : yaml["display"].entries())
    if (const int at = actuated_joint(entry.key, entry.where, model, problems); at >= 0) {
      const auto i = static_cast<std::size_t>(at);
      const JointType type = model.joints[static_cast<std::size_t>(model.actuated[i])].type;
      model.controller_axes[i] =
          read_controller_axis(entry.value, type == JointType::prismatic, model, problems);
    }
}

void read_allowed(const Yaml& yaml, RobotModel& model, Problems& problems) {
  for (const Yaml& pair : yaml.items()) {
    const std::vector<std::string> names = pair.texts();
    if (names.size() != 2) {
      problems.error("bad-value", pair.where(), "a pair of links is expected here");
      continue;
    }
    std::array<int, 2> links{model.find_link(names[0]), model.find_link(names[1])};
    if (links[0] < 0 || links[1] < 0)
      problems.error("unknown-link", pair.where(), "'" + names[links[0] < 0 ? 0 : 1] + "' is not a link");
    else
      model.allowed_collisions.push_back({std::min(links[0], links[1]), std::max(links[0], links[1])});
  }
}

/// The surfaces of MODEL.yaml are in MODEL.look beside it. The robot file itself cannot name another file.
void find_measured_look(const fs::path& robot_file, RobotModel& model) {
  model.look.erase(kMeasuredLook);
  const fs::path look = fs::path(robot_file).replace_extension(".look");
  std::error_code ignored;
  if (fs::is_regular_file(look, ignored)) model.look[kMeasuredLook] = look.string();
}

}  // namespace

RobotModel read_robot_file(const fs::path& path) {
  const Yaml yaml = Yaml::load(path.string());
  Problems problems;
  const std::string kind = yaml["polyarm"].text("");
  if (kind != "robot/1")
    throw Error(Problem{"wrong-kind",
                        yaml.where(),
                        kind.empty() ? "this is not a robot file: the line 'polyarm: robot/1' is missing"
                                     : "this is a '" + kind + "' file, a robot/1 was expected",
                        {}});
  yaml.check_keys(
      {"polyarm", "maker", "model", "payload", "reach", "source", "licence", "notes", "joints", "links",
       "named_states", "allowed_collisions", "controller_axes", "kinematics", "base", "flange", "look"},
      problems);
  RobotModel model;
  model.name = path.stem().string();
  std::vector<NamedJoint> joints;
  const auto attempt = [&](auto step) {
    try {
      step();
    } catch (const Error& e) {
      problems.add(e);
    }
  };
  attempt([&] { read_provenance(yaml, model); });
  for (const Yaml& link : yaml["links"].items())
    attempt([&] { model.links.push_back(read_link(link, problems)); });
  for (const std::string& key : yaml["look"].keys())
    attempt([&] { model.look[key] = yaml["look"][key].text(); });
  find_measured_look(path, model);
  const bool is_table = yaml.has("kinematics");
  if (is_table) attempt([&] { joints = read_table_joints(yaml, model, problems); });
  for (const Yaml& joint : is_table ? std::vector<Yaml>{} : yaml["joints"].items())
    attempt([&] { joints.push_back(read_joint(joint, problems)); });
  if (!problems.has_errors() && tie_together(model, std::move(joints), {path.string()}, problems, problems)) {
    attempt([&] { read_named_states(yaml["named_states"], model, problems); });
    attempt([&] { read_allowed(yaml["allowed_collisions"], model, problems); });
    attempt([&] { read_controller_axes(yaml["controller_axes"], model, problems); });
  }
  problems.throw_if_errors();
  const bool shaped = std::any_of(model.links.begin(), model.links.end(),
                                  [](const Link& link) { return !link.collisions.empty(); });
  if (is_table && !shaped) derive_shapes(model);
  complete_inertials(model, problems);
  return model;
}

}  // namespace polyarm::description
