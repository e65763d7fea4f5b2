/// Faults of forward mode: each is named, the robot stands, its moves are forgotten, and nothing goes on.
#include <cmath>

#include "tests/support/forward_laws.hpp"
#include "tests/xarm/forward_rig.hpp"

namespace polyarm {
namespace {

using namespace test;
using xarm::Machine;
using xarm::State;

/// What a person does at the controller.
void repair(FarSide& far) {
  for (const char* order : {"release", "clear", "healthy"}) far.order(order);
}

class XarmForwardWhileMoving : public testing::TestWithParam<FaultRow> {};
INSTANTIATE_TEST_SUITE_P(Faults, XarmForwardWhileMoving,
                         testing::Values(FaultRow{"e_stop", Cause::emergency_stop, "release it"},
                                         FaultRow{"e_stop=2", Cause::emergency_stop, "both channels"},
                                         FaultRow{"error=31", Cause::collision, "clear the space"},
                                         FaultRow{"error=22", Cause::self_collision, "change the path"},
                                         FaultRow{"error=23", Cause::joint_limit, "move it back"},
                                         FaultRow{"error=24", Cause::speed_limit, "lower the speed"},
                                         FaultRow{"error=21", Cause::kinematics, "change the target"},
                                         FaultRow{"error=35", Cause::boundary, "manual mode"},
                                         FaultRow{"pause", Cause::paused, "who did it"},
                                         FaultRow{"stop", Cause::stopped, "stop button"},
                                         FaultRow{"motors_off", Cause::stopped, "another program"},
                                         FaultRow{"teach", Cause::mode_changed, "joint teach"},
                                         FaultRow{"mode=1", Cause::mode_changed, "servo"},
                                         FaultRow{"nonsense", Cause::bad_data, "check the address"},
                                         FaultRow{"short_report", Cause::bad_data, "`report_port`"},
                                         FaultRow{"not_a_number", Cause::bad_data, "`report_port`"},
                                         FaultRow{"bad_answer", Cause::bad_data, "`command_port`"},
                                         FaultRow{"other_register", Cause::bad_data, "`command_port`"},
                                         FaultRow{"close_command", Cause::closed, "closed a connection"},
                                         FaultRow{"close_report", Cause::closed, "closed a connection"},
                                         FaultRow{"refuse_moves", Cause::moves_refused, "takes no move"},
                                         FaultRow{"power_off", Cause::closed, "wait until it runs"}),
                         fault_name<Cause>);

TEST_P(XarmForwardWhileMoving, IsNamedStandsAndMovesNothingWhenItIsRecovered) {
  ForwardRig rig;
  expect_fault_ends_all_moves(rig, GetParam(), 60, [&](FarSide& far) {
    repair(far);
    expect_standing(rig);
    far.order("ready");  // nobody who sets it ready sets it in motion
  });
}

/// Also over a connection that was closed: the driver makes another one to stop it.
class XarmForwardEnds : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Faults, XarmForwardEnds,
                         testing::Values("close_command", "close_report", "nonsense", "bad_answer", "pause"));

TEST_P(XarmForwardEnds, NoMoveStaysAtTheController) {
  ForwardRig rig;
  ASSERT_TRUE(begins(rig));
  for (int i = 0; i < 6; ++i) ASSERT_TRUE(rig.moves->accept(rig.turn(i % 2 ? -0.9 : 0.9, i < 5 ? 0.02 : 0)));
  ASSERT_TRUE(rig.passes(60));
  EXPECT_GT(rig.queued(), 1);
  rig.far().order(GetParam());
  bool failed = false;
  for (int i = 0; i < 3000 && !failed; ++i) failed = rig.pass() == ReturnType::error;
  ASSERT_TRUE(failed);
  EXPECT_EQ(rig.queued(), 0);
  EXPECT_EQ(rig.far().with([](Machine& m) { return m.state(); }), State::stopped);
  expect_standing(rig);
}

TEST(XarmForwardFaults, SilenceOfTheReportsIsNamedAndTheRobotStops) {
  ForwardRig rig(Parameters{{"silence_ms", "400"}});
  ASSERT_TRUE(begins(rig));
  ASSERT_TRUE(rig.moves->accept(rig.turn(1.5)));
  ASSERT_TRUE(rig.passes(50));
  rig.far().order("silent");
  for (int i = 0; i < 100'000 && rig.component.cause() == Cause::none; ++i) rig.pass();
  EXPECT_EQ(rig.component.cause(), Cause::report_silent) << rig.component.reason();
  EXPECT_EQ(rig.queued(), 0);
  expect_standing(rig);
}

TEST(XarmForwardFaults, SilenceOfTheAnswersIsNamed) {
  ForwardRig rig(Parameters{{"answer_ms", "400"}});
  ASSERT_TRUE(begins(rig));
  ASSERT_TRUE(rig.moves->accept(rig.turn(0.5)));
  ASSERT_TRUE(rig.passes(50));
  rig.far().order("mute");
  for (int i = 0; i < 1000 && rig.component.cause() == Cause::none; ++i) rig.pass();
  EXPECT_EQ(rig.component.cause(), Cause::command_silent) << rig.component.reason();
  expect_standing(rig, 2000);
}

TEST(XarmForwardFaults, AnotherTcpThanThatOfTheCellIsNamed) {
  ForwardRig rig;
  ASSERT_TRUE(begins(rig));
  rig.far().order("refuse_tool");
  hardware::ForwardMove line = rig.shift({0, -0.1, 0});
  line.at = line.at * Pose{{0, 0, 0.1}, {}};
  ASSERT_TRUE(rig.moves->accept(line));
  bool failed = false;
  for (int i = 0; i < 1000 && !failed; ++i) failed = rig.pass() == ReturnType::error;
  ASSERT_TRUE(failed);
  EXPECT_EQ(rig.component.cause(), Cause::tool_differs) << rig.component.reason();
  EXPECT_NE(rig.component.reason().find("100 mm"), std::string::npos) << rig.component.reason();
  expect_standing(rig);
}

TEST(XarmForwardFaults, AStopThatTheControllerIgnoresIsNamed) {
  ForwardRig rig;
  ASSERT_TRUE(begins(rig));
  ASSERT_TRUE(rig.moves->accept(rig.turn(1)));
  ASSERT_TRUE(rig.passes(60));
  rig.far().order("ignore_stop");
  bool failed = false;
  for (int i = 0; i < 6000 && !failed; ++i) failed = rig.pass(0) == ReturnType::error;
  ASSERT_TRUE(failed);
  EXPECT_EQ(rig.component.cause(), Cause::halt_unconfirmed) << rig.component.reason();
  expect_standing(rig);
}

/// Nobody here moves it.
TEST(XarmForwardFaults, AMoveOfAnotherClientIsNamed) {
  ForwardRig rig;
  ASSERT_TRUE(begins(rig, 300));
  rig.far().with([](Machine& machine) {
    xarm::UxMove move;
    move.joints[0] = 1;
    move.speed = move.acceleration = 1;
    const auto request = encode(move, {});
    machine.answer({1, xarm::kPrivateProtocol, request.reg, request.data});
    return 0;
  });
  bool failed = false;
  for (int i = 0; i < 1000 && !failed; ++i) failed = rig.pass() == ReturnType::error;
  ASSERT_TRUE(failed);
  EXPECT_EQ(rig.component.cause(), Cause::moves) << rig.component.reason();
  expect_standing(rig);
}

TEST(XarmForwardFaults, ARobotThatSomethingElseMovesIsNamed) {
  ForwardRig rig;
  ASSERT_TRUE(begins(rig, 300));
  rig.far().order("other_moves");
  bool failed = false;
  for (int i = 0; i < 1000 && !failed; ++i) failed = rig.pass() == ReturnType::error;
  ASSERT_TRUE(failed);
  EXPECT_EQ(rig.component.cause(), Cause::moves) << rig.component.reason();
}

TEST(XarmForwardFaults, LateReportsAndAnswersThatComeTwiceAreNoFaults) {
  ForwardRig rig;
  ASSERT_TRUE(begins(rig));
  ASSERT_TRUE(rig.moves->accept(rig.turn(0.4)));
  ASSERT_TRUE(rig.passes(30));
  rig.far().order("late=20");
  ASSERT_TRUE(rig.passes(60));
  rig.far().order("twice");
  ASSERT_TRUE(rig.passes_until([&] { return rig.done(); }));
  expect_at(rig.q(), *rig.target, 1e-4);
}

class XarmForwardBefore : public testing::TestWithParam<FaultRow> {};
INSTANTIATE_TEST_SUITE_P(Faults, XarmForwardBefore,
                         testing::Values(FaultRow{"e_stop", Cause::emergency_stop, "release it"},
                                         FaultRow{"refuse_enable", Cause::enable_refused, "motors"},
                                         FaultRow{"refuse_state", Cause::state_refused, "become ready"},
                                         FaultRow{"other_moves", Cause::moves, "nothing was commanded"},
                                         FaultRow{"other_axes", Cause::wrong_axes, "7 axes"},
                                         FaultRow{"bad_answer", Cause::bad_data, "`command_port`"},
                                         FaultRow{"nonsense", Cause::bad_data, "`report_port`"}),
                         fault_name<Cause>);

TEST_P(XarmForwardBefore, StartingIsRefusedInWords) {
  ForwardRig rig(Parameters{{"start_timeout", "3"}});
  const bool early = std::string(GetParam().order) != "other_moves";
  if (!early) {
    ASSERT_TRUE(rig.configure());
  }
  rig.far().order(GetParam().order);
  EXPECT_FALSE(early ? rig.start() : rig.activate());
  expect_named(rig, GetParam());
}

TEST(XarmForwardFaults, DrawnAtRandomTheyAreAlwaysNamedAndNothingJumpsOrGoesOnByItself) {
  constexpr const char* kOrders[] = {"e_stop",       "e_stop=2",       "error=31",      "error=23",
                                     "pause",        "stop",           "teach",         "mode=1",
                                     "motors_off",   "nonsense",       "short_report",  "not_a_number",
                                     "bad_answer",   "other_register", "close_command", "close_report",
                                     "refuse_moves", "power_off",      "refuse_enable"};
  ForwardRig rig;
  expect_random_faults_end_all_moves(
      rig, kOrders, {.seed = 35, .until = 200, .after = 150, .most_jump = 3.2 * 0.004, .least_named = 0.5},
      repair);
}

}  // namespace
}  // namespace polyarm
