/// The driver against the simulated controller: states, commands, life cycle.
#include <algorithm>

#include "tests/abb/rig.hpp"
#include "tests/support/realtime_guard.hpp"
#include "tests/support/wire_laws.hpp"

namespace polyarm {
namespace {

using test::AbbRig;
using namespace test;

class BothVersions : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Rws, BothVersions, testing::Values("1", "2"));

TEST_P(BothVersions, ReadsWhatTheControllerMeasures) {
  AbbRig rig(Parameters{{"rws", GetParam()}});
  ASSERT_TRUE(rig.configure()) << rig.component.reason();
  rig.read();
  EXPECT_NEAR(rig.state("joint_3/position"), -0.1, 1e-9) << "before EGM runs";
  EXPECT_EQ(rig.state("controller/egm"), 0);
  EXPECT_EQ(rig.state("controller/motors_on"), 1);
  rig.far().with([](abb::Machine& machine) { return machine.set_input("diA", true), 0; });
  ASSERT_TRUE(rig.activate()) << rig.component.reason();
  ASSERT_TRUE(rig.runs(30, [](int) {}));
  EXPECT_NEAR(rig.state("joint_3/position"), -0.1, 1e-9);
  EXPECT_EQ(rig.state("controller/egm"), 1);
  EXPECT_EQ(rig.state("controller/automatic"), 1);
  EXPECT_EQ(rig.state("controller/running"), 1);
  EXPECT_EQ(rig.state("controller/converged"), 1);
  EXPECT_EQ(rig.state("controller/lost_packets"), 0);
  EXPECT_EQ(rig.state("controller/speed_ratio"), 1);
  EXPECT_EQ(rig.state("io/diA"), 1);
  EXPECT_TRUE(std::isnan(rig.state("force/force.x"))) << "no sensor";
}

TEST(AbbComponent, TheFlangeIsWhereTheCataloguesKinematicsHaveIt) {
  AbbRig rig;
  expect_flange_is_where_the_model_has_it(rig, abb_model(), "flange_pose", 1e-9, 1e-6);
}

TEST(AbbComponent, TheFirstCommandIsTheMeasuredPosition) {
  AbbRig rig;
  expect_first_command_is_measured(
      rig, [&] { return rig.far().messages(); }, 151);
}

TEST(AbbComponent, TheRobotFollowsPositionsInEachCycleOnce) {
  AbbRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.runs(50, [](int) {}));
  const double from = rig.command("joint_3/position");
  const std::uint64_t before = rig.far().messages();
  double behind = 0;
  ASSERT_TRUE(rig.runs(800, [&](int i) {
    behind = std::max(behind, std::abs(rig.command("joint_3/position") - rig.state("joint_3/position")));
    rig.command("joint_3/position") = from + 0.6 * smooth((i + 1) / 800.0);
  }));
  EXPECT_NEAR(static_cast<double>(rig.far().messages() - before), 800, 2) << "one command for each packet";
  EXPECT_EQ(rig.state("controller/shaped"), 0) << "the motion is within the limits";
  EXPECT_LT(behind, 0.02) << "the velocity in the commands keeps the delay small";
  ASSERT_TRUE(rig.runs(600, [](int) {}));
  EXPECT_NEAR(rig.state("joint_3/position"), from + 0.6, 1e-4);
}

TEST(AbbComponent, NoJointIsFasterThanTheModuleAllows) {
  AbbRig rig(Parameters{{"max_speed", "20"}});
  expect_no_joint_is_faster(rig, "joint_1", Cause::too_fast, "MaxSpeedDeviation", 1e-9);
}

TEST(AbbComponent, WithoutACommandTheArmHoldsAndGoesOnFromThere) {
  AbbRig rig;
  expect_arm_holds_without_a_command(rig, "joint_2", "joint_4", 0.001, 200, 800);
}

TEST_P(BothVersions, SignalsAndTheSpeedRatioAreExchangedEveryFewCycles) {
  AbbRig rig(Parameters{{"wires", "doA=diA"}, {"rws", GetParam()}});
  expect_signals_are_exchanged(rig, "io/doA", "io/diA", "io/doB");
  rig.command("controller/speed_ratio") = 0.4;
  ASSERT_TRUE(rig.runs(60, [](int) {}));
  EXPECT_EQ(rig.state("controller/speed_ratio"), 0.4);
}

TEST(AbbComponent, DeactivatingWhileItMovesBrakesAndStopsTheProgram) {
  AbbRig rig;
  expect_deactivating_ends_a_motion(rig, "joint_1", [](abb::Machine& m) { return m.program_runs(); });
}

TEST(AbbComponent, RepeatedAndReorderedPacketsMoveNothing) {
  AbbRig rig;
  expect_disturbed_packets_move_nothing(rig, {"duplicate=5", "reorder=2", "late=2"});
}

TEST(AbbComponent, WrongParametersAreNamed) {
  EXPECT_THROW(abb::AbbComponent().on_init(abb_context()), Error) << "a host must be given";
  EXPECT_THROW(abb::AbbComponent().on_init(abb_context({{"host", "x"}, {"rws", "3"}})), Error);
  EXPECT_THROW(abb::AbbComponent().on_init(abb_context({{"host", "x"}, {"digital_in", "a a"}})), Error);
  EXPECT_THROW(abb::AbbComponent().on_init(
                   abb_context({{"host", "x"}, {"digital_in", "n/d/doA"}, {"digital_out", "doA"}})),
               Error);
  EXPECT_THROW(abb::AbbComponent().on_init(abb_context({{"host", "x"}, {"password_file", "/no/such"}})),
               Error);
  EXPECT_THROW(abb::FakeAbb().on_init(abb_context({{"wires", "doA"}})), Error);
  EXPECT_THROW(abb::FakeAbb().on_init(abb_context({{"faults", "e_stop"}})), Error);
  hardware::ComponentContext context = abb_context();
  context.period = 2'000'000;
  EXPECT_THROW(abb::FakeAbb().on_init(context), Error);
}

/// The driver alone, as for a real controller: the far side ticks on its own thread.
class Alone {
 public:
  explicit Alone(FarSideOptions options = far_options(), Parameters more = {}) : far(options) {
    Parameters parameters{{"host", "127.0.0.1"},
                          {"rws_port", std::to_string(far.rws_port())},
                          {"egm_port", "0"},
                          {"silence_ms", "10000"},
                          {"loop_silence_ms", "10000"},
                          {"rws", std::to_string(options.rws_version)},
                          {"start_timeout", "60"},
                          {"connect_timeout", "60"}};
    more.merge(parameters);
    component.on_init(abb_context(more));
  }
  ~Alone() { component.on_shutdown(); }
  class Driver : public abb::AbbComponent {
   public:
    int egm_port() { return link()->egm_port(); }
  };
  bool start() {
    if (component.on_configure() != CallbackReturn::success) return false;
    far.send_egm_to("127.0.0.1", component.egm_port());
    return component.on_activate() == CallbackReturn::success;
  }
  FarSide far;
  Driver component;
};

TEST(AbbComponent, ReadAndWriteNeitherAllocateNorLock) {
  if (!RealtimeGuard::watches()) GTEST_SKIP();
  FarSideOptions options = far_options();
  options.machine.rapid.comm_timeout = 60;
  Alone alone(options, {{"digital_out", "doA"}, {"digital_in", "diA"}});
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

TEST(AbbComponent, ACellAtAnotherRateGetsTheControllersInWords) {
  Alone alone(far_options(), {{"sampling_ms", "8"}});
  EXPECT_EQ(alone.component.on_configure(), CallbackReturn::failure);
  EXPECT_EQ(alone.component.cause(), Cause::wrong_rate);
  EXPECT_NE(alone.component.reason().find("rate: 125"), std::string::npos) << alone.component.reason();
}

TEST(AbbComponent, AnotherCertificateIsRefused) {
  Alone alone(far_options(), {{"fingerprint", "AA:BB"}});
  EXPECT_EQ(alone.component.on_configure(), CallbackReturn::failure);
  EXPECT_EQ(alone.component.cause(), Cause::certificate) << alone.component.reason();
}

TEST(AbbComponent, OnlyTheInterfaceThatReachesTheControllerListens) {
  Alone alone;
  ASSERT_EQ(alone.component.on_configure(), CallbackReturn::success) << alone.component.reason();
  EXPECT_NE(alone.component.summary().find("RobotWare 7.10.0"), std::string::npos)
      << alone.component.summary();
  std::string why;
  const int port = alone.component.egm_port();
  EXPECT_FALSE(wire::bind_udp("127.0.0.1", port, why)) << "taken there";
  EXPECT_TRUE(wire::bind_udp("127.0.0.2", port, why)) << "not listening elsewhere: " << why;
}

}  // namespace
}  // namespace polyarm
