#include "polyarm/kinematics/dynamics.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "polyarm/catalogue/catalogue.hpp"
#include "tests/kinematics/sample_states.hpp"
#include "tests/kinematics/sample_trees.hpp"
#include "tests/support/realtime_guard.hpp"

namespace polyarm::kinematics {
namespace {

using Values = std::vector<double>;

/// Trees at random and, where `robots`, every robot of the catalogue.
std::vector<test::SampleTree> trees(bool robots) {
  auto out = test::sample_trees();
  if (!robots) return out;
  const description::Catalogue catalogue({POLYARM_SOURCE_DIR "/robots"});
  for (const std::string& name : catalogue.names()) out.push_back({name, catalogue.load(name), {}});
  return out;
}

std::vector<std::string> names_of(const Tree& tree) {
  std::vector<std::string> out;
  for (const TreeJoint& joint : tree.joints()) out.push_back(joint.name);
  return out;
}

/// For robots of the catalogue whose last link has no mass, because the source has none for it.
bool moves_nothing(Dynamics& dynamics) {
  if (dynamics.tree().massless_joints().empty()) return false;
  const Values q = dynamics.tree().neutral(), zero(dynamics.tree().velocities(), 0.0);
  Values out(zero.size());
  EXPECT_FALSE(dynamics.forward(q, zero, zero, out));
  return true;
}

double largest(const Values& values) {
  double out = 0;
  for (const double v : values) out = std::max(out, std::abs(v));
  return out;
}
double product(const Values& a, const Values& b) {
  double out = 0;
  for (std::size_t i = 0; i < a.size(); ++i) out += a[i] * b[i];
  return out;
}

/// A tree, its dynamics and a state, with results as values.
struct Robot {
  Tree tree;
  Dynamics dynamics;
  std::size_t n;
  explicit Robot(const test::SampleTree& sample, InstructionSet set = fastest_instructions())
      : tree(sample.model, sample.options), dynamics(tree, set), n(tree.velocities()) {}
  Values inverse(const Values& q, const Values& v, const Values& a) {
    Values out(n);
    dynamics.inverse(q, v, a, out);
    return out;
  }
  Values gravity(const Values& q) {
    Values out(n);
    dynamics.gravity(q, out);
    return out;
  }
  Values mass(const Values& q) {
    Values out(n * n);
    dynamics.mass_matrix(q, out);
    return out;
  }
  Values forward(const Values& q, const Values& v, const Values& tau) {
    Values out(n);
    EXPECT_TRUE(dynamics.forward(q, v, tau, out));
    return out;
  }
  double energy(const Values& q, const Values& v) {
    const Values M = mass(q);
    double out = tree.potential_energy(q);
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j) out += 0.5 * v[i] * M[i * n + j] * v[j];
    return out;
  }
};

/// Whether Cholesky's decomposition exists.
bool positive_definite(Values M, std::size_t n) {
  for (std::size_t j = 0; j < n; ++j) {
    if (!(M[j * n + j] > 0)) return false;
    for (std::size_t i = j + 1; i < n; ++i) {
      const double l = M[i * n + j] / M[j * n + j];
      for (std::size_t k = j; k < n; ++k) M[i * n + k] -= l * M[j * n + k];
    }
  }
  return true;
}

TEST(Dynamics, MassMatrixIsSymmetricPositiveDefiniteAndWhatAccelerationsAskFor) {
  Random random(1);
  for (const auto& sample : trees(true)) {
    Robot robot(sample);
    const std::size_t n = robot.n;
    for (int i = 0; i < 3; ++i) {
      const Values q = test::any_state(robot.tree, random), M = robot.mass(q), rest(n, 0.0);
      const Values held = robot.gravity(q);
      for (std::size_t j = 0; j < n; ++j) {
        Values unit(n, 0.0);
        unit[j] = 1;
        const Values column = robot.inverse(q, rest, unit);
        for (std::size_t k = 0; k < n; ++k) {
          ASSERT_EQ(M[k * n + j], M[j * n + k]);
          ASSERT_NEAR(M[k * n + j], column[k] - held[k], 1e-12 * (1 + largest(column))) << sample.name;
        }
      }
      ASSERT_NE(positive_definite(M, n), moves_nothing(robot.dynamics)) << sample.name;
    }
  }
}

TEST(Dynamics, ForwardIsTheInverseOfInverse) {
  Random random(2);
  for (const auto& sample : trees(true)) {
    Robot robot(sample);
    if (moves_nothing(robot.dynamics)) continue;
    for (int i = 0; i < 5; ++i) {
      const Values q = test::any_state(robot.tree, random), v = test::any_values(robot.n, random),
                   tau = test::any_values(robot.n, random, 50);
      const Values a = robot.forward(q, v, tau), back = robot.inverse(q, v, a);
      for (std::size_t k = 0; k < robot.n; ++k)
        ASSERT_NEAR(back[k], tau[k],
                    1e-10 * (1 + largest(tau) + largest(robot.inverse(q, v, Values(robot.n, 0.0)))))
            << sample.name;
    }
  }
}

TEST(Dynamics, GravityTorquesAreTheSlopeOfThePotentialEnergy) {
  Random random(3);
  constexpr double kStep = 1e-5;
  for (const auto& sample : trees(true)) {
    Robot robot(sample);
    const Values q = test::any_state(robot.tree, random), held = robot.gravity(q);
    const double size = 1 + robot.tree.mass() * 10;
    for (std::size_t j = 0; j < robot.n; ++j) {
      Values unit(robot.n, 0.0), a = q, b = q;
      unit[j] = 1;
      robot.tree.integrate(a, unit, -kStep);
      robot.tree.integrate(b, unit, kStep);
      const double slope = (robot.tree.potential_energy(b) - robot.tree.potential_energy(a)) / (2 * kStep);
      ASSERT_NEAR(held[j], slope, 1e-8 * size) << sample.name << " " << j;
    }
  }
}

TEST(Dynamics, EnergyChangesByTheWorkOfTheTorques) {
  Random random(4);
  constexpr double kStep = 1e-4;
  for (const auto& sample : trees(true)) {
    Robot robot(sample);
    if (moves_nothing(robot.dynamics)) continue;
    const std::size_t n = robot.n;
    const Values q = test::any_state(robot.tree, random), v = test::any_values(n, random),
                 tau = test::any_values(n, random, 20), a = robot.forward(q, v, tau);
    // So light a link may be that its acceleration makes of this step a long way.
    const double step = kStep / (1 + 0.1 * largest(a));
    const auto energy_after = [&](double t) {
      Values moved = q, faster = v, way(n);
      for (std::size_t i = 0; i < n; ++i) {
        way[i] = v[i] + 0.5 * t * a[i];
        faster[i] += t * a[i];
      }
      robot.tree.integrate(moved, way, t);
      return robot.energy(moved, faster);
    };
    const double power = (energy_after(step) - energy_after(-step)) / (2 * step);
    double scale = 1;
    for (std::size_t i = 0; i < n; ++i) scale += std::abs(tau[i] * v[i]);
    const double rounding = 1e-14 * (1 + std::abs(robot.energy(q, v))) / step;
    ASSERT_NEAR(power, product(tau, v), 1e-4 * scale + rounding) << sample.name;
  }
}

TEST(Dynamics, AFreeMotionKeepsItsEnergy) {
  Random random(5);
  constexpr double kStep = 2e-4;
  for (const auto& sample : trees(false)) {
    Robot robot(sample);
    const std::size_t n = robot.n;
    const Values rest(n, 0.0);
    Values q = test::any_state(robot.tree, random), v = test::any_values(n, random, 1);
    const double before = robot.energy(q, v);
    double moved = 0;
    for (int i = 0; i < 1000; ++i) {
      // Midpoint rule.
      Values half = q, half_v = v;
      robot.tree.integrate(half, v, kStep / 2);
      const Values a = robot.forward(q, v, rest);
      for (std::size_t k = 0; k < n; ++k) half_v[k] += kStep / 2 * a[k];
      const Values middle = robot.forward(half, half_v, rest);
      robot.tree.integrate(q, half_v, kStep);
      for (std::size_t k = 0; k < n; ++k) v[k] += kStep * middle[k];
      moved = std::max(moved, std::abs(robot.tree.potential_energy(q) - before));
    }
    EXPECT_NEAR(robot.energy(q, v), before, 2e-4 * (1 + moved)) << sample.name;
    EXPECT_GT(moved, 0.01) << sample.name;
  }
}

TEST(Dynamics, AMimicJointWeighsOnTheOneItFollows) {
  Random random(6);
  for (const auto& sample : trees(false)) {
    auto loose = sample;
    std::vector<std::size_t> all;
    loose.model.actuated.clear();
    for (std::size_t j = 0; j < loose.model.joints.size(); ++j) {
      loose.model.joints[j].mimic.reset();
      if (loose.model.joints[j].moves()) loose.model.actuated.push_back(static_cast<int>(j));
    }
    Robot tied(sample), free(loose);
    const Values q = test::any_state(tied.tree, random), v = test::any_values(tied.n, random),
                 a = test::any_values(tied.n, random);
    Values q2 = free.tree.neutral(), v2(free.n), a2(free.n);
    std::vector<double> ratio(free.n, 1);
    std::vector<std::size_t> of(free.n);
    for (const TreeJoint& joint : free.tree.joints()) {
      const auto find = [&](const std::string& name) {
        return std::find_if(tied.tree.joints().begin(), tied.tree.joints().end(),
                            [&](const TreeJoint& other) { return other.name == name; });
      };
      double offset = 0, factor = 1;
      std::string name = joint.name;
      if (const int j = sample.model.find_joint(name); j >= 0)
        if (const auto& mimic = sample.model.joints[static_cast<std::size_t>(j)].mimic) {
          name = sample.model.joints[static_cast<std::size_t>(mimic->joint)].name;
          factor = mimic->multiplier, offset = mimic->offset;
        }
      const auto from = find(name);
      ASSERT_NE(from, tied.tree.joints().end());
      for (std::size_t i = 0; i < joint.positions; ++i)
        q2[joint.position + i] = factor * q[from->position + i] + offset;
      for (std::size_t i = 0; i < joint.velocities; ++i) {
        of[joint.velocity + i] = from->velocity + i;
        ratio[joint.velocity + i] = factor;
        v2[joint.velocity + i] = factor * v[from->velocity + i];
        a2[joint.velocity + i] = factor * a[from->velocity + i];
      }
    }
    const Values is = tied.inverse(q, v, a), each = free.inverse(q2, v2, a2);
    Values want(tied.n, 0.0);
    for (std::size_t i = 0; i < free.n; ++i) want[of[i]] += ratio[i] * each[i];
    for (std::size_t i = 0; i < tied.n; ++i)
      ASSERT_NEAR(is[i], want[i], 1e-12 * (1 + largest(each))) << sample.name;
  }
}

TEST(Dynamics, ABatchIsOneStateAfterTheOtherBitByBit) {
  Random random(7);
  for (const auto& sample : trees(false))
    for (const InstructionSet set : test::kInstructionSets)
      for (const std::size_t count : {2u, 8u, 13u}) {
        Robot robot(sample, set);
        const std::size_t n = robot.n, m = robot.tree.positions();
        Values q(count * m), v(count * n), a(count * n), columns_q(count * m), columns_v(count * n),
            columns_a(count * n);
        for (std::size_t s = 0; s < count; ++s) {
          const Values one = test::any_state(robot.tree, random);
          for (std::size_t i = 0; i < m; ++i) q[s * m + i] = columns_q[i * count + s] = one[i];
          for (std::size_t i = 0; i < n; ++i) {
            v[s * n + i] = columns_v[i * count + s] = random.between(-2, 2);
            a[s * n + i] = columns_a[i * count + s] = random.between(-9, 9);
          }
        }
        Values tau(count * n), columns_tau(count * n), M(count * n * n), out(count * n), held(count * n);
        robot.dynamics.inverse_batch(BatchLayout::state_after_state, count, q, v, a, tau);
        robot.dynamics.inverse_batch(BatchLayout::joint_after_joint, count, columns_q, columns_v, columns_a,
                                     columns_tau);
        robot.dynamics.mass_matrix_batch(BatchLayout::joint_after_joint, count, columns_q, M);
        robot.dynamics.gravity_batch(BatchLayout::state_after_state, count, q, held);
        ASSERT_TRUE(robot.dynamics.forward_batch(BatchLayout::state_after_state, count, q, v, a, out));
        for (std::size_t s = 0; s < count; ++s) {
          const auto part = [&](const Values& from, std::size_t size) {
            return Values(from.begin() + static_cast<long>(s * size),
                          from.begin() + static_cast<long>((s + 1) * size));
          };
          const Values one_q = part(q, m), one_v = part(v, n), one_a = part(a, n), mass = robot.mass(one_q);
          ASSERT_EQ(part(tau, n), robot.inverse(one_q, one_v, one_a)) << sample.name;
          ASSERT_EQ(part(held, n), robot.gravity(one_q));
          ASSERT_EQ(part(out, n), robot.forward(one_q, one_v, one_a));
          for (std::size_t i = 0; i < n; ++i) ASSERT_EQ(columns_tau[i * count + s], tau[s * n + i]);
          for (std::size_t i = 0; i < n * n; ++i) ASSERT_EQ(M[i * count + s], mass[i]);
        }
      }
}

TEST(Dynamics, InstructionSetsAgreeButForRounding) {
  Random random(8);
  for (const auto& sample : trees(false)) {
    Robot wide(sample), narrow(sample, InstructionSet::portable);
    const Values q = test::any_state(wide.tree, random), v = test::any_values(wide.n, random),
                 a = test::any_values(wide.n, random);
    const Values x = wide.inverse(q, v, a), y = narrow.inverse(q, v, a);
    for (std::size_t i = 0; i < wide.n; ++i) ASSERT_NEAR(x[i], y[i], 1e-12 * (1 + largest(x))) << sample.name;
  }
}

TEST(Dynamics, SaysWhereNothingIsMoved) {
  auto model = test::sample_trees().front().model;
  for (auto& link : model.links) link.inertial.reset();
  Tree tree(model);
  Dynamics dynamics(tree);
  const Values zero(tree.velocities(), 0.0);
  Values out(tree.velocities());
  EXPECT_FALSE(dynamics.forward(zero, zero, zero, out));
  EXPECT_EQ(tree.massless_joints(), names_of(tree));
}

TEST(Dynamics, APendulumSwingsAsTheTextbookSays) {
  description::RobotModel model;
  model.links.push_back({"base", {}, {}, {}, -1});
  model.links.push_back(
      {"rod", description::Inertial{2, {0, 0, -0.5}, {0.1, 0, 0, 0.1, 0, 0.02}}, {}, {}, 0});
  description::Joint joint;
  joint.name = "pivot", joint.type = description::JointType::continuous;
  joint.parent_link = 0, joint.child_link = 1, joint.axis = {1, 0, 0};
  model.joints.push_back(joint);
  model.actuated = {0};
  Robot robot({"pendulum", model, {}});
  const double q = 0.7, inertia = 0.1 + 2 * 0.25;
  EXPECT_NEAR(robot.mass({q})[0], inertia, 1e-15);
  EXPECT_NEAR(robot.gravity({q})[0], 2 * 9.81 * 0.5 * std::sin(q), 1e-14);
  EXPECT_NEAR(robot.forward({q}, {3}, {0})[0], -2 * 9.81 * 0.5 * std::sin(q) / inertia, 1e-13);
}

TEST(Dynamics, MayBeCalledInTheControlCycle) {
  Random random(9);
  for (const auto& sample : trees(false)) {
    Robot robot(sample);
    const std::size_t n = robot.n;
    const Values q = test::any_state(robot.tree, random), v = test::any_values(n, random);
    Values tau(n), a(n), M(n * n), J(6 * n), moving = q;
    std::string violations;
    {
      const test::RealtimeGuard guard;
      for (int i = 0; i < 50; ++i) {
        robot.dynamics.inverse(q, v, v, tau);
        robot.dynamics.bias(q, v, tau);
        robot.dynamics.gravity(q, tau);
        robot.dynamics.mass_matrix(q, M);
        (void)robot.dynamics.forward(q, v, tau, a);
        robot.tree.jacobian(q, 1, {}, J);
        robot.tree.integrate(moving, v, 1e-3);
      }
      violations = guard.violations();
    }
    EXPECT_EQ(violations, "") << sample.name;
  }
}

}  // namespace
}  // namespace polyarm::kinematics
