#include "polyarm/kinematics/tree_builder.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>

#include "polyarm/base/error.hpp"

namespace polyarm::kinematics {

using description::Joint;
using description::JointType;

namespace {

/// Components of directions and lengths (m) below this count as zero: they are rounding errors.
constexpr double kNothing = 5e-15;

[[noreturn]] void refuse(const std::string& what) {
  throw Error("bad-model", what, "correct the robot's description");
}

Vec3 without_noise(Vec3 v) {
  for (double* c : {&v.x, &v.y, &v.z})
    if (std::abs(*c) < kNothing) *c = 0;
  return v;
}

void copy(double* to, const Vec3& v) {
  to[0] = v.x, to[1] = v.y, to[2] = v.z;
}

bool finite(const Pose& p) {
  const double sum =
      p.position.x + p.position.y + p.position.z + p.rotation.x + p.rotation.y + p.rotation.z + p.rotation.w;
  return std::isfinite(sum);
}

std::size_t index_in(std::size_t size, int i, const std::string& what) {
  if (i < 0 || static_cast<std::size_t>(i) >= size) refuse(what + " does not exist");
  return static_cast<std::size_t>(i);
}

bool has_axes(JointType type) {
  return type == JointType::planar || type == JointType::floating;
}

TreeJoint tree_joint(const std::string& name, JointType type) {
  TreeJoint out{name, type};
  if (type == JointType::planar) out.positions = out.velocities = 3;
  if (type == JointType::floating) out.positions = 7, out.velocities = 6;
  return out;
}

}  // namespace

TreeBuilder::TreeBuilder(const description::RobotModel& model, const TreeOptions& options, Tree& out)
    : model_{model},
      options_{options},
      out_{out},
      at_zero_(model.links.size()),
      joint_of_(model.joints.size(), -1) {}

TreeBuilder::Drive TreeBuilder::drive_of(int joint) const {
  Drive out;
  for (std::size_t followed = 0; followed <= model_.joints.size(); ++followed) {
    const Joint& at = model_.joints[index_in(model_.joints.size(), joint, "a joint that is followed")];
    if (!at.mimic) {
      if (joint_of_[static_cast<std::size_t>(joint)] >= 0) out.joint = joint;
      return out;
    }
    if (has_axes(at.type)) refuse("the mimic joint '" + at.name + "' is planar or floating");
    out.offset += out.ratio * at.mimic->offset;
    out.ratio *= at.mimic->multiplier;
    joint = at.mimic->joint;
    const auto next = index_in(model_.joints.size(), joint, "the joint that '" + at.name + "' mimics");
    if (has_axes(model_.joints[next].type)) refuse("'" + at.name + "' mimics a planar or floating joint");
  }
  refuse("mimic joints follow each other in a circle");
}

void TreeBuilder::add_joint(const TreeJoint& joint) {
  out_.joints_.push_back(joint);
  out_.joints_.back().position = out_.model_.positions;
  out_.joints_.back().velocity = out_.model_.velocities;
  out_.model_.positions += joint.positions;
  out_.model_.velocities += joint.velocities;
}

void TreeBuilder::number_joints() {
  if (options_.root == RootJoint::planar) add_joint(tree_joint("root", JointType::planar));
  if (options_.root == RootJoint::floating) add_joint(tree_joint("root", JointType::floating));
  for (const int i : model_.actuated) {
    const std::size_t at = index_in(model_.joints.size(), i, "an actuated joint");
    joint_of_[at] = static_cast<int>(out_.joints_.size());
    add_joint(tree_joint(model_.joints[at].name, model_.joints[at].type));
  }
}

int TreeBuilder::add_step(Motion motion, const Vec3& h, const Vec3& origin, int parent, std::size_t position,
                          std::size_t velocity, double ratio) {
  TreeStep step;
  step.motion = motion;
  step.parent = parent;
  step.position = position;
  step.velocity = velocity;
  step.ratio = ratio;
  Vec3 axis = normalized(without_noise(h));
  if (motion == Motion::turn_any) {
    const bool x = axis.x != 0, y = axis.y != 0, z = axis.z != 0;
    if (x + y + z == 1) {
      step.motion = x ? Motion::turn_x : y ? Motion::turn_y : Motion::turn_z;
      if (axis.x + axis.y + axis.z < 0) axis = -axis, step.ratio = -ratio;
    }
  }
  copy(step.h, axis);
  const Vec3 from = parent < 0 ? Vec3{} : origins_[static_cast<std::size_t>(parent)];
  copy(step.p, without_noise(origin - from));
  steps_.push_back(step);
  origins_.push_back(origin);
  return static_cast<int>(steps_.size()) - 1;
}

int TreeBuilder::add_steps(const TreeJoint& joint, const Vec3& axis, const Pose& at, int from_step,
                           double ratio) {
  const std::size_t q = joint.position, v = joint.velocity;
  const Vec3 axes[] = {at.rotation * Vec3{1, 0, 0}, at.rotation * Vec3{0, 1, 0}, at.rotation * Vec3{0, 0, 1}};
  if (joint.type == JointType::planar) {
    const Quaternion turned = at.rotation * rotation_between({0, 0, 1}, normalized(axis));
    const int x = add_step(Motion::slide, turned * Vec3{1, 0, 0}, at.position, from_step, q, v, 1);
    const int y = add_step(Motion::slide, turned * Vec3{0, 1, 0}, at.position, x, q + 1, v + 1, 1);
    return add_step(Motion::turn_any, turned * Vec3{0, 0, 1}, at.position, y, q + 2, v + 2, 1);
  }
  if (joint.type == JointType::floating) {
    int last = from_step;
    for (std::size_t i = 0; i < 3; ++i)
      last = add_step(Motion::slide, axes[i], at.position, last, q + i, v + i, 1);
    for (std::size_t i = 0; i < 3; ++i) {
      last = add_step(i == 0 ? Motion::ball : Motion::held, axes[i], at.position, last, q + 3, v + 3 + i, 1);
      for (std::size_t k = 0; k < 3; ++k) copy(steps_.back().ball_axes + 3 * k, axes[k]);
    }
    return last;
  }
  const bool slides = joint.type == JointType::prismatic;
  return add_step(slides ? Motion::slide : Motion::turn_any, at.rotation * normalized(axis), at.position,
                  from_step, q, v, ratio);
}

void TreeBuilder::add_root() {
  const std::size_t root = index_in(model_.links.size(), model_.root, "the root link");
  at_zero_[root] = {};
  Tree::Link& link = out_.links_[root];
  if (options_.root != RootJoint::fixed) link.step = add_steps(out_.joints_.front(), {0, 0, 1}, {}, -1, 1);
  add_body(model_.root);
}

void TreeBuilder::add_link_of(int j) {
  const Joint& joint = model_.joints[static_cast<std::size_t>(j)];
  const std::size_t parent =
      index_in(model_.links.size(), joint.parent_link, "the parent of '" + joint.name + "'");
  const std::size_t child =
      index_in(model_.links.size(), joint.child_link, "the child of '" + joint.name + "'");
  if (!finite(joint.origin)) refuse("the origin of '" + joint.name + "' has a number that is not finite");
  Pose at = at_zero_[parent] * joint.origin;
  at.rotation = normalized(at.rotation);
  int step = out_.links_[parent].step;
  const Drive drive = joint.moves() ? drive_of(j) : Drive{};
  if (drive.joint >= 0 && drive.ratio != 0) {
    TreeJoint own = out_.joints_[static_cast<std::size_t>(joint_of_[static_cast<std::size_t>(drive.joint)])];
    own.type = joint.type;
    step = add_steps(own, joint.axis, at, step, drive.ratio);
  }
  const Vec3 axis = normalized(joint.axis);
  if (joint.type == JointType::prismatic) {
    at.position = at * (drive.offset * axis);
    // A slide has no position of its own: it starts at its offset.
    if (step != out_.links_[parent].step) {
      TreeStep& last = steps_.back();
      const Vec3 from = last.parent < 0 ? Vec3{} : origins_[static_cast<std::size_t>(last.parent)];
      origins_.back() = at.position;
      copy(last.p, without_noise(at.position - from));
    }
  } else if (!has_axes(joint.type) && joint.moves()) {
    at.rotation = normalized(at.rotation * from_axis_angle(axis, drive.offset));
  }
  at_zero_[child] = at;
  out_.links_[child].step = step;
  add_body(joint.child_link);
}

void TreeBuilder::add_body(int i) {
  Tree::Link& link = out_.links_[static_cast<std::size_t>(i)];
  const Pose& at = at_zero_[static_cast<std::size_t>(i)];
  const Vec3 origin = link.step < 0 ? Vec3{} : origins_[static_cast<std::size_t>(link.step)];
  link.from_step = {at.position - origin, at.rotation};
  const auto& inertial = model_.links[static_cast<std::size_t>(i)].inertial;
  if (link.step < 0 || !inertial || !(inertial->mass > 0)) return;
  TreeStep& step = steps_[static_cast<std::size_t>(link.step)];
  const Vec3 c = link.from_step * inertial->center;
  const double m = inertial->mass;
  const auto& I = inertial->inertia;
  // Columns of R I, then R I R^T, then parallel axes.
  const Vec3 x = at.rotation * Vec3{I[0], I[1], I[2]}, y = at.rotation * Vec3{I[1], I[3], I[4]},
             z = at.rotation * Vec3{I[2], I[4], I[5]};
  const Vec3 rx = at.rotation * Vec3{x.x, y.x, z.x}, ry = at.rotation * Vec3{x.y, y.y, z.y},
             rz = at.rotation * Vec3{x.z, y.z, z.z};
  const double about_origin[] = {
      rx.x + m * (c.y * c.y + c.z * c.z), rx.y - m * c.x * c.y, rx.z - m * c.x * c.z,
      ry.y + m * (c.x * c.x + c.z * c.z), ry.z - m * c.y * c.z, rz.z + m * (c.x * c.x + c.y * c.y)};
  step.mass += m;
  step.moment[0] += m * c.x, step.moment[1] += m * c.y, step.moment[2] += m * c.z;
  for (std::size_t k = 0; k < 6; ++k) step.inertia[k] += about_origin[k];
  for (const double value : about_origin)
    if (!std::isfinite(value))
      refuse("the inertia of '" + model_.links[static_cast<std::size_t>(i)].name + "' is not finite");
}

void TreeBuilder::build() {
  if (!finite(options_.T_world_base)) refuse("the base's pose has a number that is not finite");
  out_.links_.resize(model_.links.size());
  out_.T_world_reference_ = options_.T_world_base;
  out_.T_world_reference_.rotation = normalized(options_.T_world_base.rotation);
  out_.gravity_ = options_.gravity;
  copy(out_.model_.gravity, inverse(out_.T_world_reference_.rotation) * options_.gravity);
  number_joints();
  add_root();
  std::vector<bool> placed(model_.links.size(), false);
  placed[static_cast<std::size_t>(model_.root)] = true;
  for (std::size_t j = 0; j < model_.joints.size(); ++j) {
    const Joint& joint = model_.joints[j];
    const auto parent =
        index_in(model_.links.size(), joint.parent_link, "the parent of '" + joint.name + "'");
    const auto child = index_in(model_.links.size(), joint.child_link, "the child of '" + joint.name + "'");
    if (!placed[parent] || placed[child]) refuse("the links around '" + joint.name + "' form a circle");
    placed[child] = true;
    add_link_of(static_cast<int>(j));
  }
  auto steps = std::make_shared<const std::vector<TreeStep>>(std::move(steps_));
  out_.model_.step = steps->data();
  out_.model_.steps = steps->size();
  out_.steps_ = std::move(steps);
}

}  // namespace polyarm::kinematics
