#ifdef POLYARM_MUJOCO

#include <algorithm>

#include "tests/drivers/mujoco_stage.hpp"

/// Feeders, outfeeds and movers in physics.
namespace polyarm::test::mujoco_test {
namespace {

Stage line() {
  Stage out = parts_only();
  out.scene.kinds = {"ball", "cube"};
  out.scene.feeders = {{"magazine", {{0.3, 0, 0.021}, {}}}};
  out.scene.outfeeds = {{"chute", {0.2, -0.1, 0}, {0.4, 0.1, 0.1}}};
  out.scene.sensors = {{"eye", {0.25, -0.05, 0}, {0.35, 0.05, 0.1}}};
  out.scene.parts = {cube("one", {}), cube("two", {})};
  for (description::Part& part : out.scene.parts) part.feeder = "magazine";
  return out;
}

TEST(Mujoco, FeederPresentsTheNextPart) {
  const Stage stage = line();
  Rig rig = simulate(stage);
  rig.run(0.1);
  EXPECT_EQ(rig.state("scene/magazine/remaining"), 2);
  EXPECT_EQ(rig.state("scene/eye/present"), 0);
  EXPECT_FALSE(rig.part(0).entered || rig.part(1).entered);
  rig.command("scene/magazine/feed") = 1;
  rig.run(1);
  EXPECT_EQ(rig.state("scene/magazine/presented"), 1);
  EXPECT_EQ(rig.state("scene/magazine/remaining"), 1);
  EXPECT_EQ(rig.state("scene/magazine/present"), 1);
  EXPECT_EQ(rig.state("scene/magazine/kind"), 2);
  EXPECT_EQ(rig.state("scene/eye/present"), 1);
  EXPECT_TRUE(rig.part(0).in_world && rig.part(0).asleep);
  EXPECT_NEAR(norm(rig.part(0).pose.position - Vec3{0.3, 0, 0.02}), 0, 5e-4);
  EXPECT_FALSE(rig.part(1).in_world);
}

TEST(Mujoco, FeederWaitsUntilItsPlaceIsFree) {
  const Stage stage = line();
  Rig rig = simulate(stage);
  rig.command("scene/magazine/feed") = 2;
  rig.run(1);
  EXPECT_EQ(rig.state("scene/magazine/presented"), 1) << "two in one place would push each other away";
  EXPECT_NEAR(norm(rig.part(0).pose.position - Vec3{0.3, 0, 0.02}), 0, 5e-4);
  rig.command("scene/chute/take") = 1;
  rig.run(1);
  EXPECT_EQ(rig.state("scene/magazine/presented"), 2);
  EXPECT_NEAR(norm(rig.part(1).pose.position - Vec3{0.3, 0, 0.02}), 0, 5e-4);
}

TEST(Mujoco, OutfeedTakesWhatRestsThere) {
  const Stage stage = line();
  Rig rig = simulate(stage);
  rig.command("scene/chute/take") = 1;  // before anything is there: waits
  rig.run(0.1);
  EXPECT_EQ(rig.state("scene/chute/taken"), 0);
  rig.command("scene/magazine/feed") = 1;
  rig.run(0.1);
  EXPECT_EQ(rig.state("scene/chute/taken"), 0) << "does not rest yet";
  rig.run(1.5);
  EXPECT_EQ(rig.state("scene/chute/taken"), 1);
  EXPECT_EQ(rig.state("scene/chute/present"), 0);
  EXPECT_FALSE(rig.part(0).in_world);
  rig.command("scene/magazine/feed") = 2;
  rig.run(1.5);
  EXPECT_EQ(rig.state("scene/chute/taken"), 1) << "one for each count";
  EXPECT_EQ(rig.state("scene/chute/present"), 1);
  EXPECT_TRUE(rig.part(1).in_world);
}

TEST(Mujoco, MoverCarriesAPart) {
  Stage stage = parts_only();
  stage.scene.movers = {{"shuttle", {1, 0, 0}, 0, 0.3, 0.2, 1}};
  description::Fixture tray = block("tray", {0.2, 0.2, 0.02}, {0, 0.1, 0.011});
  tray.mover = "shuttle";
  stage.scene.fixtures.push_back(tray);
  stage.scene.parts = {cube("on_it", {0.03, 0.1, 0.041}), cube("beside_it", {0, -0.3, 0.02})};
  for (const double settle : {0.02, 1.5}) {  // awake when the journey begins, and asleep
    Rig rig = simulate(stage);
    rig.run(settle);
    EXPECT_EQ(rig.part(0).asleep, settle > 1);
    const double start = rig.part(0).pose.position.x;
    double worst = 0;
    for (const double goal : {0.3, 0.1}) {
      rig.command("scene/shuttle/position") = goal;
      for (int k = 0; k < 3000; ++k) {
        ASSERT_EQ(rig.cycle(), hardware::ReturnType::ok);
        const double rode = rig.part(0).pose.position.x - start;
        worst = std::max(worst, std::abs(rode - rig.state("scene/shuttle/position")));
      }
      EXPECT_NEAR(rig.state("scene/shuttle/position"), goal, 1e-9);
    }
    EXPECT_LT(worst, 1e-3);
    EXPECT_NEAR(rig.part(1).pose.position.x, 0, 1e-5);
    EXPECT_NEAR(rig.part(0).pose.position.z, 0.041, 2e-4);
  }
}

}  // namespace
}  // namespace polyarm::test::mujoco_test

#endif
