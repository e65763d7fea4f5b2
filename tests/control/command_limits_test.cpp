#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "polyarm/control/limits.hpp"
#include "polyarm/hardware/interface_table.hpp"

namespace polyarm::control {
namespace {

/// One joint of 1 rad/s in a loop of 1 ms, commanded its position.
class CommandLimitsTest : public ::testing::Test {
 protected:
  void make(double acceleration = INFINITY) {
    table.add_state("arm/joint/position", 0);
    table.add_command("arm/joint/position");
    table.seal();
    controllers::JointFacts joint{};
    joint.name = "arm/joint";
    joint.lower = -10, joint.upper = 10;
    joint.velocity = 1, joint.acceleration = acceleration, joint.jerk = INFINITY;
    joint.states_acceleration = std::isfinite(acceleration);
    limits.build(table, {joint}, 1'000'000);
  }
  double give(double command) {
    table.commands()[0] = command;
    return keep();
  }
  /// A cycle in which nobody writes.
  double keep() {
    hardware::FaultEvents faults;
    limits.restrict(table.commands(), table.states(), ++cycle, false, faults);
    return table.commands()[0];
  }
  hardware::InterfaceTable table;
  CommandLimits limits;
  std::uint64_t cycle = 0;
};

TEST_F(CommandLimitsTest, AStepIsAsLongAsACycleAllows) {
  make();
  give(0);
  EXPECT_NEAR(give(0.0009), 0.0009, 1e-12);
  EXPECT_NEAR(give(0.01), 0.0019, 1e-8);
  EXPECT_EQ(limits.clamps(), 1u);
}

TEST_F(CommandLimitsTest, AtARateOfItsOwnAStepIsAsLongAsItsTurn) {
  make();
  limits.set_turns("arm/", 10);
  double q = give(0);
  for (int turn = 0; turn < 5; ++turn) {
    for (int k = 0; k < 9; ++k) EXPECT_EQ(keep(), q);
    EXPECT_NEAR(give(q + 0.0099), q + 0.0099, 1e-12);
    q += 0.0099;
  }
  EXPECT_EQ(limits.clamps(), 0u);
  for (int k = 0; k < 50; ++k) keep();
  EXPECT_NEAR(give(q + 1), q + 0.01, 1e-7) << "and no longer, however long it stood";
  EXPECT_NEAR(give(q + 1), q + 0.011, 1e-7) << "nor longer than the time since";
}

TEST_F(CommandLimitsTest, AccelerationsAreThoseOfTurnsToo) {
  make(10);
  limits.set_turns("arm/", 10);
  double q = give(0), v = 0;
  for (int turn = 0; turn < 8; ++turn) {
    for (int k = 0; k < 9; ++k) EXPECT_EQ(keep(), q);
    v += 9.9 * 0.01;
    EXPECT_NEAR(give(q + v * 0.01), q + v * 0.01, 1e-12);
    q += v * 0.01;
  }
  EXPECT_EQ(limits.clamps(), 0u);
  for (int k = 0; k < 9; ++k) keep();
  give(q);
  EXPECT_EQ(limits.clamps(), 1u) << "it cannot stand at once";
}

TEST_F(CommandLimitsTest, OthersKeepTheirCycle) {
  make();
  limits.set_turns("other/", 10);
  give(0);
  for (int k = 0; k < 9; ++k) keep();
  EXPECT_NEAR(give(1), 0.001, 1e-8);
}

}  // namespace
}  // namespace polyarm::control
