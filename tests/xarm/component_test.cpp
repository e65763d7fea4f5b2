/// The driver against the simulated controller: states, commands, life cycle.
#include <algorithm>

#include "tests/support/realtime_guard.hpp"
#include "tests/support/wire_laws.hpp"
#include "tests/xarm/rig.hpp"

namespace polyarm {
namespace {

using test::XarmRig;
using namespace test;
using xarm::Machine;
using xarm::Mode;
using xarm::State;

TEST(XarmComponent, ReadsWhatTheControllerReports) {
  XarmRig rig(Parameters{{"tool_io", "true"}, {"force_sensor", "true"}});
  ASSERT_TRUE(rig.configure()) << rig.component.reason();
  rig.read();
  EXPECT_NEAR(rig.state("joint3/position"), -0.6, kRounding) << "before it is active";
  EXPECT_EQ(rig.state("controller/mode"), 0);
  EXPECT_EQ(rig.state("controller/ready"), 0);
  rig.far().with([](Machine& machine) {
    machine.set_input(3, true);
    machine.set_tool_input(1, true);
    return 0;
  });
  rig.far().order("warning=14");
  ASSERT_TRUE(rig.activate()) << rig.component.reason();
  ASSERT_TRUE(rig.runs(30, [](int) {}));
  EXPECT_NEAR(rig.state("joint3/position"), -0.6, kRounding);
  EXPECT_EQ(rig.state("controller/mode"), 1);
  EXPECT_EQ(rig.state("controller/state"), 2) << "it stands";
  EXPECT_EQ(rig.state("controller/ready"), 1);
  for (const char* none : {"error", "warning", "queued", "shaped", "replaced"})
    EXPECT_EQ(rig.state(std::string("controller/") + none), 0) << none;
  EXPECT_EQ(rig.state("joint2/effort"), 0);
  EXPECT_EQ(rig.state("tcp_wrench/force.z"), 0);
  EXPECT_EQ(rig.state("io/digital_in_3"), 1);
  EXPECT_EQ(rig.state("io/digital_in_2"), 0);
  EXPECT_EQ(rig.state("io/tool_in_1"), 1);
  EXPECT_EQ(rig.state("io/tool_in_0"), 0);
}

TEST(XarmComponent, TheTcpIsWhereTheCataloguesKinematicsHaveIt) {
  XarmRig rig;
  expect_flange_is_where_the_model_has_it(rig, xarm_model(), "tcp_pose", 1e-6, 1e-5);
}

TEST(XarmComponent, TheFirstCommandIsTheMeasuredPosition) {
  XarmRig rig;
  const auto commands = [&] { return rig.far().with([](Machine& m) { return m.servo_commands(); }); };
  expect_first_command_is_measured(rig, commands, 195);
}

struct Arm {
  const char* model;
  std::size_t joints;
};
class Arms : public testing::TestWithParam<Arm> {};
INSTANTIATE_TEST_SUITE_P(Models, Arms,
                         testing::Values(Arm{"ufactory/xarm5", 5}, Arm{"ufactory/xarm_6", 6},
                                         Arm{"ufactory/xarm_7", 7}, Arm{"ufactory/lite_6", 6}),
                         [](const auto& arm) { return std::string(arm.param.model).substr(9); });

template <std::size_t kJoints>
void expect_each_joint_follows(const char* model) {
  std::vector<double> start(kJoints, 0.0);
  for (std::size_t j = 0; j < kJoints; ++j) {
    const auto& robot = catalogue_model(model);
    const auto& limits = robot.joints[static_cast<std::size_t>(robot.actuated[j])].limits;
    start[j] = (limits.lower.value_or(-1) + limits.upper.value_or(1)) / 2;
  }
  WireRig<xarm::FakeXarm, 3, kJoints> rig(wire_context(catalogue_model(model), start, 4'000'000, {}));
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  for (std::size_t j = 0; j < kJoints; ++j) {
    const double from = rig.commands[j];
    ASSERT_TRUE(rig.runs(300, [&](int i) { rig.commands[j] = from + 0.1 * smooth((i + 1) / 200.0); }))
        << rig.component.reason();
    EXPECT_NEAR(rig.states[3 * j], from + 0.1, kRounding) << "joint " << j + 1;
  }
}

TEST_P(Arms, EachJointFollowsItsCommands) {
  const Arm arm = GetParam();
  if (arm.joints == 5) expect_each_joint_follows<5>(arm.model);
  if (arm.joints == 6) expect_each_joint_follows<6>(arm.model);
  if (arm.joints == 7) expect_each_joint_follows<7>(arm.model);
}

class LoopPeriods : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Ms, LoopPeriods, testing::Values(4, 5, 10));

TEST_P(LoopPeriods, TheRobotFollowsWithTheLagOfTheController) {
  XarmRig rig(Parameters{}, GetParam() * 1'000'000);
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.runs(50, [](int) {}));
  const double from = rig.command("joint3/position");
  double most = 0;
  ASSERT_TRUE(rig.runs(800, [&](int i) {
    most = std::max(most, std::abs(rig.state("joint3/position") - rig.command("joint3/position")));
    rig.command("joint3/position") = from - 0.6 * smooth((i + 1) / 800.0);
  }));
  EXPECT_EQ(rig.state("controller/shaped"), 0) << "the motion is within the limits";
  EXPECT_EQ(rig.state("controller/replaced"), 0) << "each command is sent";
  EXPECT_LT(most, 0.006) << "two cycles";
  ASSERT_TRUE(rig.runs(100, [](int) {}));
  EXPECT_NEAR(rig.state("joint3/position"), from - 0.6, kRounding);
}

TEST(XarmComponent, NoJointIsFasterThanItsLimit) {
  XarmRig rig(Parameters{{"max_speed", "20"}});
  expect_no_joint_is_faster(rig, "joint1", Cause::too_fast, "max_speed", 0.1);
}

TEST(XarmComponent, WithoutACommandTheArmHoldsAndGoesOnFromThere) {
  XarmRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  const double from = rig.command("joint2/position");
  ASSERT_TRUE(rig.runs(200, [&](int i) { rig.command("joint2/position") = from + travel(i, 0.001); }));
  rig.command("joint4/position") = std::nan("");
  ASSERT_TRUE(rig.runs(200, [](int) {}));
  const double at = rig.state("joint2/position");
  EXPECT_GT(at, from + travel(199, 0.001)) << "it was braked, not stopped at once";
  ASSERT_TRUE(rig.runs(50, [](int) {}));
  EXPECT_EQ(rig.state("joint2/position"), at) << "it stands";
  rig.hold();
  ASSERT_TRUE(rig.runs(50, [](int) {})) << rig.component.reason();
}

TEST(XarmComponent, SignalsAreExchangedEveryFewCycles) {
  XarmRig rig(Parameters{{"wires", "1=3"}, {"digital_out", "1-9"}, {"tool_io", "true"}});
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  for (int round = 0; round < 6; ++round) {
    rig.command("io/digital_out_1") = rig.command("io/digital_out_9") = round % 2;
    rig.command("io/tool_out_1") = 1 - round % 2;
    ASSERT_TRUE(rig.runs(40, [](int) {}));
    EXPECT_EQ(rig.state("io/digital_out_1"), round % 2) << round;
    EXPECT_EQ(rig.state("io/digital_out_9"), round % 2) << "in the second word";
    EXPECT_EQ(rig.state("io/digital_in_3"), round % 2) << "wired to output 1";
    EXPECT_EQ(rig.state("io/tool_out_1"), 1 - round % 2);
    EXPECT_EQ(rig.state("io/digital_out_2"), 0) << "what nobody commands stays";
    EXPECT_EQ(rig.state("io/tool_out_0"), 0);
  }
}

TEST(XarmComponent, DeactivatingWhileItMovesBrakesAndLeavesTheControllerStopped) {
  XarmRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  const double from = rig.command("joint1/position");
  ASSERT_TRUE(rig.runs(200, [&](int i) { rig.command("joint1/position") = from + travel(i, 0.002); }));
  const double last = rig.command("joint1/position");
  rig.forget_jumps();
  EXPECT_EQ(rig.component.on_deactivate(), CallbackReturn::success);
  EXPECT_EQ(rig.component.cause(), Cause::none);
  EXPECT_LE(rig.largest_jump(), 0.002 + kRounding);
  rig.far().with([](Machine& m) {
    EXPECT_EQ(m.mode(), Mode::position);
    EXPECT_EQ(m.state(), State::stopped);
    EXPECT_TRUE(m.enabled()) << "the motors hold it";
    return 0;
  });
  const auto at = rig.q();
  EXPECT_GT(at[0], last + 0.002) << "it did not stop at once";
  ASSERT_EQ(rig.read(), ReturnType::ok);
  for (int i = 0; i < 100; ++i) rig.far().step();
  EXPECT_NEAR(rig.q()[0], at[0], 1e-4) << "its lag is gone";
  ASSERT_TRUE(rig.activate()) << rig.component.reason();
  EXPECT_TRUE(rig.runs(10, [](int) {}));
}

TEST(XarmComponent, LateReportsAndRepeatedAnswersMoveNothing) {
  XarmRig rig;
  expect_disturbed_packets_move_nothing(rig, {"late=3", "twice"});
}

TEST(XarmComponent, WrongParametersAreNamed) {
  EXPECT_THROW(xarm::XarmComponent().on_init(xarm_context()), Error) << "a host must be given";
  for (const auto& [name, value] :
       std::initializer_list<std::pair<std::string, std::string>>{{"servo_ms", "2"},
                                                                  {"digital_in", "5-4"},
                                                                  {"digital_out", "16"},
                                                                  {"report_port", "0"},
                                                                  {"clear_errors", "7"}})
    EXPECT_THROW(xarm::XarmComponent().on_init(xarm_context({{"host", "x"}, {name, value}})), Error) << name;
  EXPECT_THROW(xarm::XarmComponent().on_init(xarm_context({{"host", "x"}}, 100'000'000)), Error);
  EXPECT_THROW(xarm::FakeXarm().on_init(xarm_context({{"wires", "1"}})), Error);
  EXPECT_THROW(xarm::FakeXarm().on_init(xarm_context({{"faults", "e_stop"}})), Error);
  EXPECT_THROW(xarm::FakeXarm().on_init(xarm_context({}, 2'000'000)), Error) << "faster than 250 Hz";
}

TEST(XarmComponent, CommandsGoOutAtMostEveryFourMilliseconds) {
  EXPECT_EQ(xarm::cycles_of_command(1'000'000, 4), 4);
  EXPECT_EQ(xarm::cycles_of_command(2'000'000, 4), 2);
  EXPECT_EQ(xarm::cycles_of_command(4'000'000, 4), 1);
  EXPECT_EQ(xarm::cycles_of_command(10'000'000, 4), 1);
  EXPECT_EQ(xarm::cycles_of_command(3'000'000, 4), 2);
}

TEST(XarmComponent, ReadAndWriteNeitherAllocateNorLock) {
  if (!RealtimeGuard::watches()) GTEST_SKIP();
  Alone alone(far_options(), {{"digital_out", "0-3"}, {"digital_in", "0-3"}, {"tool_io", "true"}});
  auto& component = alone.component;
  ASSERT_FALSE(component.paces()) << "100 Hz is no clock for a loop";
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
    alone.step(static_cast<std::uint64_t>(i));
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

}  // namespace
}  // namespace polyarm
