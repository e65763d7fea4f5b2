/// The driver against the simulated controller: states, commands, life cycle.
#include <algorithm>
#include <thread>

#include "tests/kuka/rig.hpp"
#include "tests/support/realtime_guard.hpp"
#include "tests/support/wire_laws.hpp"

namespace polyarm {
namespace {

using test::KukaRig;
using namespace test;

TEST(KukaComponent, ReadsWhatTheControllerMeasures) {
  KukaRig rig;
  ASSERT_TRUE(rig.configure()) << rig.component.reason();
  rig.read();
  EXPECT_NEAR(rig.state("joint_3/position"), 1.1, 1e-7) << "before RSI runs";
  EXPECT_EQ(rig.state("controller/rsi"), 0);
  EXPECT_EQ(rig.state("controller/drives_on"), 1);
  rig.far().with([](kuka::Machine& machine) { return machine.set_input(3, true), 0; });
  ASSERT_TRUE(rig.activate()) << rig.component.reason();
  ASSERT_TRUE(rig.runs(30, [](int) {}));
  EXPECT_NEAR(rig.state("joint_3/position"), 1.1, 1e-7);
  EXPECT_EQ(rig.state("controller/rsi"), 1);
  EXPECT_EQ(rig.state("controller/automatic"), 1);
  EXPECT_EQ(rig.state("controller/running"), 1);
  EXPECT_EQ(rig.state("controller/late_answers"), 0);
  EXPECT_EQ(rig.state("controller/lost_packets"), 0);
  EXPECT_EQ(rig.state("controller/speed_override"), 1);
  EXPECT_EQ(rig.state("io/digital_in_3"), 1);
  EXPECT_EQ(rig.state("io/digital_in_2"), 0);
}

TEST(KukaComponent, TheFlangeIsWhereTheCataloguesKinematicsHaveIt) {
  KukaRig rig;
  expect_flange_is_where_the_model_has_it(rig, kuka_model(), "flange_pose", 1e-8, 1e-6);
}

TEST(KukaComponent, TheFirstCommandIsTheMeasuredPosition) {
  KukaRig rig;
  expect_first_command_is_measured(
      rig, [&] { return rig.far().answers(); }, 191);
}

class BothCycles : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Rsi, BothCycles, testing::Values(4, 12));

TEST_P(BothCycles, TheRobotFollowsPositionsInEachCycleOnce) {
  KukaRig rig(Parameters{}, GetParam() * 1'000'000);
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.runs(50, [](int) {}));
  const double from = rig.command("joint_3/position");
  const std::uint64_t before = rig.far().answers();
  ASSERT_TRUE(
      rig.runs(800, [&](int i) { rig.command("joint_3/position") = from + 0.6 * smooth((i + 1) / 800.0); }));
  EXPECT_NEAR(static_cast<double>(rig.far().answers() - before), 800, 2) << "one answer for each packet";
  EXPECT_EQ(rig.state("controller/shaped"), 0) << "the motion is within the limits";
  ASSERT_TRUE(rig.runs(50, [](int) {}));
  EXPECT_NEAR(rig.state("joint_3/position"), from + 0.6, 1e-6);
}

TEST(KukaComponent, NoJointIsFasterThanItsLimit) {
  KukaRig rig(Parameters{{"max_speed", "20"}});
  expect_no_joint_is_faster(rig, "joint_1", Cause::too_fast, "max_speed", 1e-3);
}

TEST(KukaComponent, WithoutACommandTheArmHoldsAndGoesOnFromThere) {
  KukaRig rig;
  expect_arm_holds_without_a_command(rig, "joint_2", "joint_4", 0.001, 200, 800);
}

TEST(KukaComponent, SignalsAndTheOverrideAreExchangedEveryFewCycles) {
  KukaRig rig(Parameters{{"wires", "1=4"}});
  expect_signals_are_exchanged(rig, "io/digital_out_1", "io/digital_in_4", "io/digital_out_2");
  rig.command("controller/speed_override") = 0.4;
  ASSERT_TRUE(rig.runs(60, [](int) {}));
  EXPECT_EQ(rig.state("controller/speed_override"), 0.4);
}

TEST(KukaComponent, DeactivatingWhileItMovesBrakesAndEndsRsi) {
  KukaRig rig;
  expect_deactivating_ends_a_motion(rig, "joint_1", [](kuka::Machine& m) { return m.rsi(); });
}

TEST(KukaComponent, RepeatedReorderedAndMissingPacketsMoveNothing) {
  KukaRig rig;
  expect_disturbed_packets_move_nothing(rig, {"duplicate=5", "reorder=2", "late=2", "skip=40"});
  EXPECT_EQ(rig.state("controller/lost_packets"), 11) << "40 ms of the clock, and one out of order";
}

TEST(KukaComponent, WrongParametersAreNamed) {
  EXPECT_THROW(kuka::KukaComponent().on_init(kuka_context()), Error) << "a host must be given";
  for (const auto& [name, value] :
       std::initializer_list<std::pair<std::string, std::string>>{{"cycle_ms", "8"},
                                                                  {"digital_in", "0-4"},
                                                                  {"digital_in", "5-4"},
                                                                  {"digital_out", "40"},
                                                                  {"eki", "7"}})
    EXPECT_THROW(kuka::KukaComponent().on_init(kuka_context({{"host", "x"}, {name, value}})), Error) << name;
  EXPECT_THROW(
      kuka::KukaComponent().on_init(kuka_context({{"host", "x"}, {"eki", "false"}, {"digital_out", "1"}})),
      Error);
  EXPECT_THROW(kuka::FakeKuka().on_init(kuka_context({{"wires", "1"}})), Error);
  EXPECT_THROW(kuka::FakeKuka().on_init(kuka_context({{"faults", "e_stop"}})), Error);
  EXPECT_THROW(kuka::FakeKuka().on_init(kuka_context({}, 2'000'000)), Error);
}

TEST(KukaComponent, ReadAndWriteNeitherAllocateNorLock) {
  if (!RealtimeGuard::watches()) GTEST_SKIP();
  FarSideOptions options = far_options();
  options.machine.identity.late_limit = 100'000;
  Alone alone(options, {{"digital_out", "1-4"}, {"digital_in", "1-4"}});
  auto& component = alone.component;
  ASSERT_TRUE(component.paces());
  ASSERT_TRUE(alone.start()) << component.reason();
  std::vector<double> states(component.state_interfaces().size()),
      commands(component.command_interfaces().size(), std::nan(""));
  hardware::Cycle cycle{0, 4'000'000, 0};
  component.await_cycle(60'000'000'000);
  component.read(cycle, states);
  for (std::size_t j = 0; j < 6; ++j) commands[j] = states[2 * j];
  std::string violations;
  bool fine = true;
  for (int i = 0; i < 100; ++i) {
    component.await_cycle(60'000'000'000);
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

TEST(KukaComponent, ACellAtAnotherRateGetsTheControllersInWords) {
  FarSideOptions options = far_options();
  options.machine.identity.cycle_ms = 12;
  Alone alone(options);
  EXPECT_EQ(alone.component.on_configure(), CallbackReturn::failure);
  EXPECT_EQ(alone.component.cause(), Cause::wrong_rate);
  EXPECT_NE(alone.component.reason().find("rate: 83"), std::string::npos) << alone.component.reason();
}

/// A person starts the program; nothing but the packets of RSI says what the controller does.
TEST(KukaComponent, WithoutEthernetKrlItFollowsAProgramThatAPersonStarted) {
  FarSideOptions options = far_options();
  options.machine.identity.late_limit = 100'000;
  Alone alone(options, {{"eki", "false"}, {"connect_timeout", "1"}});
  ASSERT_TRUE(alone.configure()) << alone.component.reason();
  std::vector<double> states(alone.component.state_interfaces().size());
  hardware::Cycle cycle{0, 4'000'000, 0};
  ASSERT_EQ(alone.component.read(cycle, states), ReturnType::ok);
  EXPECT_TRUE(std::isnan(states[0])) << "nobody knows where the robot is";
  alone.far.with([](kuka::Machine& m) { return m.start(); });
  while (std::isnan(states[0])) alone.component.read(cycle, states);  // its packets are answered already
  EXPECT_EQ(states[1], 0) << "it stands";
  ASSERT_EQ(alone.component.on_activate(), CallbackReturn::success) << alone.component.reason();
  ASSERT_EQ(alone.component.read(cycle, states), ReturnType::ok);
  EXPECT_NEAR(states[0], 10 * kDegree, 1e-6);
  EXPECT_EQ(alone.far.requests(), 0u);
  EXPECT_EQ(alone.component.on_deactivate(), CallbackReturn::success);
  EXPECT_FALSE(alone.far.with([](kuka::Machine& m) { return m.rsi(); })) << "its Stop ended RSI";
}

/// Where a context of another person has no STOP, RSI goes on with the last corrections.
TEST(KukaComponent, WithoutEthernetKrlASessionThatDoesNotEndIsNotAnsweredWithZeroCorrections) {
  FarSideOptions options = far_options();
  options.machine.identity.late_limit = 100'000;
  Alone alone(options, {{"eki", "false"}, {"connect_timeout", "1"}});
  ASSERT_TRUE(alone.configure()) << alone.component.reason();
  alone.far.with([](kuka::Machine& m) {
    m.no_stop = true;
    return m.start();
  });
  ASSERT_EQ(alone.component.on_activate(), CallbackReturn::success) << alone.component.reason();
  std::vector<double> states(alone.component.state_interfaces().size()),
      commands(alone.component.command_interfaces().size(), std::nan(""));
  hardware::Cycle cycle{0, 4'000'000, 0};
  alone.component.await_cycle(60'000'000'000);
  ASSERT_EQ(alone.component.read(cycle, states), ReturnType::ok);
  for (std::size_t j = 0; j < 6; ++j) commands[j] = states[2 * j];
  const double from = commands[0];
  for (int i = 0; i < 300; ++i) {
    alone.component.await_cycle(60'000'000'000);
    commands[0] = from + travel(i, 1e-4);
    ASSERT_EQ(alone.component.read(cycle, states), ReturnType::ok) << alone.component.reason();
    ASSERT_EQ(alone.component.write(cycle, commands), ReturnType::ok) << alone.component.reason();
  }
  EXPECT_EQ(alone.component.on_deactivate(), CallbackReturn::success);
  const Six at = alone.far.with([](kuka::Machine& m) {
    m.forget_jumps();
    return m.q();
  });
  EXPECT_GT(at[0] * kDegree, from + 0.01);
  const std::uint64_t sent = alone.far.packets();
  while (alone.far.packets() < sent + 50) std::this_thread::yield();
  EXPECT_LE(alone.far.with([](kuka::Machine& m) { return m.largest_jump(); }), 1e-6);
  EXPECT_FALSE(alone.far.with([](kuka::Machine& m) { return m.reply().state.message; }));
  EXPECT_NEAR(alone.far.with([](kuka::Machine& m) { return m.q()[0]; }), at[0], 1e-6);
}

TEST(KukaComponent, OnlyTheInterfaceThatReachesTheControllerListens) {
  Alone alone;
  ASSERT_TRUE(alone.configure()) << alone.component.reason();
  EXPECT_NE(alone.component.summary().find("RSI 5 at 250 Hz"), std::string::npos)
      << alone.component.summary();
  std::string why;
  const int port = alone.component.rsi_port();
  EXPECT_FALSE(wire::bind_udp("127.0.0.1", port, why)) << "taken there";
  EXPECT_TRUE(wire::bind_udp("127.0.0.2", port, why)) << "not listening elsewhere: " << why;
}

}  // namespace
}  // namespace polyarm
