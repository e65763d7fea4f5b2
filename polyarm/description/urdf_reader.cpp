#include <tinyxml2.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "polyarm/base/text.hpp"
#include "polyarm/description/model_builder.hpp"
#include "polyarm/description/urdf.hpp"

namespace polyarm::description {

namespace {

using tinyxml2::XMLElement;

/// Reads one description; complaints carry the line of the element.
class UrdfReader {
 public:
  UrdfReader(const std::string& file, Problems& warnings, const UrdfOptions& options)
      : file_(file), warnings_(warnings), options_(options) {}

  RobotModel read(std::string_view text) {
    tinyxml2::XMLDocument document;
    if (document.Parse(text.data(), text.size()) != tinyxml2::XML_SUCCESS)
      throw Error(Problem{"xml-syntax",
                          {file_, document.ErrorLineNum()},
                          "not valid XML: " + std::string(document.ErrorName()),
                          "check that every element is closed and every quote has its partner"});
    const XMLElement* robot = document.FirstChildElement("robot");
    if (!robot)
      throw Error(Problem{"no-robot", {file_, 1}, "there is no <robot> element", "is this a URDF file?"});
    if (const XMLElement* macro = unexpanded(*robot))
      throw Error(Problem{"xacro", at(*macro), "this file is xacro: it has to be expanded to URDF first",
                          "name the xacro file itself, or run `polyarm xacro FILE -o robot.urdf`"});
    if (const char* name = robot->Attribute("name")) model_.name = name;
    for (const XMLElement* e = robot->FirstChildElement(); e; e = e->NextSiblingElement()) element(*e);
    problems_.throw_if_errors();
    tie_together(model_, std::move(joints_), {file_, robot->GetLineNum()}, problems_);
    problems_.throw_if_errors();
    for (const HardwareInfo& hardware : model_.hardware) check_hardware(hardware);
    problems_.throw_if_errors();
    if (facts_) read_facts(*facts_);
    problems_.throw_if_errors();
    complete_inertials(model_, warnings_);
    return std::move(model_);
  }

 private:
  Location at(const XMLElement& e) const { return {file_, e.GetLineNum()}; }
  void error(const XMLElement& e, std::string code, std::string what, std::string advice = {}) {
    problems_.error(std::move(code), at(e), std::move(what), std::move(advice));
  }

  /// The first element that only xacro understands: a tag of its own, or `${…}` in an attribute. Comments and
  /// the name space that xacro leaves behind in what it expands do not count.
  static const XMLElement* unexpanded(const XMLElement& e) {
    if (std::string_view(e.Name()).starts_with("xacro:")) return &e;
    for (const tinyxml2::XMLAttribute* a = e.FirstAttribute(); a; a = a->Next())
      if (std::string_view(a->Value()).find("${") != std::string_view::npos) return &e;
    for (const XMLElement* child = e.FirstChildElement(); child; child = child->NextSiblingElement())
      if (const XMLElement* found = unexpanded(*child)) return found;
    return nullptr;
  }

  void element(const XMLElement& e) {
    const std::string tag = e.Name();
    if (tag == "link")
      link(e);
    else if (tag == "joint")
      joint(e);
    else if (tag == "ros2_control")
      hardware(e);
    else if (tag == "polyarm")
      facts_ = &e;
    else if (tag != "material" && tag != "gazebo" && tag != "transmission" && passed_over_.insert(tag).second)
      warnings_.warning("unknown-tag", at(e), "<" + tag + "> is passed over");
  }

  std::string attribute(const XMLElement& e, const char* name) {
    const char* value = e.Attribute(name);
    const std::string text(value ? trim(value) : "");
    if (text.empty())
      error(e, "missing-attribute", std::string("<") + e.Name() + "> has no attribute '" + name + "'");
    return text;
  }

  std::optional<double> number(const XMLElement* e, const char* name) {
    const char* text = e ? e->Attribute(name) : nullptr;
    if (!text) return std::nullopt;
    const auto value = parse_number(text);
    if (!value) error(*e, "bad-number", std::string(name) + "=\"" + text + "\" is not a number");
    return value;
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
                        std::string("<") + e.Name() + "> has no geometry, it is passed over");
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
      warnings_.warning("unknown-tag", at(*g), "the geometry <" + kind + "> is passed over");
      return;
    }
    if (has_size(s))
      out.push_back(std::move(s));
    else
      warnings_.warning("no-size", at(*g), "the <" + kind + "> has no size above zero, it is passed over");
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

  std::string resolve_mesh(const std::string& uri) const {
    std::vector<std::filesystem::path> candidates;
    if (uri.starts_with("package://")) {
      for (const auto& folder : options_.package_folders) candidates.push_back(folder / uri.substr(10));
    } else if (uri.starts_with("file://")) {
      candidates.emplace_back(uri.substr(7));
    } else {
      candidates.push_back(std::filesystem::path(file_).parent_path() / uri);
    }
    std::error_code error;
    for (const auto& candidate : candidates)
      if (std::filesystem::is_regular_file(candidate, error)) return candidate.string();
    return {};
  }

  JointType joint_type(const XMLElement& e) {
    const std::string text = attribute(e, "type");
    std::vector<std::string> names;
    for (const JointType type : {JointType::fixed, JointType::revolute, JointType::continuous,
                                 JointType::prismatic, JointType::planar, JointType::floating}) {
      if (text == name(type)) return type;
      names.emplace_back(name(type));
    }
    if (!text.empty()) error(e, "bad-type", "'" + text + "' is no joint type" + did_you_mean(text, names));
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
    out.joint.origin = origin(e);
    axis(e, out.joint);
    limits(e, out.joint);
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
    const double length = std::hypot(given.x, given.y, given.z);  // does not overflow on the way
    if (!(length > 1e-9) || !std::isfinite(length))
      return error(*a, "zero-axis", "the axis of the joint '" + joint.name + "' has no direction");
    if (std::abs(length - 1) < 1e-12)
      joint.axis = given;
    else
      joint.axis = {given.x / length, given.y / length, given.z / length};
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
      if (*joint.limits.lower > *joint.limits.upper)
        error(*l, "bad-limit",
              "the lower limit " + format_number(*joint.limits.lower) + " of '" + joint.name +
                  "' is above its upper limit " + format_number(*joint.limits.upper));
      if (*joint.limits.lower == *joint.limits.upper) {
        warnings_.warning("no-limit", at(*l), "the joint '" + joint.name + "' has a range of nothing",
                          "it is taken as unlimited");
        joint.limits.lower.reset();
        joint.limits.upper.reset();
      }
    }
    for (const auto& [name, value] : {std::pair{"velocity", &joint.limits.velocity},
                                      {"effort", &joint.limits.effort},
                                      {"acceleration", &joint.limits.acceleration},
                                      {"jerk", &joint.limits.jerk}})
      if (const auto stated = number(l, name); stated && *stated > 0) *value = *stated;
  }

  // --- <ros2_control>
  // -----------------------------------------------------------------------------------------

  static void parameters(const XMLElement& e, std::map<std::string, std::string>& out) {
    for (const XMLElement* p = e.FirstChildElement("param"); p; p = p->NextSiblingElement("param"))
      if (const char* name = p->Attribute("name"))
        out[name] = std::string(trim(p->GetText() ? p->GetText() : ""));
  }

  static std::string text_in(const XMLElement* e, const char* tag) {
    const XMLElement* child = e ? e->FirstChildElement(tag) : nullptr;
    return std::string(trim(child && child->GetText() ? child->GetText() : ""));
  }

  bool flag(const XMLElement& e, const char* name, bool fallback) {
    const char* text = e.Attribute(name);
    if (!text) return fallback;
    const std::string value = lower(trim(text));
    if (value != "true" && value != "false" && value != "1" && value != "0")
      error(e, "bad-value", std::string(name) + "=\"" + text + "\" is neither true nor false");
    return value == "true" || value == "1";
  }

  /// Children that <ros2_control> does not have are refused, as the reference refuses them.
  void only(const XMLElement& e, const std::vector<std::string>& known) {
    for (const XMLElement* c = e.FirstChildElement(); c; c = c->NextSiblingElement())
      if (std::find(known.begin(), known.end(), c->Name()) == known.end())
        error(*c, "unknown-tag",
              std::string("<") + e.Name() + "> has no <" + c->Name() + ">" + did_you_mean(c->Name(), known),
              "it can have " + join(known, ", "));
  }

  void hardware(const XMLElement& e) {
    HardwareInfo out;
    out.where = at(e);
    out.name = attribute(e, "name");
    out.type = attribute(e, "type");
    const std::vector<std::string> types{"system", "actuator", "sensor"};
    if (!out.type.empty() && std::find(types.begin(), types.end(), out.type) == types.end())
      error(e, "bad-type", "'" + out.type + "' is no type of hardware" + did_you_mean(out.type, types),
            "write system, actuator or sensor");
    only(e, {"hardware", "properties", "joint", "sensor", "gpio", "transmission"});
    if (const auto rate = number(&e, "rw_rate")) {
      if (*rate < 0 || *rate != std::floor(*rate) || *rate > 1e6)
        error(e, "bad-value", "rw_rate is a whole number of Hz, 0 for that of the loop");
      else
        out.rw_rate = static_cast<int>(*rate);
    }
    out.is_async = flag(e, "is_async", false);
    if (const auto priority = number(&e, "thread_priority"))
      out.thread_priority = static_cast<int>(std::clamp(*priority, 0.0, 99.0));
    async_properties(e, out);
    if (const XMLElement* h = e.FirstChildElement("hardware")) {
      out.plugin = text_in(h, "plugin");
      out.group = text_in(h, "group");
      if (out.plugin.empty()) error(*h, "missing-tag", "the hardware '" + out.name + "' has no <plugin>");
      parameters(*h, out.parameters);
    } else {
      error(e, "missing-tag", "<ros2_control> '" + out.name + "' has no <hardware>",
            "add <hardware><plugin>…</plugin></hardware>");
    }
    for (const char* kind : {"joint", "sensor", "gpio"})
      for (const XMLElement* c = e.FirstChildElement(kind); c; c = c->NextSiblingElement(kind))
        component(*c, kind, out);
    for (const XMLElement* t = e.FirstChildElement("transmission"); t;
         t = t->NextSiblingElement("transmission"))
      transmission(*t, out);
    const auto joints = std::count_if(out.components.begin(), out.components.end(),
                                      [](const ComponentInfo& c) { return c.kind == "joint"; });
    if (out.type == "actuator" && joints != 1)
      error(e, "bad-type", "the actuator '" + out.name + "' has " + std::to_string(joints) + " joints",
            "an actuator has one; several make a system");
    model_.hardware.push_back(std::move(out));
  }

  void async_properties(const XMLElement& e, HardwareInfo& out) {
    const XMLElement* properties = e.FirstChildElement("properties");
    const XMLElement* async = properties ? properties->FirstChildElement("async") : nullptr;
    if (!async) return;
    if (const auto priority = number(async, "thread_priority"))
      out.thread_priority = static_cast<int>(std::clamp(*priority, 0.0, 99.0));
    if (const char* affinity = async->Attribute("affinity"))
      for (const std::string& word : split_words(affinity, "[], "))
        if (const auto cpu = parse_number(word); cpu && *cpu >= 0 && *cpu < 4096)
          out.affinity.push_back(static_cast<int>(*cpu));
  }

  void component(const XMLElement& c, const char* kind, HardwareInfo& out) {
    ComponentInfo component;
    component.name = attribute(c, "name");
    component.kind = kind;
    component_lines_[out.name + "/" + component.name] = at(c);
    only(c, {"command_interface", "state_interface", "param", "limits"});
    if (c.Attribute("mimic")) component.mimic = flag(c, "mimic", true);
    if (const XMLElement* l = c.FirstChildElement("limits"))
      component.limits_enabled = flag(*l, "enable", true);
    parameters(c, component.parameters);
    interfaces(c, "command_interface", component.command_interfaces);
    interfaces(c, "state_interface", component.state_interfaces);
    out.components.push_back(std::move(component));
  }

  void transmission_ends(const XMLElement& t, const char* tag, std::vector<TransmissionEnd>& out) {
    for (const XMLElement* e = t.FirstChildElement(tag); e; e = e->NextSiblingElement(tag)) {
      TransmissionEnd end;
      end.name = attribute(*e, "name");
      if (const char* role = e->Attribute("role")) end.role = role;
      for (const auto& [name, value] :
           {std::pair{"mechanical_reduction", &end.reduction}, {"offset", &end.offset}}) {
        const std::string text = text_in(e, name);
        if (text.empty()) continue;
        if (const auto given = parse_number(text))
          *value = *given;
        else
          error(*e, "bad-number", std::string(name) + " is '" + text + "', which is not a number");
      }
      if (end.reduction == 0)
        error(*e, "bad-value", "the mechanical_reduction of '" + end.name + "' is 0", "1 leaves it as it is");
      out.push_back(std::move(end));
    }
  }

  void transmission(const XMLElement& t, HardwareInfo& out) {
    TransmissionInfo info;
    info.name = attribute(t, "name");
    info.plugin = text_in(&t, "plugin");
    if (info.plugin.empty()) error(t, "missing-tag", "the transmission '" + info.name + "' has no <plugin>");
    transmission_ends(t, "joint", info.joints);
    transmission_ends(t, "actuator", info.actuators);
    parameters(t, info.parameters);
    out.transmissions.push_back(std::move(info));
  }

  void interfaces(const XMLElement& e, const char* tag, std::vector<InterfaceInfo>& out) {
    static const std::vector<std::string> kTypes{"double", "float32", "bool",   "uint8", "int8",
                                                 "uint16", "int16",   "uint32", "int32"};
    for (const XMLElement* i = e.FirstChildElement(tag); i; i = i->NextSiblingElement(tag)) {
      InterfaceInfo info;
      info.name = attribute(*i, "name");
      if (const char* type = i->Attribute("data_type")) info.data_type = type;
      if (std::find(kTypes.begin(), kTypes.end(), info.data_type) == kTypes.end())
        error(*i, "bad-type",
              "'" + info.data_type + "' is no data_type" + did_you_mean(info.data_type, kTypes));
      if (const auto size = number(i, "size")) {
        if (*size < 1 || *size != std::floor(*size) || *size > 1000)
          error(*i, "bad-value", "the size of '" + info.name + "' is a whole number from 1");
        else
          info.size = static_cast<int>(*size);
      }
      if (const XMLElement* l = i->FirstChildElement("limits"))
        info.limits_enabled = flag(*l, "enable", true);
      parameters(*i, info.parameters);
      if (const char* initial = i->Attribute("initial_value")) info.parameters["initial_value"] = initial;
      for (const auto& [name, value] :
           {std::pair{"min", &info.min}, {"max", &info.max}, {"initial_value", &info.initial_value}})
        if (const auto text = info.parameters.find(name); text != info.parameters.end()) {
          *value = parse_number(text->second);
          if (lower(text->second) == "true") *value = 1;
          if (lower(text->second) == "false") *value = 0;
          if (!*value && !text->second.empty() && info.data_type == "double")
            warnings_.warning("bad-number", at(*i),
                              std::string(name) + " of '" + info.name + "' is '" + text->second +
                                  "', which is not a number; it is passed over");
        }
      out.push_back(std::move(info));
    }
  }

  // --- <polyarm>, written by write_urdf
  // -----------------------------------------------------------------------------------------

  void read_facts(const XMLElement& e) {
    Provenance& p = model_.provenance;
    for (const auto& [name, value] :
         {std::pair{"maker", &p.maker}, {"model", &p.model}, {"source", &p.source}, {"licence", &p.licence}})
      if (const char* text = e.Attribute(name)) *value = text;
    p.payload_kg = number(&e, "payload");
    p.reach_m = number(&e, "reach");
    for (const XMLElement* c = e.FirstChildElement(); c; c = c->NextSiblingElement()) {
      const std::string_view tag = c->Name();
      if (tag == "note" && c->GetText()) p.notes.emplace_back(c->GetText());
      if (tag == "state") read_state(*c);
      if (tag == "allowed_collision") {
        const auto [low, high] = std::minmax({index_of(*c, "link1"), index_of(*c, "link2")});
        model_.allowed_collisions.push_back({low, high});
      }
      if (tag == "estimated")
        if (auto& inertial = model_.links[static_cast<std::size_t>(index_of(*c, "link"))].inertial)
          inertial->estimated = true;
    }
  }

  /// The index of the link that the attribute names; the root, and a problem, where there is none.
  int index_of(const XMLElement& e, const char* name) {
    const std::string link = attribute(e, name);
    const int found = model_.find_link(link);
    if (found < 0) error(e, "unknown-link", "there is no link '" + link + "'");
    return std::max(found, 0);
  }

  void read_state(const XMLElement& e) {
    const std::vector<std::string> names = model_.joint_names();
    std::vector<double> values(names.size(), 0.0);
    for (const XMLElement* j = e.FirstChildElement("joint"); j; j = j->NextSiblingElement("joint")) {
      const std::string joint = attribute(*j, "name");
      const auto found = std::find(names.begin(), names.end(), joint);
      if (found == names.end())
        error(*j, "unknown-joint", "there is no joint '" + joint + "'" + did_you_mean(joint, names));
      else
        values[static_cast<std::size_t>(found - names.begin())] = number(j, "value").value_or(0);
    }
    model_.named_states[attribute(e, "name")] = std::move(values);
  }

  /// A joint that does not move cannot be commanded, and one that mimics another is not commanded by itself.
  void check_component(const HardwareInfo& hardware, const ComponentInfo& component) {
    const int found = component.kind == "joint" ? model_.find_joint(component.name) : -1;
    if (found < 0) return;
    const Joint& joint = model_.joints[static_cast<std::size_t>(found)];
    const Location& where = component_lines_[hardware.name + "/" + component.name];
    if (!joint.moves())
      problems_.error("fixed-joint", where,
                      "<ros2_control> names the joint '" + component.name + "', which is fixed",
                      "leave it out");
    if (component.mimic.value_or(false) && !joint.mimic)
      problems_.error("no-mimic", where,
                      "the joint '" + component.name + "' has no <mimic> in the description",
                      "add <mimic joint=…> to it, or leave mimic=\"true\" out");
    if (joint.mimic && component.mimic.value_or(true) && !component.command_interfaces.empty())
      problems_.error("mimic-commanded", where,
                      "the joint '" + component.name + "' follows another and cannot be commanded",
                      "leave its command interfaces out, or write mimic=\"false\"");
  }

  void check_hardware(const HardwareInfo& hardware) {
    std::vector<std::string> names;
    for (const Joint& joint : model_.joints) names.push_back(joint.name);
    for (const ComponentInfo& component : hardware.components) check_component(hardware, component);
    for (const ComponentInfo& component : hardware.components)
      if (component.kind == "joint" && model_.find_joint(component.name) < 0)
        problems_.error("unknown-joint", component_lines_[hardware.name + "/" + component.name],
                        "<ros2_control> '" + hardware.name + "' names the joint '" + component.name +
                            "', which the robot does not have" + did_you_mean(component.name, names));
  }

  std::string file_;
  Problems& warnings_;
  const UrdfOptions& options_;
  RobotModel model_;
  std::vector<NamedJoint> joints_;
  Problems problems_;
  std::set<std::string> passed_over_, link_names_;
  std::map<std::string, Location> component_lines_;
  const XMLElement* facts_ = nullptr;  ///< <polyarm>: what URDF has no place for
};

}  // namespace

RobotModel read_urdf(std::string_view text, const std::string& file, Problems& warnings,
                     const UrdfOptions& options) {
  return UrdfReader(file, warnings, options).read(text);
}

}  // namespace polyarm::description
