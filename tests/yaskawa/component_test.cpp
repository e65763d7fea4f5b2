/// The driver against the simulated controller: states, commands, life cycle.
#include <algorithm>

#include "tests/support/realtime_guard.hpp"
#include "tests/yaskawa/rig.hpp"

namespace polyarm {
namespace {

using test::YaskawaRig;
using namespace test;
using yaskawa::Machine;

TEST(YaskawaComponent, ReadsWhatTheControllerMeasures) {
  YaskawaRig rig;
  ASSERT_TRUE(rig.configure()) << rig.component.reason();
  rig.read();
  EXPECT_NEAR(rig.state("joint_3/position"), 0.1, kPulse) << "before the job runs";
  EXPECT_EQ(rig.state("controller/ready"), 0);
  EXPECT_EQ(rig.state("controller/servo_on"), 1);
  rig.far().with([](Machine& machine) { return machine.set_input(3, true), 0; });
  ASSERT_TRUE(rig.activate()) << rig.component.reason();
  ASSERT_TRUE(rig.runs(30, [](int) {}));
  EXPECT_NEAR(rig.state("joint_3/position"), 0.1, kPulse);
  for (const char* on : {"servo_on", "play", "remote", "running", "ready"})
    EXPECT_EQ(rig.state(std::string("controller/") + on), 1) << on;
  for (const char* off : {"hold", "alarm", "error", "emergency_stop", "alarm_code", "busy", "shaped"})
    EXPECT_EQ(rig.state(std::string("controller/") + off), 0) << off;
  EXPECT_EQ(rig.state("joint_2/torque_share"), 0);
  EXPECT_EQ(rig.state("io/digital_in_3"), 1);
  EXPECT_EQ(rig.state("io/digital_in_2"), 0);
}

TEST(YaskawaComponent, TheFlangeIsWhereTheCataloguesKinematicsHaveIt) {
  YaskawaRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.runs(2, [](int) {}));
  int tip = -1;
  for (std::size_t i = 0; i < yaskawa_model().links.size(); ++i)
    if (yaskawa_model().links[i].name == "flange") tip = static_cast<int>(i);
  const Pose flange = kinematics::Chain(yaskawa_model(), tip).forward(rig.q());
  EXPECT_NEAR(rig.state("flange_pose/position.x"), flange.position.x, 1e-6) << "micrometres";
  EXPECT_NEAR(rig.state("flange_pose/position.z"), flange.position.z - 0.33, 1e-6)
      << "base coordinates begin at the height of the second axis";
  const Quaternion q{rig.state("flange_pose/orientation.x"), rig.state("flange_pose/orientation.y"),
                     rig.state("flange_pose/orientation.z"), rig.state("flange_pose/orientation.w")};
  EXPECT_LT(angle_between(q, flange.rotation), 1e-5);
}

TEST(YaskawaComponent, TheFirstCommandIsTheMeasuredPosition) {
  YaskawaRig rig;
  const Six before = rig.q();
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.runs(200, [](int) {}));
  EXPECT_LE(rig.largest_jump(), 1e-6);
  EXPECT_GT(rig.far().with([](Machine& m) { return m.points(); }), 35u);
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(rig.q()[i], before[i], 1e-6);
}

class LoopPeriods : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Ms, LoopPeriods, testing::Values(2, 4, 10));

TEST_P(LoopPeriods, TheRobotFollowsPositionsByTheTimeOfItsPoints) {
  YaskawaRig rig(Parameters{}, GetParam() * 1'000'000);
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.runs(50, [](int) {}));
  const double from = rig.command("joint_3/position");
  double most = 0;
  ASSERT_TRUE(rig.runs(800, [&](int i) {
    rig.command("joint_3/position") = from + 0.6 * smooth((i + 1) / 800.0);
    most = std::max(most, rig.state("controller/buffered"));
  }));
  EXPECT_EQ(rig.state("controller/shaped"), 0) << "the motion is within the limits";
  EXPECT_EQ(rig.state("controller/busy"), 0);
  EXPECT_LE(most, 0.14) << "the buffer holds what `lead_ms` says";
  EXPECT_GE(most, 0.06);
  ASSERT_TRUE(rig.runs(300, [](int) {}));
  EXPECT_NEAR(rig.state("joint_3/position"), from + 0.6, kPulse);
}

TEST(YaskawaComponent, TheWayBetweenPointsIsThatOfTheLoop) {
  YaskawaRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.runs(50, [](int) {}));
  const double from = rig.command("joint_1/position");
  std::vector<double> wanted, measured;
  ASSERT_TRUE(rig.runs(900, [&](int i) {
    rig.command("joint_1/position") = from + 0.5 * smooth((i + 1) / 700.0);
    wanted.push_back(rig.command("joint_1/position"));
    measured.push_back(rig.state("joint_1/position"));
  }));
  double best = 1;
  for (double lag = 10; lag < 60; lag += 0.1) {  // cycles
    double off = 0;
    for (std::size_t i = 100; i < wanted.size(); ++i) {
      const double at = static_cast<double>(i) - lag;
      const auto k = static_cast<std::size_t>(at);
      const double then = wanted[k] + (at - std::floor(at)) * (wanted[k + 1] - wanted[k]);
      off = std::max(off, std::abs(measured[i] - then));
    }
    best = std::min(best, off);
  }
  EXPECT_LT(best, 1e-3) << "behind by the same time all along";
}

TEST(YaskawaComponent, NoJointIsFasterThanItsLimit) {
  YaskawaRig rig(Parameters{{"max_speed", "20"}});
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  const double from = rig.command("joint_1/position");
  // 50 degrees/s: the driver holds back, and gives up in words.
  ASSERT_TRUE(rig.fails(400, [&](int i) { rig.command("joint_1/position") = from + travel(i, 0.0035); }));
  EXPECT_EQ(rig.component.cause(), Cause::too_fast) << rig.component.reason();
  EXPECT_NE(rig.component.reason().find("max_speed"), std::string::npos) << rig.component.reason();
  EXPECT_LE(rig.far().with([](Machine& m) { return m.take_fastest(); }), 24) << "the cubic between points";
}

TEST(YaskawaComponent, WithoutACommandTheArmHoldsAndGoesOnFromThere) {
  YaskawaRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  const double from = rig.command("joint_2/position");
  ASSERT_TRUE(rig.runs(200, [&](int i) { rig.command("joint_2/position") = from + travel(i, 0.001); }));
  rig.command("joint_4/position") = std::nan("");
  ASSERT_TRUE(rig.runs(800, [](int) {}));
  EXPECT_NEAR(rig.state("joint_2/velocity"), 0, 1e-4) << "it stands";
  rig.hold();
  ASSERT_TRUE(rig.runs(50, [](int) {})) << rig.component.reason();
}

TEST(YaskawaComponent, SignalsAreExchangedEveryFewCycles) {
  YaskawaRig rig(Parameters{{"wires", "1=4"}});
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  for (int round = 0; round < 6; ++round) {
    rig.command("io/digital_out_1") = round % 2;
    ASSERT_TRUE(rig.runs(80, [](int) {}));
    EXPECT_EQ(rig.state("io/digital_out_1"), round % 2) << round;
    EXPECT_EQ(rig.state("io/digital_in_4"), round % 2) << "wired to output 1";
    EXPECT_EQ(rig.state("io/digital_out_2"), 0) << "what nobody commands stays";
  }
}

/// A gripper must not close where the robot will be in a moment.
TEST(YaskawaComponent, AnOutputIsSwitchedWhereTheLoopWantedIt) {
  YaskawaRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  const double from = rig.command("joint_1/position");
  double at = 0, wanted = 0;
  ASSERT_TRUE(rig.runs(600, [&](int i) {
    rig.command("joint_1/position") = from + 0.4 * smooth(i / 400.0);
    if (i == 200) rig.command("io/digital_out_1") = 1;
    if (i == 200) wanted = rig.command("joint_1/position");
    if (at == 0 && rig.far().with([](Machine& m) { return m.output(1); })) at = rig.q()[0];
  }));
  EXPECT_GT(at, wanted - 0.005) << "not before";
  EXPECT_LT(at, wanted + 0.04) << "signals are exchanged every 12 cycles";
}

TEST(YaskawaComponent, OutputsThatWaitAreSwitchedByDeactivating) {
  YaskawaRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  rig.command("io/digital_out_1") = 1;
  ASSERT_TRUE(rig.runs(3, [](int) {}));
  EXPECT_FALSE(rig.far().with([](Machine& m) { return m.output(1); }));
  EXPECT_EQ(rig.component.on_deactivate(), CallbackReturn::success);
  EXPECT_TRUE(rig.far().with([](Machine& m) { return m.output(1); }));
}

TEST(YaskawaComponent, DeactivatingWhileItMovesBrakesAndEndsTheJob) {
  YaskawaRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  const double from = rig.command("joint_1/position");
  ASSERT_TRUE(rig.runs(200, [&](int i) { rig.command("joint_1/position") = from + travel(i, 0.002); }));
  rig.forget_jumps();
  EXPECT_EQ(rig.component.on_deactivate(), CallbackReturn::success);
  EXPECT_EQ(rig.component.cause(), Cause::none);
  EXPECT_FALSE(rig.far().with([](Machine& m) { return m.ready(); }));
  const Six at = rig.q();
  EXPECT_GT(at[0], from + 0.25) << "it did not stop at once";
  ASSERT_EQ(rig.read(), ReturnType::ok);
  for (int i = 0; i < 100; ++i) rig.far().step();
  EXPECT_NEAR(rig.q()[0], at[0], kPulse);
  ASSERT_TRUE(rig.activate()) << rig.component.reason();
  EXPECT_TRUE(rig.runs(10, [](int) {}));
}

TEST(YaskawaComponent, BusyAnswersRepeatThePointAndMoveNothing) {
  YaskawaRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  const double from = rig.command("joint_1/position");
  ASSERT_TRUE(rig.runs(200, [&](int i) { rig.command("joint_1/position") = from + travel(i, 0.001); }));
  rig.far().order("busy=6");
  ASSERT_TRUE(rig.runs(200, [&](int i) { rig.command("joint_1/position") = from + travel(200 + i, 0.001); }));
  EXPECT_GE(rig.state("controller/busy"), 6);
  ASSERT_TRUE(rig.runs(200, [](int) {})) << rig.component.reason();
  EXPECT_NEAR(rig.state("joint_1/position"), rig.command("joint_1/position"), kPulse);
}

TEST(YaskawaComponent, LateAndRepeatedAnswersMoveNothing) {
  YaskawaRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  const Six before = rig.q();
  for (const char* fault : {"late=3", "hses_twice"}) {
    rig.far().order(fault);
    ASSERT_TRUE(rig.runs(30, [](int) {})) << fault << rig.component.reason();
  }
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(rig.q()[i], before[i], 1e-6);
}

TEST(YaskawaComponent, WrongParametersAreNamed) {
  EXPECT_THROW(yaskawa::YaskawaComponent().on_init(yaskawa_context()), Error) << "a host must be given";
  for (const auto& [name, value] :
       std::initializer_list<std::pair<std::string, std::string>>{{"lead_ms", "5"},
                                                                  {"digital_in", "0-4"},
                                                                  {"digital_in", "5-4"},
                                                                  {"digital_out", "40"},
                                                                  {"group", "4"},
                                                                  {"hses", "7"}})
    EXPECT_THROW(yaskawa::YaskawaComponent().on_init(yaskawa_context({{"host", "x"}, {name, value}})), Error)
        << name;
  EXPECT_THROW(yaskawa::FakeYaskawa().on_init(yaskawa_context({{"wires", "1"}})), Error);
  EXPECT_THROW(yaskawa::FakeYaskawa().on_init(yaskawa_context({{"faults", "e_stop"}})), Error);
  EXPECT_THROW(yaskawa::FakeYaskawa().on_init(yaskawa_context({}, 3'333'333)), Error);
}

TEST(YaskawaComponent, PointsLastWholeMilliseconds) {
  EXPECT_EQ(yaskawa::cycles_of_point(4'000'000, 20), 5);
  EXPECT_EQ(yaskawa::cycles_of_point(8'000'000, 20), 3);
  EXPECT_EQ(yaskawa::cycles_of_point(2'500'000, 20), 8);
  EXPECT_EQ(yaskawa::cycles_of_point(16'666'667, 20), 3) << "50 ms";
  EXPECT_THROW(yaskawa::cycles_of_point(3'162'278, 20), Error);
}

TEST(YaskawaComponent, ReadAndWriteNeitherAllocateNorLock) {
  if (!RealtimeGuard::watches()) GTEST_SKIP();
  Alone alone(far_options(), {{"digital_out", "1-4"}, {"digital_in", "1-4"}});
  auto& component = alone.component;
  ASSERT_FALSE(component.paces()) << "40 Hz is no clock for a loop";
  ASSERT_TRUE(alone.start()) << component.reason();
  std::vector<double> states(component.state_interfaces().size()),
      commands(component.command_interfaces().size(), std::nan(""));
  hardware::Cycle cycle{0, 4'000'000, 0};
  alone.far.hold_clock(true);
  component.read(cycle, states);
  for (std::size_t j = 0; j < 6; ++j) commands[j] = states[3 * j];
  std::string violations;
  bool fine = true;
  for (int i = 0; i < 200; ++i) {
    alone.step(i);
    const RealtimeGuard guard;
    commands[0] += 1e-6 * std::min(i, 20);
    commands[7] = i % 2;
    fine = component.read(cycle, states) == ReturnType::ok &&
           component.write(cycle, commands) == ReturnType::ok && fine;
    if (violations.empty()) violations = guard.violations();
  }
  EXPECT_TRUE(fine) << component.reason();
  EXPECT_EQ(violations, "");
}

class BothOrders : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(Bytes, BothOrders, testing::Bool());

TEST_P(BothOrders, TheByteOrderIsFoundAndWithoutTheEthernetServerItMovesToo) {
  FarSideOptions options = far_options();
  options.order = GetParam() ? wire::ByteOrder::big : wire::ByteOrder::little;
  Alone alone(options, {{"hses", "false"}, {"digital_out", "1"}});
  ASSERT_TRUE(alone.start()) << alone.component.reason();
  std::vector<double> states(alone.component.state_interfaces().size()),
      commands(alone.component.command_interfaces().size(), std::nan(""));
  hardware::Cycle cycle{0, 4'000'000, 0};
  ASSERT_EQ(alone.component.read(cycle, states), ReturnType::ok);
  EXPECT_NEAR(states[0], 10 * kDegree, kPulse);
  for (std::size_t j = 0; j < 6; ++j) commands[j] = states[3 * j];
  const double from = commands[0];
  alone.far.hold_clock(true);
  for (int i = 0; i < 300; ++i) {
    alone.step(i);
    commands[0] = from + 0.05 * smooth(i / 250.0);
    ASSERT_EQ(alone.component.read(cycle, states), ReturnType::ok) << alone.component.reason();
    ASSERT_EQ(alone.component.write(cycle, commands), ReturnType::ok) << alone.component.reason();
  }
  alone.far.hold_clock(false);
  EXPECT_EQ(alone.component.on_deactivate(), CallbackReturn::success);
  EXPECT_NEAR(alone.far.with([](Machine& m) { return m.q()[0]; }) * kDegree, from + 0.05, 1e-3);
}

}  // namespace
}  // namespace polyarm
