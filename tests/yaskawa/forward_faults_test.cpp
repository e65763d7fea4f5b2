/// Forward mode: what goes wrong before and while the robot moves.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/support/wire_faults.hpp"
#include "tests/yaskawa/forward_rig.hpp"

namespace polyarm {
namespace {

using hardware::ForwardMove;
using namespace test;
using Rig = YaskawaForwardRig;

// --- before it moves --------------------------------------------------------------------------------------

class YaskawaForwardBefore : public testing::TestWithParam<FaultRow> {};
INSTANTIATE_TEST_SUITE_P(Faults, YaskawaForwardBefore,
                         testing::Values(FaultRow{"no_ladder", Cause::no_watchdog, "into its ladder"},
                                         FaultRow{"no_job", Cause::hses_refused, "no such job"},
                                         FaultRow{"teach", Cause::teach_mode, "REMOTE"},
                                         FaultRow{"alarm=4321", Cause::alarm, "4321"},
                                         FaultRow{"hold=1", Cause::hold, "button of the pendant"},
                                         FaultRow{"e_stop", Cause::servo_refused, "do not switch on"},
                                         FaultRow{"hses_nonsense", Cause::hses_bad_data,
                                                  "no answer of its Ethernet server"}),
                         fault_name<Cause>);

TEST_P(YaskawaForwardBefore, StartingIsRefusedInWordsAndWorksOnceItIsMended) {
  const bool ladder = std::string(GetParam().order) == "no_ladder";
  Rig rig(ladder ? Parameters{{"watchdog_ms", "100"}} : Parameters{});
  const Six before = rig.q();
  rig.far().order(GetParam().order);
  ASSERT_FALSE(rig.start());
  expect_named(rig, GetParam());
  rig.component.on_cleanup();
  repair(rig.far());
  EXPECT_EQ(rig.q(), before);
  if (ladder) return;  // its timer is too short for a machine with other load
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  EXPECT_EQ(rig.q(), before);
}

TEST(YaskawaForward, AJobOfSomebodyElseIsLeftAlone) {
  Rig rig;
  rig.far().with([](yaskawa::Machine& m) { return m.select_job("WELD"), m.start_job(); });
  ASSERT_FALSE(rig.start());
  EXPECT_EQ(rig.component.cause(), Cause::job_runs);
  EXPECT_NE(rig.component.reason().find("WELD"), std::string::npos) << rig.component.reason();
  EXPECT_TRUE(rig.far().with([](yaskawa::Machine& m) { return m.runs("WELD"); }));
}

TEST(YaskawaForward, AnotherToolAtThePendantOrOtherPulsesMoveNothing) {
  const auto refused = [](const char* order, Parameters parameters) {
    Rig rig(std::move(parameters));
    ASSERT_TRUE(rig.start()) << rig.component.reason();
    ASSERT_TRUE(rig.passes(5));
    if (order) rig.far().order(order);
    const Six before = rig.q();
    ASSERT_TRUE(rig.moves->accept(rig.turn(0.3)));
    bool failed = false;
    for (int i = 0; i < 100 && !failed; ++i) failed = rig.pass() == ReturnType::error;
    EXPECT_TRUE(failed);
    EXPECT_EQ(rig.q(), before);
  };
  refused("other_tool", {});
  refused(nullptr, {{"base_height", "0.5"}});
  refused(nullptr, {{"tool_number", "3"}});
}

// --- while it moves ---------------------------------------------------------------------------------------

/// The cable breaks: nothing reaches the controller any more.
TEST(YaskawaForward, WithoutTheHeartbeatTheLadderStopsTheRobotAndNothingGoesOn) {
  Rig rig(Parameters{{"answer_ms", "300"}});
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  ForwardMove slow = rig.turn(1.4);
  slow.share = 0.03;
  ASSERT_TRUE(rig.moves->accept(slow));
  ASSERT_TRUE(rig.passes(30));
  rig.far().order("hses_mute");
  bool failed = false;
  for (int i = 0; i < 5 && !failed; ++i) failed = rig.pass() == ReturnType::error;
  ASSERT_TRUE(failed);
  rig.far().hold_clock(true);  // the driver has ended, and its controller would go on with the real time
  EXPECT_EQ(rig.component.cause(), Cause::hses_silent) << rig.component.reason();
  const double from = rig.q()[0];
  for (int i = 0; i < 20; ++i) rig.far().step();
  EXPECT_GT(rig.q()[0], from + 1e-3) << "the timer of the ladder still runs";
  expect_standing(rig, 50);
  EXPECT_LT(rig.q()[0], from + 0.4) << "it has not come to its end";
  EXPECT_TRUE(rig.far().with([](yaskawa::Machine& m) { return m.panel().external_hold; }));
  const Six at = rig.q();
  rig.far().order("healthy");
  rig.far().order("unhold");
  EXPECT_FALSE((rig.far().step(), rig.far().with([](yaskawa::Machine& m) { return m.start_job(); })))
      << "held until a new session";
  ASSERT_TRUE(rig.configure()) << rig.component.reason();
  ASSERT_TRUE(rig.activate()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(60));
  expect_at(rig, at, 1e-6);
}

TEST(YaskawaForward, AJobThatIgnoresItsHoldIsStoppedByTheLadder) {
  Rig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  ForwardMove slow = rig.turn(1.4);
  slow.share = 0.03;
  ASSERT_TRUE(rig.moves->accept(slow));
  ASSERT_TRUE(rig.passes(20));
  rig.far().order("deaf_hold");
  bool failed = false;
  for (int i = 0; i < 400 && !failed; ++i) failed = rig.pass(0) == ReturnType::error;
  ASSERT_TRUE(failed);
  EXPECT_EQ(rig.component.cause(), Cause::hold_ignored) << rig.component.reason();
  expect_standing(rig, 100);
  EXPECT_LT(rig.q()[0], (*rig.target)[0] - 0.1);
}

class YaskawaForwardWhileMoving : public testing::TestWithParam<FaultRow> {};
INSTANTIATE_TEST_SUITE_P(Faults, YaskawaForwardWhileMoving,
                         testing::Values(FaultRow{"e_stop", Cause::servo_off, "an emergency stop"},
                                         FaultRow{"teach", Cause::teach_mode, "key of the pendant to REMOTE"},
                                         FaultRow{"play", Cause::not_remote, "without remote"},
                                         FaultRow{"servo_off", Cause::servo_off, "servos"},
                                         FaultRow{"hold=1", Cause::hold, "by the button of the pendant"},
                                         FaultRow{"hold=2", Cause::hold, "by a signal from outside"},
                                         FaultRow{"hold=3", Cause::hold, "by a command"},
                                         FaultRow{"stop_job", Cause::job_stopped, "was stopped there"},
                                         FaultRow{"alarm=4321", Cause::alarm, "alarm 4321 (OUT OF RANGE"},
                                         FaultRow{"error", Cause::error, "cancel it at the pendant"},
                                         FaultRow{"meddle", Cause::moves_changed, "D080"},
                                         FaultRow{"locked_places", Cause::hses_refused, "the data is in use"},
                                         FaultRow{"hses_nonsense", Cause::hses_bad_data,
                                                  "no answer of its Ethernet server"},
                                         FaultRow{"hses_refuse", Cause::hses_refused, "status A000"},
                                         FaultRow{"power_off", Cause::hses_silent, "does not answer"}),
                         fault_name<Cause>);

TEST_P(YaskawaForwardWhileMoving, IsNamedStandsAndMovesNothingWhenItIsRecovered) {
  const bool silent = GetParam().cause == Cause::hses_silent;
  Rig rig(silent ? Parameters{{"answer_ms", "300"}} : Parameters{});
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  for (int i = 0; i < 8; ++i) ASSERT_TRUE(rig.moves->accept(rig.turn(i % 2 ? -0.3 : 0.3)));
  ASSERT_TRUE(rig.passes(20));
  rig.far().order(GetParam().order);
  bool failed = false;
  for (int i = 0; i < 300 && !failed; ++i) failed = rig.pass() == ReturnType::error;
  ASSERT_TRUE(failed);
  expect_named(rig, GetParam());
  expect_standing(rig, 100);
  repair(rig.far());
  expect_standing(rig, 20);
  rig.far().with([](yaskawa::Machine& m) { return m.servo(true), m.start_job(); });
  expect_standing(rig, 50);  // nobody who starts the job sets it in motion
  rig.far().order("stop_job");
  ASSERT_TRUE(rig.configure()) << rig.component.reason();
  expect_standing(rig, 20);
  rig.forget_jumps();
  const Six before = rig.q();
  ASSERT_TRUE(rig.activate()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(60));
  EXPECT_TRUE(rig.moves->flow().idle) << "what was left is forgotten";
  EXPECT_LE(rig.largest_jump(), 1e-6);
  expect_at(rig, before, 1e-6);
}

// --- at random --------------------------------------------------------------------------------------------

/// Before, during and after moves, pauses and clears. POLYARM_FAULT_ROUNDS: how many.
TEST(YaskawaForwardFaults, DrawnAtRandomTheyAreAlwaysNamedAndNothingJumpsOrGoesOnByItself) {
  constexpr const char* kOrders[] = {
      "e_stop",      "teach",      "play",       "servo_off",   "hold=1",        "hold=2", "hold=3",
      "stop_job",    "alarm=4321", "error",      "meddle",      "locked_places", "no_job", "hses_nonsense",
      "hses_refuse", "other_tool", "hses_twice", "hses_lost=1", "refuse_servo"};
  const int rounds = fault_rounds(20);
  Draw draw(37);
  Rig rig(Parameters{{"answer_ms", "2000"}});
  int named = 0;
  for (int round = 0; round < rounds; ++round) {
    const std::string order = kOrders[draw(std::size(kOrders))];
    if (!rig.configure()) {
      ADD_FAILURE() << round << " " << rig.component.reason();
      break;
    }
    rig.forget_jumps();
    if (draw(4) == 0) rig.far().order(order);
    const Six before = rig.q();
    if (rig.component.cause() == Cause::none && rig.activate()) {
      rig.target.reset();
      const int moves = static_cast<int>(1 + draw(9)), until = static_cast<int>(draw(50));
      for (int i = 0; i < moves; ++i)
        rig.moves->accept(rig.turn(i % 2 ? -0.2 : 0.2, draw(2) && i + 1 < moves ? 0.02 : 0));
      const double pace = draw(3) == 0 ? 0 : 1;
      bool alive = true;
      for (int i = 0; alive && i < until; ++i) alive = rig.pass() == ReturnType::ok;
      if (alive && draw(4) == 0) rig.moves->clear();
      if (alive) rig.far().order(order);
      for (int i = 0; alive && i < 40; ++i) alive = rig.pass(pace) == ReturnType::ok;
    } else {
      for (std::size_t j = 0; j < 6; ++j) EXPECT_NEAR(rig.q()[j], before[j], 1e-6) << order;
    }
    if (rig.component.cause() != Cause::none) {
      ++named;
      EXPECT_GT(rig.component.reason().size(), 30u) << order;
    }
    EXPECT_LE(rig.largest_jump(), 7 * 0.016) << order;  // rad in 16 ms, of an axis that moves here
    rig.component.on_error();
    expect_standing(rig, 100);
    repair(rig.far());
    expect_standing(rig, 20);
  }
  EXPECT_GT(named, rounds / 3);
}

}  // namespace
}  // namespace polyarm
