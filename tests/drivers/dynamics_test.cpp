// Dynamics against MuJoCo's: the same trees told to both.
#include "polyarm/kinematics/dynamics.hpp"

#include <gtest/gtest.h>

#if POLYARM_MUJOCO
#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <memory>
#include <string>

#include "polyarm/catalogue/catalogue.hpp"
#include "tests/kinematics/sample_trees.hpp"

namespace polyarm::kinematics::dynamics_test {
namespace {

using description::JointType;
using Values = std::vector<double>;

/// MuJoCo keeps an inertia as main axes and moments, found to about nine digits, to seven where two moments
/// are nearly the same: of the largest torque; and of accelerations, rad/s^2 or m/s^2.
struct Agreement {
  double torque = 1e-8, acceleration = 1e-5;
};
constexpr Agreement kOfTheCatalogue{1e-6, 1e-3};

std::string place(const Pose& pose) {
  const auto& [p, r] = pose;
  return fmt::format("pos=\"{:.17g} {:.17g} {:.17g}\" quat=\"{:.17g} {:.17g} {:.17g} {:.17g}\"", p.x, p.y,
                     p.z, r.w, r.x, r.y, r.z);
}

std::string inertial(const description::Link& link) {
  if (!link.inertial || !(link.inertial->mass > 0)) return "";
  const auto& [mass, c, i, estimated] = *link.inertial;
  return fmt::format(
      "<inertial pos=\"{:.17g} {:.17g} {:.17g}\" mass=\"{:.17g}\" "
      "fullinertia=\"{:.17g} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g}\"/>",
      c.x, c.y, c.z, mass, i[0], i[3], i[5], i[1], i[2], i[4]);
}

std::string joint_text(const description::Joint& joint) {
  const auto one = [&](const char* type, const std::string& name, const Vec3& axis) {
    return fmt::format("<joint name=\"{}\" type=\"{}\" axis=\"{:.17g} {:.17g} {:.17g}\"/>", name, type,
                       axis.x, axis.y, axis.z);
  };
  switch (joint.type) {
    case JointType::fixed:
      return "";
    case JointType::prismatic:
      return one("slide", joint.name, joint.axis);
    case JointType::revolute:
    case JointType::continuous:
      return one("hinge", joint.name, joint.axis);
    case JointType::planar: {
      const Quaternion turned = rotation_between({0, 0, 1}, joint.axis);
      return one("slide", joint.name, turned * Vec3{1, 0, 0}) +
             one("slide", joint.name + ".y", turned * Vec3{0, 1, 0}) +
             one("hinge", joint.name + ".z", turned * Vec3{0, 0, 1});
    }
    case JointType::floating:
      return one("slide", joint.name, {1, 0, 0}) + one("slide", joint.name + ".y", {0, 1, 0}) +
             one("slide", joint.name + ".z", {0, 0, 1}) +
             fmt::format("<joint name=\"{}.turn\" type=\"ball\"/>", joint.name);
  }
  return "";
}

void write_link(const description::RobotModel& model, int link, std::string& out) {
  out += inertial(model.links[static_cast<std::size_t>(link)]);
  for (const auto& joint : model.joints) {
    if (joint.parent_link != link) continue;
    out += fmt::format("<body {}>", place(joint.origin)) + joint_text(joint);
    write_link(model, joint.child_link, out);
    out += "</body>";
  }
}

/// `model` without mimic joints, as MuJoCo reads it.
std::string mjcf(const description::RobotModel& model, const TreeOptions& options) {
  std::string out = fmt::format(
      "<mujoco><compiler angle=\"radian\" autolimits=\"false\"/>"
      "<option gravity=\"{:.17g} {:.17g} {:.17g}\"><flag contact=\"disable\"/></option><worldbody>",
      options.gravity.x, options.gravity.y, options.gravity.z);
  description::Joint root;
  root.name = "root";
  if (options.root == RootJoint::floating) root.type = JointType::floating;
  if (options.root == RootJoint::planar) root.type = JointType::planar, root.axis = {0, 0, 1};
  out += fmt::format("<body {}>", place(options.T_world_base)) + joint_text(root);
  write_link(model, model.root, out);
  return out + "</body></worldbody></mujoco>";
}

struct Physics {
  std::unique_ptr<mjModel, void (*)(mjModel*)> model{nullptr, mj_deleteModel};
  std::unique_ptr<mjData, void (*)(mjData*)> data{nullptr, mj_deleteData};
};

Physics physics(const std::string& text) {
  Physics out;
  mjVFS vfs;
  mj_defaultVFS(&vfs);
  mj_makeEmptyFileVFS(&vfs, "model.xml", static_cast<int>(text.size()) + 1);
  std::memcpy(vfs.filedata[0], text.c_str(), text.size() + 1);
  char error[500] = "";
  out.model.reset(mj_loadXML("model.xml", &vfs, error, sizeof error));
  mj_deleteVFS(&vfs);
  if (out.model) out.data.reset(mj_makeData(out.model.get()));
  return out;
}

/// Where MuJoCo has the values of each of our joints: addresses of position and velocity for each part.
struct Place {
  int position = 0, velocity = 0;
};
std::vector<Place> places(const Physics& p, const TreeJoint& joint) {
  const auto find = [&](const std::string& name) {
    const int id = mj_name2id(p.model.get(), mjOBJ_JOINT, name.c_str());
    EXPECT_GE(id, 0) << name;
    return Place{p.model->jnt_qposadr[id], p.model->jnt_dofadr[id]};
  };
  std::vector<Place> out{find(joint.name)};
  if (joint.type == JointType::planar || joint.type == JointType::floating) {
    out.push_back(find(joint.name + ".y"));
    out.push_back(find(joint.name + ".z"));
  }
  if (joint.type == JointType::floating) {
    const Place turn = find(joint.name + ".turn");
    for (int i = 0; i < 3; ++i) out.push_back({turn.position, turn.velocity + i});
  }
  return out;
}

/// Our order of velocities in MuJoCo's.
std::vector<std::size_t> order(const Physics& p, const Tree& tree) {
  std::vector<std::size_t> out;
  for (const TreeJoint& joint : tree.joints())
    for (const Place& at : places(p, joint)) out.push_back(static_cast<std::size_t>(at.velocity));
  return out;
}

void set_positions(const Physics& p, const Tree& tree, const Values& q) {
  for (const TreeJoint& joint : tree.joints()) {
    const auto at = places(p, joint);
    const double* from = q.data() + joint.position;
    for (std::size_t i = 0; i < std::min<std::size_t>(3, joint.positions); ++i)
      p.data->qpos[at[i].position] = from[i];
    if (joint.type != JointType::floating) continue;
    const Quaternion r = normalized(Quaternion{from[3], from[4], from[5], from[6]});
    const double turn[] = {r.w, r.x, r.y, r.z};
    std::copy(turn, turn + 4, p.data->qpos + at[3].position);
  }
}

void compare(const test::SampleTree& sample, Random& random, Agreement agree = {}) {
  SCOPED_TRACE(sample.name);
  const Tree tree(sample.model, sample.options);
  Dynamics dynamics(tree);
  const Physics p = physics(mjcf(sample.model, sample.options));
  ASSERT_NE(p.data, nullptr);
  const std::size_t n = tree.velocities();
  ASSERT_EQ(static_cast<std::size_t>(p.model->nv), n);
  const auto theirs = order(p, tree);
  for (int i = 0; i < 3; ++i) {
    const Values q = test::any_state(tree, random), v = test::any_values(n, random),
                 a = test::any_values(n, random);
    set_positions(p, tree, q);
    for (std::size_t k = 0; k < n; ++k) {
      p.data->qvel[theirs[k]] = v[k];
      p.data->qacc[theirs[k]] = a[k];
    }
    Values tau(n), M(n * n), back(n), full(n * n);
    dynamics.inverse(q, v, a, tau);
    dynamics.mass_matrix(q, M);
    mj_inverse(p.model.get(), p.data.get());
    mj_fullM(p.model.get(), full.data(), p.data->qM);
    double size = 1;
    for (const double t : tau) size = std::max(size, std::abs(t));
    for (std::size_t k = 0; k < n; ++k) {
      ASSERT_NEAR(tau[k], p.data->qfrc_inverse[theirs[k]], agree.torque * size);
      for (std::size_t j = 0; j < n; ++j)
        ASSERT_NEAR(M[k * n + j], full[theirs[k] * n + theirs[j]], agree.torque * size);
    }
    if (!tree.massless_joints().empty()) continue;
    for (std::size_t k = 0; k < n; ++k) p.data->qfrc_applied[theirs[k]] = tau[k];
    mj_forward(p.model.get(), p.data.get());
    ASSERT_TRUE(dynamics.forward(q, v, tau, back));
    for (std::size_t k = 0; k < n; ++k) {
      ASSERT_NEAR(back[k], a[k], 1e-8);
      ASSERT_NEAR(p.data->qacc[theirs[k]], back[k], agree.acceleration);
    }
    std::fill_n(p.data->qfrc_applied, n, 0.0);
  }
}

TEST(DynamicsAndMuJoCo, AgreeOnTreesOfEveryTypeOfJoint) {
  Random random(21);
  for (auto sample : test::sample_trees()) {
    sample.model.actuated.clear();
    for (std::size_t j = 0; j < sample.model.joints.size(); ++j) {
      sample.model.joints[j].mimic.reset();
      if (sample.model.joints[j].moves()) sample.model.actuated.push_back(static_cast<int>(j));
    }
    compare(sample, random);
  }
}

/// Inertias that no body has are refused by MuJoCo, and so is what moves without mass: rounder ones instead.
void make_real(description::RobotModel& model, Random& random) {
  for (description::Link& link : model.links) {
    if (!link.inertial || !(link.inertial->mass > 1e-6)) {
      if (link.parent_joint >= 0) link.inertial = test::any_inertial(random);
      continue;
    }
    auto& i = link.inertial->inertia;
    const double more = std::abs(i[0]) + std::abs(i[3]) + std::abs(i[5]) +
                        2 * (std::abs(i[1]) + std::abs(i[2]) + std::abs(i[4])) + 1e-6;
    for (const std::size_t k : {0, 3, 5}) i[k] += more;
  }
}

/// All of the catalogue, as its files say; with inertias changed, in both, where MuJoCo does not take them.
TEST(DynamicsAndMuJoCo, AgreeOnEveryArmOfTheCatalogue) {
  const description::Catalogue catalogue({POLYARM_SOURCE_DIR "/robots"});
  Random random(22);
  int arms = 0, changed = 0;
  for (const std::string& name : catalogue.names()) {
    description::RobotModel model = catalogue.load(name);
    model.actuated.clear();
    for (std::size_t j = 0; j < model.joints.size(); ++j) {
      model.joints[j].mimic.reset();
      if (model.joints[j].moves()) model.actuated.push_back(static_cast<int>(j));
    }
    if (!physics(mjcf(model, {})).data) make_real(model, random), ++changed;
    compare({name, model, {}}, random, kOfTheCatalogue);
    ++arms;
    if (arms % 10 != 0) continue;
    model.links[static_cast<std::size_t>(model.root)].inertial = test::any_inertial(random);
    compare({name + " floating", model, {RootJoint::floating, {}, {0, 0, -9.81}}}, random, kOfTheCatalogue);
  }
  std::printf("%d robots, of %d inertias were changed\n", arms, changed);
  EXPECT_GT(arms, 300);
  EXPECT_LT(changed, arms / 4);
}

}  // namespace
}  // namespace polyarm::kinematics::dynamics_test
#endif
