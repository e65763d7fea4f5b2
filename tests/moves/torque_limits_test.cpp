#include "polyarm/moves/torque_limits.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "polyarm/kinematics/dynamics.hpp"
#include "polyarm/moves/holding.hpp"
#include "tests/moves/arm_moves.hpp"

namespace polyarm::moves::torque_limits_test {
namespace {

using test::Arm;
using test::joint;
using test::line;
using test::shifted;
using test::Values;

Values efforts(const description::RobotModel& model) {
  Values out;
  for (const int index : model.actuated)
    out.push_back(model.joints[static_cast<std::size_t>(index)].limits.effort.value_or(0));
  return out;
}

/// An arm that carries something, and the torques of its motions by a model of the test's own.
struct Loaded {
  Arm arm;
  explicit Loaded(double mass, bool judged = true) : arm("universal_robots/ur5e"), model(arm.model) {
    const Payload payload{mass, {0.02, 0, 0.1}};
    if (judged)
      arm.facts->torques =
          std::make_shared<const TorqueLimits>(arm.model, Pose{}, payload, efforts(arm.model));
    description::Link& tool = model.links[static_cast<std::size_t>(model.tool_link())];
    EXPECT_FALSE(tool.inertial) << "the load below is all that it has";
    if (mass > 0) tool.inertial = description::Inertial{payload.mass, payload.center, {}};
  }
  /// Greatest share of an effort limit, looked at 10 times more closely than the planner does.
  double most(const MovePlan& plan) const {
    kinematics::Dynamics dynamics{kinematics::Tree(model)};
    const Values limits = efforts(model);
    Values q(6), v(6), a(6), j(6), tau(6);
    double out = 0;
    for (const PlannedMotion& motion : plan.motions) {
      std::size_t hint = 0;
      const int samples = std::max(2000, static_cast<int>(motion.path.duration() / 4e-4));
      for (int k = 0; k <= samples; ++k) {
        motion.path.sample(motion.path.duration() * k / samples, q, v, a, j, hint);
        dynamics.inverse(q, v, a, tau);
        for (std::size_t i = 0; i < 6; ++i) out = std::max(out, std::abs(tau[i]) / limits[i]);
      }
    }
    return out;
  }
  description::RobotModel model;
};

const Values kFrom{0.0, -1.2, 0.6, -0.5, -1.5, 0.0}, kTo{0.9, -0.6, 0.3, -1.0, -1.2, 0.5};

TEST(TorqueLimits, AHeavyLoadIsAcceleratedGently) {
  const Loaded blind(9, false), knowing(9);
  const std::vector<Move> moves{joint(kTo, "there", 0.05), joint({1.5, -1.0, 0.8, -0.6, -1.2, 0}, "on")};
  const MovePlan fast = plan_moves(*blind.arm.facts, kFrom, moves);
  ASSERT_GT(blind.most(fast), 1.1) << "so that there is something to keep to";
  const MovePlan kept = plan_moves(*knowing.arm.facts, kFrom, moves);
  EXPECT_LE(knowing.most(kept), 1 + 1e-3);
  EXPECT_GT(knowing.most(kept), 0.9) << "and no slower than that needs";
  EXPECT_GT(kept.duration(), fast.duration());
  EXPECT_LT(kept.motions.front().torque_share, 1);
}

TEST(TorqueLimits, LinesToo) {
  const Loaded blind(13, false), knowing(13);
  const Values from{0.0, -0.9, 1.0, -1.2, -1.5, 0.0};
  const Pose start = knowing.arm.chain().forward(from);
  std::vector<Move> moves{line(shifted(start, {0, 0, 0.2}), "a", 0.03),
                          line(shifted(start, {0, 0.1, 0}), "b", 0.03),
                          line(shifted(start, {0, 0, 0.1}), "c")};
  for (Move& move : moves) move.tcp_speed = 2, move.tcp_acceleration = 40;
  const MovePlan fast = plan_moves(*blind.arm.facts, from, moves);
  ASSERT_GT(blind.most(fast), 1.02);
  const MovePlan kept = plan_moves(*knowing.arm.facts, from, moves);
  EXPECT_LE(knowing.most(kept), 1 + 1e-3);
  EXPECT_GT(kept.duration(), fast.duration());
}

TEST(TorqueLimits, WhoCarriesLittleIsNotSlowed) {
  const Loaded blind(0, false), knowing(0.2);
  Move slow = joint(kTo, "there");
  slow.acceleration = 0.3;
  const std::vector<Move> moves{slow};
  EXPECT_EQ(plan_moves(*blind.arm.facts, kFrom, moves).duration(),
            plan_moves(*knowing.arm.facts, kFrom, moves).duration());
}

TEST(TorqueLimits, ALoadThatCannotBeHeldIsRefusedWithItsJoint) {
  const Loaded arm(25);
  const Values out{0.0, -0.1, 0.1, 0.0, -1.5, 0.0};
  try {
    plan_moves(*arm.arm.facts, kFrom, std::vector{joint(out, "far")});
    FAIL() << "25 kg at a metre";
  } catch (const MoveError& e) {
    EXPECT_EQ(e.move, 0u);
    const Problem& why = e.problems().front();
    EXPECT_EQ(why.code, "payload");
    EXPECT_NE(why.what.find("the move to far"), std::string::npos) << why.what;
    EXPECT_NE(why.what.find("wrist_1_joint needs"), std::string::npos) << why.what;
    EXPECT_NE(why.what.find("25 kg"), std::string::npos) << why.what;
    EXPECT_NE(why.what.find("limit is 28"), std::string::npos) << why.what;
  }
}

TEST(TorqueLimits, AnEstimateSlowsOnlyWhoCarriesMoreThanItWasMadeFor) {
  Arm arm("universal_robots/ur5e");
  arm.model.provenance.payload_kg = 5;
  EXPECT_TRUE(torque_limits_of(arm.model, {}, {}, efforts(arm.model)));
  arm.model.provenance.notes = {"effort limits of all joints are estimated: 1.5 times what weight asks for"};
  EXPECT_FALSE(torque_limits_of(arm.model, {}, {}, efforts(arm.model)));
  EXPECT_FALSE(torque_limits_of(arm.model, {}, {4.9, {}}, efforts(arm.model)));
  EXPECT_TRUE(torque_limits_of(arm.model, {}, {6, {}}, efforts(arm.model)));
  EXPECT_FALSE(torque_limits_of(arm.model, {}, {6, {}}, Values(6, INFINITY)));
}

TEST(TorqueLimits, ALimitThatDoesNotHoldTheBareArmSaysNothing) {
  const Arm arm("universal_robots/ur5e");
  Values effort = efforts(arm.model);
  effort[1] = 5;  // of the shoulder
  Arm other("universal_robots/ur5e");
  other.facts->torques = std::make_shared<const TorqueLimits>(arm.model, Pose{}, Payload{0.1, {}}, effort);
  EXPECT_NO_THROW(plan_moves(*other.facts, kFrom, std::vector{joint(kTo, "there")}));
}

TEST(Holding, NamesTheJointsWhoseLimitsDoNotHoldTheArm) {
  Arm arm("universal_robots/ur5e");
  const Values stretched{0, 0, 0, 0, 0, 0};
  EXPECT_TRUE(overloads_at(arm.model, {}, {}, stretched).empty());
  description::Joint& shoulder = arm.model.joints[static_cast<std::size_t>(arm.model.actuated[1])];
  shoulder.limits.effort = 5;
  const std::vector<Overload> found = overloads_at(arm.model, {}, {}, stretched);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].joint, 1u);
  EXPECT_EQ(found[0].limit, 5);
  EXPECT_GT(found[0].torque, 30) << "a stretched arm of 20 kg";
  EXPECT_GT(overloads_at(arm.model, {}, {5, {}}, stretched).at(0).torque, found[0].torque + 30) << "with a load";
  EXPECT_TRUE(overloads_at(arm.model, {}, {}, {0, -M_PI / 2, 0, -M_PI / 2, 0, 0}).empty()) << "upright";
  shoulder.limits.effort = 0;
  EXPECT_TRUE(overloads_at(arm.model, {}, {}, stretched).empty()) << "0 is not stated";
}

TEST(TorqueLimits, LoadsAddUp) {
  const Payload both = joined({1, {0, 0, 0.1}}, {3, {0, 0.4, 0.1}});
  EXPECT_EQ(both.mass, 4);
  EXPECT_NEAR(both.center.y, 0.3, 1e-12);
  EXPECT_NEAR(both.center.z, 0.1, 1e-12);
}

}  // namespace
}  // namespace polyarm::moves::torque_limits_test
