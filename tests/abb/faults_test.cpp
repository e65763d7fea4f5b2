/// Everything that can end a link, with the words for it: the robot stands afterwards, and nothing moves it
/// again.
#include <thread>

#include "tests/abb/rig.hpp"
#include "tests/support/wire_faults.hpp"

namespace polyarm {
namespace {

using test::AbbRig;
using namespace test;

/// What a person does at the controller. The motors stay off.
void mend(FarSide& far) {
  for (const char* order : {"release", "guard_closed", "restart", "auto", "healthy"}) far.order(order);
}

class WhileMoving : public testing::TestWithParam<FaultRow> {};
INSTANTIATE_TEST_SUITE_P(
    Faults, WhileMoving,
    testing::Values(FaultRow{"e_stop", Cause::emergency_stop, "release the button"},
                    FaultRow{"guard_open", Cause::guard_stop, "guard"},
                    FaultRow{"manual", Cause::manual_mode, "manual mode"},
                    FaultRow{"manual_full", Cause::manual_mode, "turn its key"},
                    FaultRow{"motors_off", Cause::motors_off, "switch them on"},
                    FaultRow{"stop", Cause::program_stopped, "was stopped there"},
                    FaultRow{"egm_stop", Cause::egm_stopped, "EGMStop"},
                    FaultRow{"egm_error", Cause::egm_error, "reports an error"},
                    FaultRow{"collision", Cause::collision, "look what the arm touched"},
                    FaultRow{"range", Cause::joint_range, "reached its limit"},
                    FaultRow{"singular", Cause::singularity, "singularity"},
                    FaultRow{"speed", Cause::speed, "too fast"}, FaultRow{"overload", Cause::load, "payload"},
                    FaultRow{"event=50063", Cause::event, "event 50063"},
                    FaultRow{"system_failure", Cause::system_failure, "restart it"},
                    FaultRow{"deaf", Cause::commands_late, "No data from the UdpUc device"},
                    FaultRow{"garbage", Cause::bad_data, "no packet of EGM"},
                    FaultRow{"again", Cause::restarted, "began anew"},
                    FaultRow{"power_off", Cause::rws_silent, "check cable and power"},
                    FaultRow{"nonsense", Cause::rws_bad_data, "no proxy"},
                    FaultRow{"busy", Cause::busy, "too many sessions"}),
    fault_name<Cause>);

TEST_P(WhileMoving, IsNamedStandsAndDoesNotJumpWhenItIsRecovered) {
  AbbRig rig(Parameters{{"connect_timeout", "20"}});
  // The program ends by itself where commands do not reach it; then the loop must not wait for the limits.
  expect_fault_while_moving(rig, GetParam(), {.joint = "joint_3", .after = 10}, mend);
}

class BeforeItMoves : public testing::TestWithParam<FaultRow> {};
INSTANTIATE_TEST_SUITE_P(
    Faults, BeforeItMoves,
    testing::Values(FaultRow{"login", Cause::login, "user or password"},
                    FaultRow{"forbidden", Cause::forbidden, "grants"},
                    FaultRow{"busy", Cause::busy, "too many sessions"},
                    FaultRow{"mastership", Cause::mastership, "mastership"},
                    FaultRow{"nonsense", Cause::rws_bad_data, "no answer of Robot Web Services"},
                    FaultRow{"no_option", Cause::no_option, "3124-1"},
                    FaultRow{"no_module", Cause::no_module, "polyarm setup abb"},
                    FaultRow{"old_software", Cause::old_software, "6.05"},
                    FaultRow{"refuse_start", Cause::start_refused, "does not start its program"},
                    FaultRow{"old_egm", Cause::old_egm, "6.07"}, FaultRow{"seven", Cause::axes, "7 joints"},
                    FaultRow{"egm_error", Cause::egm_error, "reports an error"},
                    FaultRow{"slow", Cause::wrong_rate, "125 Hz"},
                    FaultRow{"e_stop", Cause::emergency_stop, "emergency stop"},
                    FaultRow{"guard_open", Cause::guard_stop, "guard"},
                    FaultRow{"manual", Cause::manual_mode, "MANR"},
                    FaultRow{"system_failure", Cause::system_failure, "system failure"}),
    fault_name<Cause>);

TEST_P(BeforeItMoves, StartingIsRefusedInWordsAndWorksOnceItIsMended) {
  AbbRig rig(Parameters{{"connect_timeout", "20"}});
  expect_fault_before_motion(rig, GetParam(), mend);
}

/// These end by a time without an answer.
class InSilence : public testing::TestWithParam<FaultRow> {};
INSTANTIATE_TEST_SUITE_P(Faults, InSilence,
                         testing::Values(FaultRow{"silent", Cause::no_packets, "UDPUC Device"},
                                         FaultRow{"stranger", Cause::other_sender, "another sender"},
                                         FaultRow{"mute", Cause::rws_silent, "does not answer"}),
                         fault_name<Cause>);

TEST_P(InSilence, StartingIsRefusedInWords) {
  AbbRig rig(Parameters{{"connect_timeout", "0.3"}, {"start_timeout", "0.3"}});
  rig.far().with([](abb::Machine& m) { return m.options().rapid.comm_timeout = 1000; });
  rig.far().order(GetParam().order);
  ASSERT_FALSE(rig.start());
  // A machine that is too slow for the times of this test gives another one of the causes of silence.
  const bool slow = rig.component.cause() == Cause::rws_silent || rig.component.cause() == Cause::tls;
  if (!slow) {
    EXPECT_EQ(rig.component.cause(), GetParam().cause) << rig.component.reason();
  }
  EXPECT_NE(rig.component.reason().find("127.0.0.1"), std::string::npos) << rig.component.reason();
}

TEST(AbbFaults, MotorsThatAreOffAreSwitchedOnByActivatingOrNot) {
  expect_drives_are_switched_on<AbbRig>("motors_off", "refuse_motors", "motors_on", Cause::motors_off,
                                        Cause::motors_refused);
}

TEST(AbbFaults, ASignalThatIsMissingOrLockedIsNamed) {
  AbbRig rig;
  rig.far().with([](abb::Machine& m) { return m.options().signals.erase("diA"); });
  EXPECT_FALSE(rig.start());
  EXPECT_EQ(rig.component.cause(), Cause::no_signal);
  EXPECT_NE(rig.component.reason().find("'diA'"), std::string::npos) << rig.component.reason();
  rig.far().with([](abb::Machine& m) { return m.set_input("diA", false), 0; });
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  rig.far().order("locked_signals");
  rig.command("io/doA") = 1;
  ASSERT_TRUE(rig.fails(100, [](int) {}));
  EXPECT_EQ(rig.component.cause(), Cause::signal_refused) << rig.component.reason();
  expect_standing(rig);
}

TEST(AbbFaults, AClosedConnectionIsOpenedAgain) {
  AbbRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  for (int i = 0; i < 5; ++i) {
    rig.far().order("close_rws");
    ASSERT_TRUE(rig.runs(60, [](int) {}));
  }
  rig.far().order("e_stop");
  ASSERT_TRUE(rig.fails(400, [](int) {}));
  EXPECT_EQ(rig.component.cause(), Cause::emergency_stop) << rig.component.reason();
}

TEST(AbbFaults, ARefusedActivationLeavesTheComponentReading) {
  AbbRig rig;
  expect_refused_activation_keeps_reading(rig, "manual", "auto");
}

TEST(AbbFaults, AJumpOfTheCommandsIsNotSent) {
  AbbRig rig;
  expect_no_jump_is_sent(rig, "joint_5", Cause::jump);
}

TEST(AbbFaults, AFirstCommandAwayFromTheMeasuredPositionIsNotSent) {
  AbbRig rig;
  expect_no_far_begin_is_sent(rig, "joint_2", Cause::jump);
}

TEST(AbbFaults, TheControllerStopsTheRobotWhenCommandsEnd) {
  AbbRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  const double from = rig.command("joint_1/position");
  ASSERT_TRUE(rig.runs(120, [&](int i) { rig.command("joint_1/position") = from + travel(i, 0.0015); }));
  rig.far().order("deaf");  // as if the process were killed: no command arrives any more
  for (int i = 0; i < 300; ++i) rig.far().step();
  const Six at = rig.q();
  EXPECT_FALSE(rig.far().with([](abb::Machine& m) { return m.program_runs(); })) << "its watchdog ended it";
  for (int i = 0; i < 60; ++i) rig.far().step();
  EXPECT_NEAR(rig.q()[0], at[0], 1e-6);
}

TEST(AbbFaults, ALoopThatFallsSilentIsBrakedByTheDriver) {
  AbbRig rig(Parameters{{"loop_silence_ms", "300"}});  // the controller's clock stands still
  expect_silent_loop_is_braked(rig, Cause::loop_silent);
}

/// The loop asks for nothing beyond the limits; what it has to make up for was lost while it was late.
TEST(AbbFaults, ALateLoopIsNotCalledTooFast) {
  AbbRig rig(Parameters{{"max_behind", "0.001"}});
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  const double from = rig.command("joint_1/position");
  int n = 0;
  const auto move = [&](int) { rig.command("joint_1/position") = from + travel(++n, 0.0015); };
  ASSERT_TRUE(rig.runs(120, move));
  ASSERT_TRUE(rig.far().step(60'000'000'000));
  const std::uint64_t answered = rig.far().messages();
  for (unsigned i = 1; i <= 15; ++i) {  // packets without a command of the loop
    move(0);
    rig.far().step();
    while (rig.far().messages() < answered + i) std::this_thread::yield();
  }
  ASSERT_EQ(rig.component.AbbComponent::read(rig.cycle, rig.states), ReturnType::ok);
  rig.component.write(rig.cycle, rig.commands);
  ASSERT_TRUE(rig.fails(50, move));
  EXPECT_EQ(rig.component.cause(), Cause::loop_silent) << rig.component.reason();
  EXPECT_NE(rig.component.reason().find("delays the loop"), std::string::npos) << rig.component.reason();
  EXPECT_LE(rig.largest_jump(), 60 * kDegree * 0.004 + 1e-9);
}

/// The loop ends at a fault without a command for the newest packet: the driver answers it itself. A packet
/// that nobody could read is not waited for.
TEST(AbbFaults, AFaultLeavesNoPacketWithoutItsAnswer) {
  for (const char* order : {"garbage", "login", "nonsense"}) {
    AbbRig rig(Parameters{{"connect_timeout", "20"}});
    ASSERT_TRUE(rig.start()) << rig.component.reason();
    ASSERT_TRUE(rig.runs(5, [](int) {}));
    rig.far().order(order);
    bool failed = false;
    for (int i = 0; i < 3000 && !failed; ++i) {
      failed = rig.read() != ReturnType::ok || rig.component.write(rig.cycle, rig.commands) != ReturnType::ok;
    }
    ASSERT_TRUE(failed) << order;
    EXPECT_TRUE(rig.far().step(60'000'000'000)) << order << ": the last packet has an answer";
  }
}

TEST(AbbFaults, AControllerThatIsNotThereIsNamed) {
  expect_unreachable<abb::AbbComponent>(
      abb_context({{"host", "127.0.0.1"}, {"rws_port", std::to_string(closed_port())}}), Cause::unreachable,
      "");
}

TEST(AbbFaults, CommandsOfAStrangerAreNotTaken) {
  FarSideOptions options = far_options();
  FarSide far(options);
  std::string why;
  const Descriptor owner = wire::bind_udp("127.0.0.1", 0, why),
                   stranger = wire::bind_udp("127.0.0.1", 0, why);
  far.send_egm_to("127.0.0.1", wire::local_port(owner.number()));
  far.with([](abb::Machine& m) { return m.start_program(); });
  std::array<std::uint8_t, 2048> bytes;
  wire::UdpAddress from;
  ASSERT_TRUE(wire::wait_readable(owner.number(), 60'000'000'000));
  ASSERT_EQ(wire::receive_datagram(owner.number(), bytes, &from).got, wire::Got::bytes);
  abb::EgmSensor message;
  message.planned.emplace().joints.emplace().count = 6;
  for (int i = 0; i < 50; ++i) wire::send_datagram(stranger.number(), abb::encode(message), from);
  const std::uint64_t sent = far.packets();
  while (far.packets() < sent + 5) std::this_thread::yield();
  EXPECT_EQ(far.messages(), 0u);
}

TEST(AbbFaults, TheFirstPacketIsWaitedForToo) {
  FarSide far(far_options());
  far.hold_clock(true);
  std::string why;
  const Descriptor owner = wire::bind_udp("127.0.0.1", 0, why);
  far.send_egm_to("127.0.0.1", wire::local_port(owner.number()));
  far.with([](abb::Machine& m) { return m.start_program(); });
  ASSERT_TRUE(far.step(1'000'000)) << "nothing was sent before";
  EXPECT_FALSE(far.step(1'000'000));
}

/// Faults drawn at random, in every state: always named, always standing, never a jump.
TEST(AbbFaults, DrawnAtRandomTheyAreAlwaysNamedAndNothingJumps) {
  constexpr const char* kOrders[] = {
      "e_stop",         "guard_open", "manual",     "motors_off",  "stop",      "egm_stop",
      "egm_error",      "collision",  "range",      "singular",    "overload",  "event=50063",
      "system_failure", "garbage",    "again",      "power_off",   "nonsense",  "busy",
      "login",          "forbidden",  "mastership", "close_rws",   "no_module", "refuse_start",
      "old_egm",        "seven",      "slow",       "duplicate=3", "reorder=2", "late=3"};
  AbbRig rig(Parameters{{"connect_timeout", "20"}, {"start_timeout", "20"}, {"rws", "1"}});
  expect_random_faults_end_well(rig, kOrders, {.joint = "joint_6", .after = 60}, 60 * kDegree * 0.004 + 1e-9,
                                mend, [](abb::Machine& m) { m.step(0.004); });
}

}  // namespace
}  // namespace polyarm
