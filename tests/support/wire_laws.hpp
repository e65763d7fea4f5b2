#pragma once
/// What a driver that streams positions owes its users, the same for each maker. `Rig` is a WireRig.
#include <gtest/gtest.h>

#include <cmath>
#include <initializer_list>
#include <span>
#include <string>

#include "polyarm/kinematics/chain.hpp"
#include "tests/support/wire_rig.hpp"

namespace polyarm::test {

/// `pose`: the states of the flange, such as "flange_pose". `below`: m, of the controller's origin above the
/// robot's base.
template <class Rig>
void expect_flange_is_where_the_model_has_it(Rig& rig, const description::RobotModel& model,
                                             const std::string& pose, double within, double angle_within,
                                             double below = 0) {
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.runs(2, [](int) {}));
  int tip = -1;
  for (std::size_t i = 0; i < model.links.size(); ++i)
    if (model.links[i].name == "flange") tip = static_cast<int>(i);
  const auto joints = rig.q();
  const Pose flange = kinematics::Chain(model, tip).forward(std::span(joints).first(6));
  const auto at = [&](const char* part) { return rig.state(pose + "/" + part); };
  EXPECT_NEAR(at("position.x"), flange.position.x, within);
  EXPECT_NEAR(at("position.z"), flange.position.z - below, within);
  const Quaternion q{at("orientation.x"), at("orientation.y"), at("orientation.z"), at("orientation.w")};
  EXPECT_LT(angle_between(q, flange.rotation), angle_within);
}

/// `commands()`: that the controller has taken.
template <class Rig, typename Commands>
void expect_first_command_is_measured(Rig& rig, Commands commands, std::uint64_t least) {
  const auto before = rig.q();
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.runs(200, [](int) {}));
  EXPECT_LE(rig.largest_jump(), 1e-6);
  EXPECT_GE(commands(), least);
  for (std::size_t i = 0; i < before.size(); ++i) EXPECT_NEAR(rig.q()[i], before[i], 1e-6);
}

/// While `moved` moves, `lost` has no command any more.
template <class Rig>
void expect_arm_holds_without_a_command(Rig& rig, const std::string& moved, const std::string& lost,
                                        double step, int before, int after) {
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  const double from = rig.command(moved + "/position");
  ASSERT_TRUE(
      rig.runs(before, [&](int i) { rig.command(moved + "/position") = from + travel(i, step, 80); }));
  rig.command(lost + "/position") = std::nan("");
  ASSERT_TRUE(rig.runs(after, [](int) {}));
  EXPECT_NEAR(rig.state(moved + "/velocity"), 0, 1e-4) << "it stands";
  rig.hold();
  ASSERT_TRUE(rig.runs(50, [](int) {})) << rig.component.reason();
}

/// `wires` connects output to input; nobody commands `other`.
template <class Rig>
void expect_signals_are_exchanged(Rig& rig, const std::string& output, const std::string& input,
                                  const std::string& other) {
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  for (int round = 0; round < 6; ++round) {
    rig.command(output) = round % 2;
    ASSERT_TRUE(rig.runs(30, [](int) {}));
    EXPECT_EQ(rig.state(output), round % 2) << round;
    EXPECT_EQ(rig.state(input), round % 2) << "wired to " << output;
    EXPECT_EQ(rig.state(other), 0) << "what nobody commands stays";
  }
}

/// `runs(machine)`: what the driver starts and ends there.
template <class Rig, typename Runs>
void expect_deactivating_ends_a_motion(Rig& rig, const std::string& joint, Runs runs) {
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  const double from = rig.command(joint + "/position");
  ASSERT_TRUE(rig.runs(200, [&](int i) { rig.command(joint + "/position") = from + travel(i, 0.002, 80); }));
  EXPECT_EQ(rig.component.on_deactivate(), CallbackReturn::success);
  EXPECT_EQ(static_cast<int>(rig.component.cause()), 0) << rig.component.reason();
  EXPECT_FALSE(rig.far().with([&](auto& machine) { return runs(machine); }));
  const auto at = rig.q();
  ASSERT_EQ(rig.read(), ReturnType::ok);
  EXPECT_NEAR(rig.state(joint + "/position"), at[0], 1e-2) << "not where it was before the motion";
  for (int i = 0; i < 100; ++i) rig.far().step();
  EXPECT_NEAR(rig.q()[0], at[0], 1e-3);
  ASSERT_TRUE(rig.activate()) << rig.component.reason();
  EXPECT_TRUE(rig.runs(10, [](int) {}));
}

/// `faults`: orders for packets, one after the other.
template <class Rig>
void expect_disturbed_packets_move_nothing(Rig& rig, std::initializer_list<const char*> faults) {
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  const auto before = rig.q();
  for (const char* fault : faults) {
    rig.far().order(fault);
    ASSERT_TRUE(rig.runs(20, [](int) {})) << fault;
  }
  for (std::size_t i = 0; i < before.size(); ++i) EXPECT_NEAR(rig.q()[i], before[i], 1e-6);
}

/// 50 degrees/s with a `max_speed` of 20: the driver holds back, and gives up in words.
template <class Rig, class Cause>
void expect_no_joint_is_faster(Rig& rig, const std::string& joint, Cause too_fast, const char* words,
                               double within) {
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  const double from = rig.command(joint + "/position");
  ASSERT_TRUE(
      rig.fails(400, [&](int i) { rig.command(joint + "/position") = from + travel(i, 0.0035, 80); }));
  EXPECT_EQ(rig.component.cause(), too_fast) << rig.component.reason();
  EXPECT_NE(rig.component.reason().find(words), std::string::npos) << rig.component.reason();
  EXPECT_LE(rig.far().with([](auto& machine) { return machine.take_fastest(); }), 20 + within);
}

}  // namespace polyarm::test
