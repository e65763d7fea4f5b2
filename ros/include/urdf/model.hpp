#pragma once
/// A robot description as controllers read it: links with masses and shapes, joints, their types, limits,
/// axes and origins. Materials are not read.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace urdf {

struct Vector3 {
  double x = 0, y = 0, z = 0;
};
struct Rotation {
  double x = 0, y = 0, z = 0, w = 1;
  void setFromRPY(double r, double p, double yaw) {
    const double cr = std::cos(r / 2), sr = std::sin(r / 2), cp = std::cos(p / 2), sp = std::sin(p / 2);
    const double cy = std::cos(yaw / 2), sy = std::sin(yaw / 2);
    x = sr * cp * cy - cr * sp * sy, y = cr * sp * cy + sr * cp * sy;
    z = cr * cp * sy - sr * sp * cy, w = cr * cp * cy + sr * sp * sy;
  }
  void getRPY(double& r, double& p, double& yaw) const {
    r = std::atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y));
    p = std::asin(std::fmax(-1, std::fmin(1, 2 * (w * y - z * x))));
    yaw = std::atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z));
  }
  void getQuaternion(double& qx, double& qy, double& qz, double& qw) const { qx = x, qy = y, qz = z, qw = w; }
  Vector3 operator*(const Vector3& v) const {
    const Vector3 t{2 * (y * v.z - z * v.y), 2 * (z * v.x - x * v.z), 2 * (x * v.y - y * v.x)};
    return {v.x + w * t.x + y * t.z - z * t.y, v.y + w * t.y + z * t.x - x * t.z,
            v.z + w * t.z + x * t.y - y * t.x};
  }
};
struct Pose {
  Vector3 position;
  Rotation rotation;
};
struct JointLimits {
  double lower = 0, upper = 0, effort = 0, velocity = 0;
};
struct JointSafety {
  double soft_upper_limit = 0, soft_lower_limit = 0, k_position = 0, k_velocity = 0;
};
struct JointDynamics {
  double damping = 0, friction = 0;
};
struct JointMimic {
  double offset = 0, multiplier = 1;
  std::string joint_name;
};
struct Joint {
  enum Type { UNKNOWN, REVOLUTE, CONTINUOUS, PRISMATIC, FLOATING, PLANAR, FIXED };
  std::string name;
  Type type = UNKNOWN;
  Vector3 axis{1, 0, 0};
  std::string child_link_name, parent_link_name;
  Pose parent_to_joint_origin_transform;
  std::shared_ptr<JointLimits> limits;
  std::shared_ptr<JointSafety> safety;
  std::shared_ptr<JointDynamics> dynamics;
  std::shared_ptr<JointMimic> mimic;
};
struct Inertial {
  Pose origin;
  double mass = 0, ixx = 0, ixy = 0, ixz = 0, iyy = 0, iyz = 0, izz = 0;
};
struct Geometry {
  enum { SPHERE, BOX, CYLINDER, MESH, CAPSULE } type = SPHERE;
  virtual ~Geometry() = default;
};
struct Sphere : Geometry {
  double radius = 0;
};
struct Box : Geometry {
  Vector3 dim;
};
struct Cylinder : Geometry {
  double length = 0, radius = 0;
};
struct Capsule : Geometry {
  double length = 0, radius = 0;
};
struct Mesh : Geometry {
  std::string filename;
  Vector3 scale{1, 1, 1};
};
using GeometrySharedPtr = std::shared_ptr<Geometry>;
struct Visual {
  Pose origin;
  GeometrySharedPtr geometry;
  std::string material_name, name;
};
struct Collision {
  Pose origin;
  GeometrySharedPtr geometry;
  std::string name;
};
using VisualSharedPtr = std::shared_ptr<Visual>;
using CollisionSharedPtr = std::shared_ptr<Collision>;
struct Link {
  std::string name;
  std::shared_ptr<Inertial> inertial;
  VisualSharedPtr visual;  ///< the first one
  CollisionSharedPtr collision;
  std::vector<VisualSharedPtr> visual_array;
  std::vector<CollisionSharedPtr> collision_array;
  std::shared_ptr<Joint> parent_joint;
  std::vector<std::shared_ptr<Joint>> child_joints;
  std::vector<std::shared_ptr<Link>> child_links;
  std::weak_ptr<Link> parent_link_;
  std::shared_ptr<Link> getParent() const { return parent_link_.lock(); }
};
using JointSharedPtr = std::shared_ptr<Joint>;
using JointConstSharedPtr = std::shared_ptr<const Joint>;
using LinkSharedPtr = std::shared_ptr<Link>;
using LinkConstSharedPtr = std::shared_ptr<const Link>;

namespace detail {
/// A start tag with its attributes, or an end tag.
struct Tag {
  std::string name;
  std::map<std::string, std::string> attributes;
  bool ends = false, empty = false;
  std::string text(const char* key) const {
    const auto found = attributes.find(key);
    return found == attributes.end() ? std::string() : found->second;
  }
  double number(const char* key, double otherwise) const {
    const std::string value = text(key);
    return value.empty() ? otherwise : std::strtod(value.c_str(), nullptr);
  }
  Vector3 vector(const char* key, Vector3 otherwise) const {
    const std::string value = text(key);
    if (value.empty()) return otherwise;
    char* at = nullptr;
    otherwise.x = std::strtod(value.c_str(), &at);
    otherwise.y = std::strtod(at, &at);
    otherwise.z = std::strtod(at, &at);
    return otherwise;
  }
};
/// The next tag from `at` on; none at the end, or if the text is no XML.
inline std::optional<Tag> next_tag(const std::string& xml, std::size_t& at) {
  for (;;) {
    at = xml.find('<', at);
    if (at == std::string::npos) return std::nullopt;
    if (xml.compare(at, 4, "<!--") == 0) {
      at = xml.find("-->", at);
      continue;
    }
    if (at + 1 < xml.size() && (xml[at + 1] == '?' || xml[at + 1] == '!')) {
      ++at;
      continue;
    }
    break;
  }
  Tag out;
  std::size_t i = at + 1;
  if (i < xml.size() && xml[i] == '/') out.ends = true, ++i;
  const auto word = [&](const char* stop) {
    const std::size_t begin = i;
    i = std::min(xml.find_first_of(stop, i), xml.size());
    return xml.substr(begin, i - begin);
  };
  out.name = word(" \t\r\n/>");
  for (;;) {
    i = std::min(xml.find_first_not_of(" \t\r\n", i), xml.size());
    if (i >= xml.size()) return std::nullopt;
    if (xml[i] == '/') out.empty = true, ++i;
    if (i < xml.size() && xml[i] == '>') break;
    const std::string key = word("= \t\r\n>");
    i = xml.find_first_of("\"'>", i);
    if (i == std::string::npos || xml[i] == '>') return std::nullopt;
    const char quote = xml[i++];
    const std::size_t end = xml.find(quote, i);
    if (end == std::string::npos) return std::nullopt;
    out.attributes[key] = xml.substr(i, end - i);
    i = end + 1;
  }
  at = i + 1;
  return out;
}
}  // namespace detail

class ModelInterface {
 public:
  std::string name_;
  std::map<std::string, LinkSharedPtr> links_;
  std::map<std::string, JointSharedPtr> joints_;
  LinkSharedPtr root_link_;

  const std::string& getName() const { return name_; }
  LinkConstSharedPtr getRoot() const { return root_link_; }
  LinkConstSharedPtr getLink(const std::string& name) const {
    const auto found = links_.find(name);
    return found == links_.end() ? nullptr : found->second;
  }
  JointConstSharedPtr getJoint(const std::string& name) const {
    const auto found = joints_.find(name);
    return found == joints_.end() ? nullptr : found->second;
  }
  void getLinks(std::vector<LinkSharedPtr>& out) const {
    for (const auto& [name, link] : links_) out.push_back(link);
  }
  void getLink(const std::string& name, LinkSharedPtr& out) const {
    const auto found = links_.find(name);
    out = found == links_.end() ? nullptr : found->second;
  }

  /// False if there is no such file, or if it is no robot description.
  bool initFile(const std::string& file) {
    std::ifstream in(file);
    return in && initString({std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()});
  }

  /// False if the text is no robot description.
  bool initString(const std::string& xml) {
    *this = {};
    std::size_t at = 0;
    std::vector<std::string> path;
    JointSharedPtr joint;
    LinkSharedPtr link;
    while (const auto tag = detail::next_tag(xml, at)) {
      if (tag->ends) {
        if (path.empty() || path.back() != tag->name) return false;
        path.pop_back();
        if (path.size() == 1) joint = nullptr, link = nullptr;
        continue;
      }
      if (path.empty() && tag->name == "robot") name_ = tag->text("name");
      if (path.size() == 1 && path[0] == "robot") begin(*tag, joint, link);
      if (path.size() == 2 && joint) take(*tag, *joint);
      if (path.size() == 2 && link && tag->name == "inertial") link->inertial = std::make_shared<Inertial>();
      if (path.size() == 3 && link && link->inertial && path[2] == "inertial") take(*tag, *link->inertial);
      if (link) take_shape(*tag, path, *link);
      if (!tag->empty) path.push_back(tag->name);
      if (path.size() == 1) joint = nullptr, link = nullptr;
    }
    return path.empty() && connect();
  }

 private:
  void begin(const detail::Tag& tag, JointSharedPtr& joint, LinkSharedPtr& link) {
    if (tag.name == "link") {
      link = std::make_shared<Link>();
      link->name = tag.text("name");
      links_[link->name] = link;
    } else if (tag.name == "joint") {
      static const std::map<std::string, Joint::Type> types = {
          {"revolute", Joint::REVOLUTE},   {"continuous", Joint::CONTINUOUS}, {"prismatic", Joint::PRISMATIC},
          {"floating", Joint::FLOATING}, {"planar", Joint::PLANAR},         {"fixed", Joint::FIXED}};
      joint = std::make_shared<Joint>();
      joint->name = tag.text("name");
      const auto type = types.find(tag.text("type"));
      if (type != types.end()) joint->type = type->second;
      joints_[joint->name] = joint;
    }
  }
  static Pose pose(const detail::Tag& tag) {
    Pose out;
    out.position = tag.vector("xyz", {});
    const Vector3 angles = tag.vector("rpy", {});
    out.rotation.setFromRPY(angles.x, angles.y, angles.z);
    return out;
  }
  static void take(const detail::Tag& tag, Inertial& body) {
    if (tag.name == "origin") body.origin = pose(tag);
    if (tag.name == "mass") body.mass = tag.number("value", 0);
    if (tag.name != "inertia") return;
    body.ixx = tag.number("ixx", 0), body.ixy = tag.number("ixy", 0), body.ixz = tag.number("ixz", 0);
    body.iyy = tag.number("iyy", 0), body.iyz = tag.number("iyz", 0), body.izz = tag.number("izz", 0);
  }
  template <class Part>
  static void take_shape(const detail::Tag& tag, const std::vector<std::string>& path,
                         std::vector<std::shared_ptr<Part>>& all, std::shared_ptr<Part>& first) {
    if (path.size() == 2) {
      all.push_back(std::make_shared<Part>());
      all.back()->name = tag.text("name");
      first = all.front();
    } else if (path.size() == 3 && tag.name == "origin") {
      all.back()->origin = pose(tag);
    } else if (path.size() == 4 && path[3] == "geometry") {
      all.back()->geometry = geometry(tag);
    }
  }
  static void take_shape(const detail::Tag& tag, const std::vector<std::string>& path, Link& link) {
    const std::string& part = path.size() == 2 ? tag.name : path.size() > 2 ? path[2] : link.name;
    if (path.size() < 2) return;
    if (part == "visual") take_shape(tag, path, link.visual_array, link.visual);
    if (part == "collision") take_shape(tag, path, link.collision_array, link.collision);
  }
  static GeometrySharedPtr geometry(const detail::Tag& tag) {
    const auto round = [&](auto made, auto type) -> GeometrySharedPtr {
      made->type = type;
      made->radius = tag.number("radius", 0);
      if constexpr (!std::is_same_v<decltype(made), std::shared_ptr<Sphere>>)
        made->length = tag.number("length", 0);
      return made;
    };
    if (tag.name == "sphere") return round(std::make_shared<Sphere>(), Geometry::SPHERE);
    if (tag.name == "cylinder") return round(std::make_shared<Cylinder>(), Geometry::CYLINDER);
    if (tag.name == "capsule") return round(std::make_shared<Capsule>(), Geometry::CAPSULE);
    if (tag.name == "box") {
      const auto made = std::make_shared<Box>();
      made->type = Geometry::BOX;
      made->dim = tag.vector("size", {});
      return made;
    }
    if (tag.name != "mesh") return nullptr;
    const auto made = std::make_shared<Mesh>();
    made->type = Geometry::MESH;
    made->filename = tag.text("filename");
    made->scale = tag.vector("scale", made->scale);
    return made;
  }
  static void take(const detail::Tag& tag, Joint& joint) {
    if (tag.name == "parent") joint.parent_link_name = tag.text("link");
    if (tag.name == "child") joint.child_link_name = tag.text("link");
    if (tag.name == "axis") joint.axis = tag.vector("xyz", joint.axis);
    if (tag.name == "origin") joint.parent_to_joint_origin_transform = pose(tag);
    if (tag.name == "limit")
      joint.limits = std::make_shared<JointLimits>(
          JointLimits{tag.number("lower", 0), tag.number("upper", 0), tag.number("effort", 0),
                      tag.number("velocity", 0)});
    if (tag.name == "safety_controller")
      joint.safety = std::make_shared<JointSafety>(
          JointSafety{tag.number("soft_upper_limit", 0), tag.number("soft_lower_limit", 0),
                      tag.number("k_position", 0), tag.number("k_velocity", 0)});
    if (tag.name == "dynamics")
      joint.dynamics = std::make_shared<JointDynamics>(
          JointDynamics{tag.number("damping", 0), tag.number("friction", 0)});
    if (tag.name == "mimic")
      joint.mimic = std::make_shared<JointMimic>(
          JointMimic{tag.number("offset", 0), tag.number("multiplier", 1), tag.text("joint")});
  }
  bool connect() {
    for (const auto& [name, joint] : joints_) {
      const auto parent = links_.find(joint->parent_link_name), child = links_.find(joint->child_link_name);
      if (parent == links_.end() || child == links_.end()) return false;
      child->second->parent_joint = joint;
      child->second->parent_link_ = parent->second;
      parent->second->child_joints.push_back(joint);
      parent->second->child_links.push_back(child->second);
    }
    for (const auto& [name, link] : links_)
      if (!link->parent_joint) root_link_ = link;
    return root_link_ != nullptr;
  }
};
using ModelInterfaceSharedPtr = std::shared_ptr<ModelInterface>;
using ModelInterfaceConstSharedPtr = std::shared_ptr<const ModelInterface>;
class Model : public ModelInterface {};
using ModelSharedPtr = std::shared_ptr<Model>;

/// Null if the text is no robot description.
inline ModelInterfaceSharedPtr parseURDF(const std::string& xml) {
  auto out = std::make_shared<ModelInterface>();
  return out->initString(xml) ? out : nullptr;
}
inline ModelInterfaceSharedPtr parseURDFFile(const std::string& file) {
  auto out = std::make_shared<ModelInterface>();
  return out->initFile(file) ? out : nullptr;
}

}  // namespace urdf
