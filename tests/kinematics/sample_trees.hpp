#pragma once
/// Trees at random for tests: every type of joint, branches, mimic joints, masses all over.
#include <algorithm>
#include <string>
#include <vector>

#include "polyarm/description/robot_model.hpp"
#include "polyarm/kinematics/random.hpp"
#include "polyarm/kinematics/tree.hpp"

namespace polyarm::test {

inline Vec3 any_vector(kinematics::Random& random, double size = 1) {
  return {random.between(-size, size), random.between(-size, size), random.between(-size, size)};
}
inline Quaternion any_rotation(kinematics::Random& random) {
  return from_rpy(random.between(-3, 3), random.between(-1.5, 1.5), random.between(-3, 3));
}

/// Three boxes of different density in a random place: a real body, so a real inertia.
inline description::Inertial any_inertial(kinematics::Random& random) {
  description::Inertial out;
  out.mass = random.between(0.3, 5);
  out.center = any_vector(random, 0.2);
  const Vec3 size{random.between(0.05, 0.3), random.between(0.05, 0.3), random.between(0.05, 0.3)};
  const Quaternion turn = any_rotation(random);
  const Vec3 axes[] = {turn * Vec3{1, 0, 0}, turn * Vec3{0, 1, 0}, turn * Vec3{0, 0, 1}};
  const double s[] = {size.x * size.x, size.y * size.y, size.z * size.z};
  const double main[] = {(s[1] + s[2]) * out.mass / 12, (s[0] + s[2]) * out.mass / 12,
                         (s[0] + s[1]) * out.mass / 12};
  for (int i = 0; i < 3; ++i) {
    const Vec3& a = axes[i];
    const double part[] = {a.x * a.x, a.x * a.y, a.x * a.z, a.y * a.y, a.y * a.z, a.z * a.z};
    for (std::size_t k = 0; k < 6; ++k) out.inertia[k] += main[i] * part[k];
  }
  return out;
}

struct TreeKind {
  std::size_t joints = 6;
  bool branches = false, mimic = false, aligned = false;
  std::vector<description::JointType> types{description::JointType::revolute};
};

inline description::RobotModel any_tree(kinematics::Random& random, const TreeKind& kind) {
  using description::JointType;
  description::RobotModel model;
  model.name = "tree";
  model.links.push_back({"link_0", any_inertial(random), {}, {}, -1});
  for (std::size_t i = 0; i < kind.joints; ++i) {
    description::Joint joint;
    const auto pick = [&](std::size_t n) { return static_cast<std::size_t>(random.unit() * double(n)); };
    joint.name = "joint_" + std::to_string(i);
    joint.type = kind.types[pick(kind.types.size())];
    joint.parent_link = static_cast<int>(kind.branches ? pick(i + 1) : i);
    joint.child_link = static_cast<int>(i + 1);
    const Vec3 straight[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {-1, 0, 0}, {0, -1, 0}, {0, 0, -1}};
    joint.origin = {any_vector(random, 0.4), kind.aligned ? Quaternion{} : any_rotation(random)};
    joint.axis = kind.aligned ? straight[pick(6)] : normalized(any_vector(random));
    const bool single = joint.type != JointType::planar && joint.type != JointType::floating;
    std::vector<int> before;
    for (const int j : model.actuated)
      if (const auto type = model.joints[static_cast<std::size_t>(j)].type;
          type != JointType::planar && type != JointType::floating)
        before.push_back(j);
    if (kind.mimic && single && joint.moves() && !before.empty() && random.unit() < 0.4)
      joint.mimic = {before[pick(before.size())], random.between(-2, 2), random.between(-1, 1)};
    else if (joint.moves())
      model.actuated.push_back(static_cast<int>(i));
    model.joints.push_back(joint);
    model.links.push_back(
        {"link_" + std::to_string(i + 1), any_inertial(random), {}, {}, static_cast<int>(i)});
  }
  return model;
}

struct SampleTree {
  std::string name;
  description::RobotModel model;
  kinematics::TreeOptions options;
};

inline std::vector<SampleTree> sample_trees() {
  using description::JointType;
  using kinematics::RootJoint;
  kinematics::Random random(3);
  const std::vector<JointType> turning{JointType::revolute, JointType::continuous};
  const std::vector<JointType> simple{JointType::revolute, JointType::prismatic, JointType::fixed};
  const std::vector<JointType> all{JointType::revolute, JointType::prismatic, JointType::planar,
                                   JointType::floating, JointType::continuous};
  const Pose somewhere{{0.4, -0.3, 0.8}, from_rpy(0.2, -0.4, 2.1)};
  std::vector<SampleTree> out;
  const auto add = [&](const char* name, const TreeKind& kind, RootJoint root) {
    out.push_back({name, any_tree(random, kind), {root, somewhere, {0.3, -0.2, -9.81}}});
  };
  add("aligned arm", {6, false, false, true, turning}, RootJoint::fixed);
  add("arm", {7, false, false, false, turning}, RootJoint::fixed);
  add("sliding arm", {9, false, false, false, simple}, RootJoint::fixed);
  add("branched", {12, true, false, true, simple}, RootJoint::fixed);
  add("mimic", {12, true, true, false, simple}, RootJoint::fixed);
  add("floating", {8, true, false, false, turning}, RootJoint::floating);
  add("floating mimic", {10, true, true, true, simple}, RootJoint::floating);
  add("planar", {6, true, false, false, simple}, RootJoint::planar);
  add("every type", {7, true, true, false, all}, RootJoint::floating);
  add("one", {1, false, false, false, turning}, RootJoint::fixed);
  return out;
}

/// Within pi of zero, quaternions anywhere, of a length that is not quite one.
inline std::vector<double> any_state(const kinematics::Tree& tree, kinematics::Random& random) {
  std::vector<double> q(tree.positions());
  for (double& value : q) value = random.between(-3, 3);
  for (const auto& joint : tree.joints()) {
    if (joint.type != description::JointType::floating) continue;
    const Quaternion r = any_rotation(random);
    double* at = q.data() + joint.position;
    at[0] /= 3, at[1] /= 3, at[2] /= 3;
    at[3] = r.x, at[4] = r.y, at[5] = r.z, at[6] = r.w;
  }
  return q;
}
inline std::vector<double> any_values(std::size_t n, kinematics::Random& random, double size = 2) {
  std::vector<double> out(n);
  for (double& value : out) value = random.between(-size, size);
  return out;
}

}  // namespace polyarm::test
