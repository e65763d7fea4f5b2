#include "polyarm/hardware/transmission.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>

#include "tests/support/realtime_guard.hpp"

namespace polyarm::hardware {
namespace {

using description::TransmissionEnd;
using description::TransmissionInfo;
using Pair = std::array<double, 2>;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

TransmissionEnd end(const std::string& name, double reduction, double offset = 0) {
  TransmissionEnd out;
  out.name = name;
  out.role = name;
  out.reduction = reduction;
  out.offset = offset;
  return out;
}

TransmissionInfo simple(double reduction, double offset = 0) {
  TransmissionInfo out;
  out.name = "t";
  out.where = {"robot.urdf", 12};
  out.plugin = "transmission_interface/SimpleTransmission";
  out.joints = {end("joint1", reduction, offset)};
  out.actuators = {end("actuator1", 1)};
  return out;
}

TransmissionInfo pair_of(const std::string& type, const Pair& na, const Pair& nj, const Pair& offset) {
  TransmissionInfo out = simple(1);
  out.plugin = "transmission_interface/" + type;
  out.joints = {end("joint1", nj[0], offset[0]), end("joint2", nj[1], offset[1])};
  out.actuators = {end("actuator1", na[0]), end("actuator2", na[1])};
  return out;
}

TransmissionInfo differential(const Pair& na, const Pair& nj, const Pair& offset) {
  return pair_of("DifferentialTransmission", na, nj, offset);
}

TransmissionInfo four_bar(const Pair& na, const Pair& nj, const Pair& offset) {
  return pair_of("FourBarLinkageTransmission", na, nj, offset);
}

Pair joints_of(const TransmissionInfo& info, Quantity quantity, Pair actuators) {
  Pair out{};
  Transmission(info).to_joints(quantity, actuators, out);
  return out;
}

double joint_of(const TransmissionInfo& info, Quantity quantity, double actuator) {
  return joints_of(info, quantity, {actuator, 0})[0];
}

void expect_near(const Pair& a, const Pair& b) {
  EXPECT_NEAR(a[0], b[0], 1e-12 * std::max(1.0, std::abs(b[0])));
  EXPECT_NEAR(a[1], b[1], 1e-12 * std::max(1.0, std::abs(b[1])));
}

TEST(SimpleTransmission, MultipliesEffortAndDividesMotion) {
  EXPECT_DOUBLE_EQ(joint_of(simple(10, 1), Quantity::effort, 1), 10);
  EXPECT_DOUBLE_EQ(joint_of(simple(10, 1), Quantity::velocity, 1), 0.1);
  EXPECT_DOUBLE_EQ(joint_of(simple(10, 1), Quantity::position, 1), 1.1);
  EXPECT_DOUBLE_EQ(joint_of(simple(-10, 1), Quantity::effort, 1), -10);
  EXPECT_DOUBLE_EQ(joint_of(simple(-10, 1), Quantity::velocity, 1), -0.1);
  EXPECT_DOUBLE_EQ(joint_of(simple(-10, 1), Quantity::position, 1), 0.9);
}

TEST(SimpleTransmission, TakesTheReductionFromTheJointOrTheActuator) {
  TransmissionInfo info = simple(1);
  info.actuators[0].reduction = 50;
  EXPECT_DOUBLE_EQ(joint_of(info, Quantity::velocity, 100), 2);
}

TEST(DifferentialTransmission, HasTheKnownNumbers) {
  const TransmissionInfo info = differential({10, -20}, {-2, 4}, {-2, 4});
  expect_near(joints_of(info, Quantity::effort, {3, 5}), {140, 520});
  expect_near(joints_of(info, Quantity::velocity, {3, 5}), {-0.0125, 0.06875});
  expect_near(joints_of(info, Quantity::position, {3, 5}), {-2.0125, 4.06875});
}

TEST(DifferentialTransmission, TurnsOneJointWhenActuatorsAgreeAndTheOtherWhenTheyDiffer) {
  const TransmissionInfo info = differential({10, 10}, {2, 2}, {0, 0});
  expect_near(joints_of(info, Quantity::velocity, {20, 20}), {1, 0});
  expect_near(joints_of(info, Quantity::velocity, {20, -20}), {0, 1});
}

/// The formulas of the documentation, written out.
TEST(FourBarTransmission, HasTheKnownFormulas) {
  const Pair na{10, -20}, nj{-2, 4}, off{-2, 4}, a{3, 5};
  const TransmissionInfo info = four_bar(na, nj, off);
  const double v1 = a[0] / (nj[0] * na[0]);
  const double v2 = (a[1] / na[1] - a[0] / (nj[0] * na[0])) / nj[1];
  expect_near(joints_of(info, Quantity::velocity, a), {v1, v2});
  expect_near(joints_of(info, Quantity::velocity, a), {-0.15, -0.025});
  expect_near(joints_of(info, Quantity::position, a), {-2.15, 3.975});
  expect_near(joints_of(info, Quantity::effort, a),
              {nj[0] * na[0] * a[0] + na[1] * a[1], nj[1] * na[1] * a[1]});
  expect_near(joints_of(info, Quantity::effort, a), {-160, -400});
}

// --- laws

class TransmissionLaws : public ::testing::Test {
 protected:
  double ratio() {
    const double size = std::uniform_real_distribution<double>(0.2, 300)(random_);
    return random_() % 2 ? size : -size;
  }
  double number() { return std::uniform_real_distribution<double>(-50, 50)(random_); }
  TransmissionInfo any() {
    switch (random_() % 3) {
      case 0:
        return simple(ratio(), number());
      case 1:
        return differential({ratio(), ratio()}, {ratio(), ratio()}, {number(), number()});
      default:
        return four_bar({ratio(), ratio()}, {ratio(), ratio()}, {number(), number()});
    }
  }
  std::mt19937 random_{7};
};

TEST_F(TransmissionLaws, ThereAndBackIsTheIdentity) {
  for (int i = 0; i < 20000; ++i) {
    const Transmission t(any());
    const Pair wanted{number(), number()};
    for (const Quantity q : {Quantity::position, Quantity::velocity, Quantity::effort}) {
      Pair values = wanted;
      t.to_actuators(q, values, values);  // in place
      t.to_joints(q, values, values);
      for (std::size_t k = 0; k < t.size(); ++k) ASSERT_NEAR(values[k], wanted[k], 1e-8);
    }
  }
}

TEST_F(TransmissionLaws, NoPowerIsLostOrGained) {
  for (int i = 0; i < 20000; ++i) {
    const Transmission t(any());
    const Pair tau{number(), number()}, v{number(), number()};
    Pair joint_tau{}, joint_v{};
    t.to_joints(Quantity::effort, tau, joint_tau);
    t.to_joints(Quantity::velocity, v, joint_v);
    double actuators = 0, joints = 0, scale = 1;
    for (std::size_t k = 0; k < t.size(); ++k) {
      actuators += tau[k] * v[k];
      joints += joint_tau[k] * joint_v[k];
      scale += std::abs(joint_tau[k] * joint_v[k]);
    }
    ASSERT_NEAR(actuators, joints, 1e-12 * scale);
  }
}

TEST(Transmission, LetsANanReachOnlyWhatDependsOnIt) {
  const Pair four = joints_of(four_bar({1, 1}, {1, 1}, {0, 0}), Quantity::position, {0.5, kNan});
  EXPECT_EQ(four[0], 0.5);
  EXPECT_TRUE(std::isnan(four[1]));
}

TEST(Transmission, NeitherAllocatesNorLocks) {
  if (!polyarm::test::RealtimeGuard::watches()) GTEST_SKIP() << "a sanitizer watches the allocations";
  const Transmission t(differential({10, -20}, {-2, 4}, {-2, 4}));
  Pair values{3, 5};
  std::string violations;
  {
    const polyarm::test::RealtimeGuard guard;
    for (int i = 0; i < 100000; ++i)
      for (const Quantity q : {Quantity::position, Quantity::velocity, Quantity::effort}) {
        t.to_joints(q, values, values);
        t.to_actuators(q, values, values);
      }
    violations = guard.violations();
  }
  EXPECT_EQ(violations, "");
  EXPECT_NEAR(values[0], 3, 1e-6);
}

TEST(Transmission, PutsItsEndsInTheOrderOfTheirRoles) {
  TransmissionInfo info = four_bar({10, 20}, {2, 4}, {1, 2});
  std::swap(info.joints[0], info.joints[1]);
  std::swap(info.actuators[0], info.actuators[1]);
  const Transmission t(info);
  EXPECT_EQ(t.joints(), (std::vector<std::string>{"joint1", "joint2"}));
  EXPECT_EQ(t.actuators(), (std::vector<std::string>{"actuator1", "actuator2"}));
  Pair swapped{}, plain{};
  t.to_joints(Quantity::position, Pair{3, 5}, swapped);
  Transmission(four_bar({10, 20}, {2, 4}, {1, 2})).to_joints(Quantity::position, Pair{3, 5}, plain);
  EXPECT_EQ(swapped, plain);
}

TEST(Transmission, KnowsWhichInterfacesItTransmits) {
  EXPECT_EQ(quantity_of("position"), Quantity::position);
  EXPECT_EQ(quantity_of("absolute_position"), Quantity::position);
  EXPECT_EQ(quantity_of("velocity"), Quantity::velocity);
  EXPECT_EQ(quantity_of("torque"), Quantity::effort);
  EXPECT_FALSE(quantity_of("temperature"));
}

// --- refused

void expect_refused(const TransmissionInfo& info, const std::string& code, const std::string& piece) {
  try {
    const Transmission t(info);
    FAIL() << "was accepted";
  } catch (const Error& e) {
    EXPECT_EQ(e.problems().at(0).code, code);
    EXPECT_EQ(e.problems().at(0).where.line, 12);
    EXPECT_NE(std::string(e.what()).find(piece), std::string::npos) << e.what();
  }
}

TEST(Transmission, RefusesAReductionOfZero) {
  expect_refused(simple(0), "bad-reduction", "reduction of 0 at 'joint1'");
  for (int i = 0; i < 4; ++i) {
    Pair na{1, 1}, nj{1, 1};
    (i < 2 ? na : nj)[static_cast<std::size_t>(i % 2)] = 0;
    expect_refused(differential(na, nj, {0, 0}), "bad-reduction", "reduction of 0");
    expect_refused(four_bar(na, nj, {0, 0}), "bad-reduction", "reduction of 0");
  }
}

TEST(Transmission, RefusesReductionsThatCannotBeCalculatedWith) {
  expect_refused(simple(kNan), "bad-reduction", "'joint1'");
  expect_refused(simple(1e-320), "bad-reduction", "too large or too small");
  expect_refused(differential({1e200, 1}, {1e200, 1}, {0, 0}), "bad-reduction", "too large or too small");
}

TEST(Transmission, NamesTheNearestTypeItKnows) {
  TransmissionInfo info = simple(1);
  info.plugin = "transmission_interface/SimpelTransmission";
  expect_refused(info, "unknown-transmission", "did you mean 'transmission_interface/SimpleTransmission'");
  info.plugin = "";
  expect_refused(info, "unknown-transmission", "''");
  info.plugin = "SimpleTransmission";
  EXPECT_EQ(Transmission(info).size(), 1u);
}

TEST(Transmission, RefusesWrongNumbersOfEndsAndWrongRoles) {
  TransmissionInfo info = simple(1);
  info.actuators.clear();
  expect_refused(info, "bad-transmission", "1 joints and 0 actuators");
  info = differential({1, 1}, {1, 1}, {0, 0});
  info.joints[1].role = "jiont2";
  expect_refused(info, "bad-transmission", "did you mean 'joint2'");
  info.joints[1].role = "joint1";
  expect_refused(info, "bad-transmission", "'joint1' twice");
  info.joints[1].role = info.joints[0].role = "";
  EXPECT_EQ(Transmission(info).size(), 2u);
}

}  // namespace
}  // namespace polyarm::hardware
