/// Robots of one cell that run at rates of their own.
#include <gtest/gtest.h>

#include "tests/support/lock_step_cell.hpp"

namespace polyarm {
namespace {

using cell::Cell;

struct TwoRobots {
  test::Folder folder;
  cell::Observer observer;
  std::unique_ptr<Cell> made;

  explicit TwoRobots(const std::string& base) {
    hardware::register_driver(
        "mock", [] { return std::unique_ptr<hardware::Component>(new drivers::MockComponent); });
    const std::string model = std::string(POLYARM_SOURCE_DIR) + "/examples/r6bot/r6bot.urdf";
    const std::string file = folder.write(
        "cell.yaml", "polyarm: cell/1\nrate: 1000\nrobots:\n  arm: {model: " + model +
                         ", hardware: mock}\n  base: {model: " + model + ", hardware: mock" + base + "}\n");
    cell::CellOptions options;
    options.lock_step = true;
    made = std::make_unique<Cell>(cell::read_cell_file(file), description::Catalogue({}), options, observer);
  }
  unsigned divisor_of_component(const std::string& robot) {
    hardware::Hardware& hardware = made->loop().hardware();
    const auto index = made->loop().table().find_state(robot + "/joint_1/position");
    return hardware.info(static_cast<std::size_t>(hardware.component_of_state(*index))).divisor;
  }
  std::uint64_t updates_of(const std::string& controller) {
    for (const control::ListedController& c : made->loop().controllers().list())
      if (c.name == controller) return c.updates;
    return 0;
  }
};

TEST(Rates, ARobotAndItsControllersRunAtItsOwn) {
  TwoRobots cell(", rate: 50");
  EXPECT_EQ(cell.divisor_of_component("arm"), 1u);
  EXPECT_EQ(cell.divisor_of_component("base"), 20u);
  for (int k = 0; k < 2000; ++k) cell.made->loop().step_next();
  EXPECT_EQ(cell.updates_of("arm_joint_trajectory_controller"), 2000u);
  EXPECT_EQ(cell.updates_of("base_joint_trajectory_controller"), 100u);
}

TEST(Rates, AThreadOfItsOwnIsAWord) {
  TwoRobots cell(", rate: 50, thread: true");
  hardware::Hardware& hardware = cell.made->loop().hardware();
  int own = 0;
  for (std::size_t i = 0; i < hardware.size(); ++i) own += hardware.info(i).async ? 1 : 0;
  EXPECT_EQ(own, 1);
}

TEST(Rates, WhatIsNoPartOfTheLoopsIsRefusedWithWhatWouldBe) {
  for (const auto& [rate, hint] : {std::pair{"300", "250"}, std::pair{"3000", "raise the cell's rate"}}) {
    try {
      TwoRobots cell(std::string(", rate: ") + rate);
      ADD_FAILURE() << rate << " was taken";
    } catch (const Error& e) {
      EXPECT_EQ(e.problems().front().code, "bad-rate");
      EXPECT_NE(e.problems().front().advice.find(hint), std::string::npos) << e.problems().front().advice;
    }
  }
}

}  // namespace
}  // namespace polyarm
