#pragma once
/// What Polyarm knows of a robot as a robot description: links with masses and shapes, joints with origins,
/// axes and limits. And limits of joints as structs.
#include <cmath>
#include <map>
#include <sstream>
#include <string>
#include <unordered_map>
#include <vector>

#include "joint_limits/joint_limits.hpp"
#include "polyarm/controllers/controller.hpp"
#include "polyarm/description/robot_model.hpp"

namespace polyarm_ros {

inline std::string xml_text(const std::string& text) {
  std::string out;
  for (const char c : text)
    out += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '"' ? "&quot;" : std::string(1, c);
  return out;
}

inline void write_origin(std::ostream& out, const polyarm::Pose& pose) {
  const polyarm::Quaternion& q = pose.rotation;
  const double sine = std::fmax(-1, std::fmin(1, 2 * (q.w * q.y - q.z * q.x)));
  out << "<origin xyz=\"" << pose.position.x << " " << pose.position.y << " " << pose.position.z << "\" rpy=\""
      << std::atan2(2 * (q.w * q.x + q.y * q.z), 1 - 2 * (q.x * q.x + q.y * q.y)) << " " << std::asin(sine)
      << " " << std::atan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y * q.y + q.z * q.z)) << "\"/>";
}

inline void write_geometry(std::ostream& out, const polyarm::description::Shape& shape) {
  using polyarm::description::ShapeKind;
  const auto three = [&](const polyarm::Vec3& v) { out << v.x << " " << v.y << " " << v.z; };
  const auto round = [&](const char* name) {
    out << "<" << name << " radius=\"" << shape.radius << "\"";
    if (shape.kind != ShapeKind::sphere) out << " length=\"" << shape.length << "\"";
    out << "/>";
  };
  out << "<geometry>";
  switch (shape.kind) {
    case ShapeKind::box:
      out << "<box size=\"", three(shape.size), out << "\"/>";
      break;
    case ShapeKind::cylinder:
      round("cylinder");
      break;
    case ShapeKind::sphere:
      round("sphere");
      break;
    case ShapeKind::capsule:
      round("capsule");
      break;
    case ShapeKind::mesh:
      out << "<mesh filename=\"" << xml_text(shape.mesh) << "\" scale=\"", three(shape.scale), out << "\"/>";
  }
  out << "</geometry>";
}

inline void write_shapes(std::ostream& out, const char* part,
                         const std::vector<polyarm::description::Shape>& shapes) {
  for (const polyarm::description::Shape& shape : shapes) {
    out << "<" << part << ">";
    write_origin(out, shape.pose);
    write_geometry(out, shape);
    out << "</" << part << ">";
  }
}

inline void write_link(std::ostream& out, const polyarm::description::Link& link) {
  out << "<link name=\"" << xml_text(link.name) << "\">";
  if (link.inertial) {
    const auto& body = *link.inertial;
    static const char* const names[] = {"ixx", "ixy", "ixz", "iyy", "iyz", "izz"};
    out << "<inertial><origin xyz=\"" << body.center.x << " " << body.center.y << " " << body.center.z
        << "\" rpy=\"0 0 0\"/><mass value=\"" << body.mass << "\"/><inertia";
    for (std::size_t i = 0; i < 6; ++i) out << " " << names[i] << "=\"" << body.inertia[i] << "\"";
    out << "/></inertial>";
  }
  write_shapes(out, "visual", link.visuals);
  write_shapes(out, "collision", link.collisions);
  out << "</link>";
}

inline void write_joint(std::ostream& out, const polyarm::description::RobotModel& model,
                        const polyarm::description::Joint& joint) {
  static const char* const types[] = {"fixed", "revolute", "continuous", "prismatic", "planar", "floating"};
  if (joint.parent_link < 0 || joint.child_link < 0) return;  // a description without links
  const auto link = [&](int i) { return xml_text(model.links[static_cast<std::size_t>(i)].name); };
  out << "<joint name=\"" << xml_text(joint.name) << "\" type=\"" << types[static_cast<int>(joint.type)]
      << "\"><parent link=\"" << link(joint.parent_link) << "\"/><child link=\"" << link(joint.child_link)
      << "\"/>";
  write_origin(out, joint.origin);
  out << "<axis xyz=\"" << joint.axis.x << " " << joint.axis.y << " " << joint.axis.z << "\"/>";
  const auto& limits = joint.limits;
  if (joint.moves()) {
    out << "<limit";
    if (limits.lower) out << " lower=\"" << *limits.lower << "\"";
    if (limits.upper) out << " upper=\"" << *limits.upper << "\"";
    out << " velocity=\"" << limits.velocity.value_or(0) << "\" effort=\"" << limits.effort.value_or(0)
        << "\"/>";
  }
  if (joint.mimic && joint.mimic->joint >= 0)
    out << "<mimic joint=\"" << xml_text(model.joints[static_cast<std::size_t>(joint.mimic->joint)].name)
        << "\" multiplier=\"" << joint.mimic->multiplier << "\" offset=\"" << joint.mimic->offset << "\"/>";
  out << "</joint>";
}

/// `inside`: more elements of <robot>.
inline std::string robot_text(const polyarm::description::RobotModel& model, const std::string& inside = {}) {
  std::ostringstream out;
  out.precision(17);
  out << "<?xml version=\"1.0\"?><robot name=\"" << xml_text(model.name) << "\">";
  for (const auto& link : model.links) write_link(out, link);
  for (const auto& joint : model.joints) write_joint(out, model, joint);
  out << inside << "</robot>";
  return out.str();
}

inline void note_limits(const std::string& name, const polyarm::controllers::JointFacts& from,
                        std::unordered_map<std::string, joint_limits::JointLimits>& hard,
                        std::unordered_map<std::string, joint_limits::SoftJointLimits>& soft) {
  joint_limits::JointLimits limits;
  const auto note = [](double value, double& to, bool& has) {
    if ((has = std::isfinite(value))) to = value;
  };
  note(from.lower, limits.min_position, limits.has_position_limits);
  note(from.upper, limits.max_position, limits.has_position_limits);
  note(from.velocity, limits.max_velocity, limits.has_velocity_limits);
  note(from.acceleration, limits.max_acceleration, limits.has_acceleration_limits);
  note(from.deceleration, limits.max_deceleration, limits.has_deceleration_limits);
  note(from.jerk, limits.max_jerk, limits.has_jerk_limits);
  note(from.effort, limits.max_effort, limits.has_effort_limits);
  limits.angle_wraparound = from.continuous;
  hard[name] = limits;
  if (from.soft)
    soft[name] = {from.soft->lower, from.soft->upper, from.soft->k_position, from.soft->k_velocity};
}

}  // namespace polyarm_ros
