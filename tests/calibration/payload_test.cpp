/// Payloads from wrist forces and joint torques.
#include "polyarm/calibration/payload.hpp"

#include <gtest/gtest.h>

#include "polyarm/base/error.hpp"
#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/kinematics/dynamics.hpp"
#include "tests/calibration/noise.hpp"

namespace polyarm::calibration {
namespace {

constexpr double kMass = 2.4;
const Vec3 kCenter{0.02, -0.03, 0.11};

WrenchSample resting(Noise& noise, const Quaternion& rotation, double force, double torque) {
  WrenchSample out;
  out.rotation = rotation;
  const Vec3 weight = inverse(rotation) * Vec3{0, 0, -kMass * 9.81};
  out.force = weight + Vec3{3, -1, 5} + noise.vector(force);
  out.torque = cross(kCenter, weight) + Vec3{0.1, 0.2, -0.3} + noise.vector(torque);
  return out;
}

std::vector<WrenchSample> resting(Noise& noise, std::size_t n, double force, double torque) {
  std::vector<WrenchSample> out;
  for (std::size_t i = 0; i < n; ++i) out.push_back(resting(noise, noise.any_rotation(), force, torque));
  return out;
}

TEST(WristForce, GivesMassCentreAndTheSensorsZero) {
  Noise noise(1);
  const Payload found = payload_from_wrenches(resting(noise, 8, 0, 0));
  EXPECT_NEAR(found.mass, kMass, 1e-9);
  EXPECT_LT(norm(found.center - kCenter), 1e-9);
  EXPECT_LT(norm(found.force_offset - Vec3{3, -1, 5}), 1e-8);
  EXPECT_LT(norm(found.torque_offset - Vec3{0.1, 0.2, -0.3}), 1e-8);
}

TEST(WristForce, ErrorsShrinkAndAgreeWithTheStatedUncertainty) {
  Noise noise(2);
  const auto error_of = [&](std::size_t n, double& stated) {
    double square = 0;
    stated = 0;
    for (int k = 0; k < 200; ++k) {
      const Payload found = payload_from_wrenches(resting(noise, n, 0.2, 0.02));
      square += (found.mass - kMass) * (found.mass - kMass) / 200;
      stated += found.mass_sigma * found.mass_sigma / 200;
    }
    stated = std::sqrt(stated);
    return std::sqrt(square);
  };
  double few_stated = 0, many_stated = 0;
  const double few = error_of(12, few_stated), many = error_of(108, many_stated);
  EXPECT_NEAR(few / many, 3, 0.7);
  EXPECT_NEAR(many_stated / many, 1, 0.2);
}

TEST(WristForce, MotionGivesTheInertiaToo) {
  Noise noise(3);
  const double inertia[6] = {0.02, 0.001, -0.002, 0.03, 0.0015, 0.012};
  std::vector<WrenchSample> samples;
  for (int i = 0; i < 200; ++i) {
    WrenchSample one;
    one.rotation = noise.any_rotation();
    one.angular_velocity = noise.vector(2);
    one.angular_acceleration = noise.vector(15);
    one.acceleration = noise.vector(3);
    const Vec3 &w = one.angular_velocity, &dw = one.angular_acceleration;
    const Vec3 at_center = one.acceleration + inverse(one.rotation) * Vec3{0, 0, 9.81} + cross(dw, kCenter) +
                           cross(w, cross(w, kCenter));
    const auto times = [&](const Vec3& v) {
      return Vec3{inertia[0] * v.x + inertia[1] * v.y + inertia[2] * v.z,
                  inertia[1] * v.x + inertia[3] * v.y + inertia[4] * v.z,
                  inertia[2] * v.x + inertia[4] * v.y + inertia[5] * v.z};
    };
    const Vec3 force = kMass * at_center, torque = times(dw) + cross(w, times(w)) + cross(kCenter, force);
    one.force = -force + noise.vector(0.1);
    one.torque = -torque + noise.vector(0.01);
    samples.push_back(one);
  }
  const Payload found = payload_from_wrenches(samples, {.inertia = true});
  EXPECT_NEAR(found.mass, kMass, 5 * found.mass_sigma);
  EXPECT_LT(norm(found.center - kCenter), 5 * found.center_sigma);
  EXPECT_LT(found.inertia_sigma, 2e-3);
  for (std::size_t k = 0; k < 6; ++k) EXPECT_NEAR(found.inertia[k], inertia[k], 6 * found.inertia_sigma) << k;
}

TEST(WristForce, RefusesAHandThatDoesNotTurn) {
  Noise noise(4);
  std::vector<WrenchSample> same;
  for (int i = 0; i < 20; ++i)
    same.push_back(resting(noise, from_axis_angle({0, 0, 1}, 0.3 * i) * from_rpy(M_PI, 0, 0), 0.2, 0.02));
  EXPECT_THROW(payload_from_wrenches(same), Error);
  EXPECT_THROW(payload_from_wrenches(std::span(same).first(1)), Error);
  EXPECT_THROW(payload_from_wrenches(resting(noise, 30, 0.2, 0.02), {.inertia = true}), Error);
}

TEST(WristForce, NamesTheSampleThatContradictsTheOthers) {
  Noise noise(6);
  std::vector<WrenchSample> samples = resting(noise, 12, 0.05, 0.005);
  EXPECT_FALSE(payload_from_wrenches(samples).outlier);
  samples[5].force = samples[5].force + Vec3{0, 4, 0};
  const Payload found = payload_from_wrenches(samples);
  ASSERT_TRUE(found.outlier);
  EXPECT_EQ(found.outlier->sample, 5u);
}

TEST(WristForce, TheToolIsNoPartOfThePayload) {
  Payload total;
  total.mass = 3;
  total.mass_sigma = 0.01;
  total.center = {0, 0, 0.15};
  const Payload rest = without_part(total, {1, {0, 0, 0.05}}, "the tool");
  EXPECT_NEAR(rest.mass, 2, 1e-12);
  EXPECT_NEAR(rest.center.z, 0.2, 1e-12);
  EXPECT_THROW(without_part(total, {2.99, {}}, "the tool"), Error);
  EXPECT_THROW(without_part(total, {4, {}}, "the tool"), Error);
}

TEST(KnownLoads, AreComparedWithWhatIsMeasured) {
  Noise noise(7);
  const std::vector<WrenchSample> samples = resting(noise, 6, 0.01, 0.001);
  for (const double each : load_residuals(samples, {kMass, kCenter})) EXPECT_LT(each, 0.05);
  double most = 0;
  for (const double each : load_residuals(samples, {kMass + 1, kCenter})) most = std::max(most, each);
  EXPECT_GT(most, 5);
  EXPECT_THROW(load_residuals(std::span(samples).first(1), {kMass, kCenter}), Error);

  const auto model = description::Catalogue({POLYARM_SOURCE_DIR "/robots"}).load("universal_robots/ur5e");
  description::RobotModel loaded = model;
  const int tip = model.tool_link();
  loaded.links[static_cast<std::size_t>(tip)].inertial = description::Inertial{kMass, kCenter, {}, false};
  const kinematics::Tree tree(loaded);
  kinematics::Dynamics dynamics(tree);
  TorqueSample one{
      {0.1, -1, 1, 0.2, 0.3, 0.4}, std::vector<double>(6), std::vector<double>(6), std::vector<double>(6)};
  dynamics.inverse(one.q, one.v, one.a, one.tau);
  EXPECT_LT(load_residuals(model, tip, std::span(&one, 1), {kMass, kCenter}).front(), 1e-9);
  EXPECT_GT(load_residuals(model, tip, std::span(&one, 1), {0, {}}).front(), 5);
}

TEST(JointTorques, GiveThePayload) {
  Noise noise(5);
  const auto model = description::Catalogue({POLYARM_SOURCE_DIR "/robots"}).load("universal_robots/ur5e");
  const int tip = model.tool_link();
  description::RobotModel loaded = model;
  description::Link& hand = loaded.links[static_cast<std::size_t>(tip)];
  ASSERT_FALSE(hand.inertial);
  hand.inertial = description::Inertial{kMass, kCenter, {0.02, 0, 0, 0.03, 0, 0.012}, false};
  const kinematics::Tree tree(loaded);
  kinematics::Dynamics dynamics(tree);
  const auto sample = [&](double torque) {
    TorqueSample one;
    for (int j = 0; j < 6; ++j) {
      one.q.push_back(noise.uniform(-2, 2));
      one.v.push_back(noise.normal(0.8));
      one.a.push_back(noise.normal(3));
    }
    one.tau.resize(6);
    dynamics.inverse(one.q, one.v, one.a, one.tau);
    for (std::size_t j = 0; j < 6; ++j)
      one.tau[j] += (one.v[j] > 0 ? 2 : -2) + 3 * one.v[j] + noise.normal(torque);
    return one;
  };
  std::vector<TorqueSample> samples;
  for (int i = 0; i < 100; ++i) samples.push_back(sample(0.1));
  const Payload found = payload_from_torques(model, tip, samples, {.inertia = true, .friction = true});
  EXPECT_NEAR(found.mass, kMass, 5 * found.mass_sigma);
  EXPECT_LT(found.mass_sigma, 0.05);
  EXPECT_LT(norm(found.center - kCenter), 5 * found.center_sigma);
  samples.front().tau.pop_back();
  EXPECT_THROW(payload_from_torques(model, tip, samples), Error);
}

}  // namespace
}  // namespace polyarm::calibration
