/// The driver against the simulated controller: states, commands, life cycle.
#include <algorithm>

#include "tests/fanuc/rig.hpp"
#include "tests/support/realtime_guard.hpp"
#include "tests/support/wire_laws.hpp"

namespace polyarm {
namespace {

using test::FanucRig;
using namespace test;

TEST(FanucComponent, ReadsWhatTheControllerMeasures) {
  FanucRig rig;
  ASSERT_TRUE(rig.configure()) << rig.component.reason();
  rig.far().with([](fanuc::Machine& machine) {
    machine.set_input(3, true);
    machine.set_input(16, true);
    machine.set_output(2, true);
    return 0;
  });
  ASSERT_TRUE(rig.activate()) << rig.component.reason();
  ASSERT_TRUE(rig.runs(3, [](int) {}));
  EXPECT_NEAR(rig.state("J3/position"), -0.1, 1e-6);
  EXPECT_NEAR(rig.state("J5/position"), rig.q()[4], 1e-6);
  EXPECT_EQ(rig.state("controller/ready"), 1);
  EXPECT_EQ(rig.state("controller/error"), 0);
  EXPECT_EQ(rig.state("controller/moving"), 0);
  EXPECT_EQ(rig.state("controller/lost_packets"), 0);
  EXPECT_EQ(rig.state("io/digital_in_3"), 1);
  EXPECT_EQ(rig.state("io/digital_in_4"), 0);
  EXPECT_EQ(rig.state("io/digital_in_16"), 1);
  EXPECT_EQ(rig.state("io/digital_out_2"), 1) << "what nobody commands stays";
  EXPECT_TRUE(std::isnan(rig.state("force/force.x"))) << "version 3 has no force";
}

TEST(FanucComponent, TheFlangeIsWhereTheCataloguesKinematicsHaveIt) {
  FanucRig rig;
  // The controller's world is at the height of axis 2.
  expect_flange_is_where_the_model_has_it(rig, fanuc_model(), "flange_pose", 1e-5, 1e-5, 0.245);
}

TEST(FanucComponent, TheFirstCommandIsTheMeasuredPosition) {
  FanucRig rig;
  expect_first_command_is_measured(
      rig, [&] { return rig.far().commands(); }, 151);
}

TEST(FanucComponent, TheRobotFollowsPositionsInEachCycleOnce) {
  FanucRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.runs(2, [](int) {}));
  const double from = rig.command("J3/position");
  const std::uint64_t before = rig.far().commands();
  ASSERT_TRUE(
      rig.runs(400, [&](int i) { rig.command("J3/position") = from + 0.6 * smooth((i + 1) / 400.0); }));
  EXPECT_NEAR(static_cast<double>(rig.far().commands() - before), 400, 2) << "one command for each packet";
  EXPECT_EQ(rig.state("controller/shaped"), 0) << "the motion is within the limits";
  ASSERT_TRUE(rig.runs(100, [](int) {}));
  EXPECT_NEAR(rig.state("J3/position"), from + 0.6, 1e-4);
  EXPECT_EQ(rig.component.cause(), Cause::none);
}

/// Else the clock would not wait in the first cycles, and a run would not repeat itself.
TEST(FanucComponent, EachPacketIsAnsweredFromTheFirstOneOn) {
  FanucRig rig;
  ASSERT_TRUE(rig.configure()) << rig.component.reason();
  ASSERT_EQ(rig.component.on_activate(), CallbackReturn::success) << rig.component.reason();
  EXPECT_TRUE(rig.far().step(20'000'000'000));
}

TEST(FanucComponent, CommandsBeyondTheTablesAreHeldBackAndCaughtUp) {
  FanucRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.runs(5, [](int) {}));
  const double from = rig.command("J6/position");
  rig.command("J6/position") = from + 0.005;  // at once: no controller takes that
  ASSERT_TRUE(rig.runs(100, [](int) {})) << "the far side stops at the first command beyond a limit";
  EXPECT_GT(rig.state("controller/shaped"), 0);
  EXPECT_NEAR(rig.state("J6/position"), from + 0.005, 1e-5);
  EXPECT_LT(rig.state("controller/behind"), 1e-5);
}

TEST(FanucComponent, CommandsThatStayBeyondTheTablesStopTheRobotWithTheirLimit) {
  FanucRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  const double from = rig.command("J1/position");
  // 5 rad/s: more than twice the limit of the joint.
  ASSERT_TRUE(rig.fails(100, [&](int i) { rig.command("J1/position") = from + 0.04 * i; }));
  EXPECT_EQ(rig.component.cause(), Cause::too_fast) << rig.component.reason();
  EXPECT_NE(rig.component.reason().find("joint 1"), std::string::npos) << rig.component.reason();
  EXPECT_TRUE(rig.far().with([](fanuc::Machine& m) { return m.alarm_text().empty(); }))
      << "the controller itself saw nothing beyond its limits";
}

TEST(FanucComponent, WithoutACommandTheArmHoldsAndGoesOnFromThere) {
  FanucRig rig;
  expect_arm_holds_without_a_command(rig, "J2", "J4", 0.002, 100, 200);
  EXPECT_TRUE(rig.far().with([](fanuc::Machine& m) { return m.alarm_text().empty(); }));
}

TEST(FanucComponent, OutputsGoWithTheCommandOfTheirCycle) {
  FanucRig rig(Parameters{{"wires", "1=5"}});
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.runs(3, [](int) {}));
  for (int round = 0; round < 100; ++round) {
    rig.command("io/digital_out_1") = round % 2;
    rig.command("io/digital_out_8") = 1 - round % 2;
    ASSERT_TRUE(rig.runs(1, [](int) {}));
    ASSERT_EQ(rig.read(), ReturnType::ok);
    ASSERT_EQ(rig.state("io/digital_out_1"), round % 2) << round;
    ASSERT_EQ(rig.state("io/digital_in_5"), round % 2) << "wired to output 1";
    ASSERT_EQ(rig.state("io/digital_out_8"), 1 - round % 2) << round;
    ASSERT_EQ(rig.component.write(rig.cycle, rig.commands), ReturnType::ok);
  }
}

TEST(FanucComponent, ActivatingAndEndingLeaveOutputsAsTheyAre) {
  FanucRig rig;
  rig.far().with([](fanuc::Machine& m) { return m.set_output(4, true), m.set_output(40, true), 0; });
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.runs(20, [](int) {}));
  rig.component.on_deactivate();
  const auto on = [&](int port) { return rig.far().with([&](fanuc::Machine& m) { return m.output(port); }); };
  EXPECT_TRUE(on(4));
  EXPECT_TRUE(on(40));
  EXPECT_FALSE(on(1));
  rig.far().with(
      [](fanuc::Machine& m) { return m.set_output(1, true), 0; });  // by hand, while it is inactive
  ASSERT_TRUE(rig.activate()) << rig.component.reason();
  ASSERT_TRUE(rig.runs(20, [](int) {}));
  EXPECT_TRUE(on(1));
  EXPECT_TRUE(on(4));
}

TEST(FanucComponent, DeactivatingWhileItMovesBrakesWithinTheLimits) {
  FanucRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  const double from = rig.command("J1/position");
  ASSERT_TRUE(rig.runs(100, [&](int i) { rig.command("J1/position") = from + travel(i, 0.003); }));
  EXPECT_EQ(rig.component.on_deactivate(), CallbackReturn::success);
  EXPECT_EQ(rig.component.cause(), Cause::none);
  EXPECT_TRUE(rig.far().with([](fanuc::Machine& m) { return m.alarm_text().empty(); }));
  EXPECT_FALSE(rig.far().program_runs());
  const Six at = rig.q();
  for (int i = 0; i < 100; ++i) rig.far().step();
  EXPECT_NEAR(rig.q()[0], at[0], 2e-3);
  ASSERT_TRUE(rig.activate()) << rig.component.reason();
  EXPECT_TRUE(rig.runs(10, [](int) {}));
}

TEST(FanucComponent, RepeatedAndReorderedPacketsMoveNothing) {
  FanucRig rig;
  expect_disturbed_packets_move_nothing(rig, {"duplicate=5", "reorder=2", "late=2"});
}

TEST(FanucComponent, AnOrderedFaultEndsWhenTheDriverStartsAgain) {
  FanucRig rig(Parameters{{"faults", "e_stop@0.1 release@again reset@again"}});
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.fails(500, [](int) {}));
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  EXPECT_TRUE(rig.runs(100, [](int) {}));
}

TEST(FanucComponent, WrongParametersAreNamed) {
  EXPECT_THROW(fanuc::FanucComponent().on_init(fanuc_context()), Error) << "a host must be given";
  for (const char* range : {"0-3", "5-2", "1-65", "a", "1.5", "99999"})
    EXPECT_THROW(fanuc::FanucComponent().on_init(fanuc_context({{"host", "x"}, {"digital_in", range}})),
                 Error)
        << range;
  EXPECT_THROW(fanuc::FakeFanuc().on_init(fanuc_context({{"wires", "0=1"}})), Error);
  EXPECT_THROW(fanuc::FakeFanuc().on_init(fanuc_context({{"faults", "e_stop"}})), Error);
  EXPECT_THROW(fanuc::FakeFanuc().on_init(fanuc_context({{"faults", "e_stopp@3"}})), Error);
  hardware::ComponentContext context = fanuc_context();
  context.period = 5'500'000;
  EXPECT_THROW(fanuc::FakeFanuc().on_init(context), Error);
}

/// The driver alone, as for a real controller: the far side ticks on its own thread.
class Alone {
 public:
  explicit Alone(FarSideOptions options = far_options(), Parameters more = {}) : far(std::move(options)) {
    Parameters parameters{{"host", "127.0.0.1"},
                          {"stream_port", std::to_string(far.stream_port())},
                          {"rmi_port", std::to_string(far.rmi_port())},
                          {"silence_ms", "10000"},
                          {"loop_silence_ms", "10000"},
                          {"settle", "0.05"}};
    more.merge(parameters);
    component.on_init(fanuc_context(more));
  }
  ~Alone() { component.on_shutdown(); }
  FarSide far;
  fanuc::FanucComponent component;
};

TEST(FanucComponent, ReadAndWriteNeitherAllocateNorLock) {
  if (!RealtimeGuard::watches()) GTEST_SKIP();
  Alone alone(far_options(), {{"digital_out", "1-4"}});
  auto& component = alone.component;
  ASSERT_TRUE(component.paces());
  ASSERT_EQ(component.on_configure(), CallbackReturn::success) << component.reason();
  ASSERT_EQ(component.on_activate(), CallbackReturn::success) << component.reason();
  std::vector<double> states(component.state_interfaces().size()),
      commands(component.command_interfaces().size(), std::nan(""));
  hardware::Cycle cycle{0, 8'000'000, 0};
  component.await_cycle(1'000'000'000);
  component.read(cycle, states);
  for (std::size_t j = 0; j < 6; ++j) commands[j] = states[3 * j];
  std::string violations;
  bool fine = true;
  for (int i = 0; i < 100; ++i) {
    component.await_cycle(1'000'000'000);
    const RealtimeGuard guard;
    commands[0] += 1e-5 * std::min(i, 20);
    commands[6] = i % 2;
    fine = component.read(cycle, states) == ReturnType::ok &&
           component.write(cycle, commands) == ReturnType::ok && fine;
    if (violations.empty()) violations = guard.violations();
  }
  EXPECT_TRUE(fine) << component.reason();
  EXPECT_EQ(violations, "");
}

TEST(FanucComponent, TheFirstLineComparesTheLimitsWithTheDescription) {
  FarSideOptions options = far_options();
  options.machine.table_share = 1;
  for (const char* load : {"1", "0"}) {
    Alone alone(options, {{"load", load}});
    ASSERT_EQ(alone.component.on_configure(), CallbackReturn::success) << alone.component.reason();
    const std::string said = alone.component.summary();
    EXPECT_NE(said.find("Stream Motion 3 at 125 Hz, Remote Motion 9.0"), std::string::npos) << said;
    const char* words = *load == '1' ? "its acceleration limit of J1 is 320, the description's 400"
                                     : "its limits allow those of the description";
    EXPECT_NE(said.find(words), std::string::npos) << said;
  }
}

TEST(FanucComponent, VersionFourHasForcesAndFourMilliseconds) {
  FarSideOptions options = far_options();
  options.version = 4;
  options.sampling_ms = 4;
  Alone alone(options, {{"pace", "false"}});
  ASSERT_EQ(alone.component.on_configure(), CallbackReturn::success) << alone.component.reason();
  std::vector<double> states(alone.component.state_interfaces().size());
  alone.component.read({}, states);
  const auto names = alone.component.state_interfaces();
  for (std::size_t i = 0; i < names.size(); ++i)
    if (names[i].name == "arm/force/force.x") {
      EXPECT_EQ(states[i], 0);
    }
  EXPECT_NE(alone.component.summary().find("Stream Motion 4 at 250 Hz"), std::string::npos)
      << alone.component.summary();
}

TEST(FanucComponent, ACellAtAnotherRateIsToldTheControllers) {
  FarSideOptions options = far_options();
  options.sampling_ms = 4;
  Alone alone(options);
  EXPECT_EQ(alone.component.on_configure(), CallbackReturn::failure);
  EXPECT_EQ(alone.component.cause(), Cause::wrong_rate);
  EXPECT_NE(alone.component.reason().find("rate: 250"), std::string::npos) << alone.component.reason();
}

}  // namespace
}  // namespace polyarm
