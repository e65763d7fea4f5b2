/// The geometry of one arm, from the bytes of its controller to the model that kinematics uses.
#include "drivers/ur/arm_kinematics.hpp"

#include <gtest/gtest.h>

#include <random>

#include "drivers/ur/far_side.hpp"
#include "polyarm/calibration/arm_errors.hpp"
#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/description/arm_calibration.hpp"
#include "polyarm/ik/inverse_kinematics.hpp"
#include "polyarm/kinematics/chain.hpp"

namespace polyarm {
namespace {

description::RobotModel model_of(const std::string& name) {
  return description::Catalogue({POLYARM_SOURCE_DIR "/robots"}).load("universal_robots/" + name);
}

description::ArmCalibration calibration_of(const description::RobotModel& model,
                                           const ur::Kinematics& kinematics) {
  const ur::ArmAxes arm = ur::axes_of(kinematics);
  std::vector<calibration::AxisLine> axes;
  for (std::size_t i = 0; i < 6; ++i) axes.push_back({arm.directions[i], arm.points[i]});
  return {model.name, "test", calibration::origins_for(model, model.tool_link(), axes, arm.flange)};
}

std::vector<ur::JointLine> described(const description::RobotModel& model) {
  std::vector<ur::JointLine> out;
  for (const int joint : model.actuated)
    out.push_back({model.joints[static_cast<std::size_t>(joint)].origin,
                   model.joints[static_cast<std::size_t>(joint)].axis});
  return out;
}

TEST(ArmKinematics, OfANominalArmChangeNothing) {
  for (const char* name : {"ur3", "ur5e", "ur10e", "ur16e", "ur20"}) {
    const description::RobotModel model = model_of(name);
    description::RobotModel same = model;
    description::apply(calibration_of(model, ur::facts_of(model).kinematics), same);
    const calibration::Residual off = calibration::difference_of(model, same, model.tool_link());
    EXPECT_LT(off.position, 2e-4) << name;
    EXPECT_LT(off.rotation, 1e-3) << name;
    EXPECT_LT(ur::flange_difference(ur::facts_of(model).kinematics, described(model)), 2e-4) << name;
  }
}

TEST(ArmKinematics, OfACalibratedArmArriveInTheModel) {
  for (const char* name : {"ur3", "ur5e", "ur10e", "ur16e", "ur20"}) {
    const description::RobotModel model = model_of(name);
    ur::MachineFacts facts = ur::facts_of(model);
    ur::make_calibrated(facts);
    description::RobotModel arm = model;
    description::apply(calibration_of(model, facts.arm), arm);
    const kinematics::Chain chain(arm, arm.tool_link());
    const calibration::Residual off = calibration::difference_of(model, arm, model.tool_link());
    EXPECT_GT(off.position, 5e-4) << name;
    EXPECT_LT(off.position, 2e-2) << name;
    for (const ur::Six q :
         {ur::Six{0.4, -1.1, 0.9, -0.3, 0.7, 1.9}, ur::Six{}, ur::Six{-2, -2, 2, 1, -1, 3}}) {
      const Pose tool = chain.forward(q);
      const ur::Six pose = ur::flange_pose(facts.arm, q);
      EXPECT_NEAR(pose[0], -tool.position.x, 1e-9) << name;
      EXPECT_NEAR(pose[1], -tool.position.y, 1e-9) << name;
      EXPECT_NEAR(pose[2], tool.position.z, 1e-9) << name;
    }
    EXPECT_GT(ur::flange_difference(facts.arm, described(model)), 5e-4) << name;
    EXPECT_LT(ur::flange_difference(facts.arm, described(arm)), 1e-9) << name;
  }
}

TEST(ArmKinematics, OfACalibratedArmAreSolvedBackwards) {
  for (const char* name : {"ur3", "ur5e", "ur10e"}) {
    const description::RobotModel model = model_of(name);
    ur::MachineFacts facts = ur::facts_of(model);
    ur::make_calibrated(facts);
    description::RobotModel arm = model;
    description::apply(calibration_of(model, facts.arm), arm);
    const ik::InverseKinematics solver(arm, arm.tool_link());
    const kinematics::Chain& chain = solver.chain();
    std::mt19937 draw(5);
    for (int k = 0; k < 500; ++k) {
      std::vector<double> q;
      for (int j = 0; j < 6; ++j) q.push_back(static_cast<double>(draw() % 6000) / 1000 - 3);
      const Pose target = chain.forward(q);
      ik::IkSolution found;
      ASSERT_TRUE(solver.solve(target, q, found) == ik::IkOutcome::solved) << name << " " << solver.report();
      const Pose reached = chain.forward(std::span(found.q.data(), chain.joints()));
      EXPECT_LT(norm(reached.position - target.position), 1e-6);
      EXPECT_LT(angle_between(reached.rotation, target.rotation), 1e-5);
    }
  }
}

TEST(ArmKinematics, AreReadFromTheController) {
  ur::FarSideOptions options;
  options.machine.facts = ur::facts_of(model_of("ur5e"));
  ur::make_calibrated(options.machine.facts);
  options.rtde = options.dashboard = options.primary = options.secondary = 0;
  ur::FarSide far(options);
  const ur::Kinematics found = ur::read_kinematics("127.0.0.1", far.primary_port(), 20'000'000'000);
  EXPECT_EQ(found, options.machine.facts.arm);
  EXPECT_NE(found, options.machine.facts.kinematics);
}

TEST(ArmKinematics, OfAnotherRobotAreRefused) {
  description::RobotModel model = model_of("ur5e");
  const auto other = calibration_of(model_of("ur10e"), ur::facts_of(model_of("ur10e")).kinematics);
  EXPECT_THROW(description::apply(other, model), Error);
}

}  // namespace
}  // namespace polyarm
