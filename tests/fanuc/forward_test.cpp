/// Forward mode: the controller interpolates, the driver sends moves and follows.
#include <cmath>

#include "polyarm/base/text.hpp"
#include "tests/fanuc/rig.hpp"
#include "tests/support/forward_laws.hpp"

namespace polyarm {
namespace {

using hardware::ForwardMove;
using namespace test;

class FanucMoveRig : public FanucRig {
 public:
  using FanucRig::FanucRig;
  /// The flange of a CRX, as the driver has it.
  static const kinematics::Chain& chain() {
    static const fanuc::MachineFacts facts = fanuc::facts_of(fanuc_model());
    return *facts.chain;
  }
};
using ForwardRig = ForwardMoveRig<FanucMoveRig>;

void expect_standing_alone(FarSide& far) {
  const auto at = [&] { return far.with([](fanuc::Machine& machine) { return machine.q(); }); };
  far.hold_clock(true);
  for (int i = 0; i < 200; ++i) far.step();
  const Six stopped = at();
  for (int i = 0; i < 100; ++i) far.step();
  for (std::size_t j = 0; j < 6; ++j) EXPECT_NEAR(at()[j], stopped[j], 1e-6);
}

TEST(FanucForward, NothingMovesBeforeAMoveIsHandedOver) {
  ForwardRig rig;
  expect_nothing_moves_before_a_move(rig, 50);
}

TEST(FanucForward, JointMovesAndLinesEndWhereTheyShould) {
  ForwardRig rig;
  expect_moves_end_where_they_should(rig, {0.05, 0, 0.1}, 1e-3);
}

TEST(FanucForward, AnArcPassesItsPoint) {
  ForwardRig rig;
  expect_arc_passes_its_point(rig, {0, -0.2, 0}, {0, -0.1, 0.1}, 0.003, 1e-3);
}

TEST(FanucForward, ABlendLeavesTheCornerByNoMoreThanItsRadiusAndSavesTime) {
  const auto line = [](ForwardRig& rig, double blend) { return rig.shift({0, 0, 0.15}, blend); };
  expect_blend_stays_near_the_corner<ForwardRig>(line, {0, 0.2, 0}, 0.02, 1e-3);
}

TEST(FanucForward, APauseStopsOnThePathAndGoesOnFromThere) {
  ForwardRig rig;
  expect_pause_stops_on_the_path(rig, 0.2, 40, 1e-3);
}

TEST(FanucForward, AfterClearTheRobotStandsAndTakesOtherMoves) {
  ForwardRig rig;
  expect_clear_ends_all_moves(rig, 60);
}

TEST(FanucForward, AClearInTheMiddleOfAMoveStopsThereAndAnotherMoveBegins) {
  ForwardRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  const Six before = rig.q();
  ASSERT_TRUE(rig.moves->accept(rig.turn(1.2)));
  ASSERT_TRUE(rig.passes(40));
  rig.moves->clear();
  ASSERT_TRUE(rig.passes_until([&] { return rig.moves->flow().idle && rig.moves->flow().standing; }, 1, 300));
  const Six at = rig.q();
  EXPECT_GT(at[0], before[0] + 0.02);
  EXPECT_LT(at[0], before[0] + 1.1) << "in the middle";
  rig.target.reset();
  ASSERT_TRUE(rig.moves->accept(rig.turn(-0.1)));
  ASSERT_TRUE(rig.passes_until([&] { return rig.done(); }));
  EXPECT_NEAR(rig.q()[0], at[0] - 0.1, 1e-3);
}

TEST(FanucForward, ThePaceIsTheControllersOverride) {
  expect_pace_sets_the_time<ForwardRig>(0.5, [](ForwardRig&, double) {});
}

TEST(FanucForward, ManyMovesPassThroughTheWindowInOrder) {
  ForwardRig rig;
  expect_many_moves_pass_in_order(rig, 0);
}

TEST(FanucForward, OutputsAndInputsGoOverTheSameWire) {
  ForwardRig rig(Parameters{{"wires", "1=2"}});
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  rig.command("io/digital_out_1") = 1;
  ASSERT_TRUE(rig.passes_until([&] { return rig.state("io/digital_in_2") == 1; }, 1, 60));
  rig.command("io/digital_out_1") = 0;
  ASSERT_TRUE(rig.passes_until([&] { return rig.state("io/digital_in_2") == 0; }, 1, 60));
}

TEST(FanucForward, AControllerThatCommandsJointsIsRefused) {
  ForwardRig rig;
  expect_joint_commands_are_refused(rig, Cause::joint_commands);
}

/// The controller's clock runs by itself, as a robot's does.
TEST(FanucForward, OnAFreeClockMovesArriveAndTheLoopNeitherAllocatesNorLocks) {
  FarSide far(far_options());
  fanuc::FanucComponent component;
  component.on_init(fanuc_context({{"host", "127.0.0.1"},
                                   {"motion", "forward"},
                                   {"rmi_port", std::to_string(far.rmi_port())},
                                   {"poll_ms", "8"},
                                   {"answer_ms", "10000"},
                                   {"loop_silence_ms", "10000"}}));
  EXPECT_FALSE(component.paces()) << "the interface has no clock";
  ASSERT_EQ(component.on_configure(), CallbackReturn::success) << component.reason();
  ASSERT_EQ(component.on_activate(), CallbackReturn::success) << component.reason();
  std::vector<double> states(component.state_interfaces().size());
  hardware::Cycle cycle{0, 8'000'000, 0};
  component.await_cycle(60'000'000'000);
  ASSERT_EQ(component.read(cycle, states), ReturnType::ok);
  expect_move_on_a_free_clock(component, turn_from(states, 3, FanucMoveRig::chain(), 0.1), cycle, states,
                              0.01);
  component.on_shutdown();
}

/// As after `kill -9`: the socket closes while instructions wait at the controller.
TEST(FanucForward, WhenTheConnectionEndsTheControllerStopsOnItsPath) {
  FarSide far(far_options());
  far.hold_clock(true);
  const auto at = [&] { return far.with([](fanuc::Machine& machine) { return machine.q(); }); };
  const Six start = at();
  {
    fanuc::RmiSession session;
    std::string why;
    int error = 0;
    ASSERT_TRUE(session.open("127.0.0.1", far.rmi_port(), "FRC_Connect", 2'000'000'000, why, error)) << why;
    ASSERT_TRUE(session.ask("Command", "FRC_Initialize", {"Command", "FRC_Initialize"}, 2'000'000'000));
    ForwardMove move;
    for (int k = 1; k <= 4; ++k) {
      for (std::size_t j = 0; j < 6; ++j) move.joints[j] = start[j] * kDegree;
      move.joints[0] += k % 2 ? 1.0 : 0.5;
      ASSERT_TRUE(session.send(fanuc::instruction_of(move, {}, k, false, {})));
    }
    ASSERT_TRUE(session.ask("Command", "FRC_GetStatus", {"Command", "FRC_GetStatus"}, 2'000'000'000));
    for (int i = 0; i < 60; ++i) far.step();
  }
  EXPECT_GT(std::abs(at()[0] - start[0]), 1);
  fanuc::RmiSession again;  // once it is accepted, the controller knows that the other one has gone
  std::string why;
  int error = 0;
  bool open = false;
  for (int i = 0; i < 100 && !open; ++i)
    open = again.open("127.0.0.1", far.rmi_port(), "FRC_Connect", 2'000'000'000, why, error);
  ASSERT_TRUE(open) << why;
  far.with([](fanuc::Machine& machine) { return machine.forget_jumps(), 0; });
  for (int i = 0; i < 200; ++i) far.step();
  const Six stopped = at();
  for (int i = 0; i < 200; ++i) far.step();
  for (std::size_t j = 0; j < 6; ++j) EXPECT_NEAR(at()[j], stopped[j], 1e-6);
  EXPECT_LT(std::abs(stopped[0] - start[0]), 55) << "not the end of the first move";
  EXPECT_LT(far.with([](fanuc::Machine& machine) { return machine.largest_jump(); }), 2) << "degrees in 8 ms";
}

TEST(FanucForward, ALoopThatFallsSilentIsNamedAndTheRobotStops) {
  FarSide far(far_options());
  fanuc::FanucComponent component;
  component.on_init(fanuc_context({{"host", "127.0.0.1"},
                                   {"motion", "forward"},
                                   {"rmi_port", std::to_string(far.rmi_port())},
                                   {"answer_ms", "10000"},
                                   {"loop_silence_ms", "200"}}));
  ASSERT_EQ(component.on_configure(), CallbackReturn::success) << component.reason();
  ASSERT_EQ(component.on_activate(), CallbackReturn::success) << component.reason();
  std::vector<double> states(component.state_interfaces().size()),
      commands(component.command_interfaces().size(), std::nan(""));
  hardware::Cycle cycle{0, 8'000'000, 0};
  component.await_cycle(1'000'000'000);
  component.read(cycle, states);
  component.write(cycle, commands);
  for (int i = 0; i < 200 && component.cause() == Cause::none; ++i) component.await_cycle(100'000'000);
  EXPECT_EQ(component.cause(), Cause::loop_silent) << component.reason();
  EXPECT_EQ(component.read(cycle, states), ReturnType::error);
  component.on_error();
  expect_standing_alone(far);
}

class ForwardWhileMoving : public testing::TestWithParam<FaultRow> {};
INSTANTIATE_TEST_SUITE_P(
    Faults, ForwardWhileMoving,
    testing::Values(FaultRow{"e_stop", Cause::emergency_stop, "release the button"},
                    FaultRow{"fence_open", Cause::fence, "fence"},
                    FaultRow{"t1", Cause::teach_mode, "teach pendant"},
                    FaultRow{"contact", Cause::contact, "contact"},
                    FaultRow{"alarm=65", Cause::alarm, "SRVO-065"},
                    FaultRow{"abort", Cause::program_stopped, "ended there without an alarm"},
                    FaultRow{"hold", Cause::program_stopped, "held by hand"},
                    FaultRow{"mute", Cause::rmi_silent, "does not answer"},
                    FaultRow{"terminate", Cause::terminated, "ended the remote session"},
                    FaultRow{"close_rmi", Cause::rmi_closed, "closed the Remote Motion Interface"},
                    FaultRow{"power_off", Cause::rmi_closed, "switched off"}),
    fault_name<Cause>);

TEST_P(ForwardWhileMoving, IsNamedStandsAndMovesNothingWhenItIsRecovered) {
  ForwardRig rig(Parameters{{"answer_ms", "300"}, {"connect_timeout", "0.5"}});
  expect_fault_ends_all_moves(rig, GetParam(), 60, mend);
}

TEST(FanucForwardFaults, DrawnAtRandomTheyAreAlwaysNamedAndNothingJumpsOrGoesOnByItself) {
  constexpr const char* kOrders[] = {"e_stop",   "fence_open", "t1",   "t2",        "contact",   "motn=610",
                                     "alarm=65", "abort",      "hold", "terminate", "close_rmi", "power_off"};
  ForwardRig rig(Parameters{{"connect_timeout", "1"}});
  expect_random_faults_end_all_moves(rig, kOrders, {.until = 120, .after = 120, .most_jump = 0.03}, mend);
}

}  // namespace
}  // namespace polyarm
