/// Everything that can end a link, with the words for it: the robot stands afterwards, and nothing moves it
/// again.
#include <set>
#include <thread>

#include "tests/kuka/rig.hpp"
#include "tests/support/wire_faults.hpp"

namespace polyarm {
namespace {

using test::KukaRig;
using namespace test;

class WhileMoving : public testing::TestWithParam<FaultRow> {};
INSTANTIATE_TEST_SUITE_P(Faults, WhileMoving,
                         testing::Values(FaultRow{"e_stop", Cause::emergency_stop, "release the button"},
                                         FaultRow{"guard_open", Cause::guard_stop, "guard"},
                                         FaultRow{"t1", Cause::manual_mode, "mode T1"},
                                         FaultRow{"t2", Cause::manual_mode, "mode T2"},
                                         FaultRow{"aut", Cause::drives_off, "drives"},
                                         FaultRow{"drives_off", Cause::drives_off, "switch them on"},
                                         FaultRow{"stop", Cause::program_stopped, "was stopped there"},
                                         FaultRow{"cancel", Cause::program_ended, "deselected"},
                                         FaultRow{"rsi_off", Cause::rsi_ended, "RSI_OFF"},
                                         FaultRow{"collision", Cause::message, "read it at its smartPAD"},
                                         FaultRow{"small_limit", Cause::message, "a limit of RSI"},
                                         FaultRow{"deaf", Cause::late_answers, "answers in a row too late"},
                                         FaultRow{"garbage", Cause::bad_data, "no datagram of RSI"},
                                         FaultRow{"again", Cause::restarted, "went back"},
                                         FaultRow{"nonsense", Cause::eki_bad_data,
                                                  "no message of PolyarmEki"},
                                         FaultRow{"close_eki", Cause::eki_closed, "closed the connection"},
                                         FaultRow{"power_off", Cause::eki_closed, "switched off"}),
                         fault_name<Cause>);

TEST_P(WhileMoving, IsNamedStandsAndDoesNotJumpWhenItIsRecovered) {
  KukaRig rig;
  // RSI ends by itself where answers do not reach it; then the loop must not wait for the limits.
  expect_fault_while_moving(rig, GetParam(), {.joint = "joint_3"}, mend);
}

class BeforeItMoves : public testing::TestWithParam<FaultRow> {};
INSTANTIATE_TEST_SUITE_P(
    Faults, BeforeItMoves,
    testing::Values(FaultRow{"busy", Cause::eki_busy, "takes one client"},
                    FaultRow{"nonsense", Cause::eki_bad_data, "another program may listen"},
                    FaultRow{"other_program", Cause::program_version, "version 3 of PolyarmEki"},
                    FaultRow{"old_rsi", Cause::old_rsi, "RSI 2"}, FaultRow{"seven", Cause::axes, "7 axes"},
                    FaultRow{"slow", Cause::wrong_rate, "83 Hz"},
                    FaultRow{"e_stop", Cause::emergency_stop, "emergency stop"},
                    FaultRow{"guard_open", Cause::guard_stop, "guard"},
                    FaultRow{"t1", Cause::manual_mode, "choose EXT"},
                    FaultRow{"collision", Cause::message, "acknowledge it"},
                    FaultRow{"refuse_start", Cause::start_refused, "another program is selected"},
                    FaultRow{"rsi_error=7", Cause::rsi_refused, "returned 7"}),
    fault_name<Cause>);

TEST_P(BeforeItMoves, StartingIsRefusedInWordsAndWorksOnceItIsMended) {
  KukaRig rig;
  expect_fault_before_motion(rig, GetParam(), mend);
}

/// These end by a time without an answer.
class InSilence : public testing::TestWithParam<FaultRow> {};
INSTANTIATE_TEST_SUITE_P(Faults, InSilence,
                         testing::Values(FaultRow{"silent", Cause::no_packets, "IP_NUMBER"},
                                         FaultRow{"stranger", Cause::other_sender, "127.0.0.2"},
                                         FaultRow{"mute", Cause::eki_silent, "does not answer"}),
                         fault_name<Cause>);

TEST_P(InSilence, StartingIsRefusedInWords) {
  KukaRig rig(Parameters{{"connect_timeout", "0.5"}, {"start_timeout", "0.5"}});
  rig.far().with([](kuka::Machine& m) { return m.options().identity.late_limit = 100'000; });
  rig.far().order(GetParam().order);
  ASSERT_FALSE(rig.start());
  // A machine that is too slow for the times of this test gives another one of the causes of silence.
  if (rig.component.cause() != Cause::eki_silent) {
    EXPECT_EQ(rig.component.cause(), GetParam().cause) << rig.component.reason();
    EXPECT_NE(rig.component.reason().find(GetParam().words), std::string::npos) << rig.component.reason();
  }
  EXPECT_NE(rig.component.reason().find("127.0.0.1"), std::string::npos) << rig.component.reason();
}

TEST(KukaFaults, DrivesThatAreOffAreSwitchedOnByActivatingOrNot) {
  expect_drives_are_switched_on<KukaRig>("drives_off", "refuse_drives", "drives_on", Cause::drives_off,
                                         Cause::drives_refused);
}

TEST(KukaFaults, ARefusedActivationLeavesTheComponentReading) {
  KukaRig rig;
  expect_refused_activation_keeps_reading(rig, "t2", "ext");
}

TEST(KukaFaults, AControllerThatIsNotThereIsNamed) {
  expect_unreachable<kuka::KukaComponent>(
      kuka_context({{"host", "127.0.0.1"}, {"eki_port", std::to_string(closed_port())}}), Cause::unreachable,
      "");
}

TEST(KukaFaults, ASecondClientIsNamed) {
  Alone first;
  ASSERT_TRUE(first.configure()) << first.component.reason();
  kuka::KukaComponent second;
  second.on_init(kuka_context({{"host", "127.0.0.1"},
                               {"eki_port", std::to_string(first.far.eki_port())},
                               {"rsi_port", "0"},
                               {"connect_timeout", "60"}}));
  EXPECT_EQ(second.on_configure(), CallbackReturn::failure);
  EXPECT_EQ(second.cause(), Cause::eki_busy) << second.reason();
}

TEST(KukaFaults, APortThatIsTakenIsNamed) {
  std::string why;
  const Descriptor taken = wire::bind_udp("127.0.0.1", 0, why);
  Alone alone(far_options(), {{"rsi_port", std::to_string(wire::local_port(taken.number()))}});
  EXPECT_EQ(alone.component.on_configure(), CallbackReturn::failure);
  EXPECT_EQ(alone.component.cause(), Cause::port_taken) << alone.component.reason();
}

TEST(KukaFaults, AnOutputThatCannotBeSwitchedIsNamed) {
  KukaRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  rig.far().order("locked_outputs");
  rig.command("io/digital_out_2") = 1;
  ASSERT_TRUE(rig.fails(100, [](int) {}));
  EXPECT_EQ(rig.component.cause(), Cause::output_refused) << rig.component.reason();
  EXPECT_NE(rig.component.reason().find("output 2"), std::string::npos) << rig.component.reason();
  expect_standing(rig);
}

TEST(KukaFaults, AJumpOfTheCommandsIsNotSent) {
  KukaRig rig;
  expect_no_jump_is_sent(rig, "joint_5", Cause::jump);
}

TEST(KukaFaults, AFirstCommandAwayFromTheMeasuredPositionIsNotSent) {
  KukaRig rig;
  expect_no_far_begin_is_sent(rig, "joint_2", Cause::jump);
}

TEST(KukaFaults, WhatRsiWouldEndForIsNotSent) {
  KukaRig rig(Parameters{{"max_correction", "10"}});
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  const double from = rig.command("joint_1/position");
  ASSERT_TRUE(rig.fails(2000, [&](int i) { rig.command("joint_1/position") = from + travel(i, 0.0015); }));
  EXPECT_EQ(rig.component.cause(), Cause::correction_limit) << rig.component.reason();
  EXPECT_NE(rig.component.reason().find("axis A1"), std::string::npos) << rig.component.reason();
  EXPECT_FALSE(rig.far().with([](kuka::Machine& m) { return m.reply().state.message; }));
  // A new start begins where the robot stands.
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  const double next = rig.command("joint_1/position");
  EXPECT_TRUE(rig.runs(50, [&](int i) { rig.command("joint_1/position") = next + travel(i, 0.0015); }));
}

TEST(KukaFaults, ASoftwareLimitOfTheControllerIsNamed) {
  KukaRig rig;
  rig.far().with([](kuka::Machine& m) { return m.options().identity.upper[0] = 25; });
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  const double from = rig.command("joint_1/position");  // 17 degrees
  ASSERT_TRUE(rig.fails(2000, [&](int i) { rig.command("joint_1/position") = from + travel(i, 0.0015); }));
  EXPECT_EQ(rig.component.cause(), Cause::soft_limit) << rig.component.reason();
  expect_standing(rig);
}

TEST(KukaFaults, TheControllerStopsTheRobotWhenAnswersEnd) {
  KukaRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  const double from = rig.command("joint_1/position");
  ASSERT_TRUE(rig.runs(120, [&](int i) { rig.command("joint_1/position") = from + travel(i, 0.0015); }));
  rig.far().order("deaf");  // as if the process were killed: no answer arrives any more
  for (int i = 0; i < 100; ++i) rig.far().step();
  const Six at = rig.q();
  EXPECT_FALSE(rig.far().with([](kuka::Machine& m) { return m.rsi(); })) << "its own limit ended it";
  for (int i = 0; i < 60; ++i) rig.far().step();
  EXPECT_NEAR(rig.q()[0], at[0], 1e-6);
}

TEST(KukaFaults, ALoopThatFallsSilentIsBrakedByTheDriver) {
  KukaRig rig(Parameters{{"loop_silence_ms", "300"}});  // the controller's clock stands still
  expect_silent_loop_is_braked(rig, Cause::loop_silent);
}

TEST(KukaFaults, SilenceOfTheControllerIsNamed) {
  KukaRig rig(Parameters{{"silence_ms", "50"}});
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  rig.far().order("silent");
  ASSERT_TRUE(rig.fails(100'000'000, [](int) {}));
  // The controller gets no answers in this silence either, and ends RSI after its limit.
  EXPECT_TRUE(rig.component.cause() == Cause::silent || rig.component.cause() == Cause::message)
      << rig.component.reason();
  expect_standing(rig);
}

/// With relative corrections, an answer that was lost leaves the robot elsewhere.
TEST(KukaFaults, WithRelativeCorrectionsALateAnswerEndsTheMotion) {
  KukaRig rig(Parameters{{"relative", "true"}});
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  const double from = rig.command("joint_1/position");
  ASSERT_TRUE(rig.runs(300, [&](int i) { rig.command("joint_1/position") = from + travel(i, 0.0015); }));
  EXPECT_NEAR(rig.q()[0], rig.command("joint_1/position"), 0.01) << "steps add up";
  rig.far().order("deaf");
  ASSERT_TRUE(rig.fails(20, [](int) {}));
  EXPECT_EQ(rig.component.cause(), Cause::relative_late) << rig.component.reason();
}

/// The loop ends at a fault without a command for the newest packet: the driver answers it itself.
TEST(KukaFaults, AFaultLeavesNoPacketWithoutItsAnswer) {
  for (const char* order : {"garbage", "nonsense", "close_eki"}) {
    KukaRig rig;
    ASSERT_TRUE(rig.start()) << rig.component.reason();
    ASSERT_TRUE(rig.runs(5, [](int) {}));
    rig.far().order(order);
    bool failed = false;
    for (int i = 0; i < 3000 && !failed; ++i)
      failed = rig.read() != ReturnType::ok || rig.component.write(rig.cycle, rig.commands) != ReturnType::ok;
    ASSERT_TRUE(failed) << order;
    EXPECT_TRUE(rig.far().step(60'000'000'000)) << order << ": the last packet has an answer";
  }
}

TEST(KukaFaults, AnswersOfAStrangerAreNotTaken) {
  FarSideOptions options = far_options();
  options.machine.identity.late_limit = 100'000;
  FarSide far(options);
  std::string why;
  const Descriptor owner = wire::bind_udp("127.0.0.1", 0, why),
                   stranger = wire::bind_udp("127.0.0.1", 0, why);
  far.send_rsi_to("127.0.0.1", wire::local_port(owner.number()));
  far.with([](kuka::Machine& m) { return m.start(); });
  std::array<std::uint8_t, 2048> bytes;
  wire::UdpAddress from;
  ASSERT_TRUE(wire::wait_readable(owner.number(), 60'000'000'000));
  ASSERT_EQ(wire::receive_datagram(owner.number(), bytes, &from).got, wire::Got::bytes);
  const std::string text = kuka::encode(kuka::RsiSensor{1, {1, 1, 1, 1, 1, 1}, false});
  const std::span<const std::uint8_t> answer(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
  for (int i = 0; i < 50; ++i) wire::send_datagram(stranger.number(), answer, from);
  const std::uint64_t sent = far.packets();
  while (far.packets() < sent + 5) std::this_thread::yield();
  EXPECT_EQ(far.answers(), 0u);
}

TEST(KukaFaults, TheFirstPacketIsWaitedForToo) {
  FarSide far(far_options());
  far.hold_clock(true);
  std::string why;
  const Descriptor owner = wire::bind_udp("127.0.0.1", 0, why);
  far.send_rsi_to("127.0.0.1", wire::local_port(owner.number()));
  ASSERT_EQ(far.with([](kuka::Machine& m) { return m.start(); }), kuka::EkiResult::done);
  while (far.packets() == 0) ASSERT_TRUE(far.step(1'000'000)) << "nothing was sent before";
  EXPECT_FALSE(far.step(1'000'000));
}

/// An answer with another IPOC than that of the newest packet is late, and moves nothing.
TEST(KukaFaults, AnAnswerWithAnotherClockIsLate) {
  kuka::Machine machine(far_options().machine);
  ASSERT_EQ(machine.start(), kuka::EkiResult::done);
  while (!machine.rsi()) machine.step();
  const Six before = machine.q();
  for (int i = 1; i < machine.options().identity.late_limit; ++i) {
    machine.take({machine.ipoc() + (i % 2 ? 4 : -4), {1, 1, 1, 1, 1, 1}, false});
    machine.step();
    ASSERT_TRUE(machine.rsi()) << i;
    ASSERT_EQ(machine.packet().delay, i);
  }
  machine.step();
  EXPECT_FALSE(machine.rsi());
  EXPECT_EQ(machine.q(), before);
}

TEST(KukaWords, EveryCauseSaysWhatToDo) {
  expect_words_for_every_cause(Cause::halt_unconfirmed, kuka::sentence, kuka::name, 25);
}

/// Faults drawn at random, in every state: always named, always standing, never a jump.
TEST(KukaFaults, DrawnAtRandomTheyAreAlwaysNamedAndNothingJumps) {
  constexpr const char* kOrders[] = {
      "e_stop",    "guard_open",   "t1",        "t2",           "aut",         "ext",       "drives_off",
      "stop",      "cancel",       "rsi_off",   "collision",    "small_limit", "deaf",      "garbage",
      "again",     "skip=40",      "slow",      "nonsense",     "busy",        "close_eki", "other_program",
      "old_rsi",   "seven",        "rsi_error", "refuse_start", "power_off",   "late=3",    "duplicate=3",
      "reorder=2", "refuse_drives"};
  KukaRig rig;
  expect_random_faults_end_well(rig, kOrders, {.joint = "joint_6", .after = 90}, 60 * kDegree * 0.004 + 1e-7,
                                mend, [](kuka::Machine& m) { m.step(); });
}

}  // namespace
}  // namespace polyarm
