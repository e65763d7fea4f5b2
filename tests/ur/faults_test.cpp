/// Everything that can end a link, with the words for it: the robot stands afterwards, and nothing moves it
/// again.
#include <regex>
#include <thread>

#include "tests/support/wire_faults.hpp"
#include "tests/ur/rig.hpp"

namespace polyarm {
namespace {

using test::UrRig;
using namespace test;

struct FaultRow {
  const char* order;
  Cause cause;
  const char* words;  ///< a part of the sentence
};
std::ostream& operator<<(std::ostream& out, const FaultRow& row) {
  return out << row.order;
}

class WhileMoving : public testing::TestWithParam<FaultRow> {};
INSTANTIATE_TEST_SUITE_P(
    Faults, WhileMoving,
    testing::Values(FaultRow{"protective_stop", Cause::protective_stop, "protective stop"},
                    FaultRow{"safeguard_stop", Cause::safeguard_stop, "safeguard stop"},
                    FaultRow{"emergency_stop", Cause::emergency_stop, "release the button"},
                    FaultRow{"violation", Cause::safety_fault, "VIOLATION"},
                    FaultRow{"power_off", Cause::robot_mode, "switched off"},
                    FaultRow{"program_stop", Cause::program_stopped, "was stopped there"},
                    FaultRow{"program_pause", Cause::program_paused, "was paused there"},
                    FaultRow{"close_rtde", Cause::rtde_closed, "closed the RTDE connection"},
                    FaultRow{"garbage", Cause::bad_data, "no RTDE"},
                    FaultRow{"dead", Cause::rtde_closed, "switched off"},
                    FaultRow{"deaf", Cause::not_reading, "does not read its commands"}),
    [](const auto& info) { return std::string(info.param.order); });

TEST_P(WhileMoving, IsNamedStandsAndDoesNotJumpWhenItIsRecovered) {
  UrRig rig(Parameters{{"watchdog_ms", "200"}});
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  const double from = rig.command("elbow_joint/position");
  int n = 0;
  const auto move = [&](int) { rig.command("elbow_joint/position") = from + 0.001 * ++n; };
  ASSERT_TRUE(rig.runs(100, move));
  rig.far().order(GetParam().order);
  ASSERT_TRUE(rig.fails(2000, move));
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
  rig.far().with([](ur::Machine& machine) { return machine.forget_jumps(), 0; });
  ASSERT_TRUE(rig.activate()) << rig.component.reason();
  ASSERT_TRUE(rig.runs(100, [](int) {}));
  EXPECT_LE(rig.far().with([](ur::Machine& m) { return m.largest_jump(); }), 1e-6)
      << "the first command is the measured position";
}

class BeforeItMoves : public testing::TestWithParam<FaultRow> {};
INSTANTIATE_TEST_SUITE_P(
    Faults, BeforeItMoves,
    testing::Values(FaultRow{"wrong_version", Cause::wrong_version, "refuses RTDE protocol"},
                    FaultRow{"second_client", Cause::second_client, "another program"},
                    FaultRow{"local", Cause::not_remote, "local control"},
                    FaultRow{"power_off", Cause::robot_mode, "switched off"},
                    FaultRow{"protective_stop", Cause::protective_stop, "Enable robot"},
                    FaultRow{"emergency_stop", Cause::emergency_stop, "emergency stop"},
                    FaultRow{"unreachable", Cause::no_answer_back, "firewall"},
                    FaultRow{"script_error", Cause::script_error, "compile_error_name_not_found"}),
    [](const auto& info) { return std::string(info.param.order); });

TEST_P(BeforeItMoves, StartingIsRefusedInWordsAndWorksOnceItIsMended) {
  UrRig rig(Parameters{{"start_timeout", "0.3"}});
  const ur::Six before = rig.q();
  rig.far().order(GetParam().order);
  ASSERT_FALSE(rig.start());
  EXPECT_EQ(rig.component.cause(), GetParam().cause) << rig.component.reason();
  EXPECT_NE(rig.component.reason().find(GetParam().words), std::string::npos) << rig.component.reason();
  rig.component.on_cleanup();
  mend(rig.far());
  UrRig* const again = &rig;
  ASSERT_TRUE(again->configure()) << rig.component.reason();
  rig.component.on_cleanup();
  const ur::Six after = rig.q();
  for (std::size_t j = 0; j < 6; ++j) EXPECT_EQ(after[j], before[j]) << "joint " << j;
}

TEST(UrFaults, EveryCauseHasItsOwnWords) {
  expect_words_for_every_cause(Cause::joint_commands, ur::sentence, ur::name, 27);
}

TEST(UrFaults, WithoutRemoteControlThePortItselfRefuses) {
  UrRig rig(Parameters{{"dashboard", "false"}});
  ASSERT_TRUE(rig.configure()) << rig.component.reason();
  rig.far().order("local");
  EXPECT_FALSE(rig.activate());
  EXPECT_EQ(rig.component.cause(), Cause::not_remote);
  EXPECT_NE(rig.component.reason().find("read-only"), std::string::npos) << rig.component.reason();
}

TEST(UrFaults, AControllerThatIsNotThereIsNamedWithItsAddress) {
  ur::UrComponent component;
  std::string why;
  const Descriptor taken =
      wire::listen_tcp("127.0.0.1", 0, why);  // bound, and then closed: nobody answers there
  const int port = wire::local_port(taken.number());
  const Descriptor gone = wire::listen_tcp("127.0.0.1", 0, why);
  int closed_port = 0;
  {
    const Descriptor closing = wire::listen_tcp("127.0.0.1", 0, why);
    closed_port = wire::local_port(closing.number());
  }
  component.on_init(ur_context({{"host", "127.0.0.1"}, {"rtde_port", std::to_string(closed_port)}}));
  EXPECT_EQ(component.on_configure(), CallbackReturn::failure);
  EXPECT_EQ(component.cause(), Cause::unreachable);
  EXPECT_NE(component.reason().find("127.0.0.1:" + std::to_string(closed_port) + " refuses"),
            std::string::npos)
      << component.reason();

  ur::UrComponent mute;  // somebody listens, and says nothing
  mute.on_init(
      ur_context({{"host", "127.0.0.1"}, {"rtde_port", std::to_string(port)}, {"connect_timeout", "0.1"}}));
  EXPECT_EQ(mute.on_configure(), CallbackReturn::failure);
  EXPECT_EQ(mute.cause(), Cause::rtde_silent) << mute.reason();
}

TEST(UrFaults, OldSoftwareIsNamedWithItsVersion) {
  ur::FarSideOptions options;
  options.machine.major = 3;
  options.machine.minor = 4;
  options.rtde = options.dashboard = options.primary = options.secondary = 0;
  FarSide far(options);
  ur::UrComponent component;
  component.on_init(ur_context({{"host", "127.0.0.1"}, {"rtde_port", std::to_string(far.rtde_port())}}));
  EXPECT_EQ(component.on_configure(), CallbackReturn::failure);
  EXPECT_EQ(component.cause(), Cause::too_old);
  EXPECT_NE(component.reason().find("3.4.0"), std::string::npos) << component.reason();
}

TEST(UrFaults, ACellAtAnotherRateIsToldTheControllers) {
  ur::FarSideOptions options;
  options.machine.major = 3;
  options.machine.minor = 15;
  options.rate = 125;
  options.rtde = options.dashboard = options.primary = options.secondary = 0;
  FarSide far(options);
  ur::UrComponent component;
  component.on_init(ur_context({{"host", "127.0.0.1"},
                                {"rtde_port", std::to_string(far.rtde_port())},
                                {"primary_port", std::to_string(far.primary_port())}}));
  EXPECT_EQ(component.on_configure(), CallbackReturn::failure);
  EXPECT_EQ(component.cause(), Cause::wrong_rate);
  EXPECT_NE(component.reason().find("rate: 125"), std::string::npos) << component.reason();
}

TEST(UrFaults, AJumpOfTheCommandsIsNotSent) {
  UrRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.runs(50, [](int) {}));
  rig.command("wrist_2_joint/position") += 0.3;
  ASSERT_TRUE(rig.fails(5, [](int) {}));
  EXPECT_EQ(rig.component.cause(), Cause::jump);
  EXPECT_NE(rig.component.reason().find("joint 5"), std::string::npos) << rig.component.reason();
  EXPECT_LE(rig.far().with([](ur::Machine& m) { return m.largest_jump(); }), 1e-6);
}

TEST(UrFaults, AFirstCommandAwayFromTheMeasuredPositionIsNotSent) {
  UrRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  rig.command("shoulder_lift_joint/position") += 0.02;  // less than a step, more than a measurement
  ASSERT_TRUE(rig.fails(5, [](int) {}));
  EXPECT_EQ(rig.component.cause(), Cause::jump);
}

TEST(UrFaults, TheRobotsProgramStopsTheRobotWhenCommandsEnd) {
  UrRig rig;  // the controller's clock runs here as fast as the machine can, the driver's does not
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  const double from = rig.command("elbow_joint/position");
  ASSERT_TRUE(rig.runs(100, [&](int i) { rig.command("elbow_joint/position") = from + 0.001 * (i + 1); }));
  ASSERT_EQ(rig.read(), ReturnType::ok);            // waits until the program has the last command
  for (int i = 0; i < 4000; ++i) rig.far().step();  // 8 s without a command
  EXPECT_TRUE(rig.far().with([](ur::Machine& m) { return m.still(); }));
  ASSERT_TRUE(rig.fails(500, [](int) {}));
  EXPECT_EQ(rig.component.cause(), Cause::commands_late) << rig.component.reason();
}

TEST(UrFaults, ALoopThatFallsSilentIsStoppedByTheDriver) {
  UrRig rig(Parameters{{"watchdog_ms", "1000"}});  // the controller's clock stands still
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  for (int i = 0; i < 3 && rig.component.cause() == Cause::none; ++i) rig.cycle_once();
  while (rig.component.cause() == Cause::none) std::this_thread::yield();  // it takes what it takes
  EXPECT_EQ(rig.component.cause(), Cause::loop_silent) << rig.component.reason();
  rig.component.on_error();
  expect_standing(rig);
}

TEST(UrFaults, SilenceOfTheControllerIsNamed) {
  UrRig rig(Parameters{{"silence_ms", "50"}});
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  rig.far().order("silent");
  ASSERT_TRUE(rig.fails(20, [](int) {}));
  EXPECT_EQ(rig.component.cause(), Cause::rtde_silent) << rig.component.reason();
  EXPECT_NE(rig.component.reason().find("check cable"), std::string::npos);
}

TEST(UrFaults, ARefusedActivationLeavesTheComponentReading) {
  UrRig rig;
  ASSERT_TRUE(rig.configure()) << rig.component.reason();
  rig.far().order("local");
  EXPECT_FALSE(rig.activate());
  EXPECT_EQ(rig.read(), ReturnType::ok) << "it is inactive, not broken";
  rig.far().order("remote");
  EXPECT_TRUE(rig.activate()) << rig.component.reason();
  EXPECT_EQ(rig.component.cause(), Cause::none);
}

TEST(UrFaults, AnotherProgramIsNotReplaced) {
  UrRig rig(Parameters{{"start_timeout", "0.2"}});
  ASSERT_TRUE(rig.configure()) << rig.component.reason();
  rig.far().with([](ur::Machine& machine) { return machine.program(ur::Machine::Program::playing), 0; });
  while (rig.state("controller/program_state") != ur::playing) rig.read();
  EXPECT_FALSE(rig.activate());
  EXPECT_EQ(rig.component.cause(), Cause::other_program) << rig.component.reason();
  EXPECT_NE(rig.component.reason().find("runs another program"), std::string::npos);
  EXPECT_FALSE(rig.far().program_runs());
}

TEST(UrFaults, AConnectionThatNobodyExpectsIsClosed) {
  std::string why;
  int port = 0;  // a free one, for the driver to listen at
  {
    const Descriptor free = wire::listen_tcp("127.0.0.1", 0, why);
    port = wire::local_port(free.number());
  }
  UrRig rig(Parameters{{"own_port", std::to_string(port)}});
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  const Descriptor stranger = wire::connect_tcp("127.0.0.1", port, 5'000'000'000, why);
  ASSERT_TRUE(stranger) << why;
  ASSERT_TRUE(wire::wait_readable(stranger.number(), 10'000'000'000));
  std::array<std::uint8_t, 64> bytes;
  EXPECT_EQ(wire::receive(stranger.number(), bytes).got, wire::Got::closed);
  ASSERT_TRUE(rig.runs(20, [](int) {}));
  EXPECT_EQ(rig.component.cause(), Cause::none);
}

/// Faults drawn at random, in every state: always named, always standing, never a jump.
/// POLYARM_FAULT_ROUNDS: more rounds.
TEST(UrFaults, DrawnAtRandomTheyAreAlwaysNamedAndNothingJumps) {
  constexpr const char* kOrders[] = {"protective_stop", "safeguard_stop", "emergency_stop", "violation",
                                     "power_off",       "program_stop",   "program_pause",  "close_rtde",
                                     "garbage",         "dead",           "local",          "close_stream",
                                     "duplicate=3"};
  std::uint32_t seed = 27;
  const auto draw = [&](std::uint32_t n) {
    seed = seed * 1664525u + 1013904223u;
    return (seed >> 8) % n;
  };
  UrRig rig;
  int named = 0;
  const int rounds = fault_rounds(25);
  for (int round = 0; round < rounds; ++round) {
    const char* order = kOrders[draw(std::size(kOrders))];
    if (!rig.configure()) {
      ADD_FAILURE() << round << " " << rig.component.reason();
      break;
    }
    rig.far().with([](ur::Machine& machine) { return machine.forget_jumps(), 0; });
    if (draw(4) == 0) rig.far().order(order);
    if (rig.activate()) {
      const double from = rig.command("wrist_3_joint/position");
      const double way = draw(2) ? 0.0005 : -0.0005;
      const auto move = [&](int i) { rig.command("wrist_3_joint/position") = from + way * (i + 1); };
      const int before = static_cast<int>(draw(40));
      bool alive = true;
      int i = 0;
      for (; alive && i < before; ++i) move(i), alive = rig.cycle_once() == ReturnType::ok;
      if (alive) rig.far().order(order);
      for (int k = 0; alive && k < 200; ++k, ++i) move(i), alive = rig.cycle_once() == ReturnType::ok;
    }
    if (rig.component.cause() != Cause::none) {
      ++named;
      EXPECT_GT(rig.component.reason().size(), 30u) << order;
    }
    EXPECT_LE(rig.far().with([](ur::Machine& m) { return m.largest_jump(); }), 6e-4) << order;
    rig.component.on_error();
    mend(rig.far());
    expect_standing(rig);
  }
  EXPECT_GT(named, rounds / 2);
}

}  // namespace
}  // namespace polyarm
