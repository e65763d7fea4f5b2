/// Joint offsets and axes from measured poses of robots of the catalogue.
#include "polyarm/calibration/arm_errors.hpp"

#include <gtest/gtest.h>

#include "polyarm/base/error.hpp"
#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/kinematics/chain.hpp"
#include "tests/calibration/noise.hpp"

namespace polyarm::calibration {
namespace {

description::RobotModel robot(const std::string& name) {
  return description::Catalogue({POLYARM_SOURCE_DIR "/robots"}).load(name);
}

std::vector<double> state(Noise& noise, const kinematics::Chain& chain) {
  std::vector<double> q;
  for (std::size_t j = 0; j < chain.joints(); ++j)
    q.push_back(noise.uniform(std::max(chain.lower()[j], -2.0), std::min(chain.upper()[j], 2.0)));
  return q;
}

/// The arm with errors of its joints.
description::RobotModel with_offsets(description::RobotModel model, const std::vector<double>& offsets) {
  for (std::size_t j = 0; j < offsets.size(); ++j) {
    description::Joint& joint = model.joints[static_cast<std::size_t>(model.actuated[j])];
    joint.origin.rotation = joint.origin.rotation * from_axis_angle(normalized(joint.axis), offsets[j]);
  }
  return model;
}
description::RobotModel with_origins(description::RobotModel model,
                                     const std::map<std::string, Pose>& origins) {
  for (description::Joint& joint : model.joints)
    if (const auto found = origins.find(joint.name); found != origins.end()) joint.origin = found->second;
  return model;
}

struct Measured {
  Pose base, target;
  std::vector<ArmSample> samples;
};
Measured measured(Noise& noise, const description::RobotModel& model, std::size_t n, double position,
                  double rotation) {
  const kinematics::Chain chain(model, model.tool_link());
  Measured out{noise.any_pose(1), noise.any_pose(0.1), {}};
  for (std::size_t i = 0; i < n; ++i) {
    const std::vector<double> q = state(noise, chain);
    out.samples.push_back({q, noise.measured(out.base * chain.forward(q) * out.target, position, rotation)});
  }
  return out;
}

const std::vector<double> kOffsets{0.01, -0.02, 0.015, 0.008, -0.012, 0.02};

TEST(JointOffsets, AreFoundAndThoseThatNothingShowsAreNamed) {
  for (const char* name : {"universal_robots/ur5e", "abb/irb_120"}) {
    Noise noise(1);
    const description::RobotModel model = robot(name), real = with_offsets(model, kOffsets);
    const Measured at = measured(noise, real, 40, 1e-4, 2e-4);
    const ArmErrors found = arm_errors(model, model.tool_link(), at.samples, {});
    ASSERT_EQ(found.numbers.size(), 6u);
    EXPECT_FALSE(found.numbers[0].identifiable) << name;  // the angle of the base
    EXPECT_FALSE(found.numbers[5].identifiable) << name;  // the angle of the target
    for (std::size_t j = 1; j < 5; ++j) {
      EXPECT_TRUE(found.numbers[j].identifiable);
      EXPECT_NEAR(found.numbers[j].value, kOffsets[j], 5 * found.numbers[j].sigma) << found.numbers[j].name;
      EXPECT_LT(found.numbers[j].sigma, 3e-4);
    }
    EXPECT_GT(found.before.rms.position, 10 * found.after.rms.position);
    // With all of them known, the corrected arm is the real one.
    std::vector<ArmSample> inside;
    const kinematics::Chain chain(real, real.tool_link());
    for (const ArmSample& each : at.samples) inside.push_back({each.q, chain.forward(each.q)});
    const ArmErrors exact =
        arm_errors(model, model.tool_link(), inside, {.base_known = true, .target_known = true});
    const Residual off = difference_of(with_origins(model, exact.origins), real, model.tool_link());
    EXPECT_LT(off.position, 1e-7) << name;
    EXPECT_LT(off.rotation, 1e-6) << name;
  }
}

TEST(JointOffsets, TheSampleThatContradictsTheOthersIsNamed) {
  Noise noise(8);
  const description::RobotModel model = robot("universal_robots/ur5e"), real = with_offsets(model, kOffsets);
  Measured at = measured(noise, real, 30, 1e-4, 2e-4);
  EXPECT_FALSE(arm_errors(model, model.tool_link(), at.samples, {}).after.outlier);
  at.samples[17].measured.position = at.samples[17].measured.position + Vec3{0, 0, 5e-3};
  const ArmErrors found = arm_errors(model, model.tool_link(), at.samples, {});
  ASSERT_TRUE(found.after.outlier);
  EXPECT_EQ(found.after.outlier->sample, 17u);
}

TEST(JointOffsets, AreCheckedWithFewSamples) {
  Noise noise(9);
  const description::RobotModel model = robot("universal_robots/ur5e"), real = with_offsets(model, kOffsets);
  const Measured at = measured(noise, real, 4, 1e-5, 2e-5);
  EXPECT_LT(arm_residuals(real, real.tool_link(), at.samples, {}).rms.position, 1e-4);
  EXPECT_GT(arm_residuals(model, model.tool_link(), at.samples, {}).rms.position, 1e-3);
  EXPECT_THROW(arm_residuals(model, model.tool_link(), std::span(at.samples).first(1), {}), Error);
}

TEST(JointOffsets, ComeFromPositionsAlone) {
  Noise noise(2);
  const description::RobotModel model = robot("universal_robots/ur5e"), real = with_offsets(model, kOffsets);
  const Measured at = measured(noise, real, 60, 1e-4, 1);
  const ArmErrors found = arm_errors(model, model.tool_link(), at.samples, {.positions_only = true});
  for (std::size_t j = 1; j < 5; ++j)
    EXPECT_NEAR(found.numbers[j].value, kOffsets[j], 5 * found.numbers[j].sigma) << found.numbers[j].name;
}

TEST(Axes, AreFoundWithTheirTiltsAndShifts) {
  Noise noise(3);
  const description::RobotModel model = robot("universal_robots/ur5e");
  description::RobotModel real = model;
  for (description::Joint& joint : real.joints)
    if (joint.moves()) joint.origin = noise.measured(joint.origin, 1e-3, 2e-3);
  const kinematics::Chain chain(real, real.tool_link());
  std::vector<ArmSample> samples;
  for (int i = 0; i < 80; ++i) {
    const std::vector<double> q = state(noise, chain);
    samples.push_back({q, noise.measured(chain.forward(q), 2e-5, 2e-5)});
  }
  const ArmErrors found =
      arm_errors(model, model.tool_link(), samples, {.axes = true, .base_known = true, .target_known = true});
  const Residual before = difference_of(model, real, model.tool_link());
  const Residual after = difference_of(with_origins(model, found.origins), real, model.tool_link());
  EXPECT_GT(before.position, 3e-3);
  EXPECT_LT(after.position, 1e-4);
  EXPECT_LT(after.rotation, 1e-4);
  for (const ArmNumber& each : found.numbers) EXPECT_TRUE(each.identifiable) << each.name;
}

TEST(Axes, OfAnUnknownBaseAreNotAllIdentifiable) {
  Noise noise(4);
  const description::RobotModel model = robot("universal_robots/ur5e");
  const Measured at = measured(noise, model, 60, 1e-4, 1e-4);
  const ArmErrors found = arm_errors(model, model.tool_link(), at.samples, {.axes = true});
  int hidden = 0;
  for (const ArmNumber& each : found.numbers) hidden += !each.identifiable;
  EXPECT_GE(hidden, 4);  // the first axis moves with the base
}

TEST(Origins, PutTheAxesWhereTheyAreWanted) {
  Noise noise(5);
  const description::RobotModel model = robot("abb/irb_120");
  description::RobotModel real = model;
  for (description::Joint& joint : real.joints)
    if (joint.moves()) joint.origin = noise.measured(joint.origin, 2e-3, 5e-3);
  const kinematics::Chain chain(real, real.tool_link());
  std::vector<AxisLine> axes;
  for (const auto& axis : chain.axes()) axes.push_back({axis.direction, axis.point});
  const auto origins =
      origins_for(model, model.tool_link(), axes, chain.forward(std::vector<double>(chain.joints())));
  const Residual off = difference_of(with_origins(model, origins), real, model.tool_link());
  EXPECT_LT(off.position, 1e-12);
  EXPECT_LT(off.rotation, 1e-7);
}

TEST(JointOffsets, TooFewSamplesAreRefused) {
  Noise noise(6);
  const description::RobotModel model = robot("universal_robots/ur5e");
  const Measured at = measured(noise, model, 3, 0, 0);
  EXPECT_THROW(arm_errors(model, model.tool_link(), at.samples, {}), Error);
  EXPECT_THROW(arm_errors(model, model.tool_link(), std::vector<ArmSample>(30, {{0, 0}, {}}), {}), Error);
}

}  // namespace
}  // namespace polyarm::calibration
