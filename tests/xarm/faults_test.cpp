/// Everything that can end a link, with the words for it: the robot stands afterwards, and nothing moves it
/// again.
#include <set>

#include "tests/support/wire_faults.hpp"
#include "tests/xarm/rig.hpp"

namespace polyarm {
namespace {

using test::XarmRig;
using namespace test;
using xarm::Machine;

/// What a person does at the controller. Errors and the stopped state stay.
void mend(FarSide& far) {
  for (const char* order : {"release", "healthy"}) far.order(order);
}

class WhileMoving : public testing::TestWithParam<FaultRow> {};
INSTANTIATE_TEST_SUITE_P(
    Faults, WhileMoving,
    testing::Values(FaultRow{"e_stop", Cause::emergency_stop, "button at the control box"},
                    FaultRow{"e_stop=2", Cause::emergency_stop, "close both channels"},
                    FaultRow{"e_stop=3", Cause::emergency_stop, "enabling switch"},
                    FaultRow{"error=13", Cause::joint_error, "joint 3"},
                    FaultRow{"error=31", Cause::collision, "clear the space"},
                    FaultRow{"error=22", Cause::self_collision, "would touch itself"},
                    FaultRow{"error=23", Cause::joint_limit, "beyond its limit"},
                    FaultRow{"error=21", Cause::kinematics, "no joint positions lead there"},
                    FaultRow{"error=24", Cause::speed_limit, "lower the speed"},
                    FaultRow{"error=60", Cause::speed_limit, "tool would be too fast in servo mode"},
                    FaultRow{"error=25", Cause::planning, "cannot plan"},
                    FaultRow{"error=35", Cause::boundary, "safety boundary"},
                    FaultRow{"error=19", Cause::tool_error, "baud rate"},
                    FaultRow{"error=53", Cause::force_sensor, "overloaded"},
                    FaultRow{"error=33", Cause::controller_error, "C33"},
                    FaultRow{"error=99", Cause::controller_error, "does not know the code"},
                    FaultRow{"pause", Cause::paused, "was paused"},
                    FaultRow{"stop", Cause::stopped, "stopped without an error"},
                    FaultRow{"motors_off", Cause::stopped, "stopped without an error"},
                    FaultRow{"refuse_servo", Cause::command_refused, "refused a servo command"},
                    FaultRow{"nonsense", Cause::bad_data, "no frame"},
                    FaultRow{"short_report", Cause::bad_data, "report_port"},
                    FaultRow{"not_a_number", Cause::bad_data, "no frame"},
                    FaultRow{"bad_answer", Cause::bad_data, "command_port"},
                    FaultRow{"other_register", Cause::bad_data, "no frame"},
                    FaultRow{"close_command", Cause::closed, "closed a connection"},
                    FaultRow{"close_report", Cause::closed, "closed a connection"},
                    FaultRow{"power_off", Cause::closed, "switched off"}),
    fault_name<Cause>);

TEST_P(WhileMoving, IsNamedStandsAndDoesNotJumpWhenItIsRecovered) {
  XarmRig rig;
  expect_fault_while_moving(rig, GetParam(), {.joint = "joint3", .after = 60, .patience = 1000}, mend);
}

/// The mode is left to who chose it, and recovering takes it back.
class ModeOfOthers : public testing::TestWithParam<FaultRow> {};
INSTANTIATE_TEST_SUITE_P(Faults, ModeOfOthers,
                         testing::Values(FaultRow{"teach", Cause::mode_changed, "joint teach"},
                                         FaultRow{"mode=0", Cause::mode_changed, "mode 0 (position)"}),
                         fault_name<Cause>);

TEST_P(ModeOfOthers, EndsTheMotionAndIsNotChangedByTheDriver) {
  XarmRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  rig.far().order(GetParam().order);
  const auto mode = rig.far().with([](Machine& m) { return m.mode(); });
  ASSERT_TRUE(rig.fails(100, [](int) {}));
  expect_named(rig, GetParam());
  rig.component.on_error();
  EXPECT_EQ(rig.far().with([](Machine& m) { return m.mode(); }), mode);
  ASSERT_TRUE(rig.start()) << rig.component.reason();
}

TEST(XarmFaults, AnotherModeThatIsReadyIsNamed) {
  XarmRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  rig.far().with([](Machine& m) { return m.set_mode(2), m.set_state(0), 0; });
  ASSERT_TRUE(rig.fails(100, [](int) {}));
  EXPECT_EQ(rig.component.cause(), Cause::mode_changed) << rig.component.reason();
  EXPECT_NE(rig.component.reason().find("mode 2 (joint teach)"), std::string::npos) << rig.component.reason();
}

class BeforeItMoves : public testing::TestWithParam<FaultRow> {};
INSTANTIATE_TEST_SUITE_P(Faults, BeforeItMoves,
                         testing::Values(FaultRow{"e_stop", Cause::emergency_stop, "release it"},
                                         FaultRow{"e_stop=2", Cause::emergency_stop, "(EI)"},
                                         FaultRow{"refuse_enable", Cause::enable_refused, "motors"},
                                         FaultRow{"other_axes=7", Cause::wrong_axes, "7 axes"},
                                         FaultRow{"nonsense", Cause::bad_data, "no frame"},
                                         FaultRow{"short_report", Cause::bad_data, "report_port"},
                                         FaultRow{"not_a_number", Cause::bad_data, "no frame"},
                                         FaultRow{"bad_answer", Cause::bad_data, "command_port"},
                                         FaultRow{"other_register", Cause::bad_data, "no frame"}),
                         fault_name<Cause>);

TEST_P(BeforeItMoves, StartingIsRefusedInWordsAndWorksOnceItIsMended) {
  XarmRig rig;
  expect_fault_before_motion(rig, GetParam(), mend);
}

/// These end by a time without an answer.
class InSilence : public testing::TestWithParam<FaultRow> {};
INSTANTIATE_TEST_SUITE_P(Faults, InSilence,
                         testing::Values(FaultRow{"silent", Cause::report_silent, "sends no reports"},
                                         FaultRow{"mute", Cause::command_silent, "does not answer"},
                                         FaultRow{"refuse_mode", Cause::mode_refused, "servo mode"},
                                         FaultRow{"refuse_state", Cause::state_refused, "ready for motion"},
                                         FaultRow{"other_moves", Cause::moves, "moves though nothing"}),
                         fault_name<Cause>);

TEST_P(InSilence, StartingIsRefusedInWords) {
  XarmRig rig(Parameters{{"connect_timeout", "1"}, {"start_timeout", "2"}});
  rig.far().order(GetParam().order);
  ASSERT_FALSE(rig.start());
  // A machine that is too slow for the times of this test gives another one of the causes of silence.
  const bool slow =
      rig.component.cause() == Cause::command_silent || rig.component.cause() == Cause::report_silent;
  if (!slow || GetParam().cause == Cause::command_silent) {
    EXPECT_EQ(rig.component.cause(), GetParam().cause) << rig.component.reason();
    EXPECT_NE(rig.component.reason().find(GetParam().words), std::string::npos) << rig.component.reason();
  }
  EXPECT_NE(rig.component.reason().find("127.0.0.1"), std::string::npos) << rig.component.reason();
}

TEST(XarmFaults, AnErrorIsClearedByActivatingOnlyIfThatIsAllowed) {
  XarmRig allowed;
  ASSERT_TRUE(allowed.configure()) << allowed.component.reason();
  allowed.far().order("error=31");
  EXPECT_EQ(allowed.read(), ReturnType::ok) << "nothing is cleared by itself";
  EXPECT_EQ(allowed.far().with([](Machine& m) { return m.error(); }), 31);
  EXPECT_TRUE(allowed.activate()) << allowed.component.reason();

  XarmRig forbidden(Parameters{{"clear_errors", "false"}});
  forbidden.far().order("error=31");
  EXPECT_FALSE(forbidden.start());
  EXPECT_EQ(forbidden.component.cause(), Cause::error_pending) << forbidden.component.reason();
  EXPECT_NE(forbidden.component.reason().find("C31"), std::string::npos) << forbidden.component.reason();
  EXPECT_EQ(forbidden.far().with([](Machine& m) { return m.error(); }), 31);
}

TEST(XarmFaults, MotorsThatAreOffAreSwitchedOnByActivating) {
  XarmRig rig;
  rig.far().order("motors_off");
  ASSERT_TRUE(rig.configure()) << rig.component.reason();
  EXPECT_FALSE(rig.far().with([](Machine& m) { return m.enabled(); }));
  ASSERT_TRUE(rig.activate()) << rig.component.reason();
  EXPECT_TRUE(rig.far().with([](Machine& m) { return m.enabled(); }));
}

TEST(XarmFaults, ARefusedActivationLeavesTheComponentReading) {
  XarmRig rig;
  expect_refused_activation_keeps_reading(rig, "refuse_enable", "healthy");
}

TEST(XarmFaults, FirmwareThatIsTooOldIsNamed) {
  FarSideOptions options = far_options();
  options.machine.firmware = "1.2.9";
  Alone alone(options);
  EXPECT_FALSE(alone.configure());
  EXPECT_EQ(alone.component.cause(), Cause::old_firmware);
  EXPECT_NE(alone.component.reason().find("1.2.9"), std::string::npos) << alone.component.reason();
}

TEST(XarmFaults, AControllerThatIsNotThereIsNamed) {
  expect_unreachable<xarm::XarmComponent>(
      xarm_context({{"host", "127.0.0.1"}, {"command_port", std::to_string(closed_port())}}),
      Cause::unreachable, "polyarm setup xarm");
}

TEST(XarmFaults, AnOutputThatCannotBeSwitchedIsNamed) {
  XarmRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  rig.far().order("locked_outputs");
  rig.command("io/digital_out_1") = 1;
  ASSERT_TRUE(rig.fails(100, [](int) {}));
  EXPECT_EQ(rig.component.cause(), Cause::signal_refused) << rig.component.reason();
  EXPECT_NE(rig.component.reason().find("output 1"), std::string::npos) << rig.component.reason();
  expect_standing(rig);
}

TEST(XarmFaults, AJumpOfTheCommandsIsNotSent) {
  XarmRig rig;
  expect_no_jump_is_sent(rig, "joint5", Cause::jump, 60);
}

TEST(XarmFaults, AFirstCommandAwayFromTheMeasuredPositionIsNotSent) {
  XarmRig rig;
  expect_no_far_begin_is_sent(rig, "joint2", Cause::jump);
}

TEST(XarmFaults, WithoutCommandsTheControllerHoldsItsLastTarget) {
  XarmRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  const double from = rig.command("joint1/position");
  ASSERT_TRUE(rig.runs(120, [&](int i) { rig.command("joint1/position") = from + travel(i, 0.002); }));
  const auto before = rig.q();
  for (int i = 0; i < 60; ++i) rig.read();  // a cycle of the controller each; it has the last command before
  const auto at = rig.q();
  EXPECT_LT(at[0] - before[0], 0.01) << "no further than its lag";
  for (int i = 0; i < 60; ++i) rig.read();
  EXPECT_EQ(rig.q(), at);
}

TEST(XarmFaults, ALoopThatFallsSilentIsNamedAndTheRobotStands) {
  XarmRig rig(Parameters{{"loop_silence_ms", "300"}});  // the controller's clock stands still
  expect_silent_loop_is_braked(rig, Cause::loop_silent);
}

/// A loop that is late does not stop the robot abruptly: a few missing commands slow it down.
TEST(XarmFaults, AGapOfTheLoopSlowsTheRobotDown) {
  Alone alone;
  ASSERT_TRUE(alone.start()) << alone.component.reason();
  std::vector<double> states(alone.component.state_interfaces().size()),
      commands(alone.component.command_interfaces().size(), std::nan(""));
  hardware::Cycle cycle{0, 4'000'000, 0};
  alone.component.read(cycle, states);
  for (std::size_t j = 0; j < 6; ++j) commands[j] = states[3 * j];
  const double from = commands[0];
  alone.far.hold_clock(true);
  for (int i = 0; i < 120; ++i) {
    commands[0] = from + travel(i, 0.001);
    ASSERT_EQ(alone.component.write(cycle, commands), ReturnType::ok);
    alone.step(static_cast<std::uint64_t>(i + 1));
  }
  const auto before = alone.far.with([](Machine& m) { return m.servo_commands(); });
  alone.step(before + 2);  // without a command of the loop
  for (int i = 0; i < 60; ++i) alone.far.step();
  EXPECT_GT(alone.far.with([](Machine& m) { return m.q()[0]; }) * kDegree, commands[0] + 1e-4)
      << "it goes on a little while it slows down";
  EXPECT_EQ(alone.component.cause(), Cause::none) << alone.component.reason();
  commands[0] = from + travel(119, 0.001);  // the loop goes on
  ASSERT_EQ(alone.component.write(cycle, commands), ReturnType::ok);
  alone.far.hold_clock(false);
}

/// The loop goes on while an answer is late: what it commanded meanwhile is not one large step.
TEST(XarmFaults, ALateAnswerMakesNoJump) {
  Alone alone;
  ASSERT_TRUE(alone.start()) << alone.component.reason();
  std::vector<double> states(alone.component.state_interfaces().size()),
      commands(alone.component.command_interfaces().size(), std::nan(""));
  hardware::Cycle cycle{0, 4'000'000, 0};
  alone.component.read(cycle, states);
  for (std::size_t j = 0; j < 6; ++j) commands[j] = states[3 * j];
  const double from = commands[0];
  alone.far.hold_clock(true);
  const auto write = [&](int i) {
    commands[0] = from + travel(i, 0.001);
    return alone.component.write(cycle, commands);
  };
  for (int i = 0; i < 120; ++i) {
    ASSERT_EQ(write(i), ReturnType::ok);
    alone.step(static_cast<std::uint64_t>(i + 1));
  }
  alone.far.with([](Machine& m) { return m.forget_jumps(), 0; });
  const auto before = alone.far.with([](Machine& m) { return m.servo_commands(); });
  alone.far.order("late_answers=5");
  for (int i = 120; i < 140; ++i) ASSERT_EQ(write(i), ReturnType::ok) << alone.component.reason();
  alone.step(before + 1);
  for (int i = 0; i < 5; ++i) alone.far.step();
  alone.step(before + 2);  // what was commanded last, once the answer is there
  EXPECT_EQ(alone.component.cause(), Cause::none) << alone.component.reason();
  EXPECT_LE(alone.far.with([](Machine& m) { return m.largest_jump(); }), 60 * 0.004 + 1e-3) << "degrees";
  EXPECT_GT(alone.far.with([](Machine& m) { return m.largest_jump(); }), 0) << "it goes on";
  alone.far.hold_clock(false);
}

TEST(XarmFaults, SilenceOfTheReportsIsNamed) {
  XarmRig rig(Parameters{{"silence_ms", "200"}});
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  rig.far().order("silent");
  ASSERT_TRUE(rig.fails(100'000'000, [](int) {}));
  EXPECT_EQ(rig.component.cause(), Cause::report_silent) << rig.component.reason();
  expect_standing(rig);
}

TEST(XarmFaults, SilenceOfTheAnswersIsNamed) {
  XarmRig rig(Parameters{{"connect_timeout", "0.5"}});
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  rig.far().order("mute");
  ASSERT_TRUE(rig.fails(100'000'000, [](int) {}));
  EXPECT_EQ(rig.component.cause(), Cause::command_silent) << rig.component.reason();
  expect_standing(rig);
}

TEST(XarmWords, EveryCauseSaysWhatToDo) {
  expect_words_for_every_cause(Cause::jump, xarm::sentence, xarm::name, 35);
}

TEST(XarmWords, EveryErrorOfTheMakersListHasWordsOfItsOwn) {
  std::set<std::string> seen;
  for (const int code : {1,  2,  3,  10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 21, 22, 23, 24, 25, 26,  27, 28,
                         30, 31, 32, 33, 34, 35, 36, 37, 38, 39, 40, 41, 42, 50, 51, 52, 53, 60, 110, 111}) {
    const std::string words = xarm::error_words(code);
    EXPECT_TRUE(seen.insert(words).second) << code;
    EXPECT_NE(words.find(": "), std::string::npos) << "what to do: " << words;
    EXPECT_EQ(words.find("does not know"), std::string::npos) << code;
  }
  EXPECT_NE(xarm::error_words(99).find("look it up"), std::string::npos);
  for (int code = 0; code < 256; ++code) EXPECT_NE(xarm::cause_of_error(code), Cause::none);
  for (const int code : {11, 12, 13, 14, 15}) EXPECT_TRUE(seen.insert(xarm::warning_words(code)).second);
}

/// Faults drawn at random, in every state: always named, always standing, never a jump.
TEST(XarmFaults, DrawnAtRandomTheyAreAlwaysNamedAndNothingJumps) {
  constexpr const char* kOrders[] = {
      "e_stop",       "e_stop=2",       "error=31",     "error=22",   "error=23",       "error=15",
      "pause",        "stop",           "teach",        "mode=0",     "motors_off",     "refuse_servo",
      "nonsense",     "short_report",   "not_a_number", "bad_answer", "other_register", "close_command",
      "close_report", "locked_outputs", "twice",        "late=3",     "refuse_enable",  "other_axes=7",
      "warning",      "push=1"};
  XarmRig rig;
  expect_random_faults_end_well(
      rig, kOrders, {.joint = "joint6", .after = 90}, 60 * kDegree * 0.004 + kRounding, mend,
      [](Machine& m) { m.step(); }, 300);
}

}  // namespace
}  // namespace polyarm
