/// Forward mode: the controller interpolates, the driver puts moves into its queue and follows.
#include <cmath>

#include "tests/support/forward_laws.hpp"
#include "tests/xarm/forward_rig.hpp"

namespace polyarm {
namespace {

using hardware::ForwardMove;
using namespace test;
using xarm::Machine;
using xarm::Mode;
using xarm::State;

constexpr Vec3 kArc{0, -0.2, 0}, kVia{0, -0.1, 0.1};  // half a circle upwards

TEST(XarmForward, NothingMovesBeforeAMoveIsHandedOver) {
  ForwardRig rig;
  expect_nothing_moves_before_a_move(rig);
}

TEST(XarmForward, JointMovesAndLinesEndWhereTheyShould) {
  ForwardRig rig;
  expect_moves_end_where_they_should(rig, {0, 0.05, 0.1}, 1e-4);
}

TEST(XarmForward, ALineIsStraight) {
  ForwardRig rig;
  expect_line_is_straight(rig, {0, -0.1, -0.08}, 2e-4);
}

/// The tool is not that of the flange: the controller gets it before the first move.
TEST(XarmForward, ALineOfATcpThatIsTurnedEndsWhereItShould) {
  ForwardRig rig;
  expect_line_of_a_turned_tcp_ends_at_its_target(rig);
}

TEST(XarmForward, AToolThatOnlyTurnsTakesItsTime) {
  ForwardRig rig;
  expect_turn_of_the_tool_takes_its_time(rig, 0.004);
}

TEST(XarmForward, AnArcPassesItsPoint) {
  ForwardRig rig;
  expect_arc_passes_its_point(rig, kArc, kVia, 0.002, 1e-4);
}

TEST(XarmForward, ABlendLeavesTheCornerByNoMoreThanItsRadiusAndSavesTime) {
  const auto joints = [](ForwardRig& rig, double blend) { return rig.turn(-0.3, blend); };
  const auto line = [](ForwardRig& rig, double blend) { return rig.shift({0, 0, -0.1}, blend); };
  expect_blend_stays_near_the_corner<ForwardRig>(line, {0, -0.15, 0}, 0.04, 2e-4);
  expect_blend_stays_near_the_corner<ForwardRig>(joints, {0, 0, -0.1}, 0.04, 2e-4);
}

/// Nobody at the controller sets it in motion: it is ready, and has no moves.
TEST(XarmForward, APauseStopsOnThePathAndGoesOnFromThere) {
  ForwardRig rig;
  expect_pause_stops_on_the_path(rig, -0.15, 100, 2e-4, [&] {
    EXPECT_EQ(rig.queued(), 0);
    rig.far().order("pause");
    rig.far().order("ready");
  });
}

TEST(XarmForward, APauseInAnArcGoesOnOnTheArc) {
  ForwardRig rig;
  expect_pause_in_an_arc_stays_on_it(rig, kArc, kVia);
}

TEST(XarmForward, ARobotThatSomebodySetsInMotionInAPauseIsPausedAgain) {
  ForwardRig rig;
  ASSERT_TRUE(begins(rig));
  ASSERT_TRUE(rig.moves->accept(rig.turn(3)));
  ASSERT_TRUE(rig.passes(80));
  ASSERT_TRUE(rig.passes(20, 0));
  rig.far().order("ready");
  ASSERT_TRUE(rig.passes_until([&] { return rig.moves->flow().standing; }, 0, 1000));
  const Six at = rig.q();
  ASSERT_TRUE(rig.passes(300, 0));
  expect_at(rig.q(), at, kStandsWithin);
  EXPECT_GT(std::abs((*rig.target)[0] - at[0]), 0.1) << "it has not come to its end";
}

TEST(XarmForward, AfterClearTheRobotStandsAndTakesOtherMoves) {
  ForwardRig rig;
  expect_clear_ends_all_moves(rig, 100);
}

TEST(XarmForward, ThePaceOfAMoveIsThatOfItsBeginning) {
  expect_pace_sets_the_time<ForwardRig>(3, [](ForwardRig&, double) {});
}

TEST(XarmForward, DeactivatingWhileItMovesStopsTheRobotAndForgetsItsMoves) {
  ForwardRig rig;
  ASSERT_TRUE(begins(rig));
  for (int i = 0; i < 4; ++i) ASSERT_TRUE(rig.moves->accept(rig.turn(i % 2 ? -0.5 : 0.5)));
  ASSERT_TRUE(rig.passes(100));
  EXPECT_EQ(rig.component.on_deactivate(), CallbackReturn::success);
  EXPECT_EQ(rig.component.cause(), Cause::none) << rig.component.reason();
  EXPECT_EQ(rig.queued(), 0);
  rig.far().with([](Machine& m) {
    EXPECT_EQ(m.state(), State::stopped);
    EXPECT_EQ(m.mode(), Mode::position);
    return 0;
  });
  expect_standing(rig);
  const Six at = rig.q();
  ASSERT_TRUE(rig.activate()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(100));
  EXPECT_TRUE(rig.moves->flow().idle);
  expect_at(rig.q(), at, 1e-6);
}

TEST(XarmForward, ManyMovesPassThroughTheQueueInOrder) {
  ForwardRig rig;
  expect_many_moves_pass_in_order(rig, 0.01);
}

/// After the connection is gone, it makes those that it has.
TEST(XarmForward, TheControllerHoldsFewMoves) {
  ForwardRig rig;
  ASSERT_TRUE(begins(rig));
  for (int i = 0; i < 12; ++i)
    ASSERT_TRUE(rig.moves->accept(rig.turn(i % 2 ? -0.1 : 0.11, i < 11 ? 0.01 : 0)));
  int most = 0;
  ASSERT_TRUE(rig.passes_until([&] { return most = std::max(most, rig.queued()), rig.done(); }));
  EXPECT_GT(most, 1);
  EXPECT_LE(most, static_cast<int>(xarm::kMoveSlots));
}

TEST(XarmForward, JointsKeepTheirSpeedOnALineThatNeedsThem) {
  ForwardRig rig(Parameters{{"line_acceleration", "20"}});
  ASSERT_TRUE(begins(rig));
  ForwardMove line = rig.shift({-0.1, -0.3, 0});
  line.speed = 10;
  ASSERT_TRUE(rig.moves->accept(line));
  double most = 0;
  const auto velocity = xarm::facts_of(xarm_model()).velocity;
  ASSERT_TRUE(rig.passes_until([&] {
    for (std::size_t j = 0; j < 6; ++j)
      most = std::max(most, std::abs(rig.states[3 * j + 1]) / (velocity[j] * kDegree));
    return rig.done();
  }));
  EXPECT_GT(most, 0.15);
  EXPECT_LE(most, 1.0);
}

TEST(XarmForward, OutputsAreSwitchedAndInputsAreRead) {
  ForwardRig rig(Parameters{{"wires", "1=3"}, {"tool_io", "true"}});
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  for (int round = 0; round < 4; ++round) {
    rig.command("io/digital_out_1") = round % 2;
    rig.command("io/tool_out_0") = 1 - round % 2;
    ASSERT_TRUE(rig.passes(10));
    EXPECT_EQ(rig.state("io/digital_out_1"), round % 2) << round;
    EXPECT_EQ(rig.state("io/digital_in_3"), round % 2) << "wired to output 1";
    EXPECT_EQ(rig.state("io/tool_out_0"), 1 - round % 2);
  }
}

TEST(XarmForward, AControllerThatCommandsJointsIsRefused) {
  ForwardRig rig;
  expect_joint_commands_are_refused(rig, Cause::joint_commands);
}

TEST(XarmForward, ArmsWithoutSixJointsAreRefused) {
  xarm::XarmComponent component;
  for (const char* model : {"ufactory/xarm5", "ufactory/xarm_7"})
    EXPECT_THROW(component.on_init(wire_context(catalogue_model(model), {}, 4'000'000,
                                                {{"host", "x"}, {"motion", "forward"}})),
                 Error);
  EXPECT_THROW(component.on_init(xarm_context({{"host", "x"}, {"motion", "sideways"}})), Error);
}

/// Moves that another client left at the controller are not carried out.
TEST(XarmForward, AQueueOfBeforeIsForgotten) {
  ForwardRig rig;
  rig.far().order("pause");
  rig.far().with([](Machine& machine) {
    xarm::UxMove move;
    move.joints[0] = 1;
    move.speed = move.acceleration = 1;
    machine.set_state(0);
    const auto request = encode(move, {});
    machine.answer({1, xarm::kPrivateProtocol, request.reg, request.data});
    machine.set_state(static_cast<int>(State::paused));
    return 0;
  });
  ASSERT_EQ(rig.queued(), 1);
  const Six before = rig.q();
  ASSERT_TRUE(begins(rig, 200));
  EXPECT_EQ(rig.queued(), 0);
  expect_at(rig.q(), before, 0.02);
}

// --- a controller whose clock runs by itself ---

TEST(XarmForward, OnAFreeClockMovesArriveAndTheLoopNeitherAllocatesNorLocks) {
  Alone alone(far_options(), {{"motion", "forward"}, {"answer_ms", "20000"}, {"watchdog_ms", "40000"}});
  auto& component = alone.component;
  ASSERT_TRUE(alone.start()) << component.reason();
  EXPECT_FALSE(component.paces());
  std::vector<double> states(component.state_interfaces().size());
  hardware::Cycle cycle{0, 4'000'000, 0};
  component.await_cycle(60'000'000'000);
  ASSERT_EQ(component.read(cycle, states), ReturnType::ok);
  const ForwardMove move = turn_from(states, 3, xarm_chain(), 0.1);
  expect_move_on_a_free_clock(component, move, cycle, states, 1e-3);
}

TEST(XarmForward, ALoopThatFallsSilentIsNamedAndTheRobotStops) {
  Alone alone(
      far_options(),
      {{"motion", "forward"}, {"answer_ms", "20000"}, {"watchdog_ms", "40000"}, {"loop_silence_ms", "200"}});
  auto& component = alone.component;
  ASSERT_TRUE(alone.start()) << component.reason();
  std::vector<double> states(component.state_interfaces().size()),
      commands(component.command_interfaces().size(), std::nan(""));
  hardware::Cycle cycle{0, 4'000'000, 0};
  component.write(cycle, commands);
  for (int i = 0; i < 4000 && component.cause() == Cause::none; ++i) component.await_cycle(100'000'000);
  EXPECT_EQ(component.cause(), Cause::loop_silent) << component.reason();
  EXPECT_EQ(component.read(cycle, states), ReturnType::error);
  component.on_error();
  EXPECT_EQ(alone.far.with([](Machine& m) { return m.state(); }), State::stopped);
}

}  // namespace
}  // namespace polyarm
