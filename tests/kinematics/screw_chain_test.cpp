#include "polyarm/kinematics/screw_chain.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "polyarm/base/error.hpp"
#include "polyarm/kinematics/random.hpp"
#include "tests/kinematics/sample_robots.hpp"
#include "tests/kinematics/sample_states.hpp"
#include "tests/support/realtime_guard.hpp"

namespace polyarm::kinematics {
namespace {

const Pose kBase{{0.4, -0.3, 0.8}, from_rpy(0.2, -0.4, 2.1)};

/// A chain of turning and sliding axes in any direction; some of the joints move two of them.
struct Sample {
  std::vector<ScrewAxis> axes;
  std::size_t joints = 0;
  Pose tcp;
};

Sample sample(Random& random, std::size_t steps, bool aligned, bool mimic, bool slides) {
  Sample out;
  const auto any = [&] { return Vec3{random.between(-1, 1), random.between(-1, 1), random.between(-1, 1)}; };
  const Vec3 straight[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {-1, 0, 0}, {0, -1, 0}, {0, 0, -1}};
  for (std::size_t k = 0; k < steps; ++k) {
    ScrewAxis axis;
    axis.direction =
        aligned ? straight[static_cast<std::size_t>(random.between(0, 5.99))] : normalized(any());
    axis.point = any();
    axis.slides = slides && random.between(0, 1) < 0.3;
    const bool again = mimic && k > 1 && random.between(0, 1) < 0.4;
    axis.joint =
        again ? static_cast<std::size_t>(random.between(0, double(out.joints) - 0.01)) : out.joints++;
    axis.ratio = again ? random.between(-2, 2) : 1;
    out.axes.push_back(axis);
  }
  out.tcp = {any(), from_rpy(random.between(-3, 3), random.between(-1.5, 1.5), random.between(-3, 3))};
  return out;
}

/// The same by quaternions, one joint after another.
Pose by_quaternions(const Sample& s, std::span<const double> q) {
  Pose out;
  for (const ScrewAxis& axis : s.axes) {
    const double value = axis.ratio * q[axis.joint];
    if (axis.slides) {
      out = out * Pose{value * axis.direction, {}};
    } else {
      const Quaternion turn = from_axis_angle(axis.direction, value);
      out = out * Pose{axis.point - turn * axis.point, turn};
    }
  }
  return out * s.tcp;
}

std::vector<Sample> samples() {
  Random random(5);
  std::vector<Sample> out;
  for (const std::size_t steps : {1u, 2u, 3u, 4u, 5u, 6u, 7u, 8u, 9u, 17u})
    for (const bool aligned : {false, true})
      for (const bool mimic : {false, true})
        for (const bool slides : {false, true}) out.push_back(sample(random, steps, aligned, mimic, slides));
  return out;
}

std::vector<double> state(std::size_t n, Random& random, double most = 4) {
  std::vector<double> q(n);
  for (double& v : q) v = random.between(-most, most);
  return q;
}

TEST(ScrewChain, PlacesTheTcpWhereQuaternionsDo) {
  Random random(6);
  for (const Sample& s : samples())
    for (const InstructionSet set : test::kInstructionSets) {
      const ScrewChain chain(s.axes, s.joints, s.tcp, {0.1, 0.2, -0.1}, set);
      for (int i = 0; i < 20; ++i) {
        const auto q = state(s.joints, random);
        const Pose is = chain.forward(q), want = by_quaternions(s, q);
        const double size = 4.0 * static_cast<double>(s.axes.size());
        ASSERT_LT(norm(is.position - want.position), 1e-15 * size * size) << s.axes.size();
        ASSERT_LT(angle_between(is.rotation, want.rotation), 1e-15 * size);
      }
    }
}

TEST(ScrewChain, AnglesOfManyTurnsLoseNoMoreThanTheirOwnDigits) {
  Random random(7);
  for (const InstructionSet set : test::kInstructionSets) {
    const std::vector<ScrewAxis> one{{0, false, 1, {0, 0, 1}, {0, 0, 0}}};
    const ScrewChain chain(one, 1, {{1, 0, 0}, {}}, {}, set);
    for (const double most : {1e-9, 1.0, 1e3, 9e4, 1.1e5, 1e9, 1e15})
      for (int i = 0; i < 2000; ++i) {
        const double q[] = {random.between(-most, most)};
        const Vec3 at = chain.forward(q).position;
        ASSERT_NEAR(at.x, std::cos(q[0]), 2.5e-16) << q[0];
        ASSERT_NEAR(at.y, std::sin(q[0]), 2.5e-16) << q[0];
      }
    for (int k = -40; k <= 40; ++k) {
      const double q[] = {k * std::numbers::pi / 4};
      ASSERT_NEAR(chain.forward(q).position.y, std::sin(q[0]), 2.5e-16) << k;
    }
    const double nowhere[] = {std::numeric_limits<double>::infinity()};
    EXPECT_TRUE(std::isnan(chain.forward(nowhere).position.x));
  }
}

TEST(ScrewChain, JacobiansInAllFramesAreDerivatives) {
  Random random(8);
  constexpr double kStep = 1e-6;
  for (const Sample& s : samples())
    for (const InstructionSet set : test::kInstructionSets) {
      const ScrewChain chain(s.axes, s.joints, s.tcp, {}, set);
      const std::size_t n = s.joints;
      auto q = state(n, random);
      std::vector<double> aligned(6 * n), body(6 * n), space(6 * n);
      const Pose at = chain.jacobian(q, aligned);
      EXPECT_EQ(at, chain.forward(q));
      chain.jacobian(q, body, JacobianFrame::body);
      chain.jacobian(q, space, JacobianFrame::space);
      for (std::size_t j = 0; j < n; ++j) {
        auto a = q, b = q;
        a[j] -= kStep, b[j] += kStep;
        const Pose before = chain.forward(a), after = chain.forward(b);
        const Vec3 v = (0.5 / kStep) * (after.position - before.position);
        const Vec3 w = (0.5 / kStep) * to_rotation_vector(after.rotation * inverse(before.rotation));
        const auto expect = [&](const std::vector<double>& J, const Vec3& linear, const Vec3& angular) {
          const double want[] = {linear.x, linear.y, linear.z, angular.x, angular.y, angular.z};
          for (std::size_t r = 0; r < 6; ++r) ASSERT_NEAR(J[r * n + j], want[r], 5e-8 * (1 + double(n * n)));
        };
        expect(aligned, v, w);
        expect(body, inverse(at.rotation) * v, inverse(at.rotation) * w);
        expect(space, v - cross(w, at.position), w);
      }
    }
}

TEST(ScrewChain, ABatchIsOneStateAfterTheOtherBitByBit) {
  Random random(9);
  for (const Sample& s : samples())
    for (const InstructionSet set : test::kInstructionSets) {
      const ScrewChain chain(s.axes, s.joints, s.tcp, {0.3, 0, 0}, set);
      const std::size_t n = s.joints;
      for (const std::size_t count : {1u, 7u, 8u, 21u}) {
        auto states = state(n * count, random);
        if (count == 8)
          states[static_cast<std::size_t>(random.unit() * double(states.size()))] = 3e6;  // one of many turns
        std::vector<double> columns(n * count), J(6 * n * count), one(6 * n);
        for (std::size_t i = 0; i < count; ++i)
          for (std::size_t j = 0; j < n; ++j) columns[j * count + i] = states[i * n + j];
        std::vector<Pose> poses(count), again(count), third(count);
        chain.forward_batch(states, BatchLayout::state_after_state, poses);
        chain.forward_batch(columns, BatchLayout::joint_after_joint, again);
        chain.jacobian_batch(columns, BatchLayout::joint_after_joint, J, third);
        for (std::size_t i = 0; i < count; ++i) {
          const Pose want = chain.jacobian(std::span(states).subspan(i * n, n), one);
          ASSERT_EQ(poses[i], want);
          ASSERT_EQ(again[i], want);
          ASSERT_EQ(third[i], want);
          for (std::size_t k = 0; k < 6 * n; ++k) ASSERT_EQ(J[k * count + i], one[k]);
        }
      }
    }
}

TEST(ScrewChain, WritesNothingBesideTheJacobian) {
  Random random(10);
  for (const Sample& s : samples())
    for (const InstructionSet set : test::kInstructionSets) {
      const ScrewChain chain(s.axes, s.joints, s.tcp, {}, set);
      std::vector<double> J(6 * s.joints + 16, 7.0);
      chain.jacobian(state(s.joints, random), std::span(J).subspan(8, 6 * s.joints));
      for (std::size_t i = 0; i < 8; ++i) {
        ASSERT_EQ(J[i], 7.0);
        ASSERT_EQ(J[6 * s.joints + 8 + i], 7.0);
      }
    }
}

TEST(ScrewChain, MayBeCalledInTheControlCycle) {
  Random random(11);
  const Sample s = sample(random, 7, false, true, true);
  const ScrewChain chain(s.axes, s.joints, s.tcp, {});
  std::vector<double> J(6 * s.joints * 16);
  const auto q = state(s.joints * 16, random);
  std::vector<Pose> out(16);
  std::string violations;
  {
    const test::RealtimeGuard guard;
    for (int i = 0; i < 1000; ++i) {
      chain.jacobian(std::span(q).first(s.joints), J);
      chain.jacobian_batch(q, BatchLayout::joint_after_joint, J, out);
    }
    violations = guard.violations();
  }
  EXPECT_EQ(violations, "");
}

TEST(ScrewChain, RefusesMoreJointsThanItHasRoomFor) {
  EXPECT_THROW(ScrewChain({}, Chain::kMaxJoints + 1, {}, {}), Error);
}

}  // namespace
}  // namespace polyarm::kinematics
