/// Everything that can end a link, with the words for it: the robot stands afterwards, and nothing moves it
/// again.
#include <set>

#include "tests/support/wire_faults.hpp"
#include "tests/yaskawa/rig.hpp"

namespace polyarm {
namespace {

using test::YaskawaRig;
using namespace test;
using yaskawa::Machine;

/// What a person does at the controller. The servos stay off.
void mend(FarSide& far) {
  for (const char* order : {"release", "reset", "unhold", "let_go", "remote", "healthy"}) far.order(order);
}

class WhileMoving : public testing::TestWithParam<FaultRow> {};
INSTANTIATE_TEST_SUITE_P(Faults, WhileMoving,
                         testing::Values(FaultRow{"e_stop", Cause::emergency_stop, "release the button"},
                                         FaultRow{"teach", Cause::teach_mode, "key of the pendant to REMOTE"},
                                         FaultRow{"play", Cause::not_remote, "without remote"},
                                         FaultRow{"servo_off", Cause::servo_off, "servos"},
                                         FaultRow{"hold=1", Cause::hold, "by the button of the pendant"},
                                         FaultRow{"hold=2", Cause::hold, "by a signal from outside"},
                                         FaultRow{"hold=3", Cause::hold, "by a command"},
                                         FaultRow{"stop_job", Cause::not_started, "INIT_ROS"},
                                         FaultRow{"alarm=4321", Cause::alarm, "alarm 4321 (OUT OF RANGE"},
                                         FaultRow{"error", Cause::error, "cancel it at the pendant"},
                                         FaultRow{"touch", Cause::pfl, "touched or pushed"},
                                         FaultRow{"refuse_step", Cause::increment_refused, "refused a step"},
                                         FaultRow{"refuse_speed", Cause::speed_refused, "lower `max_speed`"},
                                         FaultRow{"busy=100000", Cause::points_stuck, "takes no points"},
                                         FaultRow{"nonsense", Cause::bad_data, "no message of MotoROS"},
                                         FaultRow{"bad_answer", Cause::bad_data, "no message of MotoROS"},
                                         FaultRow{"close_motion", Cause::closed, "closed a connection"},
                                         FaultRow{"close_state", Cause::closed, "closed a connection"},
                                         FaultRow{"close_io", Cause::closed, "closed a connection"},
                                         FaultRow{"hses_nonsense", Cause::hses_bad_data,
                                                  "no answer of its Ethernet server"},
                                         FaultRow{"hses_refuse", Cause::hses_refused, "status A000"},
                                         FaultRow{"power_off", Cause::closed, "switched off"}),
                         fault_name<Cause>);

TEST_P(WhileMoving, IsNamedStandsAndDoesNotJumpWhenItIsRecovered) {
  YaskawaRig rig;
  expect_fault_while_moving(rig, GetParam(), {.joint = "joint_3", .after = 60, .patience = 1000}, mend);
}

class BeforeItMoves : public testing::TestWithParam<FaultRow> {};
INSTANTIATE_TEST_SUITE_P(Faults, BeforeItMoves,
                         testing::Values(FaultRow{"other_client", Cause::other_client,
                                                  "another client moves the robot"},
                                         FaultRow{"other_group", Cause::no_group, "control group 0"},
                                         FaultRow{"nonsense", Cause::bad_data, "check the ports"},
                                         FaultRow{"hses_nonsense", Cause::hses_bad_data, "hses_port"},
                                         FaultRow{"hses_refuse", Cause::hses_refused, "refused"},
                                         FaultRow{"e_stop", Cause::emergency_stop, "emergency stop"},
                                         FaultRow{"teach", Cause::teach_mode, "teach mode"},
                                         FaultRow{"play", Cause::not_remote, "REMOTE"},
                                         FaultRow{"hold=2", Cause::hold, "release it"},
                                         FaultRow{"alarm", Cause::alarm, "alarm 4107"},
                                         FaultRow{"error", Cause::error, "cancel it"},
                                         FaultRow{"power_off", Cause::hses_silent, "10040"}),
                         fault_name<Cause>);

TEST_P(BeforeItMoves, StartingIsRefusedInWordsAndWorksOnceItIsMended) {
  const bool silent = std::string(GetParam().order) == "power_off";
  YaskawaRig rig(silent ? Parameters{{"connect_timeout", "0.3"}} : Parameters{});
  expect_fault_before_motion(rig, GetParam(), mend, !silent);
}

/// These end by a time without an answer.
class InSilence : public testing::TestWithParam<FaultRow> {};
INSTANTIATE_TEST_SUITE_P(Faults, InSilence,
                         testing::Values(FaultRow{"silent", Cause::state_silent, "sends no states"},
                                         FaultRow{"mute", Cause::moto_silent, "does not answer"},
                                         FaultRow{"hses_mute", Cause::hses_silent, "10040"},
                                         FaultRow{"io_mute", Cause::moto_silent, "does not answer"},
                                         FaultRow{"stuck_job", Cause::waiting_ros, "output 889"},
                                         FaultRow{"other_moves", Cause::moves, "moves though nothing"}),
                         fault_name<Cause>);

TEST_P(InSilence, StartingIsRefusedInWords) {
  YaskawaRig rig(Parameters{{"connect_timeout", "0.5"}, {"start_timeout", "8"}});
  rig.far().order(GetParam().order);
  ASSERT_FALSE(rig.start());
  // A machine that is too slow for the times of this test gives another one of the causes of silence.
  const bool slow =
      rig.component.cause() == Cause::moto_silent || rig.component.cause() == Cause::hses_silent;
  if (!slow || GetParam().cause == Cause::moto_silent) {
    EXPECT_EQ(rig.component.cause(), GetParam().cause) << rig.component.reason();
    EXPECT_NE(rig.component.reason().find(GetParam().words), std::string::npos) << rig.component.reason();
  }
  EXPECT_NE(rig.component.reason().find("127.0.0.1"), std::string::npos) << rig.component.reason();
}

TEST(YaskawaFaults, ServosThatAreOffAreSwitchedOnByActivatingOrNot) {
  expect_drives_are_switched_on<YaskawaRig>("servo_off", "refuse_servo", "servo_on", Cause::servo_off,
                                            Cause::servo_refused);
}

/// MotoROS would reset an alarm by itself when its job starts.
TEST(YaskawaFaults, AnAlarmIsNotResetByActivating) {
  YaskawaRig rig;
  ASSERT_TRUE(rig.configure()) << rig.component.reason();
  rig.far().order("alarm");
  EXPECT_FALSE(rig.activate());
  EXPECT_EQ(rig.far().with([](Machine& m) { return m.alarm().code; }), 4107u);
}

TEST(YaskawaFaults, ARefusedActivationLeavesTheComponentReading) {
  YaskawaRig rig;
  expect_refused_activation_keeps_reading(rig, "play", "remote");
}

TEST(YaskawaFaults, AControllerThatIsNotThereIsNamed) {
  expect_unreachable<yaskawa::YaskawaComponent>(
      yaskawa_context(
          {{"host", "127.0.0.1"}, {"hses", "false"}, {"state_port", std::to_string(closed_port())}}),
      Cause::unreachable, "MotoROS must be loaded");
}

/// MotoROS has one connection for motion; while the robot stands, a new client takes it.
TEST(YaskawaFaults, ANewClientTakesTheConnectionWhileTheRobotStands) {
  Alone first;
  ASSERT_TRUE(first.configure()) << first.component.reason();
  yaskawa::YaskawaComponent second;
  second.on_init(yaskawa_context({{"host", "127.0.0.1"},
                                  {"motion_port", std::to_string(first.far.motion_port())},
                                  {"state_port", std::to_string(first.far.state_port())},
                                  {"hses_port", std::to_string(first.far.hses_port())},
                                  {"silence_ms", "10000"},
                                  {"connect_timeout", "60"}}));
  EXPECT_EQ(second.on_configure(), CallbackReturn::success) << second.reason();
  EXPECT_EQ(first.component.on_activate(), CallbackReturn::failure);
  EXPECT_EQ(first.component.cause(), Cause::closed) << first.component.reason();
  second.on_shutdown();
}

TEST(YaskawaFaults, AnOutputThatCannotBeSwitchedIsNamed) {
  YaskawaRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  rig.far().order("locked_outputs");
  rig.command("io/digital_out_2") = 1;
  ASSERT_TRUE(rig.fails(100, [](int) {}));
  EXPECT_EQ(rig.component.cause(), Cause::signal_refused) << rig.component.reason();
  EXPECT_NE(rig.component.reason().find("signal 10011"), std::string::npos) << rig.component.reason();
  expect_standing(rig);
}

TEST(YaskawaFaults, AJumpOfTheCommandsIsNotSent) {
  YaskawaRig rig;
  expect_no_jump_is_sent(rig, "joint_5", Cause::jump, 60);
}

TEST(YaskawaFaults, AFirstCommandAwayFromTheMeasuredPositionIsNotSent) {
  YaskawaRig rig;
  expect_no_far_begin_is_sent(rig, "joint_2", Cause::jump);
}

/// Between reading the position and the first point, somebody moves the robot.
TEST(YaskawaFaults, AStartAwayFromTheFirstPointIsRefusedByTheController) {
  YaskawaRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  rig.far().with([](Machine& m) { return m.push_by_hand({5, 0, 0, 0, 0, 0}), 0; });
  // The driver has not seen it yet: its state comes with the next cycle.
  ASSERT_EQ(rig.component.write(rig.cycle, rig.commands), ReturnType::ok);
  ASSERT_TRUE(rig.fails(60, [](int) {}));
  EXPECT_EQ(rig.component.cause(), Cause::start_position) << rig.component.reason();
  expect_standing(rig);
}

/// The cable is pulled: what the controller's buffer holds is the rest of the motion.
TEST(YaskawaFaults, TheRobotStandsWhenItsBufferIsEmpty) {
  YaskawaRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  const double from = rig.command("joint_1/position");
  ASSERT_TRUE(rig.runs(120, [&](int i) { rig.command("joint_1/position") = from + travel(i, 0.0015); }));
  const Six before = rig.q();
  for (int i = 0; i < 60; ++i) rig.read();  // a cycle of the controller each, without a command
  const Six at = rig.q();
  EXPECT_GT(at[0], before[0]);
  EXPECT_LT(at[0] - before[0], 0.0015 * 45) << "no further than `lead_ms`";
  for (int i = 0; i < 60; ++i) rig.read();
  EXPECT_EQ(rig.q(), at);
}

/// As if the process were killed: its connections close.
TEST(YaskawaFaults, WhenTheConnectionClosesTheControllerStopsTheRobot) {
  YaskawaRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  const double from = rig.command("joint_1/position");
  ASSERT_TRUE(rig.runs(120, [&](int i) { rig.command("joint_1/position") = from + travel(i, 0.0015); }));
  rig.far().order("close_motion");
  rig.far().step();
  EXPECT_EQ(rig.far().with([](Machine& m) { return m.queued(); }), 0);
  for (int i = 0; i < 20; ++i) rig.far().step();
  const Six at = rig.q();
  for (int i = 0; i < 60; ++i) rig.far().step();
  EXPECT_EQ(rig.q(), at);
}

TEST(YaskawaFaults, ALoopThatFallsSilentIsBrakedByTheDriver) {
  YaskawaRig rig(Parameters{{"loop_silence_ms", "300"}});  // the controller's clock stands still
  expect_silent_loop_is_braked(rig, Cause::loop_silent);
}

TEST(YaskawaFaults, SilenceOfTheControllerIsNamed) {
  YaskawaRig rig(Parameters{{"silence_ms", "200"}});
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  rig.far().order("silent");
  ASSERT_TRUE(rig.fails(100'000'000, [](int) {}));
  EXPECT_EQ(rig.component.cause(), Cause::state_silent) << rig.component.reason();
  expect_standing(rig);
}

/// The loop is slower than the controller's clock, until the buffer is empty while the robot moves.
TEST(YaskawaFaults, PointsThatComeTooLateAreNamed) {
  Alone alone(far_options(), {{"lead_ms", "40"}});
  ASSERT_TRUE(alone.start()) << alone.component.reason();
  std::vector<double> states(alone.component.state_interfaces().size()),
      commands(alone.component.command_interfaces().size(), std::nan(""));
  hardware::Cycle cycle{0, 4'000'000, 0};
  alone.far.hold_clock(true);
  alone.component.read(cycle, states);
  for (std::size_t j = 0; j < 6; ++j) commands[j] = states[3 * j];
  const double from = commands[0];
  for (int i = 0; i < 20'000 && alone.component.cause() == Cause::none; ++i) {
    alone.step(i);
    alone.far.step();  // twice as fast as the loop
    commands[0] = from + 0.3 * std::sin(i * 0.004);
    alone.component.read(cycle, states);
    alone.component.write(cycle, commands);
  }
  EXPECT_EQ(alone.component.cause(), Cause::points_late) << alone.component.reason();
  EXPECT_NE(alone.component.reason().find("lead_ms"), std::string::npos) << alone.component.reason();
  alone.far.hold_clock(false);
}

/// The controller's clock is slower than the loop's by 1 %: the buffer stays at its measure.
TEST(YaskawaFaults, ClocksThatDifferLeaveTheBufferAsItIs) {
  YaskawaRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  const double from = rig.command("joint_1/position");
  double most = 0;
  int n = 0;
  for (int i = 0; i < 6000; ++i) {
    rig.command("joint_1/position") = from + 0.2 * std::sin(0.002 * n) * smooth(n / 500.0);
    ++n;
    if (i % 100 == 99) {
      ASSERT_EQ(rig.component.write(rig.cycle, rig.commands), ReturnType::ok);  // without a cycle there
      continue;
    }
    ASSERT_EQ(rig.cycle_once(), ReturnType::ok) << i << " " << rig.component.reason();
    if (i > 500) most = std::max(most, rig.state("controller/buffered"));
  }
  EXPECT_LT(most, 0.2) << "60 cycles of drift are 240 ms";
}

TEST(YaskawaWords, EveryCauseSaysWhatToDo) {
  expect_words_for_every_cause(Cause::joint_commands, yaskawa::sentence, yaskawa::name, 46);
}

TEST(YaskawaWords, EverySubcodeOfMotoRosHasACause) {
  std::set<Cause> causes;
  for (int subcode = 5001; subcode <= 5012; ++subcode)
    EXPECT_TRUE(causes.insert(yaskawa::why_not(5, subcode).cause).second) << subcode;
  EXPECT_FALSE(causes.contains(Cause::not_ready));
  EXPECT_EQ(yaskawa::why_not(5, 5000).cause, Cause::not_ready);
  EXPECT_EQ(yaskawa::why_not(5, 5099).detail, 5099);
  EXPECT_EQ(yaskawa::why_not(3, 3011).cause, Cause::start_position);
  EXPECT_EQ(yaskawa::why_not(3, 3013).cause, Cause::speed_refused);
  for (const int subcode : {3000, 3001, 3002, 3003, 3004, 3005, 3006, 3010, 3012, 3014, 3015, 3016, 3017})
    EXPECT_EQ(yaskawa::why_not(3, subcode).detail, subcode);
  EXPECT_EQ(yaskawa::why_not(2, 0).cause, Cause::moto_failed);
  EXPECT_EQ(yaskawa::why_not(6, 0).detail, 6);
}

/// Faults drawn at random, in every state: always named, always standing, never a jump.
TEST(YaskawaFaults, DrawnAtRandomTheyAreAlwaysNamedAndNothingJumps) {
  constexpr const char* kOrders[] = {"e_stop",      "teach",          "play",          "servo_off",
                                     "hold",        "hold=2",         "stop_job",      "alarm",
                                     "error",       "touch",          "refuse_step",   "refuse_speed",
                                     "busy=5",      "busy=100000",    "nonsense",      "bad_answer",
                                     "other_group", "other_client",   "close_motion",  "close_state",
                                     "close_io",    "locked_outputs", "hses_nonsense", "hses_refuse",
                                     "hses_twice",  "late=3",         "refuse_servo",  "push"};
  YaskawaRig rig;
  expect_random_faults_end_well(
      rig, kOrders, {.joint = "joint_6", .after = 90}, 60 * kDegree * 0.004 + kPulse, mend,
      [](Machine& m) { m.step(); }, 300);
}

}  // namespace
}  // namespace polyarm
