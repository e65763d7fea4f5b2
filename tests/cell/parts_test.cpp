#include "polyarm/io/parts.hpp"

#include <gtest/gtest.h>

namespace polyarm::cell {
namespace {

struct OnePart {
  description::Scene scene;
  hardware::WorldState world;
  Nanoseconds now = 0;

  OnePart() {
    scene.bins.push_back({"tray", {0.2, -0.2, 0}, {0.4, -0.1, 0.1}});
    description::Part part;
    part.name = "cube";
    part.goal = description::Goal{{0.3, -0.15, 0.02}, "tray", 0.005};
    scene.parts.push_back(part);
    world.parts.resize(1);
    state().entered = state().in_world = true;
    state().pose.position = {0.3, 0.15, 0.02};
  }
  hardware::PartState& state() { return world.parts[0]; }
  void pass(PartTracker& tracker, double s) {
    for (const Nanoseconds end = now + nanoseconds(s); now < end; now += 2'000'000)
      tracker.update(now, world);
  }
};

PartReport carried_to(const Vec3& place, double speed_after = 0, double wait = 1) {
  OnePart cell;
  PartTracker tracker(cell.scene);
  cell.pass(tracker, 1);
  cell.state().held_by = 0;
  cell.pass(tracker, 1);
  cell.state().held_by = -1;
  cell.state().pose.position = place;
  cell.state().speed = speed_after;
  cell.pass(tracker, wait);
  return tracker.report().at(0);
}

TEST(PartTracker, AnUntouchedPartWaitsAndFailsOnlyACompleteRun) {
  OnePart cell;
  PartTracker tracker(cell.scene);
  cell.pass(tracker, 1);
  EXPECT_EQ(tracker.report().at(0).fate, PartFate::waiting);
  EXPECT_TRUE(tracker.failures(true).empty());
  EXPECT_EQ(tracker.failures(false).size(), 1u);
}

TEST(PartTracker, APartAtItsGoalIsPlaced) {
  const PartReport part = carried_to({0.302, -0.15, 0.02});
  EXPECT_EQ(part.fate, PartFate::placed);
  EXPECT_NEAR(*part.error_m, 0.002, 1e-12);
  EXPECT_EQ(part.bin, "tray");
}

TEST(PartTracker, APartTooFarOffIsNot) {
  EXPECT_EQ(carried_to({0.306, -0.15, 0.02}).fate, PartFate::off_goal);
}
TEST(PartTracker, APartOutsideItsBinIsNot) {
  EXPECT_EQ(carried_to({0.5, -0.15, 0.02}).fate, PartFate::wrong_bin);
}
TEST(PartTracker, APartStillRollingHasNotArrived) {
  EXPECT_EQ(carried_to({0.3, -0.15, 0.02}, 0.01).fate, PartFate::moving);
  EXPECT_EQ(carried_to({0.3, -0.15, 0.02}, 0, 0.4).fate, PartFate::moving)
      << "at rest for less than half a second";
}

TEST(PartTracker, APartTakenAwayKeepsWhatWasMeasured) {
  OnePart cell;
  PartTracker tracker(cell.scene);
  cell.state().held_by = 0;
  cell.pass(tracker, 0.1);
  cell.state().held_by = -1;
  cell.state().pose.position = {0.3, -0.151, 0.02};
  cell.pass(tracker, 1);
  cell.state().in_world = false;
  cell.state().pose.position = {9, 9, 9};
  cell.pass(tracker, 1);
  const PartReport part = tracker.report().at(0);
  EXPECT_EQ(part.fate, PartFate::placed);
  EXPECT_TRUE(part.taken);
  EXPECT_NEAR(*part.error_m, 0.001, 1e-12);
}

TEST(PartTracker, APartInTheGripperIsAFailure) {
  OnePart cell;
  PartTracker tracker(cell.scene);
  cell.state().held_by = 0;
  cell.pass(tracker, 1);
  EXPECT_EQ(tracker.failures(true).size(), 1u);
}

TEST(PartTracker, PartsThatNeverEnteredAreNotListed) {
  OnePart cell;
  cell.state().entered = false;
  PartTracker tracker(cell.scene);
  cell.pass(tracker, 1);
  EXPECT_TRUE(tracker.report().empty());
}

}  // namespace
}  // namespace polyarm::cell
