/// Everything that can end a link, with the words for it: the arm stands afterwards, and nothing moves it
/// again.
#include "tests/cia402/rig.hpp"
#include "tests/support/wire_faults.hpp"

namespace polyarm {
namespace {

using test::Cia402Rig;
using namespace test;
using cia402::FarDrive;
using cia402::Machine;

void mend(FarSide& far) {
  far.order("healthy");
}

class WhileMoving : public testing::TestWithParam<FaultRow> {};
INSTANTIATE_TEST_SUITE_P(
    Faults, WhileMoving,
    testing::Values(FaultRow{"silent=2", Cause::silent, "joint_2 (node 2)"},
                    FaultRow{"power_off=6", Cause::silent, "check its power"},
                    FaultRow{"over_current=3", Cause::emergency, "continuous over-current (0x2310)"},
                    FaultRow{"under_voltage=1", Cause::emergency, "DC link under-voltage"},
                    FaultRow{"following_error=4", Cause::following_error, "joint_4 (node 4)"},
                    FaultRow{"encoder=5", Cause::drive_fault, "encoder 1 failed (0x7305)"},
                    FaultRow{"quick_stop=2", Cause::quick_stop, "limit switches"},
                    FaultRow{"torque_off=1", Cause::switched_off, "safe torque off"},
                    FaultRow{"mode=2", Cause::wrong_mode, "mode 1 instead of 8"},
                    FaultRow{"reset=2", Cause::restarted, "has restarted"},
                    FaultRow{"stopped=3", Cause::not_operational, "\"stopped\""},
                    FaultRow{"no_heartbeat=2", Cause::no_heartbeat, "heartbeat"},
                    FaultRow{"bus_off", Cause::bus_off, "120 Ω"},
                    FaultRow{"cut", Cause::all_silent, "no drive on"},
                    FaultRow{"other_master", Cause::other_master, "SYNC"}),
    fault_name<Cause>);

/// Not expect_fault_while_moving(): the clock of these drives must not run ahead of a driver that is
/// connected.
TEST_P(WhileMoving, IsNamedStandsAndDoesNotJumpWhenItIsRecovered) {
  Cia402Rig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  const double from = rig.commands[0];
  int n = 0;
  const auto move = [&](int) { rig.commands[0] = from + travel(++n, 0.002, 80); };
  ASSERT_TRUE(rig.runs(60, move)) << rig.component.reason();
  rig.far().order(GetParam().order);
  ASSERT_TRUE(rig.fails(400, [&](int i) {
    if (i < 40) move(i);
  }));
  expect_named(rig, GetParam());
  expect_standing(rig);
  mend(rig.far());
  expect_standing(rig);  // what was mended moves nothing

  const auto before = rig.q();
  const std::size_t heard = rig.far().heard().size();
  ASSERT_TRUE(rig.configure()) << rig.component.reason();
  EXPECT_EQ(rig.component.cause(), Cause::none);
  const auto frames = rig.far().heard();
  EXPECT_TRUE(std::none_of(frames.begin() + static_cast<std::ptrdiff_t>(std::min(heard, frames.size())),
                           frames.end(), [](const auto& frame) { return frame.id >> 7 == 4; }))
      << "a new connection commands nothing";
  EXPECT_EQ(rig.q(), before);
  rig.forget_jumps();
  ASSERT_TRUE(rig.activate()) << rig.component.reason();
  ASSERT_TRUE(rig.runs(50, [](int) {})) << rig.component.reason();
  EXPECT_LE(rig.largest_jump(), 1e-6) << "the first command is the measured position";
  EXPECT_EQ(rig.q(), before);
}

class BeforeItMoves : public testing::TestWithParam<FaultRow> {};
INSTANTIATE_TEST_SUITE_P(
    Faults, BeforeItMoves,
    testing::Values(FaultRow{"torque_off=1", Cause::not_enabled, "switch on disabled"},
                    FaultRow{"no_enable=2", Cause::not_enabled, "enable input"},
                    FaultRow{"quick_stop=2", Cause::not_enabled, "quick stop active"},
                    FaultRow{"mode=3", Cause::wrong_mode, "mode 1"},
                    FaultRow{"over_current=1", Cause::drive_fault, "continuous over-current"},
                    FaultRow{"wrong_device=3", Cause::wrong_device, "profile 401"},
                    FaultRow{"no_position_mode=4", Cause::no_position_mode, "newer firmware"},
                    FaultRow{"sdo_silent=5", Cause::no_answer, "joint_5 (node 5)"},
                    FaultRow{"power_off=6", Cause::no_answer, "does not answer"},
                    FaultRow{"cut", Cause::no_answer, "bit rate"},
                    FaultRow{"bus_off", Cause::bus_off, "nobody acknowledges"},
                    FaultRow{"sdo_wrong=2", Cause::wrong_answer, "do not fit"},
                    FaultRow{"refuse_mapping=1", Cause::setting_refused, "cannot be mapped to a PDO"},
                    FaultRow{"forget=6", Cause::setting_lost, "0x60C2:1"},
                    FaultRow{"other_master", Cause::other_master, "one master"}),
    fault_name<Cause>);

TEST_P(BeforeItMoves, StartingIsRefusedInWordsAndWorksOnceItIsMended) {
  Cia402Rig rig(Parameters{{"start_timeout", "1"}, {"answer_ms", "300"}});
  expect_fault_before_motion(rig, GetParam(), mend);
}

TEST(Cia402Faults, APulledAdapterIsNamedAndTheDrivesStopByThemselves) {
  Cia402Rig rig;
  ASSERT_TRUE(rig.start());
  const double from = rig.commands[0];
  const auto move = [&](int i) { rig.commands[0] = from + travel(i, 0.002, 80); };
  ASSERT_TRUE(rig.runs(100, move));
  const std::string device = rig.device();
  rig.far().order("unplug");
  ASSERT_TRUE(rig.fails(50, move));
  EXPECT_EQ(rig.component.cause(), Cause::bus_gone) << rig.component.reason();
  EXPECT_NE(rig.component.reason().find(device), std::string::npos) << rig.component.reason();
  expect_standing(rig);
  rig.far().with([](Machine& machine) {
    for (FarDrive& drive : machine.drives()) {
      EXPECT_STREQ(drive.state_name(), "quick stop active");
      EXPECT_EQ(drive.value(0x603F), 0x8130u) << "it missed the heartbeat";
    }
    return 0;
  });
}

TEST(Cia402Faults, OneDriveInFaultStopsAllOthersAtOnce) {
  Cia402Rig rig;
  ASSERT_TRUE(rig.start());
  const double from = rig.commands[0];
  const auto move = [&](int i) { rig.commands[0] = from + travel(i, 0.002, 80); };
  ASSERT_TRUE(rig.runs(100, move));
  rig.far().order("encoder=5");  // its cause is only known some cycles later
  for (int i = 0; i < 4; ++i) {
    move(100 + i);
    rig.cycle_once();
  }
  rig.far().with([](Machine& machine) {
    for (FarDrive& drive : machine.drives()) EXPECT_FALSE(drive.enabled()) << drive.node();
    return 0;
  });
}

TEST(Cia402Faults, WithoutTheProgramDrivesThatDoNotWatchAreNotMoved) {
  Cia402Rig rig(Parameters{{"watchdog", "auto"}});
  rig.far().order("unwatched=2");
  ASSERT_TRUE(rig.configure()) << rig.component.reason();
  EXPECT_FALSE(rig.activate());
  EXPECT_EQ(rig.component.cause(), Cause::no_watchdog) << rig.component.reason();
  EXPECT_NE(rig.component.reason().find("polyarm_cia402_watchdog"), std::string::npos);
}

TEST(Cia402Faults, EndWellWhicheverComes) {
  constexpr const char* kOrders[] = {"silent=2",
                                     "power_off=6",
                                     "over_current=3",
                                     "under_voltage=1",
                                     "following_error=4",
                                     "encoder=5",
                                     "quick_stop=2",
                                     "torque_off=1",
                                     "mode=2",
                                     "reset=2",
                                     "stopped=3",
                                     "no_heartbeat",
                                     "bus_off",
                                     "cut",
                                     "other_master",
                                     "no_enable=4",
                                     "sdo_silent=5",
                                     "sdo_wrong=2",
                                     "refuse_mapping",
                                     "forget=6",
                                     "wrong_device=3",
                                     "late=2",
                                     "duplicate=1",
                                     "garbage=40",
                                     "limit=1",
                                     "no_position_mode"};
  Cia402Rig rig(Parameters{{"start_timeout", "0.5"}, {"answer_ms", "100"}});
  expect_random_faults_end_well(rig, std::span(kOrders), {.joint = "joint_1", .step = 0.002, .after = 120},
                                0.00202, mend, [](Machine& machine) { machine.tick(); });
}

TEST(Cia402Words, EveryCauseHasASentenceOfItsOwn) {
  expect_words_for_every_cause(
      Cause::wrong_rate,
      [](Cause cause, int detail, const std::string& where, const std::string& text) {
        return cia402::sentence(cause, detail, where, text);
      },
      [](Cause cause) { return std::string(cia402::name(cause)); }, 29);
}

}  // namespace
}  // namespace polyarm
