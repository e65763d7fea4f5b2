/// Faults of forward mode: each is named, the robot stands, its moves are forgotten, and nothing goes on.
#include <algorithm>

#include "tests/abb/forward_rig.hpp"
#include "tests/support/forward_laws.hpp"

namespace polyarm {
namespace {

using namespace test;

/// What a person does at the controller. The motors stay off.
void repair(FarSide& far) {
  for (const char* order : {"release", "guard_closed", "restart", "auto", "healthy"}) far.order(order);
}

class AbbForwardWhileMoving : public testing::TestWithParam<FaultRow> {};
INSTANTIATE_TEST_SUITE_P(
    Faults, AbbForwardWhileMoving,
    testing::Values(FaultRow{"e_stop", Cause::emergency_stop, "release the button"},
                    FaultRow{"guard_open", Cause::guard_stop, "close it"},
                    FaultRow{"manual", Cause::manual_mode, "manual mode"},
                    FaultRow{"motors_off", Cause::motors_off, "switch them on"},
                    FaultRow{"stop", Cause::program_stopped, "was stopped there"},
                    FaultRow{"collision", Cause::collision, "what the arm touched"},
                    FaultRow{"range", Cause::joint_range, "jog the robot back"},
                    FaultRow{"singular", Cause::singularity, "jog the robot away"},
                    FaultRow{"overload", Cause::load, "payload"},
                    FaultRow{"event=50063", Cause::event, "50063"},
                    FaultRow{"system_failure", Cause::system_failure, "restart it"},
                    FaultRow{"refuse_moves", Cause::moves_refused, "takes no move"},
                    FaultRow{"failing_move", Cause::move_failed, "could not make a move"},
                    FaultRow{"nonsense_moves", Cause::moves_bad_data, "no answer of it"},
                    FaultRow{"close_moves", Cause::moves_closed, "closed the connection"},
                    FaultRow{"other_program", Cause::moves_version, "version 2"},
                    FaultRow{"login", Cause::login, "`password_file`"},
                    FaultRow{"nonsense", Cause::rws_bad_data, "Robot Web Services"},
                    FaultRow{"power_off", Cause::rws_silent, "check cable and power"}),
    fault_name<Cause>);

TEST_P(AbbForwardWhileMoving, IsNamedStandsAndMovesNothingWhenItIsRecovered) {
  ForwardRig rig;
  expect_fault_ends_all_moves(rig, GetParam(), 60, [&](FarSide& far) {
    repair(far);
    expect_standing(rig);
    far.order("play");  // nobody who presses Start sets it in motion
  });
}

class AbbForwardBefore : public testing::TestWithParam<FaultRow> {};
INSTANTIATE_TEST_SUITE_P(Faults, AbbForwardBefore,
                         testing::Values(FaultRow{"e_stop", Cause::emergency_stop, "release the button"},
                                         FaultRow{"guard_open", Cause::guard_stop, "close it"},
                                         FaultRow{"manual", Cause::manual_mode, "manual mode"},
                                         FaultRow{"mastership", Cause::mastership, "log out there"},
                                         FaultRow{"refuse_start", Cause::start_refused,
                                                  "does not start its program"},
                                         FaultRow{"no_module", Cause::no_moves_module, "--motion forward"},
                                         FaultRow{"old_software", Cause::old_software, "6.05"},
                                         FaultRow{"other_program", Cause::moves_version, "install it again"},
                                         FaultRow{"other_base", Cause::frame_differs, "z 250 mm"},
                                         FaultRow{"nonsense_moves", Cause::moves_bad_data, "`moves_port`"}),
                         fault_name<Cause>);

TEST_P(AbbForwardBefore, StartingIsRefusedInWordsAndWorksOnceItIsMended) {
  ForwardRig rig(Parameters{{"answer_ms", "1000"}});
  rig.far().order(GetParam().order);
  EXPECT_FALSE(rig.start());
  expect_named(rig, GetParam());
  expect_standing(rig);
  repair(rig.far());
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  EXPECT_LE(rig.largest_jump(), 1e-6);
}

/// In manual mode a person may be in the middle of a program of their own.
TEST(AbbForwardFaults, ARefusedStartInManualModeLeavesTheProgramPointer) {
  ForwardRig rig;
  rig.far().order("manual");
  EXPECT_FALSE(rig.start());
  EXPECT_TRUE(rig.far().with([](abb::Machine& m) {
    return std::none_of(m.events().begin(), m.events().end(),
                        [](const abb::RwsEvent& one) { return one.code == 10002; });
  })) << "it was reset";
}

TEST(AbbForwardFaults, SilenceOfTheProgramIsNamed) {
  ForwardRig rig(Parameters{{"answer_ms", "1000"}});
  ASSERT_TRUE(begins(rig));
  ASSERT_TRUE(rig.moves->accept(rig.turn(1)));
  ASSERT_TRUE(rig.passes(50));
  rig.far().order("mute_moves");
  for (int i = 0; i < 50 && rig.component.cause() == Cause::none; ++i) rig.pass();
  EXPECT_EQ(rig.component.cause(), Cause::moves_silent) << rig.component.reason();
  expect_standing(rig, 1600);  // beyond the program's watchdog
}

/// The program runs: what is in the event log did not stop it.
TEST(AbbForwardFaults, AWarningInTheEventLogIsNoReasonForASilence) {
  ForwardRig rig(Parameters{{"answer_ms", "1000"}});
  ASSERT_TRUE(begins(rig));
  rig.far().with([](abb::Machine& m) { return m.event(50052, 2, "a warning"), 0; });
  rig.far().order("mute_moves");
  for (int i = 0; i < 50 && rig.component.cause() == Cause::none; ++i) rig.pass();
  EXPECT_EQ(rig.component.cause(), Cause::moves_silent) << rig.component.reason();
}

TEST(AbbForwardFaults, AHaltThatTheProgramDoesNotConfirmIsNamed) {
  ForwardRig rig;
  ASSERT_TRUE(begins(rig));
  ASSERT_TRUE(rig.moves->accept(rig.turn(1)));
  ASSERT_TRUE(rig.passes(60));
  rig.far().order("silent_halts");
  bool failed = false;
  for (int i = 0; i < 6000 && !failed; ++i) failed = rig.pass(0) == ReturnType::error;
  ASSERT_TRUE(failed);
  EXPECT_EQ(rig.component.cause(), Cause::halt_unconfirmed) << rig.component.reason();
  expect_standing(rig);
}

TEST(AbbForwardFaults, ALoopThatFallsSilentIsNamedAndTheRobotStops) {
  ForwardRig rig(Parameters{{"loop_silence_ms", "300"}});
  ASSERT_TRUE(begins(rig));
  ASSERT_TRUE(rig.moves->accept(rig.turn(1)));
  ASSERT_TRUE(rig.passes(60));
  for (int i = 0; i < 6000 && rig.component.cause() == Cause::none; ++i)
    rig.component.await_cycle(100'000'000);
  EXPECT_EQ(rig.component.cause(), Cause::loop_silent) << rig.component.reason();
  EXPECT_EQ(rig.read(), ReturnType::error);
  rig.component.on_error();
  EXPECT_FALSE(rig.far().takes_moves());
  expect_standing(rig);
}

TEST(AbbForwardFaults, DrawnAtRandomTheyAreAlwaysNamedAndNothingJumpsOrGoesOnByItself) {
  constexpr const char* kOrders[] = {
      "e_stop",    "guard_open",    "manual",       "motors_off",   "stop",          "collision",
      "range",     "singular",      "overload",     "event=50063",  "nonsense",      "login",
      "forbidden", "mastership",    "refuse_moves", "failing_move", "close_moves",   "nonsense_moves",
      "power_off", "other_program", "other_base",   "refuse_start", "system_failure"};
  ForwardRig rig(Parameters{{"connect_timeout", "20"}, {"rws", "1"}});
  expect_random_faults_end_all_moves(
      rig, kOrders, {.seed = 36, .until = 200, .after = 150, .most_jump = 6 * 0.004, .least_named = 1.0 / 3},
      repair);
}

}  // namespace
}  // namespace polyarm
