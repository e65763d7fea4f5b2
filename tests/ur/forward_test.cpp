/// Forward mode: the controller interpolates, the driver sends moves and follows.
#include <cmath>

#include "tests/support/forward_laws.hpp"
#include "tests/ur/forward_rig.hpp"

namespace polyarm {
namespace {

using hardware::ForwardMove;
using namespace test;

constexpr Vec3 kArc{0, 0.2, 0}, kVia{0, 0.1, -0.1};  // half a circle downwards

TEST(UrForward, NothingMovesBeforeAMoveIsHandedOver) {
  ForwardRig rig;
  expect_nothing_moves_before_a_move(rig);
}

TEST(UrForward, JointMovesAndLinesEndWhereTheyShould) {
  ForwardRig rig;
  expect_moves_end_where_they_should(rig, {0, 0.05, -0.1}, 1e-4);
}

TEST(UrForward, ALineIsStraight) {
  ForwardRig rig;
  expect_line_is_straight(rig, {0, 0.15, -0.2}, 1e-4);
}

TEST(UrForward, AnArcPassesItsPoint) {
  ForwardRig rig;
  expect_arc_passes_its_point(rig, kArc, kVia, 0.002, 1e-4);
}

TEST(UrForward, ABlendLeavesTheCornerByNoMoreThanItsRadiusAndSavesTime) {
  const auto line = [](ForwardRig& rig, double blend) { return rig.shift({0, 0, -0.15}, blend); };
  expect_blend_stays_near_the_corner<ForwardRig>(line, {0, 0.15, 0}, 0.04, 1e-4);
}

TEST(UrForward, APauseStopsOnThePathAndGoesOnFromThere) {
  ForwardRig rig;
  expect_pause_stops_on_the_path(rig, -0.2, 250, 1e-4);
}

TEST(UrForward, APausedRobotDoesNotMoveWhenSomebodyRaisesTheSliderAtThePendant) {
  ForwardRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  ASSERT_TRUE(rig.moves->accept(rig.turn(1)));
  ASSERT_TRUE(rig.passes(250));
  ASSERT_TRUE(rig.passes_until([&] { return rig.moves->flow().standing; }, 0, 500));
  const ur::Six at = rig.q();
  rig.far().with([](ur::Machine& machine) {
    machine.input("speed_slider_mask", 1);
    machine.input("speed_slider_fraction", 1);
    machine.apply_inputs();
    return 0;
  });
  ASSERT_TRUE(rig.passes(500, 0));
  EXPECT_EQ(rig.q(), at);
}

TEST(UrForward, APauseInAnArcGoesOnOnTheArc) {
  ForwardRig rig;
  expect_pause_in_an_arc_stays_on_it(rig, kArc, kVia);
}

TEST(UrForward, AfterClearTheRobotStandsAndTakesOtherMoves) {
  ForwardRig rig;
  expect_clear_ends_all_moves(rig, 100);
}

TEST(UrForward, ThePaceIsTheSpeedSliderAndIsGivenBack) {
  expect_pace_sets_the_time<ForwardRig>(0.8, [](ForwardRig& rig, double pace) {
    EXPECT_NEAR(rig.state("controller/speed_slider"), pace, 1e-9);
    rig.component.on_deactivate();
    for (int i = 0; i < 100 && rig.slider() != 1; ++i) rig.far().step();
    EXPECT_EQ(rig.slider(), 1) << "for other programs";
  });
}

TEST(UrForward, AfterAFaultInAHoldTheSliderIsGivenBackOnceAProgramEndsInOrder) {
  ForwardRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  ASSERT_TRUE(rig.moves->accept(rig.turn(0.8)));
  ASSERT_TRUE(rig.passes(200));
  ASSERT_TRUE(rig.passes_until([&] { return rig.moves->flow().standing; }, 0, 500));
  EXPECT_EQ(rig.slider(), 0);
  rig.far().order("program_stop");
  for (int i = 0; i < 100 && rig.component.cause() == Cause::none; ++i) rig.pass(0);
  EXPECT_EQ(rig.component.cause(), Cause::program_stopped) << rig.component.reason();
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5, 0));
  rig.component.on_deactivate();
  rig.far().step();
  EXPECT_EQ(rig.slider(), 1);
}

TEST(UrForward, ManyMovesPassThroughTheQueueInOrder) {
  ForwardRig rig;
  expect_many_moves_pass_in_order(rig, 0.01);
}

TEST(UrForward, JointsKeepTheirLimitsOnALineThatNeedsThem) {
  ForwardRig rig(Parameters{{"line_acceleration", "20"}});
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  ForwardMove line = rig.shift({-0.25, -0.3, 0});
  line.speed = 10;
  ASSERT_TRUE(rig.moves->accept(line));
  double most = 0;
  ASSERT_TRUE(rig.passes_until([&] {
    for (std::size_t j = 0; j < 6; ++j)
      most = std::max(most, std::abs(rig.states[4 * j + 1]) / ur::facts_of(ur_model()).velocity[j]);
    return rig.done();
  }));
  EXPECT_GT(most, 0.5);
  EXPECT_LE(most, 1.0);
}

TEST(UrForward, AControllerThatCommandsJointsIsRefused) {
  ForwardRig rig;
  expect_joint_commands_are_refused(rig, Cause::joint_commands);
}

TEST(UrForward, WithoutTheSpeedSliderItIsRefused) {
  ur::FakeUr component;
  EXPECT_THROW(component.on_init(ur_context({{"motion", "forward"}, {"io", "false"}})), Error);
}

/// The controller's clock runs by itself, as a robot's does.
TEST(UrForward, OnAFreeClockMovesArriveAndTheLoopNeitherAllocatesNorLocks) {
  ForwardAlone alone({{"watchdog_ms", "5000"}, {"silence_ms", "10000"}});
  ASSERT_TRUE(alone.start()) << alone.component.reason();
  const ForwardMove move = turn_from(alone.states, 4, ur_chain(), 0.1);
  expect_move_on_a_free_clock(alone.component, move, alone.cycle, alone.states, 1e-3);
}

TEST(UrForward, ALoopThatFallsSilentIsNamedAndTheRobotStops) {
  ForwardAlone alone({{"watchdog_ms", "200"}, {"silence_ms", "10000"}});
  ASSERT_TRUE(alone.start()) << alone.component.reason();
  alone.component.write(alone.cycle, alone.commands);
  for (int i = 0; i < 4000 && alone.component.cause() == Cause::none; ++i)
    alone.component.await_cycle(100'000'000);
  EXPECT_TRUE(alone.component.cause() == Cause::loop_silent ||
              alone.component.cause() == Cause::commands_late)
      << alone.component.reason();
  EXPECT_EQ(alone.component.read(alone.cycle, alone.states), ReturnType::error);
  alone.component.on_error();
  expect_standing_of(alone.far);
}

/// As after `kill -9`: the socket closes while moves wait at the controller.
TEST(UrForward, WhenTheConnectionEndsTheControllerStops) {
  FarSide far(far_options());
  std::string why;
  const Descriptor listener = wire::listen_tcp("127.0.0.1", 0, why);
  const Descriptor primary = wire::connect_tcp("127.0.0.1", far.primary_port(), 5'000'000'000, why);
  ur::ScriptSettings script;
  script.host = "127.0.0.1";
  script.port = wire::local_port(listener.number());
  ASSERT_TRUE(wire::send_frame(primary.number(), ur::move_program_text(script)));
  ASSERT_TRUE(wire::wait_readable(listener.number(), 10'000'000'000));
  Descriptor stream = wire::accept_tcp(listener.number());
  ASSERT_TRUE(stream);
  far.hold_clock(true);
  const auto at = [&] { return far.with([](ur::Machine& machine) { return machine.q(); }); };
  const ur::Six start = at();
  ur::MoveMessage move;
  move.work = ur::Work::joint;
  move.timeout_ms = 5000;
  move.speed = 1, move.acceleration = 10;
  for (int k = 1; k <= 4; ++k) {
    move.sequence = move.number = k;
    move.goal = start;
    move.goal[0] += k % 2 ? 1.0 : 0.5;
    ASSERT_TRUE(wire::send_frame(stream.number(), ur::encode(move)));
  }
  ASSERT_TRUE(far.step(4));
  for (int i = 0; i < 150; ++i) far.step();
  EXPECT_GT(std::abs(at()[0] - start[0]), 0.1);
  stream = Descriptor();
  const auto state = [&] {
    return far.with([](ur::Machine& machine) { return machine.value("output_int_register_25").front(); });
  };
  while (state() != static_cast<int>(ur::ScriptState::timed_out)) std::this_thread::yield();
  expect_standing_of(far);
  EXPECT_LT(std::abs(at()[0] - start[0]), 0.8) << "not the end of the first move";
}

TEST(UrForward, AProgramDoesNotGoOnWhenASafeguardStopEnds) {
  ForwardRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(rig.moves->accept(rig.turn(i % 2 ? -0.3 : 0.3)));
  ASSERT_TRUE(rig.passes(100));
  rig.far().order("deaf");  // it reads no more that it shall end
  rig.far().order("safeguard_stop");
  bool failed = false;
  for (int i = 0; i < 2000 && !failed; ++i) failed = rig.pass() == ReturnType::error;
  ASSERT_TRUE(failed);
  EXPECT_EQ(rig.component.cause(), Cause::safeguard_stop) << rig.component.reason();
  expect_standing(rig);
  const ur::Six at = rig.q();
  rig.far().order("normal");
  expect_standing(rig);
  EXPECT_EQ(rig.q(), at);
}

class UrForwardWhileMoving : public testing::TestWithParam<FaultOf<Cause>> {};
INSTANTIATE_TEST_SUITE_P(
    Faults, UrForwardWhileMoving,
    testing::Values(FaultOf<Cause>{"protective_stop", Cause::protective_stop, "protective stop"},
                    FaultOf<Cause>{"safeguard_stop", Cause::safeguard_stop, "safeguard stop"},
                    FaultOf<Cause>{"emergency_stop", Cause::emergency_stop, "release the button"},
                    FaultOf<Cause>{"violation", Cause::safety_fault, "VIOLATION"},
                    FaultOf<Cause>{"power_off", Cause::robot_mode, "switched off"},
                    FaultOf<Cause>{"program_stop", Cause::program_stopped, "was stopped there"},
                    FaultOf<Cause>{"program_pause", Cause::program_paused, "was paused there"},
                    FaultOf<Cause>{"close_rtde", Cause::rtde_closed, "closed the RTDE connection"},
                    FaultOf<Cause>{"garbage", Cause::bad_data, "no RTDE"},
                    FaultOf<Cause>{"dead", Cause::rtde_closed, "switched off"},
                    FaultOf<Cause>{"deaf", Cause::not_reading, "does not read its commands"}),
    fault_name<Cause>);

TEST_P(UrForwardWhileMoving, IsNamedStandsAndMovesNothingWhenItIsRecovered) {
  ForwardRig rig(Parameters{{"watchdog_ms", "200"}});
  expect_fault_ends_all_moves(rig, GetParam(), 200, mend);
}

TEST(UrForwardFaults, DrawnAtRandomTheyAreAlwaysNamedAndNothingJumpsOrGoesOnByItself) {
  constexpr const char* kOrders[] = {"protective_stop", "safeguard_stop", "emergency_stop", "violation",
                                     "power_off",       "program_stop",   "program_pause",  "close_rtde",
                                     "garbage",         "dead",           "local",          "close_stream"};
  ForwardRig rig;
  expect_random_faults_end_all_moves(rig, kOrders, {.until = 300, .after = 200, .most_jump = 0.008}, mend);
}

}  // namespace
}  // namespace polyarm
