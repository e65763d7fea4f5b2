/// What a controller of outputs begins with at each activation.
#include <gtest/gtest.h>

#include <limits>

#include "polyarm/joint_control/forward_command_controller.hpp"
#include "tests/controllers/joint_rig.hpp"

namespace polyarm::controllers {
namespace {

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();

/// A valve and two interfaces of a joint.
struct Outputs {
  ForwardCommandController controller;
  JointRig rig{controller, {"j1"}};
  explicit Outputs(bool keeps) {
    rig.context.command_names.push_back("arm/tool/valve");
    rig.set("interfaces", {"arm/tool/valve", "arm/j1/position", "arm/j1/velocity"});
    if (keeps) rig.set("keep_outputs", {"true"});
    rig.start();
  }
  /// The hardware fails, and comes back with commands that nobody has given.
  void fall() {
    controller.on_deactivate(rig.cycle);
    for (double& command : rig.commands) command = kNothing;
    rig.state("arm/j1/position") = 0.7;
  }
  void rise() { ASSERT_EQ(controller.on_activate(rig.cycle), CallbackReturn::success); }
  double valve() { return rig.command("arm/tool/valve"); }
};

TEST(KeptOutputs, AnOutputIsOnAgainWithTheFirstCommand) {
  Outputs io(true);
  EXPECT_EQ(io.valve(), 0) << "nothing was sent yet";
  io.controller.send(std::vector<double>{1, 0.2, 0.3});
  io.rig.step();
  io.fall();
  io.rise();
  EXPECT_EQ(io.valve(), 1);
  EXPECT_EQ(io.rig.command("arm/j1/position"), 0.7) << "a joint stays where it is";
  EXPECT_EQ(io.rig.command("arm/j1/velocity"), 0);
  io.rig.step();
  EXPECT_EQ(io.valve(), 1);
  EXPECT_EQ(io.rig.command("arm/j1/velocity"), 0) << "what was sent before does not set a joint in motion";
}

TEST(KeptOutputs, WhatWasSentMeanwhileCounts) {
  Outputs io(true);
  io.controller.send(std::vector<double>{1, kNothing, kNothing});
  io.rig.step();
  io.fall();
  io.controller.send(std::vector<double>{0, kNothing, kNothing});
  io.rise();
  EXPECT_EQ(io.valve(), 0);
  io.controller.send(std::vector<double>{1, kNothing, kNothing});
  io.rig.step();
  io.fall();
  io.controller.send(std::vector<double>{kNothing, kNothing, 0.5});
  io.rise();
  EXPECT_EQ(io.valve(), 1) << "a value that is not finite leaves the output as it is";
}

TEST(KeptOutputs, AreForgottenWhereTheyAreNotAskedFor) {
  Outputs io(false);
  io.controller.send(std::vector<double>{1, kNothing, kNothing});
  io.rig.step();
  io.fall();
  io.rise();
  EXPECT_EQ(io.valve(), 0) << "as ros2_control's controller";
}

/// A reference of another controller that ends in a joint moves it, as a command of the joint would.
TEST(KeptOutputs, AReferenceOfAJointIsNoOutput) {
  ForwardCommandController controller;
  JointRig rig{controller, {"j1"}};
  rig.context.command_names.push_back("pid/arm/j1/velocity");
  rig.set("interfaces", {"pid/arm/j1/velocity"});
  rig.set("keep_outputs", {"true"});
  rig.start();
  controller.send(std::vector<double>{0.5});
  rig.step();
  ASSERT_EQ(rig.command("pid/arm/j1/velocity"), 0.5);
  controller.on_deactivate(rig.cycle);
  rig.command("pid/arm/j1/velocity") = kNothing;
  ASSERT_EQ(controller.on_activate(rig.cycle), CallbackReturn::success);
  EXPECT_EQ(rig.command("pid/arm/j1/velocity"), 0) << "its joint stays where it is";
}

}  // namespace
}  // namespace polyarm::controllers
