/// Everything that can end a link, with the words for it: the robot stands afterwards, and nothing moves it
/// again.
#include <thread>

#include "tests/fanuc/rig.hpp"
#include "tests/support/wire_faults.hpp"

namespace polyarm {
namespace {

using test::FanucRig;
using namespace test;

class WhileMoving : public testing::TestWithParam<FaultRow> {};
INSTANTIATE_TEST_SUITE_P(
    Faults, WhileMoving,
    testing::Values(
        FaultRow{"e_stop", Cause::emergency_stop, "release the button"},
        FaultRow{"fence_open", Cause::fence, "fence"}, FaultRow{"t1", Cause::teach_mode, "teach pendant"},
        FaultRow{"t2", Cause::teach_mode, "choose AUTO"}, FaultRow{"contact", Cause::contact, "contact"},
        FaultRow{"motn=603", Cause::commands_late, "MOTN-603"},
        FaultRow{"motn=611", Cause::limit, "MOTN-611"}, FaultRow{"alarm=65", Cause::alarm, "SRVO-065"},
        FaultRow{"abort", Cause::program_stopped, "ended there without an alarm"},
        FaultRow{"hold", Cause::program_stopped, "held by hand"},
        FaultRow{"terminate", Cause::terminated, "ended the remote session"},
        FaultRow{"close_rmi", Cause::rmi_closed, "closed the Remote Motion Interface"},
        FaultRow{"power_off", Cause::rmi_closed, "switched off"},
        FaultRow{"garbage", Cause::bad_data, "no packet of its protocols"}),
    fault_name<Cause>);

TEST_P(WhileMoving, IsNamedStandsAndDoesNotJumpWhenItIsRecovered) {
  FanucRig rig;
  expect_fault_while_moving(
      rig, GetParam(),
      {.joint = "J3", .step = 0.003, .ramp = 40, .before = 60, .after = 400, .patience = 400}, mend);
}

class BeforeItMoves : public testing::TestWithParam<FaultRow> {};
INSTANTIATE_TEST_SUITE_P(Faults, BeforeItMoves,
                         testing::Values(FaultRow{"wrong_version", Cause::wrong_version, "version 1"},
                                         FaultRow{"silent", Cause::stream_silent, "J519"},
                                         FaultRow{"busy", Cause::rmi_busy, "another program"},
                                         FaultRow{"mute", Cause::unreachable, "no answer"},
                                         FaultRow{"no_program", Cause::rmi_refused, "R912"},
                                         FaultRow{"refuse", Cause::rmi_refused, "remote motion"},
                                         FaultRow{"stuck", Cause::not_ready, "ASBN_ENB"},
                                         FaultRow{"e_stop", Cause::emergency_stop, "emergency stop"},
                                         FaultRow{"fence_open", Cause::fence, "fence"},
                                         FaultRow{"t1", Cause::teach_mode, "T1 or T2"}),
                         fault_name<Cause>);

TEST_P(BeforeItMoves, StartingIsRefusedInWordsAndWorksOnceItIsMended) {
  FanucRig rig(Parameters{{"start_timeout", "0.4"}, {"connect_timeout", "0.5"}});
  expect_fault_before_motion(rig, GetParam(), mend);
}

TEST(FanucFaults, AnAlarmWhoseCauseIsGoneIsClearedByActivating) {
  FanucRig rig;
  ASSERT_TRUE(rig.configure()) << rig.component.reason();
  rig.far().order("e_stop");
  EXPECT_FALSE(rig.activate());
  rig.far().order("release");  // nobody presses RESET
  EXPECT_TRUE(rig.activate()) << rig.component.reason();
  EXPECT_EQ(rig.component.cause(), Cause::none);
}

TEST(FanucFaults, ARefusedActivationLeavesTheComponentReading) {
  FanucRig rig;
  ASSERT_TRUE(rig.configure()) << rig.component.reason();
  rig.far().order("t1");
  EXPECT_FALSE(rig.activate());
  EXPECT_EQ(rig.read(), ReturnType::ok) << "it is inactive, not broken";
  rig.far().with([](fanuc::Machine& m) { return m.set_input(2, true), 0; });
  const std::uint32_t sent = rig.far().sent_sequence();
  while (rig.far().sent_sequence() < sent + 3) std::this_thread::yield();
  while (rig.component.await_cycle(1'000'000'000) && rig.read() == ReturnType::ok)
    if (rig.state("io/digital_in_2") == 1) break;
  EXPECT_EQ(rig.state("io/digital_in_2"), 1);
  rig.far().order("auto");
  EXPECT_TRUE(rig.activate()) << rig.component.reason();
}

TEST(FanucFaults, AControllerThatIsNotThereIsNamed) {
  fanuc::FanucComponent component;
  std::string why;
  int port = 0;
  {
    const Descriptor closing = wire::bind_udp("127.0.0.1", 0, why);
    port = wire::local_port(closing.number());
  }
  component.on_init(fanuc_context(
      {{"host", "127.0.0.1"}, {"stream_port", std::to_string(port)}, {"connect_timeout", "0.1"}}));
  EXPECT_EQ(component.on_configure(), CallbackReturn::failure);
  EXPECT_EQ(component.cause(), Cause::stream_silent);
  EXPECT_NE(component.reason().find("127.0.0.1"), std::string::npos) << component.reason();
}

TEST(FanucFaults, AJumpOfTheCommandsIsNotSent) {
  FanucRig rig;
  expect_no_jump_is_sent(rig, "J5", Cause::jump);
}

TEST(FanucFaults, AFirstCommandAwayFromTheMeasuredPositionIsNotSent) {
  FanucRig rig;
  expect_no_far_begin_is_sent(rig, "J2", Cause::jump);
}

TEST(FanucFaults, TheControllerStopsTheRobotWhenCommandsEnd) {
  FanucRig rig(Parameters{{"max_behind", "0.2"}});
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  const double from = rig.command("J1/position");
  ASSERT_TRUE(rig.runs(60, [&](int i) { rig.command("J1/position") = from + travel(i, 0.003); }));
  rig.far().order("deaf");  // as if the process were killed: no command arrives any more
  for (int i = 0; i < 60; ++i) rig.far().step();
  const Six at = rig.q();
  for (int i = 0; i < 60; ++i) rig.far().step();
  EXPECT_NEAR(rig.q()[0], at[0], 1e-6);
  rig.far().order("healthy");
  ASSERT_TRUE(rig.fails(300, [](int) {}));
  // Nobody waits for the alarm's text here, so that the name of the cause depends on when it comes.
  EXPECT_NE(rig.component.cause(), Cause::none);
  EXPECT_NE(rig.component.reason().find("127.0.0.1"), std::string::npos) << rig.component.reason();
}

TEST(FanucFaults, ALoopThatFallsSilentIsBrakedByTheDriver) {
  FanucRig rig(Parameters{{"loop_silence_ms", "300"}});  // the controller's clock stands still
  expect_silent_loop_is_braked(rig, Cause::loop_silent);
}

TEST(FanucFaults, SilenceOfTheControllerIsNamed) {
  FanucRig rig(Parameters{{"silence_ms", "50"}});
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  rig.far().order("silent");
  ASSERT_TRUE(rig.fails(100'000'000, [](int) {}));
  EXPECT_EQ(rig.component.cause(), Cause::stream_silent) << rig.component.reason();
  EXPECT_NE(rig.component.reason().find("check cable"), std::string::npos);
}

TEST(FanucFaults, PacketsOfAStrangerAreNotTaken) {
  FarSide far(far_options());
  std::string why;
  const Descriptor owner = wire::connect_udp("127.0.0.1", far.stream_port(), why);
  const Descriptor stranger = wire::connect_udp("127.0.0.1", far.stream_port(), why);
  wire::send_datagram(owner.number(), fanuc::encode_start(3));
  ASSERT_TRUE(wire::wait_readable(owner.number(), 5'000'000'000));
  fanuc::Command command;
  command.motion = true;
  for (int i = 0; i < 50; ++i) wire::send_datagram(stranger.number(), fanuc::encode(command));
  const std::uint32_t sent = far.sent_sequence();
  while (far.sent_sequence() < sent + 5) std::this_thread::yield();
  EXPECT_EQ(far.commands(), 0u);
}

TEST(FanucFaults, TheFirstPacketIsWaitedForToo) {
  FarSide far(far_options());
  far.hold_clock(true);
  std::string why;
  const Descriptor client = wire::connect_udp("127.0.0.1", far.stream_port(), why);
  wire::send_datagram(client.number(), fanuc::encode_start(3));
  far.settle();
  ASSERT_TRUE(far.step(1'000'000)) << "nothing was sent before";
  EXPECT_FALSE(far.step(1'000'000));
}

/// The services of the controller alone, cycle by cycle: a client may command what no driver would.
TEST(FanucFaults, ACommandBeyondALimitIsNotDriven) {
  fanuc::FarFaults faults;
  fanuc::Machine machine(far_options().machine);
  fanuc::FarStream stream(machine, faults, 0.008);
  stream.listen("127.0.0.1", 0);
  std::string why;
  const Descriptor client = wire::connect_udp("127.0.0.1", stream.port(), why);
  wire::send_datagram(client.number(), fanuc::encode_start(3));
  stream.serve();
  stream.program(true);
  fanuc::Command command;
  command.motion = true;
  const Six at = machine.q();
  std::copy(at.begin(), at.end(), command.joints.begin());
  const auto cycles = [&](int count) {
    for (int i = 0; i < count; ++i) {
      stream.cycle();
      command.sequence = stream.sent_sequence();
      wire::send_datagram(client.number(), encode(command));
      stream.serve();
    }
  };
  cycles(20);
  ASSERT_EQ(machine.alarm_text(), "");
  command.joints[0] += 0.2;  // degrees in 8 ms, from rest
  cycles(20);
  EXPECT_NE(machine.alarm_text().find("limit over (axis 1)"), std::string::npos) << machine.alarm_text();
  EXPECT_EQ(machine.largest_jump(), 0);
  EXPECT_EQ(machine.q(), at);
}

/// Faults drawn at random, in every state: always named, always standing, never a jump.
TEST(FanucFaults, DrawnAtRandomTheyAreAlwaysNamedAndNothingJumps) {
  constexpr const char* kOrders[] = {"e_stop",    "fence_open", "t1",        "t2",      "contact",
                                     "motn=603",  "motn=610",   "alarm=65",  "abort",   "hold",
                                     "terminate", "close_rmi",  "power_off", "garbage", "duplicate=3",
                                     "reorder=2", "late=3"};
  Draw draw(27);
  FanucRig rig(Parameters{{"connect_timeout", "1"}});
  int named = 0;
  for (int round = 0; round < 40; ++round) {
    const std::string order = kOrders[draw(std::size(kOrders))];
    if (!rig.configure()) {
      ADD_FAILURE() << round << " " << rig.component.reason();
      break;
    }
    rig.forget_jumps();
    if (draw(4) == 0) rig.far().order(order);
    if (rig.component.cause() == Cause::none && rig.activate()) {
      const double from = rig.command("J6/position");
      const double way = draw(2) ? 0.003 : -0.003;
      const auto move = [&](int i) { rig.command("J6/position") = from + travel(i, way); };
      const int before = static_cast<int>(draw(80));
      bool alive = true;
      int i = 0;
      for (; alive && i < before; ++i) move(i), alive = rig.cycle_once() == ReturnType::ok;
      if (alive) rig.far().order(order);
      for (int k = 0; alive && k < 120; ++k, ++i) move(i), alive = rig.cycle_once() == ReturnType::ok;
    }
    if (rig.component.cause() != Cause::none) {
      ++named;
      EXPECT_GT(rig.component.reason().size(), 30u) << order;
    }
    EXPECT_LE(rig.largest_jump(), 0.008) << order;
    rig.component.on_error();
    mend(rig.far());
    expect_standing(rig);
  }
  EXPECT_GT(named, 20);
}

}  // namespace
}  // namespace polyarm
