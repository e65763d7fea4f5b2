/// Where a base is that drives: by its odometry, from where the cell's file puts it.
#include "polyarm/setup/moving_base.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "polyarm/base/error.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/setup/cell_file.hpp"
#include "tests/support/jetbot_cell.hpp"
#include "tests/support/lock_step_cell.hpp"

namespace polyarm::cell {
namespace {

using test::Folder;
using test::LockStepCell;

TEST(MovingBase, IsWhereItsWheelsHaveTakenItFromWhereTheCellPutsIt) {
  Folder folder;
  test::write_jetbot_cell(folder, "drive 500mm\nturn 90deg\ndrive 200mm\n", "jetbot_body.urdf.xacro",
                          "xyz: [1, 2, 0.1], rpy: [0, 0, 90deg]");
  LockStepCell bench(read_cell_file(folder.path()));
  const MovingBase& base = bench.cell().base(0);
  ASSERT_TRUE(base.moves());
  EXPECT_TRUE(base.on_wheels());
  EXPECT_FALSE(base.in_physics());
  EXPECT_EQ(base.odometry_name(), "odom");
  EXPECT_EQ(base.base_name(), "base_link");
  Pose at = base.pose(bench.cell().snapshot());
  EXPECT_LT(norm(at.position - Vec3{1, 2, 0.1}), 1e-9) << "before it has driven";
  while (!bench.cell().program()->ended() && bench.cell().now() < nanoseconds(60)) bench.tick();
  ASSERT_TRUE(bench.cell().program()->ended());
  bench.run(0.1);
  at = base.pose(bench.cell().snapshot());
  // Half a metre along y of the world, then to the left, along -x.
  EXPECT_LT(norm(at.position - Vec3{0.8, 2.5, 0.1}), 0.01) << at.position.x << " " << at.position.y;
  EXPECT_LT(angle_between(at.rotation, from_rpy(0, 0, std::numbers::pi)), 0.02);
  const Pose by_frames = base.odometry_frame(bench.cell().snapshot()) * base.odometry();
  EXPECT_LT(norm(by_frames.position - at.position), 1e-9) << "the odometry's frame leads to it, too";
  // What its points mean goes with it.
  EXPECT_LT(norm(bench.cell().robots()[0]->entry.base.position - Vec3{1, 2, 0.1}), 1e-12);
}

TEST(MovingBase, OdometryOfALinkThatIsFixedToTheRootPlacesTheRoot) {
  Folder folder;
  test::write_jetbot_cell(folder, "turn 180deg\n", "jetbot_body.urdf.xacro");
  LockStepCell bench(read_cell_file(folder.path()));
  const MovingBase& base = bench.cell().base(0);
  // The axle, base_link, lies 32 mm above base_footprint, which is the root.
  EXPECT_NEAR(base.odometry_frame(bench.cell().snapshot()).position.z, 0.032, 1e-9);
  while (!bench.cell().program()->ended() && bench.cell().now() < nanoseconds(60)) bench.tick();
  EXPECT_NEAR(base.pose(bench.cell().snapshot()).position.z, 0, 1e-9);
  EXPECT_NEAR(base.odometry().position.z, -0.032, 1e-9);
}

TEST(MovingBase, StaysWhereItIsWhenItsControllerIsUnloaded) {
  Folder folder;
  test::write_jetbot_cell(folder, "drive 300mm\n");
  LockStepCell bench(read_cell_file(folder.path()));
  while (!bench.cell().program()->ended() && bench.cell().now() < nanoseconds(60)) bench.tick();
  bench.run(0.1);
  const Pose before = bench.cell().base(0).pose(bench.cell().snapshot());
  EXPECT_NEAR(before.position.x, 0.3, 0.005);
  bench.ask({{"request", "control.switch"}, {"deactivate", {"base"}}});
  bench.run(0.1);
  bench.cell().unload_controller("base");
  bench.run(0.1);
  EXPECT_EQ(bench.cell().base(0).pose(bench.cell().snapshot()), before);
}

TEST(MovingBase, AControllerThatIsUnloadedAndLoadedAgainSaysThatNothingGuardsIt) {
  Folder folder;
  test::write_jetbot_cell(folder, "log(1)\n");
  LockStepCell bench(read_cell_file(folder.path()));
  bench.run(0.5);
  bench.ask({{"request", "control.switch"}, {"deactivate", {"base"}}});
  bench.run(0.1);
  bench.cell().unload_controller("base");
  bench.run(0.1);
  const auto again = bench.ask({{"request", "control.load"}, {"name", "base"}});
  ASSERT_TRUE(again["ok"].get<bool>()) << again.dump();
  EXPECT_NE(again["result"]["warnings"].dump().find("guards do not watch this base"), std::string::npos)
      << again.dump();
}

TEST(MovingBase, CarriesWhatStandsOnIt) {
  Folder folder;
  test::write_jetbot_cell(folder, "drive 500mm, robot jetbot\nturn 90deg, robot jetbot\n",
                          "jetbot_body.urdf.xacro", "xyz: [1, 2, 0], rpy: [0, 0, 90deg]");
  std::string text = read_file((folder.path() / "cell.yaml").string());
  text.insert(text.find("controllers:"),
              "  arm: {model: universal_robots/ur3, on: jetbot, at: [0.1, 0, 0.3]}\n");
  folder.write("cell.yaml", text);
  LockStepCell bench(read_cell_file(folder.path()),
                     std::vector<std::filesystem::path>{POLYARM_SOURCE_DIR "/robots"});
  const MovingBase& arm = bench.cell().base(1);
  ASSERT_TRUE(arm.moves());
  EXPECT_TRUE(arm.carried());
  EXPECT_FALSE(arm.on_wheels());
  const Vec3 start{1, 2.1, 0.3};
  EXPECT_LT(norm(arm.pose(bench.cell().snapshot()).position - start), 1e-9) << "before it has driven";
  while (!bench.cell().program()->ended() && bench.cell().now() < nanoseconds(60)) bench.tick();
  bench.run(0.1);
  const Pose at = arm.pose(bench.cell().snapshot());
  EXPECT_LT(norm(at.position - Vec3{0.9, 2.5, 0.3}), 0.01) << at.position.x << " " << at.position.y;
  EXPECT_LT(norm(bench.cell().robots()[1]->entry.base.position - start), 1e-9) << "its points go with it";
}

TEST(MovingBase, WhatCarriesNobodyIsAnError) {
  Folder folder;
  const auto problem = [&](const std::string& robots) {
    folder.write("cell.yaml", "polyarm: cell/1\nrobots:\n" + robots);
    try {
      read_cell_file(folder.path());
    } catch (const Error& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  EXPECT_NE(problem("  a: {model: universal_robots/ur3, on: bse}\n  base: {model: universal_robots/ur3}\n")
                .find("'bse'"),
            std::string::npos);
  EXPECT_NE(problem("  a: {model: universal_robots/ur3, on: b}\n  b: {model: universal_robots/ur3, on: a}\n")
                .find("which is on"),
            std::string::npos);
  for (const auto& [on, what] :
       {std::pair{"a", "'a' is on itself"}, {"", "'on' of 'a' names no robot"}, {"\"\"", "names no robot"}}) {
    const std::string told = problem(std::string("  a: {model: universal_robots/ur3, on: ") + on + "}\n");
    EXPECT_NE(told.find(what), std::string::npos) << told;
  }
  EXPECT_NE(
      problem("  a: {model: universal_robots/ur3, on: lift}\n").find("movers of the scene carry no robot"),
      std::string::npos);
  const std::string near = problem("  a: {model: universal_robots/ur3, on: c}\n");
  EXPECT_EQ(near.find("did you mean"), std::string::npos) << "not itself: " << near;
}

TEST(MovingBase, TheLineOfTheKeyIsTold) {
  Folder folder;
  const auto line = [&](const std::string& keys) {
    folder.write("cell.yaml", "polyarm: cell/1\nrobots:\n  arm:\n    at: [0, 0, 0]\n" + keys);
    try {
      LockStepCell cell(read_cell_file(folder.path()));
    } catch (const Error& e) {
      return e.problems().front().where.line;
    }
    return 0;
  };
  const std::string model = "    model: " + test::kSixAxes + "\n";
  EXPECT_EQ(line("    model: none/such\n"), 5);
  EXPECT_EQ(line(model + "    tool: suction_cap\n"), 6);
  EXPECT_EQ(line(model + "    hardware: mocc\n"), 6);
  EXPECT_EQ(line(model + "    on: lift\n"), 6);
}

TEST(MovingBase, WhoStandsFreeIsNotCarried) {
  Folder folder;
  const std::string free =
      "<robot name='cart'><link name='l'/><ros2_control name='c' type='system'><hardware>"
      "<plugin>mock_components/GenericSystem</plugin><param "
      "name='base'>free</param></hardware></ros2_control></robot>";
  folder.write("cart.urdf", free);
  folder.write("cell.yaml",
               "polyarm: cell/1\nrobots:\n  cart: {model: cart.urdf, hardware: declared, on: arm}\n"
               "  arm: {model: " +
                   test::kSixAxes + "}\n");
  try {
    LockStepCell cell(read_cell_file(folder.path()));
    FAIL() << "was taken";
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("by its description it stands free"), std::string::npos) << e.what();
  }
}

TEST(MovingBase, OfAnArmIsFixed) {
  LockStepCell bench(std::filesystem::path(POLYARM_SOURCE_DIR) / "examples/r6bot/r6bot.urdf", std::string());
  EXPECT_FALSE(bench.cell().base(0).moves());
  EXPECT_EQ(bench.cell().base(0).pose(bench.cell().snapshot()), bench.cell().robots()[0]->entry.base);
}

TEST(MovingBase, AControllerThatIsLoadedLaterSaysThatItMakesNoWheels) {
  Folder folder;
  folder.write("cell.yaml", "polyarm: cell/1\nrobots:\n  jetbot: {model: " + std::string(POLYARM_SOURCE_DIR) +
                                "/examples/jetbot/urdf/jetbot.urdf.xacro, hardware: mock}\n"
                                "controllers: controllers.yaml\n");
  folder.write("controllers.yaml",
               "controller_manager:\n  ros__parameters:\n    update_rate: 100\n"
               "    joint_state_broadcaster: {type: joint_state_broadcaster/JointStateBroadcaster}\n");
  LockStepCell bench(read_cell_file(folder.path()));
  const auto load = [](LockStepCell& cell, const std::string& name) {
    return cell.ask({{"request", "control.load"},
                     {"name", name},
                     {"type", "diff_drive_controller/DiffDriveController"},
                     {"parameters",
                      {{"left_wheel_names", {"left_wheel_joint"}},
                       {"right_wheel_names", {"right_wheel_joint"}},
                       {"wheel_separation", 0.104},
                       {"wheel_radius", 0.032},
                       {"position_feedback", false}}}});
  };
  const auto late = load(bench, "late");
  ASSERT_TRUE(late["ok"].get<bool>()) << late.dump();
  EXPECT_NE(late["result"]["warnings"].dump().find("was no wheel when the cell started"), std::string::npos)
      << late.dump();
  test::write_jetbot_cell(folder, "log(1)\n");
  LockStepCell known(read_cell_file(folder.path()));
  const auto second = load(known, "second");
  ASSERT_TRUE(second["ok"].get<bool>()) << second.dump();
  EXPECT_EQ(second["result"]["warnings"].dump().find("wheel when"), std::string::npos)
      << "a controllers file of the cell has named these wheels: " << second.dump();
}

}  // namespace
}  // namespace polyarm::cell
