/// Forward mode: the controller interpolates, the driver sends moves and follows.
#include <cmath>

#include "tests/kuka/forward_rig.hpp"
#include "tests/support/forward_laws.hpp"

namespace polyarm {
namespace {

using hardware::ForwardMove;
using namespace test;

constexpr Vec3 kArc{0, -0.2, 0}, kVia{0, -0.1, 0.1};  // half a circle upwards

TEST(KukaForward, NothingMovesBeforeAMoveIsHandedOver) {
  ForwardRig rig;
  expect_nothing_moves_before_a_move(rig);
}

TEST(KukaForward, JointMovesAndLinesEndWhereTheyShould) {
  ForwardRig rig;
  expect_moves_end_where_they_should(rig, {0, 0.05, 0.1}, 1e-4);
}

TEST(KukaForward, ALineIsStraight) {
  ForwardRig rig;
  expect_line_is_straight(rig, {0, -0.1, -0.08}, 2e-4);
}

/// The tool is not that of the flange: the controller gets it before the first move.
TEST(KukaForward, ALineOfATcpThatIsTurnedEndsWhereItShould) {
  ForwardRig rig;
  expect_line_of_a_turned_tcp_ends_at_its_target(rig);
}

TEST(KukaForward, AToolThatOnlyTurnsTakesItsTime) {
  ForwardRig rig;
  expect_turn_of_the_tool_takes_its_time(rig, 0.004);
}

TEST(KukaForward, AnArcPassesItsPoint) {
  ForwardRig rig;
  expect_arc_passes_its_point(rig, kArc, kVia, 0.002, 1e-4);
}

TEST(KukaForward, ABlendLeavesTheCornerByNoMoreThanItsRadiusAndSavesTime) {
  const auto joints = [](ForwardRig& rig, double blend) { return rig.turn(-0.3, blend); };
  const auto line = [](ForwardRig& rig, double blend) { return rig.shift({0, 0, -0.15}, blend); };
  expect_blend_stays_near_the_corner<ForwardRig>(line, {0, -0.15, 0}, 0.04, 2e-4);
  expect_blend_stays_near_the_corner<ForwardRig>(joints, {0, -0.15, 0}, 0.04, 2e-4);
}

TEST(KukaForward, APauseStopsOnThePathAndGoesOnFromThere) {
  ForwardRig rig;
  expect_pause_stops_on_the_path(rig, -0.2, 120, 2e-4, [&] { EXPECT_EQ(rig.override_percent(), 0); });
}

TEST(KukaForward, APausedRobotDoesNotMoveWhenSomebodyRaisesTheOverrideOrPressesStart) {
  ForwardRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  ASSERT_TRUE(rig.moves->accept(rig.turn(1)));
  ASSERT_TRUE(rig.passes(50));
  ASSERT_TRUE(rig.passes_until([&] { return rig.moves->flow().standing; }, 0, 500));
  const Six at = rig.q();
  rig.far().with([](kuka::Machine& machine) { return machine.set_override(100); });
  rig.far().order("play");
  ASSERT_TRUE(rig.passes(300, 0));
  EXPECT_LT(at[0], 1.2) << "it has not come to its end";
  for (std::size_t j = 0; j < 6; ++j) EXPECT_NEAR(rig.q()[j], at[j], kStandsWithin);
}

TEST(KukaForward, APauseInAnArcGoesOnOnTheArc) {
  ForwardRig rig;
  expect_pause_in_an_arc_stays_on_it(rig, kArc, kVia);
}

TEST(KukaForward, AfterClearTheRobotStandsAndTakesOtherMoves) {
  ForwardRig rig;
  expect_clear_ends_all_moves(rig, 100);
}

TEST(KukaForward, ThePaceIsTheOverrideAndIsGivenBack) {
  struct Slowed : ForwardRig {
    Slowed() {
      far().with([](kuka::Machine& machine) { return machine.set_override(80); });
    }
  };
  expect_pace_sets_the_time<Slowed>(0.8, [](Slowed& rig, double pace) {
    EXPECT_NEAR(rig.state("controller/speed_override"), pace, 1e-9);
    rig.component.on_deactivate();
    EXPECT_EQ(rig.override_percent(), 80) << "for other programs";
  });
}

TEST(KukaForward, DeactivatingWhileItMovesStopsTheRobotAndForgetsItsMoves) {
  ForwardRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  for (int i = 0; i < 4; ++i) ASSERT_TRUE(rig.moves->accept(rig.turn(i % 2 ? -0.5 : 0.5)));
  ASSERT_TRUE(rig.passes(100));
  EXPECT_EQ(rig.component.on_deactivate(), CallbackReturn::success);
  EXPECT_EQ(rig.component.cause(), Cause::none) << rig.component.reason();
  expect_standing(rig);
  const Six at = rig.q();
  ASSERT_TRUE(rig.activate()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(100));
  EXPECT_TRUE(rig.moves->flow().idle);
  for (std::size_t j = 0; j < 6; ++j) EXPECT_NEAR(rig.q()[j], at[j], 1e-6);
}

TEST(KukaForward, ManyMovesPassThroughTheQueueInOrder) {
  ForwardRig rig;
  expect_many_moves_pass_in_order(rig, 0.01);
}

TEST(KukaForward, AxesKeepTheirSpeedOnALineThatNeedsThem) {
  ForwardRig rig(Parameters{{"line_acceleration", "20"}});
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  ForwardMove line = rig.shift({-0.15, -0.35, 0});
  line.speed = 10;
  ASSERT_TRUE(rig.moves->accept(line));
  double most = 0;
  const Six velocity = kuka::facts_of(kuka_model()).velocity;
  ASSERT_TRUE(rig.passes_until([&] {
    for (std::size_t j = 0; j < 6; ++j)
      most = std::max(most, std::abs(rig.states[2 * j + 1]) / (velocity[j] * kDegree));
    return rig.done();
  }));
  EXPECT_GT(most, 0.3);
  EXPECT_LE(most, 1.0);
}

TEST(KukaForward, OutputsAreSwitchedAndInputsAreRead) {
  ForwardRig rig(Parameters{{"wires", "1=4"}});
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  for (int round = 0; round < 4; ++round) {
    rig.command("io/digital_out_1") = round % 2;
    ASSERT_TRUE(rig.passes(10));
    EXPECT_EQ(rig.state("io/digital_out_1"), round % 2) << round;
    EXPECT_EQ(rig.state("io/digital_in_4"), round % 2) << "wired to output 1";
  }
}

TEST(KukaForward, AControllerThatCommandsJointsIsRefused) {
  ForwardRig rig;
  expect_joint_commands_are_refused(rig, Cause::joint_commands);
}

TEST(KukaForward, WithoutEthernetKrlItIsRefused) {
  kuka::KukaComponent component;
  EXPECT_THROW(component.on_init(kuka_context({{"host", "x"}, {"motion", "forward"}, {"eki", "false"}})),
               Error);
  EXPECT_THROW(component.on_init(kuka_context({{"host", "x"}, {"motion", "sideways"}})), Error);
}

/// The controller's clock runs by itself, as a robot's does.
TEST(KukaForward, OnAFreeClockMovesArriveAndTheLoopNeitherAllocatesNorLocks) {
  Alone alone(far_options(), {{"motion", "forward"}, {"answer_ms", "20000"}, {"watchdog_ms", "10000"}});
  auto& component = alone.component;
  ASSERT_EQ(component.on_configure(), CallbackReturn::success) << component.reason();
  ASSERT_EQ(component.on_activate(), CallbackReturn::success) << component.reason();
  EXPECT_FALSE(component.paces());
  std::vector<double> states(component.state_interfaces().size());
  hardware::Cycle cycle{0, 4'000'000, 0};
  component.await_cycle(60'000'000'000);
  ASSERT_EQ(component.read(cycle, states), ReturnType::ok);
  const ForwardMove move = turn_from(states, 2, kuka_chain(), 0.1);
  expect_move_on_a_free_clock(component, move, cycle, states, 1e-3);
}

TEST(KukaForward, ALoopThatFallsSilentIsNamedAndTheRobotStops) {
  Alone alone(
      far_options(),
      {{"motion", "forward"}, {"answer_ms", "20000"}, {"watchdog_ms", "10000"}, {"loop_silence_ms", "200"}});
  auto& component = alone.component;
  ASSERT_EQ(component.on_configure(), CallbackReturn::success) << component.reason();
  ASSERT_EQ(component.on_activate(), CallbackReturn::success) << component.reason();
  std::vector<double> states(component.state_interfaces().size()),
      commands(component.command_interfaces().size(), std::nan(""));
  hardware::Cycle cycle{0, 4'000'000, 0};
  component.write(cycle, commands);
  for (int i = 0; i < 4000 && component.cause() == Cause::none; ++i) component.await_cycle(100'000'000);
  EXPECT_EQ(component.cause(), Cause::loop_silent) << component.reason();
  EXPECT_EQ(component.read(cycle, states), ReturnType::error);
  component.on_error();
  EXPECT_FALSE(alone.far.with([](kuka::Machine& m) { return m.rsi(); }));
}

TEST(KukaForward, SilenceOfTheControllerIsNamed) {
  ForwardRig rig(Parameters{{"answer_ms", "1000"}});
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  ASSERT_TRUE(rig.moves->accept(rig.turn(1)));
  ASSERT_TRUE(rig.passes(50));
  rig.far().order("mute");
  for (int i = 0; i < 50 && rig.component.cause() == Cause::none; ++i) rig.pass();
  EXPECT_EQ(rig.component.cause(), Cause::eki_silent) << rig.component.reason();
  expect_standing(rig);
}

class KukaForwardWhileMoving : public testing::TestWithParam<FaultRow> {};
INSTANTIATE_TEST_SUITE_P(Faults, KukaForwardWhileMoving,
                         testing::Values(FaultRow{"e_stop", Cause::emergency_stop, "release the button"},
                                         FaultRow{"guard_open", Cause::guard_stop, "guard"},
                                         FaultRow{"t1", Cause::manual_mode, "mode T1"},
                                         FaultRow{"aut", Cause::drives_off, "drives"},
                                         FaultRow{"drives_off", Cause::drives_off, "switch them on"},
                                         FaultRow{"stop", Cause::program_stopped, "was stopped there"},
                                         FaultRow{"cancel", Cause::program_ended, "deselected"},
                                         FaultRow{"collision", Cause::message, "read it at its smartPAD"},
                                         FaultRow{"nonsense", Cause::eki_bad_data,
                                                  "no message of PolyarmEki"},
                                         FaultRow{"close_eki", Cause::eki_closed, "closed the connection"},
                                         FaultRow{"refuse_moves", Cause::moves_refused, "takes no move"},
                                         FaultRow{"power_off", Cause::eki_closed, "switched off"}),
                         fault_name<Cause>);

TEST_P(KukaForwardWhileMoving, IsNamedStandsAndMovesNothingWhenItIsRecovered) {
  ForwardRig rig;
  expect_fault_ends_all_moves(rig, GetParam(), 60, [&](FarSide& far) {
    mend(far);
    expect_standing(rig);
    far.order("play");  // nobody who presses Start sets it in motion
  });
}

TEST(KukaForward, AHaltThatTheProgramDoesNotConfirmIsNamed) {
  ForwardRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  ASSERT_TRUE(rig.moves->accept(rig.turn(1)));
  ASSERT_TRUE(rig.passes(60));
  rig.far().order("silent_halts");
  bool failed = false;
  for (int i = 0; i < 6000 && !failed; ++i) failed = rig.pass(0) == ReturnType::error;
  ASSERT_TRUE(failed);
  EXPECT_EQ(rig.component.cause(), Cause::halt_unconfirmed) << rig.component.reason();
  expect_standing(rig);
}

TEST(KukaForwardFaults, DrawnAtRandomTheyAreAlwaysNamedAndNothingJumpsOrGoesOnByItself) {
  constexpr const char* kOrders[] = {"e_stop",  "guard_open",  "t1",           "t2",        "aut",
                                     "cancel",  "drives_off",  "stop",         "collision", "nonsense",
                                     "busy",    "close_eki",   "refuse_moves", "power_off", "refuse_drives",
                                     "old_rsi", "refuse_start"};
  ForwardRig rig;
  expect_random_faults_end_all_moves(
      rig, kOrders, {.seed = 31, .until = 200, .after = 150, .most_jump = 6 * 0.004, .least_named = 1.0 / 3},
      mend);
}

}  // namespace
}  // namespace polyarm
