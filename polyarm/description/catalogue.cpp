#include "polyarm/description/catalogue.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <set>

#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/base/yaml.hpp"
#include "polyarm/description/model_builder.hpp"
#include "polyarm/description/srdf.hpp"
#include "polyarm/description/urdf.hpp"
#include "polyarm/description/xacro.hpp"

namespace polyarm::description {

namespace fs = std::filesystem;

namespace {

JointType type_of(const Yaml& yaml) {
  const std::string text = yaml.text();
  for (const JointType type :
       {JointType::fixed, JointType::revolute, JointType::continuous, JointType::prismatic})
    if (text == name(type)) return type;
  throw Error(Problem{"bad-value", yaml.where(), "'" + text + "' is no joint type",
                      "fixed, revolute, continuous or prismatic"});
}

std::optional<double> optional_number(const Yaml& yaml, Dimension dimension) {
  if (!yaml.defined()) return std::nullopt;
  return yaml.number(dimension);
}

/// The same for what makes no sense unless it is above zero.
std::optional<double> optional_positive(const Yaml& yaml, Dimension dimension) {
  const auto value = optional_number(yaml, dimension);
  if (value && !(*value > 0))
    throw Error(Problem{"bad-value", yaml.where(), "'" + yaml.text() + "' must be above zero", {}});
  return value;
}

/// Places within a kilometre: nothing that follows overflows.
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

NamedJoint read_joint(const Yaml& yaml, Problems& problems) {
  yaml.check_keys({"name", "type", "parent", "child", "xyz", "rpy", "axis", "lower", "upper", "velocity",
                   "effort", "acceleration", "jerk", "damping", "friction"},
                  problems);
  NamedJoint out;
  out.where = yaml.where();
  out.joint.name = yaml.required("name").text();
  out.joint.type = type_of(yaml.required("type"));
  out.parent = yaml.required("parent").text();
  out.child = yaml.required("child").text();
  out.joint.origin = yaml.pose();
  if (yaml.has("xyz")) place(yaml["xyz"]);
  if (yaml.has("axis")) out.joint.axis = read_axis(yaml["axis"]);
  out.joint.limits = read_limits(yaml, out.joint.type == JointType::prismatic);
  out.joint.damping = yaml["damping"].number(Dimension::none, 0);
  out.joint.friction = yaml["friction"].number(Dimension::none, 0);
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

Link read_link(const Yaml& yaml, Problems& problems) {
  yaml.check_keys({"name", "mass", "com", "inertia", "capsule"}, problems);
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

/// The joint's value, which has to be within its limits.
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

void read_allowed(const Yaml& yaml, RobotModel& model, Problems& problems) {
  for (const Yaml& pair : yaml.items()) {
    const std::vector<std::string> names = pair.texts();
    if (names.size() != 2) {
      problems.error("bad-value", pair.where(), "a pair of links is expected here");
      continue;
    }
    std::array<int, 2> links{model.find_link(names[0]), model.find_link(names[1])};
    if (links[0] < 0 || links[1] < 0)
      problems.error("unknown-link", pair.where(), "'" + names[links[0] < 0 ? 0 : 1] + "' is no link");
    else
      model.allowed_collisions.push_back({std::min(links[0], links[1]), std::max(links[0], links[1])});
  }
}

/// "universal_robots/ur3" from the last two parts of the path.
std::string name_of(const fs::path& file) {
  return file.parent_path().filename().string() + "/" + file.stem().string();
}

/// What is in a folder; nothing where it cannot be listed.
std::vector<fs::path> content_of(const fs::path& folder) {
  std::vector<fs::path> out;
  std::error_code error;
  for (auto it = fs::directory_iterator(folder, error); !error && it != fs::directory_iterator();
       it.increment(error))
    out.push_back(it->path());
  return out;
}

std::vector<fs::path> robot_files(const std::vector<fs::path>& folders) {
  std::vector<fs::path> out;
  std::set<std::string> seen;
  for (const fs::path& folder : folders)
    for (const fs::path& maker : content_of(folder))
      for (const fs::path& file : content_of(maker))
        if (file.extension() == ".yaml" && seen.insert(name_of(file)).second) out.push_back(file);
  std::sort(out.begin(), out.end(),
            [](const fs::path& a, const fs::path& b) { return name_of(a) < name_of(b); });
  return out;
}

}  // namespace

RobotModel read_robot_file(const fs::path& path) {
  const Yaml yaml = Yaml::load(path.string());
  Problems problems;
  const std::string kind = yaml["polyarm"].text("");
  if (kind != "robot/1")
    throw Error(Problem{"wrong-kind",
                        yaml.where(),
                        kind.empty() ? "this is not a robot file: it does not say 'polyarm: robot/1'"
                                     : "this is a '" + kind + "' file, a robot/1 was expected",
                        {}});
  yaml.check_keys({"polyarm", "maker", "model", "payload", "reach", "source", "licence", "notes", "joints",
                   "links", "named_states", "allowed_collisions"},
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
  for (const Yaml& joint : yaml["joints"].items())
    attempt([&] { joints.push_back(read_joint(joint, problems)); });
  if (!problems.has_errors() && tie_together(model, std::move(joints), {path.string()}, problems)) {
    attempt([&] { read_named_states(yaml["named_states"], model, problems); });
    attempt([&] { read_allowed(yaml["allowed_collisions"], model, problems); });
  }
  problems.throw_if_errors();
  complete_inertials(model, problems);
  return model;
}

std::vector<CatalogueEntry> Catalogue::entries() const {
  std::vector<CatalogueEntry> out;
  for (const fs::path& file : robot_files(folders_)) {
    const RobotModel model = read_robot_file(file);
    out.push_back({name_of(file), model.provenance.maker, model.provenance.model,
                   static_cast<int>(model.actuated.size()), model.provenance.reach_m,
                   model.provenance.payload_kg, file});
  }
  return out;
}

std::vector<std::string> Catalogue::names() const {
  std::vector<std::string> out;
  for (const fs::path& file : robot_files(folders_)) out.push_back(name_of(file));
  return out;
}

RobotModel Catalogue::load(const std::string& wanted) const {
  std::vector<fs::path> matches;
  std::vector<std::string> all;
  for (const fs::path& file : robot_files(folders_)) {
    all.push_back(name_of(file));
    if (name_of(file) == wanted) return read_robot_file(file);
    if (equal_ignoring_case(file.stem().string(), wanted)) matches.push_back(file);
    all.push_back(file.stem().string());
  }
  if (matches.size() == 1) return read_robot_file(matches.front());
  if (all.empty())
    throw Error("no-catalogue", "the catalogue of robots was not found",
                "set POLYARM_ROBOTS to the folder robots/ of Polyarm");
  throw Error("unknown-robot", "there is no robot '" + wanted + "'" + did_you_mean(wanted, all),
              "`polyarm robots` lists them; a path to a .urdf file works too");
}

std::vector<fs::path> default_catalogue_folders() {
  std::vector<fs::path> out;
  if (const char* from_user = std::getenv("POLYARM_ROBOTS"))
    for (const std::string& folder : split_words(from_user, ":")) out.emplace_back(folder);
  std::error_code error;
  fs::path here = fs::read_symlink("/proc/self/exe", error).parent_path();
  for (int up = 0; up < 5 && !here.empty(); ++up, here = here.parent_path())
    for (const fs::path& folder : {here / "robots", here / "share" / "polyarm" / "robots"})
      if (fs::is_directory(folder / "universal_robots", error)) out.push_back(folder);
  return out;
}

void add_srdf_beside(const fs::path& description, RobotModel& model, Problems& warnings) {
  const fs::path file = srdf_beside(description);
  std::error_code error;
  if (!fs::is_regular_file(file, error)) return;
  Problems problems;
  read_srdf(read_file(file), file.string(), model, problems);
  problems.throw_if_errors();
  for (const Problem& warning : problems.list()) warnings.add(warning);
}

/// A description file, expanded first where it is xacro; places then are those of the expanded text.
static RobotModel read_description(const fs::path& path, Problems& warnings,
                                   const std::map<std::string, std::string>& arguments) {
  const std::string text = read_file(path);
  if (!uses_xacro(text)) return read_urdf(text, path.string(), warnings);
  const std::string expanded = expand_xacro_text(text, path, {arguments, {}}, warnings);
  return read_urdf(expanded, path.string() + " (expanded)", warnings);
}

RobotModel load_robot(const std::string& name_or_path, const Catalogue& catalogue, Problems& warnings,
                      const std::map<std::string, std::string>& arguments) {
  const fs::path path = name_or_path;
  std::error_code error;
  const std::string extension = path.extension().string();
  if (extension == ".yaml" && fs::exists(path, error)) return read_robot_file(path);
  if (is_launch_file(path) && fs::is_regular_file(path, error))
    throw Error("launch-file", path.string() + " is a launch file of ROS, not a description",
                "type " + find_in_launch_file(read_file(path)).line());
  if (fs::is_regular_file(path, error) || extension == ".urdf" || extension == ".xacro" ||
      extension == ".xml") {
    RobotModel model = read_description(path, warnings, arguments);
    add_srdf_beside(path, model, warnings);
    return model;
  }
  return catalogue.load(name_or_path);
}

}  // namespace polyarm::description
