#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string_view>
#include <utility>

#include "polyarm/base/text.hpp"
#include "polyarm/description/gazebo_reader.hpp"
#include "polyarm/description/model_builder.hpp"
#include "polyarm/description/ros2_control_reader.hpp"
#include "polyarm/description/urdf.hpp"

namespace polyarm::description {

namespace {

using tinyxml2::XMLElement;

/// Reads one description; problems carry the line of the element.
class UrdfReader : private XmlReader {
 public:
  UrdfReader(const std::string& file, Problems& problems, Problems& warnings, const UrdfOptions& options)
      : XmlReader(file, problems, warnings),
        options_(options),
        control_(file, hardware_faults_, warnings),
        gazebo_(file, warnings) {}

  RobotModel read(std::string_view text) {
    tinyxml2::XMLDocument document;
    parse(document, text, file_);
    const XMLElement* robot = document.FirstChildElement("robot");
    if (const XMLElement* sdf = document.FirstChildElement("sdf"))
      throw Error(Problem{"no-robot", at(*sdf), "this is SDF, which is not read",
                          "name the URDF or xacro file that it was made from"});
    if (const XMLElement* mujoco = document.FirstChildElement("mujoco"))
      throw Error(Problem{"no-robot", at(*mujoco), "this is MJCF of MuJoCo, which is not read",
                          "name the URDF or xacro file of the robot"});
    if (!robot)
      throw Error(Problem{"no-robot", {file_, 1}, "there is no <robot> element", "is this a URDF file?"});
    if (const XMLElement* macro = unexpanded(*robot))
      throw Error(Problem{"xacro", at(*macro), "this file is xacro: it must be expanded to URDF first",
                          "name the xacro file itself, or run `polyarm xacro FILE -o robot.urdf`"});
    if (const char* name = robot->Attribute("name")) model_.name = name;
    for (const XMLElement* e = robot->FirstChildElement(); e; e = e->NextSiblingElement()) element(*e);
    give_up_if_wrong();
    if (model_.links.empty() && joints_.empty()) stand_in({file_, robot->GetLineNum()});
    tie_together(model_, std::move(joints_), {file_, robot->GetLineNum()}, problems_, warnings_);
    give_up_if_wrong();
    warn_of_free_joints({file_, robot->GetLineNum()});
    check_hardware(model_, hardware_faults_, warnings_);
    gazebo_.finish(model_);
    give_up_if_wrong();
    if (facts_) read_facts(*facts_);
    give_up_if_wrong();
    complete_inertials(model_, warnings_);
    for (const Problem& fault : hardware_faults_.list()) warnings_.add(fault);
    return std::move(model_);
  }

 private:
  /// Throws all problems if the robot itself has errors.
  void give_up_if_wrong() {
    if (!problems_.has_errors()) return;
    for (const Problem& fault : hardware_faults_.list()) problems_.add(fault);
    problems_.throw_if_errors();
  }

  /// Warns of joints without a value or with several: kinematics needs one value for each joint.
  void warn_of_free_joints(const Location& where) {
    for (const Joint& joint : model_.joints)
      if (joint.type == JointType::planar || joint.type == JointType::floating)
        warnings_.warning("free-joint", where,
                          "the joint '" + joint.name + "' is " + name(joint.type) +
                              ": kinematics takes it as fixed at its origin",
                          "nothing to do if it is the base; otherwise give the joint one axis");
  }

  /// The first element that needs xacro: an xacro tag, or `${…}` in an attribute. Comments and the name space
  /// that xacro leaves in its output do not count.
  static const XMLElement* unexpanded(const XMLElement& e) {
    if (std::string_view(e.Name()).starts_with("xacro:")) return &e;
    for (const tinyxml2::XMLAttribute* a = e.FirstAttribute(); a; a = a->Next())
      if (std::string_view(a->Value()).find("${") != std::string_view::npos) return &e;
    for (const XMLElement* child = e.FirstChildElement(); child; child = child->NextSiblingElement())
      if (const XMLElement* found = unexpanded(*child)) return found;
    return nullptr;
  }

  /// Completes a description of hardware only (such as the JetBot of the ROS 2 tutorials): each joint gets a
  /// link without shape and turns without limits.
  void stand_in(const Location& where) {
    for (const HardwareInfo& hardware : model_.hardware)
      for (const ComponentInfo& component : hardware.components) {
        if (component.kind != "joint") continue;
        if (model_.links.empty()) model_.links.emplace_back().name = "base_link";
        NamedJoint made;
        made.joint.name = component.name;
        made.joint.type = JointType::continuous;
        made.parent = "base_link";
        made.child = component.name + "_link";
        made.where = component.where;
        model_.links.emplace_back().name = made.child;
        joints_.push_back(std::move(made));
      }
    if (!model_.links.empty())
      warnings_.warning("no-links", where,
                        "the description has no links: the joints of its <ros2_control> run without shapes",
                        "controllers work as they are; physics and a picture need links");
  }

  void element(const XMLElement& e) {
    const std::string tag = e.Name();
    if (tag == "link")
      link(e);
    else if (tag == "joint")
      joint(e);
    else if (tag == "ros2_control")
      model_.hardware.push_back(control_.hardware(e));
    else if (tag == "transmission")
      model_.transmissions.push_back(control_.robot_transmission(e));
    else if (tag == "gazebo")
      gazebo_.add(e);
    else if (tag == "polyarm")
      facts_ = &e;
    else if (tag != "material" && passed_over_.insert(tag).second)
      warnings_.warning("unknown-tag", at(e), "<" + tag + "> is ignored");
  }

  Vec3 vector(const XMLElement& e, const char* name, const Vec3& fallback) {
    const char* text = e.Attribute(name);
    if (!text) return fallback;
    const std::vector<std::string> words = split_words(text);
    std::vector<double> values;
    for (const std::string& word : words)
      if (const auto value = parse_number(word)) values.push_back(*value);
    if (values.size() != 3 || words.size() != 3) {
      error(e, "bad-number", std::string(name) + "=\"" + text + "\" is not three numbers");
      return fallback;
    }
    return {values[0], values[1], values[2]};
  }

  Pose origin(const XMLElement& parent) {
    const XMLElement* e = parent.FirstChildElement("origin");
    return e ? pose_xyz_rpy(vector(*e, "xyz", {}), vector(*e, "rpy", {})) : Pose{};
  }

  void link(const XMLElement& e) {
    Link out;
    out.name = attribute(e, "name");
    if (!out.name.empty() && !link_names_.insert(out.name).second)
      error(e, "duplicate-name", "two links are called '" + out.name + "'", "rename one of them");
    if (const XMLElement* i = e.FirstChildElement("inertial")) out.inertial = inertial(*i);
    for (const XMLElement* v = e.FirstChildElement("visual"); v; v = v->NextSiblingElement("visual"))
      shape(*v, out.visuals);
    for (const XMLElement* c = e.FirstChildElement("collision"); c; c = c->NextSiblingElement("collision"))
      shape(*c, out.collisions);
    model_.links.push_back(std::move(out));
  }

  std::optional<Inertial> inertial(const XMLElement& e) {
    Inertial out;
    const Pose frame = origin(e);
    out.center = frame.position;
    out.mass = number(e.FirstChildElement("mass"), "value").value_or(0);
    if (out.mass < 0) {
      error(e, "bad-mass", "the mass " + format_number(out.mass) + " is negative");
      return std::nullopt;
    }
    if (const XMLElement* t = e.FirstChildElement("inertia")) {
      std::size_t k = 0;
      for (const char* name : {"ixx", "ixy", "ixz", "iyy", "iyz", "izz"})
        out.inertia[k++] = number(t, name).value_or(0);
      out.inertia = turned(out.inertia, frame.rotation);
    }
    return out.mass > 0 ? std::optional(out) : std::nullopt;
  }

  /// R I R^T: from the inertial frame's axes into the link's.
  static std::array<double, 6> turned(const std::array<double, 6>& i, const Quaternion& q) {
    if (q == Quaternion{}) return i;
    const double m[3][3] = {{i[0], i[1], i[2]}, {i[1], i[3], i[4]}, {i[2], i[4], i[5]}};
    const Vec3 columns[3] = {q * Vec3{1, 0, 0}, q * Vec3{0, 1, 0}, q * Vec3{0, 0, 1}};
    const auto r = [&](int row, int column) {
      const Vec3& c = columns[column];
      return row == 0 ? c.x : row == 1 ? c.y : c.z;
    };
    const auto entry = [&](int a, int b) {
      double sum = 0;
      for (int k = 0; k < 3; ++k)
        for (int l = 0; l < 3; ++l) sum += r(a, k) * m[k][l] * r(b, l);
      return sum;
    };
    return {entry(0, 0), entry(0, 1), entry(0, 2), entry(1, 1), entry(1, 2), entry(2, 2)};
  }

  void shape(const XMLElement& e, std::vector<Shape>& out) {
    const XMLElement* geometry = e.FirstChildElement("geometry");
    const XMLElement* g = geometry ? geometry->FirstChildElement() : nullptr;
    if (!g) {
      warnings_.warning("no-geometry", at(e),
                        std::string("<") + e.Name() + "> has no geometry, it is ignored");
      return;
    }
    Shape s;
    s.pose = origin(e);
    const std::string kind = g->Name();
    if (kind == "box") {
      s.kind = ShapeKind::box;
      s.size = vector(*g, "size", {});
    } else if (kind == "cylinder" || kind == "capsule") {
      s.kind = kind == "cylinder" ? ShapeKind::cylinder : ShapeKind::capsule;
      s.radius = number(g, "radius").value_or(0);
      s.length = number(g, "length").value_or(0);
    } else if (kind == "sphere") {
      s.kind = ShapeKind::sphere;
      s.radius = number(g, "radius").value_or(0);
    } else if (kind == "mesh") {
      s.kind = ShapeKind::mesh;
      s.mesh = attribute(*g, "filename");
      s.scale = vector(*g, "scale", {1, 1, 1});
      s.mesh_path = resolve_mesh(s.mesh);
    } else {
      warnings_.warning("unknown-tag", at(*g), "the geometry <" + kind + "> is ignored");
      return;
    }
    if (has_size(s))
      out.push_back(std::move(s));
    else
      warnings_.warning("no-size", at(*g), "the <" + kind + "> has no size above zero, it is ignored");
  }

  static bool has_size(const Shape& s) {
    switch (s.kind) {
      case ShapeKind::box:
        return s.size.x > 0 && s.size.y > 0 && s.size.z > 0;
      case ShapeKind::cylinder:
        return s.radius > 0 && s.length > 0;
      case ShapeKind::capsule:
        return s.radius > 0 && s.length >= 0;
      case ShapeKind::sphere:
        return s.radius > 0;
      case ShapeKind::mesh:
        return true;
    }
    return false;
  }

  /// The folder of a package, searched for once; empty if there is none.
  std::filesystem::path package(const std::string& name) {
    const auto [at, is_new] = packages_.try_emplace(name);
    if (is_new && options_.packages) at->second = options_.packages(name);
    return at->second;
  }

  std::string resolve_mesh(const std::string& uri) {
    constexpr std::string_view kPackage = "package://", kFile = "file://";
    std::filesystem::path path;
    if (uri.starts_with(kPackage)) {
      const std::size_t slash = std::min(uri.find('/', kPackage.size()), uri.size());
      path = package(uri.substr(kPackage.size(), slash - kPackage.size()));
      if (path.empty()) return {};
      path += uri.substr(slash);
    } else if (uri.starts_with(kFile)) {
      path = uri.substr(kFile.size());
    } else {
      path = std::filesystem::path(file_).parent_path() / uri;
    }
    std::error_code error;
    return std::filesystem::is_regular_file(path, error) ? path.string() : std::string();
  }

  JointType joint_type(const XMLElement& e) {
    const std::string text = attribute(e, "type");
    std::vector<std::string> names;
    for (const JointType type : {JointType::fixed, JointType::revolute, JointType::continuous,
                                 JointType::prismatic, JointType::planar, JointType::floating}) {
      if (text == name(type)) return type;
      names.emplace_back(name(type));
    }
    if (!text.empty()) error(e, "bad-type", "'" + text + "' is not a joint type" + suggest_(text, names));
    return JointType::fixed;
  }

  void joint(const XMLElement& e) {
    NamedJoint out;
    out.where = at(e);
    out.joint.name = attribute(e, "name");
    out.joint.type = joint_type(e);
    for (const auto& [tag, name] : {std::pair{"parent", &out.parent}, {"child", &out.child}}) {
      const XMLElement* end = e.FirstChildElement(tag);
      if (end)
        *name = attribute(*end, "link");
      else
        error(e, "missing-tag", "the joint '" + out.joint.name + "' has no <" + tag + ">");
    }
    if (const XMLElement* origin = e.FirstChildElement("origin")) {
      Vec3 rpy = vector(*origin, "rpy", {});
      settle_angles(rpy);
      out.joint.origin = pose_xyz_rpy(vector(*origin, "xyz", {}), rpy);
    }
    axis(e, out.joint);
    limits(e, out.joint);
    soft_limits(e, out.joint);
    if (const XMLElement* d = e.FirstChildElement("dynamics")) {
      out.joint.damping = number(d, "damping").value_or(0);
      out.joint.friction = number(d, "friction").value_or(0);
    }
    if (const XMLElement* m = e.FirstChildElement("mimic")) {
      out.mimics = attribute(*m, "joint");
      out.joint.mimic = Mimic{-1, number(m, "multiplier").value_or(1), number(m, "offset").value_or(0)};
    }
    joints_.push_back(std::move(out));
  }

  void axis(const XMLElement& e, Joint& joint) {
    const XMLElement* a = e.FirstChildElement("axis");
    if (!a || !joint.moves()) return;
    const Vec3 given = vector(*a, "xyz", {1, 0, 0});
    const double length = std::hypot(given.x, given.y, given.z);  // hypot: the squares cannot overflow
    if (!(length > 1e-9) || !std::isfinite(length))
      return error(*a, "zero-axis", "the axis of the joint '" + joint.name + "' has no direction");
    if (std::abs(length - 1) < 1e-12)
      joint.axis = given;
    else
      joint.axis = {given.x / length, given.y / length, given.z / length};
  }

  /// Whole numbers that are many turns as radians, and up to two turns as degrees.
  static bool looks_like_degrees(double lower, double upper) {
    const double most = std::max(std::abs(lower), std::abs(upper));
    return most >= 30 && most <= 720 && lower == std::floor(lower) && upper == std::floor(upper) &&
           lower < upper;
  }

  void limits(const XMLElement& e, Joint& joint) {
    const XMLElement* l = e.FirstChildElement("limit");
    const bool ranged = joint.type == JointType::revolute || joint.type == JointType::prismatic;
    if (!l && ranged)
      warnings_.warning("no-limit", at(e), "the joint '" + joint.name + "' has no <limit>",
                        "it is taken as unlimited");
    if (!l) return;
    if (ranged) {
      joint.limits.lower = number(l, "lower").value_or(0);
      joint.limits.upper = number(l, "upper").value_or(0);
      if (*joint.limits.lower > *joint.limits.upper) {
        warnings_.warning("bad-limit", at(*l),
                          "the lower limit " + format_number(*joint.limits.lower) + " of '" + joint.name +
                              "' is above its upper limit " + format_number(*joint.limits.upper) +
                              "; they are exchanged",
                          "write the smaller value as lower");
        std::swap(*joint.limits.lower, *joint.limits.upper);
      }
      if (joint.type == JointType::revolute && looks_like_degrees(*joint.limits.lower, *joint.limits.upper))
        warnings_.warning("degrees", at(*l),
                          "the limits of '" + joint.name + "', " + format_number(*joint.limits.lower) +
                              " to " + format_number(*joint.limits.upper) + " rad, look like degrees",
                          "write radians: 180 degrees are 3.1416 rad");
      if (*joint.limits.lower == *joint.limits.upper) {
        warnings_.warning("no-limit", at(*l), "the joint '" + joint.name + "' has an empty range",
                          "it is taken as unlimited");
        joint.limits.lower.reset();
        joint.limits.upper.reset();
      }
    }
    for (const auto& [name, value] : {std::pair{"velocity", &joint.limits.velocity},
                                      {"effort", &joint.limits.effort},
                                      {"acceleration", &joint.limits.acceleration},
                                      {"deceleration", &joint.limits.deceleration},
                                      {"jerk", &joint.limits.jerk}})
      if (const auto stated = number(l, name); stated && *stated > 0) *value = *stated;
  }

  /// Reads soft limits. A range of size zero, which is the format's default, means no range.
  void soft_limits(const XMLElement& e, Joint& joint) {
    const XMLElement* s = e.FirstChildElement("safety_controller");
    if (!s || !joint.moves()) return;
    SoftLimits out;
    out.lower = number(s, "soft_lower_limit");
    out.upper = number(s, "soft_upper_limit");
    out.k_position = number(s, "k_position").value_or(0);
    out.k_velocity = number(s, "k_velocity").value_or(0);
    if (out.lower && out.upper && *out.lower > *out.upper) {
      warnings_.warning("bad-limit", at(*s),
                        "the soft lower limit " + format_number(*out.lower) + " of '" + joint.name +
                            "' is above its soft upper limit " + format_number(*out.upper) +
                            "; they are exchanged",
                        "write the smaller value as soft_lower_limit");
      std::swap(*out.lower, *out.upper);
    }
    if (out.lower == out.upper) out.lower = out.upper = std::nullopt;
    if (out.k_position < 0 || out.k_velocity < 0)
      error(*s, "bad-number", "k_position and k_velocity of '" + joint.name + "' must be zero or more");
    joint.soft_limits = out;
  }

  // --- <polyarm>, written by write_urdf

  void read_facts(const XMLElement& e) {
    Provenance& p = model_.provenance;
    for (const auto& [name, value] :
         {std::pair{"maker", &p.maker}, {"model", &p.model}, {"source", &p.source}, {"licence", &p.licence}})
      if (const char* text = e.Attribute(name)) *value = text;
    p.payload_kg = number(&e, "payload");
    p.reach_m = number(&e, "reach");
    if (e.Attribute("tip")) model_.tip = index_of(e, "tip");
    if (const char* source = e.Attribute("controller_axes")) {
      p.controller_axes = source;
      model_.controller_axes.resize(model_.actuated.size());
    }
    for (const XMLElement* c = e.FirstChildElement(); c; c = c->NextSiblingElement()) {
      const std::string_view tag = c->Name();
      if (tag == "note" && c->GetText()) p.notes.emplace_back(c->GetText());
      if (tag == "state") read_state(*c);
      if (tag == "controller_axis") read_controller_axis(*c);
      if (tag == "group") read_group(*c);
      if (tag == "end_effector")
        model_.end_effectors.push_back({attribute(*c, "name"), attribute(*c, "group"),
                                        optional_attribute(*c, "parent_group"), index_of(*c, "parent_link")});
      if (tag == "allowed_collision") {
        const auto [low, high] = std::minmax({index_of(*c, "link1"), index_of(*c, "link2")});
        model_.allowed_collisions.push_back({low, high});
      }
      if (tag == "estimated")
        if (auto& inertial = model_.links[static_cast<std::size_t>(index_of(*c, "link"))].inertial)
          inertial->estimated = true;
    }
  }

  /// The index of the link in the attribute; the root and a problem if there is none.
  int index_of(const XMLElement& e, const char* name) {
    const std::string link = attribute(e, name);
    const int found = model_.find_link(link);
    if (found < 0) error(e, "unknown-link", "there is no link '" + link + "'");
    return std::max(found, 0);
  }

  /// The index in `actuated` of the joint in the element; empty and a problem if there is none.
  std::optional<std::size_t> value_of(const XMLElement& e) {
    const std::vector<std::string> names = model_.joint_names();
    const std::string joint = attribute(e, "joint");
    const auto found = std::find(names.begin(), names.end(), joint);
    if (found != names.end()) return static_cast<std::size_t>(found - names.begin());
    error(e, "unknown-joint", "there is no joint '" + joint + "'" + suggest_(joint, names));
    return std::nullopt;
  }

  void read_controller_axis(const XMLElement& e) {
    const auto at = value_of(e);
    if (!at || *at >= model_.controller_axes.size()) return;
    ControllerAxis& axis = model_.controller_axes[*at];
    axis.sign = number(&e, "sign").value_or(1);
    axis.offset = number(&e, "offset").value_or(0);
    for (const XMLElement* c = e.FirstChildElement("coupling"); c; c = c->NextSiblingElement("coupling"))
      if (const auto other = value_of(*c))
        axis.coupling.push_back({static_cast<int>(*other), number(c, "factor").value_or(0)});
  }

  void read_group(const XMLElement& e) {
    GroupInfo out;
    out.name = attribute(e, "name");
    for (const XMLElement* j = e.FirstChildElement("joint"); j; j = j->NextSiblingElement("joint")) {
      const std::string joint = attribute(*j, "name");
      out.joints.push_back(model_.find_joint(joint));
      if (out.joints.back() < 0) error(*j, "unknown-joint", "there is no joint '" + joint + "'");
    }
    for (const XMLElement* l = e.FirstChildElement("link"); l; l = l->NextSiblingElement("link"))
      out.links.push_back(index_of(*l, "name"));
    model_.groups.push_back(std::move(out));
  }

  void read_state(const XMLElement& e) {
    const std::vector<std::string> names = model_.joint_names();
    std::vector<double> values(names.size(), 0.0);
    for (const XMLElement* j = e.FirstChildElement("joint"); j; j = j->NextSiblingElement("joint")) {
      const std::string joint = attribute(*j, "name");
      const auto found = std::find(names.begin(), names.end(), joint);
      if (found == names.end())
        error(*j, "unknown-joint", "there is no joint '" + joint + "'" + suggest_(joint, names));
      else
        values[static_cast<std::size_t>(found - names.begin())] = number(j, "value").value_or(0);
    }
    model_.named_states[attribute(e, "name")] = std::move(values);
  }

  const UrdfOptions& options_;
  Problems hardware_faults_;  ///< in <ros2_control>; kinematics works without it
  Ros2ControlReader control_;
  GazeboReader gazebo_;
  RobotModel model_;
  std::vector<NamedJoint> joints_;
  std::set<std::string> passed_over_, link_names_;
  std::map<std::string, std::filesystem::path> packages_;  ///< the packages found so far
  const XMLElement* facts_ = nullptr;  ///< <polyarm>: facts that URDF cannot express
};

}  // namespace

RobotModel read_urdf(std::string_view text, const std::string& file, Problems& warnings,
                     const UrdfOptions& options) {
  Problems problems;
  return UrdfReader(file, problems, warnings, options).read(text);
}

}  // namespace polyarm::description
