/// Everything that can end a link, with the words for it: the robot stands afterwards, and nothing moves it
/// again.
#include <cstdlib>
#include <set>
#include <thread>

#include "tests/kuka/rig.hpp"

namespace polyarm {
namespace {

using test::KukaRig;
using namespace test;

/// What a person does at the controller. The drives stay off.
void mend(FarSide& far) {
  for (const char* order : {"release", "guard_closed", "acknowledge", "ext", "healthy"}) far.order(order);
}

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
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  const double from = rig.command("joint_3/position");
  int n = 0;
  const auto move = [&](int) { rig.command("joint_3/position") = from + travel(++n, 0.0015); };
  ASSERT_TRUE(rig.runs(120, move));
  rig.far().order(GetParam().order);
  // RSI ends by itself where answers do not reach it; then the loop must not wait for the limits.
  ASSERT_TRUE(rig.fails(3000, [&](int i) {
    if (i < 40) move(i);
  }));
  EXPECT_EQ(rig.component.cause(), GetParam().cause) << rig.component.reason();
  const std::string said = rig.component.reason();
  EXPECT_NE(said.find(GetParam().words), std::string::npos) << said;
  EXPECT_NE(said.find("127.0.0.1"), std::string::npos) << "names the device: " << said;
  expect_standing(rig);
  mend(rig.far());
  expect_standing(rig);  // what was mended moves nothing

  ASSERT_TRUE(rig.configure()) << rig.component.reason();
  EXPECT_EQ(rig.component.cause(), Cause::none);
  expect_standing(rig);  // nor does a new connection
  const Six before = rig.q();
  rig.forget_jumps();
  ASSERT_TRUE(rig.activate()) << rig.component.reason();
  ASSERT_TRUE(rig.runs(50, [](int) {}));
  EXPECT_LE(rig.largest_jump(), 1e-6) << "the first command is the measured position";
  for (std::size_t j = 0; j < 6; ++j) EXPECT_NEAR(rig.q()[j], before[j], 1e-6);
}

class BeforeItMoves : public testing::TestWithParam<FaultRow> {};
INSTANTIATE_TEST_SUITE_P(
    Faults, BeforeItMoves,
    testing::Values(FaultRow{"busy", Cause::eki_busy, "takes one client"},
                    FaultRow{"nonsense", Cause::eki_bad_data, "another program may listen"},
                    FaultRow{"other_program", Cause::program_version, "version 2 of PolyarmEki"},
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
  const Six before = rig.q();
  rig.far().order(GetParam().order);
  ASSERT_FALSE(rig.start());
  EXPECT_EQ(rig.component.cause(), GetParam().cause) << rig.component.reason();
  EXPECT_NE(rig.component.reason().find(GetParam().words), std::string::npos) << rig.component.reason();
  EXPECT_NE(rig.component.reason().find("127.0.0.1"), std::string::npos) << rig.component.reason();
  rig.component.on_cleanup();
  mend(rig.far());
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.runs(5, [](int) {}));
  rig.component.on_cleanup();
  const Six after = rig.q();
  for (std::size_t j = 0; j < 6; ++j) EXPECT_NEAR(after[j], before[j], 1e-6) << "joint " << j;
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
  KukaRig on;
  on.far().order("drives_off");
  EXPECT_TRUE(on.start()) << on.component.reason();
  KukaRig off(Parameters{{"drives_on", "false"}});
  off.far().order("drives_off");
  EXPECT_FALSE(off.start());
  EXPECT_EQ(off.component.cause(), Cause::drives_off);
  KukaRig refused;
  refused.far().order("drives_off");
  refused.far().order("refuse_drives");
  EXPECT_FALSE(refused.start());
  EXPECT_EQ(refused.component.cause(), Cause::drives_refused) << refused.component.reason();
}

TEST(KukaFaults, ARefusedActivationLeavesTheComponentReading) {
  KukaRig rig;
  ASSERT_TRUE(rig.configure()) << rig.component.reason();
  rig.far().order("t2");
  EXPECT_FALSE(rig.activate());
  EXPECT_EQ(rig.read(), ReturnType::ok) << "it is inactive, not broken";
  rig.far().order("ext");
  EXPECT_TRUE(rig.activate()) << rig.component.reason();
}

TEST(KukaFaults, AControllerThatIsNotThereIsNamed) {
  kuka::KukaComponent component;
  std::string why;
  int port = 0;
  {
    const Descriptor closing = wire::listen_tcp("127.0.0.1", 0, why);
    port = wire::local_port(closing.number());
  }
  component.on_init(kuka_context({{"host", "127.0.0.1"}, {"eki_port", std::to_string(port)}}));
  EXPECT_EQ(component.on_configure(), CallbackReturn::failure);
  EXPECT_EQ(component.cause(), Cause::unreachable);
  EXPECT_NE(component.reason().find("127.0.0.1"), std::string::npos) << component.reason();
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
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.runs(20, [](int) {}));
  rig.command("joint_5/position") += 0.3;
  ASSERT_TRUE(rig.fails(5, [](int) {}));
  EXPECT_EQ(rig.component.cause(), Cause::jump);
  EXPECT_NE(rig.component.reason().find("joint 5"), std::string::npos) << rig.component.reason();
  expect_standing(rig);
  EXPECT_LE(rig.largest_jump(), 1e-6);
}

TEST(KukaFaults, AFirstCommandAwayFromTheMeasuredPositionIsNotSent) {
  KukaRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  rig.command("joint_2/position") += 0.02;  // less than a step, more than a measurement
  ASSERT_TRUE(rig.fails(5, [](int) {}));
  EXPECT_EQ(rig.component.cause(), Cause::jump);
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
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  for (int i = 0; i < 3 && rig.component.cause() == Cause::none; ++i) rig.cycle_once();
  while (rig.component.cause() == Cause::none) std::this_thread::yield();  // it takes what it takes
  EXPECT_EQ(rig.component.cause(), Cause::loop_silent) << rig.component.reason();
  rig.component.on_error();
  expect_standing(rig);
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
  std::set<std::string> seen, names;
  for (int i = 1; i <= static_cast<int>(Cause::jump); ++i) {
    const std::string text = kuka::sentence(static_cast<Cause>(i), 2, "the controller at 10.0.0.1", "x");
    EXPECT_NE(text.find("10.0.0.1"), std::string::npos) << text;
    EXPECT_NE(text.find_first_of(":;,"), std::string::npos) << text;
    EXPECT_TRUE(seen.insert(text).second) << text;
    EXPECT_TRUE(names.insert(kuka::name(static_cast<Cause>(i))).second) << i;
  }
  EXPECT_GE(seen.size(), 25u);
}

/// Faults drawn at random, in every state: always named, always standing, never a jump.
TEST(KukaFaults, DrawnAtRandomTheyAreAlwaysNamedAndNothingJumps) {
  const char* const asked = std::getenv("POLYARM_FAULT_ROUNDS");  // more for a long run
  const int rounds = asked ? std::atoi(asked) : 20;
  constexpr const char* kOrders[] = {
      "e_stop",    "guard_open",   "t1",        "t2",           "aut",         "ext",       "drives_off",
      "stop",      "cancel",       "rsi_off",   "collision",    "small_limit", "deaf",      "garbage",
      "again",     "skip=40",      "slow",      "nonsense",     "busy",        "close_eki", "other_program",
      "old_rsi",   "seven",        "rsi_error", "refuse_start", "power_off",   "late=3",    "duplicate=3",
      "reorder=2", "refuse_drives"};
  Draw draw(27);
  KukaRig rig;
  int named = 0;
  for (int round = 0; round < rounds; ++round) {
    const std::string order = kOrders[draw(std::size(kOrders))];
    rig.forget_jumps();
    const bool early = draw(4) == 0;
    if (early) rig.far().order(order);
    if (rig.start()) {
      const double from = rig.command("joint_6/position");
      const double way = draw(2) ? 0.0015 : -0.0015;
      const auto move = [&](int i) {
        rig.command("joint_6/position") = from + travel(std::min(i, 200), way);
      };
      const int before = static_cast<int>(draw(60));
      bool alive = true;
      int i = 0;
      for (; alive && i < before; ++i) move(i), alive = rig.cycle_once() == ReturnType::ok;
      if (alive && !early) rig.far().order(order);
      for (int k = 0; alive && k < 90; ++k, ++i) move(i), alive = rig.cycle_once() == ReturnType::ok;
    }
    if (rig.component.cause() != Cause::none) {
      ++named;
      ASSERT_GT(rig.component.reason().size(), 30u) << round << " " << order;
    }
    ASSERT_LE(rig.largest_jump(), 60 * kDegree * 0.004 + 1e-7) << round << " " << order;
    rig.component.on_error();
    mend(rig.far());
    rig.far().with([&](kuka::Machine& m) {
      for (int k = 0; k < 200; ++k) m.step();
      const auto at = m.q();
      for (int k = 0; k < 50; ++k) m.step();
      EXPECT_EQ(m.q(), at) << round << " " << order;
      return 0;
    });
  }
  EXPECT_GT(named, rounds / 2);
}

}  // namespace
}  // namespace polyarm
