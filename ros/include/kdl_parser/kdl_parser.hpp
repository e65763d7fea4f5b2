#pragma once
/// A robot description as a tree of KDL. KDL itself is the system's (liborocos-kdl-dev).
#include <fstream>
#include <iterator>
#include <kdl/frames.hpp>
#include <kdl/joint.hpp>
#include <kdl/rigidbodyinertia.hpp>
#include <kdl/rotationalinertia.hpp>
#include <kdl/segment.hpp>
#include <kdl/tree.hpp>
#include <string>

#include "urdf/model.hpp"

namespace kdl_parser {

namespace detail {
inline KDL::Frame frame(const urdf::Pose& p) {
  return {KDL::Rotation::Quaternion(p.rotation.x, p.rotation.y, p.rotation.z, p.rotation.w),
          KDL::Vector(p.position.x, p.position.y, p.position.z)};
}
inline KDL::Joint joint(const urdf::Joint& j) {
  const KDL::Frame origin = frame(j.parent_to_joint_origin_transform);
  const KDL::Vector axis = origin.M * KDL::Vector(j.axis.x, j.axis.y, j.axis.z);
  if (j.type == urdf::Joint::REVOLUTE || j.type == urdf::Joint::CONTINUOUS)
    return KDL::Joint(j.name, origin.p, axis, KDL::Joint::RotAxis);
  if (j.type == urdf::Joint::PRISMATIC) return KDL::Joint(j.name, origin.p, axis, KDL::Joint::TransAxis);
  return KDL::Joint(j.name, KDL::Joint::None);
}
/// About the link's origin, in its axes.
inline KDL::RigidBodyInertia inertia(const urdf::Link& link) {
  if (!link.inertial) return KDL::RigidBodyInertia(0);
  const urdf::Inertial& b = *link.inertial;
  const KDL::Frame origin = frame(b.origin);
  const KDL::RigidBodyInertia turned =
      KDL::Frame(origin.M) *
      KDL::RigidBodyInertia(0, KDL::Vector::Zero(), KDL::RotationalInertia(b.ixx, b.iyy, b.izz, b.ixy, b.ixz, b.iyz));
  return KDL::RigidBodyInertia(b.mass, origin.p, turned.getRotationalInertia());
}
inline bool add(const urdf::Link& link, KDL::Tree& tree) {
  for (const auto& child : link.child_links) {
    const urdf::Joint& from = *child->parent_joint;
    const KDL::Segment segment(child->name, joint(from), frame(from.parent_to_joint_origin_transform), inertia(*child));
    if (!tree.addSegment(segment, link.name) || !add(*child, tree)) return false;
  }
  return true;
}
}  // namespace detail

inline bool treeFromUrdfModel(const urdf::ModelInterface& model, KDL::Tree& tree) {
  if (!model.getRoot()) return false;
  tree = KDL::Tree(model.getRoot()->name);
  return detail::add(*model.getRoot(), tree);
}
inline bool treeFromString(const std::string& xml, KDL::Tree& tree) {
  urdf::ModelInterface model;
  return model.initString(xml) && treeFromUrdfModel(model, tree);
}
inline bool treeFromFile(const std::string& file, KDL::Tree& tree) {
  std::ifstream in(file);
  return in && treeFromString({std::istreambuf_iterator<char>(in), {}}, tree);
}

}  // namespace kdl_parser
