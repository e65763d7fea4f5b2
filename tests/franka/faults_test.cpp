/// Everything that can end a link, with the words for it: the robot stands afterwards, and nothing moves it
/// again.
#include <set>

#include "tests/franka/rig.hpp"
#include "tests/support/wire_faults.hpp"

namespace polyarm {
namespace {

using test::FrankaRig;
using namespace test;
using franka::Machine;
using franka::RobotMode;

class WhileMoving : public testing::TestWithParam<FaultRow> {};
INSTANTIATE_TEST_SUITE_P(
    Faults, WhileMoving,
    testing::Values(FaultRow{"user_stop", Cause::user_stop, "user stop"},
                    FaultRow{"guide", Cause::guiding, "by hand"},
                    FaultRow{"brakes", Cause::locked, "open the brakes"},
                    FaultRow{"safety", Cause::safety, "safety function"},
                    FaultRow{"collision", Cause::collision, "joint_reflex"},
                    FaultRow{"error=7", Cause::collision, "clear the space"},
                    FaultRow{"force=60", Cause::collision, "cartesian_reflex"},
                    FaultRow{"error=2", Cause::self_collision, "close to itself"},
                    FaultRow{"error=0", Cause::joint_limit, "end of its range"},
                    FaultRow{"error=3", Cause::speed_limit, "lower the speed"},
                    FaultRow{"error=14", Cause::discontinuity, "velocity_discontinuity"},
                    FaultRow{"error=9", Cause::deviation, "max_path_pose_deviation"},
                    FaultRow{"error=34", Cause::controller_error, "tau_J_range_violation"},
                    FaultRow{"deaf", Cause::communication, "real-time kernel"},
                    FaultRow{"drop=30", Cause::communication, "communication_constraints"},
                    FaultRow{"late=40", Cause::communication, "cable without a switch"},
                    FaultRow{"garbage", Cause::bad_data, "Franka Control Interface"},
                    FaultRow{"not_a_number", Cause::bad_data, "`port`"},
                    FaultRow{"close", Cause::closed, "closed the connection"},
                    FaultRow{"power_off", Cause::closed, "activate FCI"}),
    fault_name<Cause>);

TEST_P(WhileMoving, IsNamedStandsAndDoesNotJumpWhenItIsRecovered) {
  FrankaRig rig;
  expect_fault_while_moving(
      rig, GetParam(), {.joint = "fr3_joint3", .step = 0.0003, .before = 150, .after = 60, .patience = 2000},
      mend);
}

class BeforeItMoves : public testing::TestWithParam<FaultRow> {};
INSTANTIATE_TEST_SUITE_P(Faults, BeforeItMoves,
                         testing::Values(FaultRow{"user_stop", Cause::user_stop, "release it"},
                                         FaultRow{"guide", Cause::guiding, "let go"},
                                         FaultRow{"brakes", Cause::locked, "choose Execution"},
                                         FaultRow{"safety", Cause::safety, "Watchman"},
                                         FaultRow{"refuse_motion", Cause::motion_refused, "not possible"},
                                         FaultRow{"singular", Cause::motion_refused, "singular start"},
                                         FaultRow{"refuse_settings", Cause::setting_refused, "Set Load"},
                                         FaultRow{"other_version", Cause::other_version, "version 11"},
                                         FaultRow{"busy", Cause::no_session, "it takes one client"},
                                         FaultRow{"garbage", Cause::bad_data, "Franka Control Interface"},
                                         FaultRow{"not_a_number", Cause::bad_data, "`port`"},
                                         FaultRow{"bad_reply", Cause::bad_data, "check address"}),
                         fault_name<Cause>);

TEST_P(BeforeItMoves, StartingIsRefusedInWordsAndWorksOnceItIsMended) {
  FrankaRig rig(Parameters{{"load_mass", "0.5"}, {"load_center", "0 0 0.1"}});
  expect_fault_before_motion(rig, GetParam(), mend);
}

/// These end by a time without an answer.
class InSilence : public testing::TestWithParam<FaultRow> {};
INSTANTIATE_TEST_SUITE_P(Faults, InSilence,
                         testing::Values(FaultRow{"silent", Cause::silent, "firewall"},
                                         FaultRow{"mute", Cause::command_silent, "does not answer"},
                                         FaultRow{"stranger", Cause::other_sender, "127.0.0.2"}),
                         fault_name<Cause>);

TEST_P(InSilence, StartingIsRefusedInWords) {
  FrankaRig rig(Parameters{{"connect_timeout", "1"}, {"start_timeout", "2"}});
  rig.far().order(GetParam().order);
  ASSERT_FALSE(rig.start());
  expect_named(rig, GetParam());
}

class HandFaults : public testing::TestWithParam<FaultRow> {};
INSTANTIATE_TEST_SUITE_P(Faults, HandFaults,
                         testing::Values(FaultRow{"hand_silent", Cause::hand_silent, "check its cable"},
                                         FaultRow{"hand_mute", Cause::hand_silent, "check its cable"},
                                         FaultRow{"hand_version", Cause::hand_version, "version 4"}),
                         fault_name<Cause>);

TEST_P(HandFaults, AreNamedBeforeAnythingMoves) {
  FrankaRig rig(Parameters{{"hand", "true"}, {"connect_timeout", "1"}});
  rig.far().order(GetParam().order);
  ASSERT_FALSE(rig.configure());
  expect_named(rig, GetParam());
  mend(rig.far());
  ASSERT_TRUE(rig.start()) << rig.component.reason();
}

TEST(FrankaFaults, AHandThatCannotGraspEndsTheMotionInWords) {
  for (const auto& [order, cause] :
       {std::pair{"hand_fails", Cause::hand_failed}, {"hand_close", Cause::hand_silent}}) {
    FrankaRig rig(Parameters{{"hand", "true"}});
    ASSERT_TRUE(rig.start()) << rig.component.reason();
    rig.far().order(order);
    rig.command("tool/grip") = 1;
    ASSERT_TRUE(rig.fails(200, [](int) {})) << order;
    EXPECT_EQ(rig.component.cause(), cause) << rig.component.reason();
    expect_standing(rig);
  }
}

TEST(FrankaFaults, AnErrorIsRecoveredByActivatingOnlyIfThatIsAllowed) {
  FrankaRig allowed;
  ASSERT_TRUE(allowed.configure()) << allowed.component.reason();
  allowed.far().order("collision");
  for (int i = 0; i < 20; ++i) allowed.far().step();
  EXPECT_EQ(allowed.read(), ReturnType::ok) << "nothing is recovered by itself";
  EXPECT_EQ(allowed.far().with([](Machine& m) { return m.recoveries(); }), 0u);
  EXPECT_TRUE(allowed.activate()) << allowed.component.reason();
  EXPECT_EQ(allowed.far().with([](Machine& m) { return m.recoveries(); }), 1u);

  FrankaRig forbidden(Parameters{{"recover", "false"}});
  forbidden.far().order("collision");
  EXPECT_FALSE(forbidden.start());
  EXPECT_EQ(forbidden.component.cause(), Cause::reflex_pending) << forbidden.component.reason();
  EXPECT_NE(forbidden.component.reason().find("joint_reflex"), std::string::npos)
      << forbidden.component.reason();
  EXPECT_EQ(forbidden.far().with([](Machine& m) { return m.mode(); }), RobotMode::reflex);

  FrankaRig refused;
  refused.far().order("collision");
  refused.far().order("refuse_recovery");
  EXPECT_FALSE(refused.start());
  EXPECT_EQ(refused.component.cause(), Cause::recovery_refused) << refused.component.reason();
  EXPECT_NE(refused.component.reason().find("a person must"), std::string::npos)
      << refused.component.reason();
}

TEST(FrankaFaults, ARefusedActivationLeavesTheComponentReading) {
  FrankaRig rig;
  expect_refused_activation_keeps_reading(rig, "refuse_motion", "healthy");
}

TEST(FrankaFaults, ARobotThatIsNotThereIsNamed) {
  expect_unreachable<franka::FrankaComponent>(
      franka_context({{"host", "127.0.0.1"}, {"port", std::to_string(closed_port())}}), Cause::unreachable,
      "polyarm setup franka");
}

TEST(FrankaFaults, ASecondClientIsRefused) {
  Alone alone;
  ASSERT_TRUE(alone.configure()) << alone.component.reason();
  franka::FrankaComponent second;
  second.on_init(franka_context({{"host", "127.0.0.1"}, {"port", std::to_string(alone.far.port())}}));
  EXPECT_EQ(second.on_configure(), CallbackReturn::failure);
  EXPECT_EQ(second.cause(), Cause::no_session) << second.reason();
  EXPECT_EQ(alone.component.cause(), Cause::none) << "the first one goes on";
}

TEST(FrankaFaults, AJumpOfTheCommandsIsNotSent) {
  FrankaRig rig;
  expect_no_jump_is_sent(rig, "fr3_joint5", Cause::jump, 60);
}

TEST(FrankaFaults, AFirstCommandAwayFromTheMeasuredPositionIsNotSent) {
  FrankaRig rig;
  expect_no_far_begin_is_sent(rig, "fr3_joint2", Cause::jump);
}

TEST(FrankaFaults, ALoopThatFallsSilentIsNamedAndTheRobotStands) {
  FrankaRig rig(Parameters{{"loop_silence_ms", "300"}});  // the robot's clock stands still
  expect_silent_loop_is_braked(rig, Cause::loop_silent);
}

TEST(FrankaFaults, WithoutCommandsTheRobotStopsByItself) {
  FrankaRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  const double from = rig.commands[0];
  ASSERT_TRUE(rig.runs(200, [&](int i) { rig.commands[0] = from + travel(i, 0.0003); }));
  for (int i = 0; i < 60; ++i) rig.far().step();  // no command, no answer of anybody
  EXPECT_EQ(rig.far().with([](Machine& m) { return m.mode(); }), RobotMode::reflex);
  EXPECT_TRUE(rig.far().with([](Machine& m) { return m.errors()[25]; }))
      << "communication_constraints_violation";
  expect_standing(rig);
}

TEST(FrankaFaults, AFewLostCommandsAreNoReasonToStop) {
  FrankaRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  const double from = rig.commands[0];
  const auto move = [&](int i) { rig.commands[0] = from + travel(i, 0.0003); };
  ASSERT_TRUE(rig.runs(150, move));
  for (int n = 0; n < 5; ++n) {
    rig.far().order("drop=3");
    ASSERT_TRUE(rig.runs(60, [&](int i) { move(150 + 60 * n + i); })) << n << " " << rig.component.reason();
  }
  EXPECT_LT(rig.state("controller/success_rate"), 1);
  EXPECT_GT(rig.state("controller/success_rate"), 0.8);
}

TEST(FrankaFaults, StatesThatComeTwiceLateOrInTheWrongOrderMoveNothing) {
  FrankaRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  const auto before = rig.q();
  for (const char* fault : {"duplicate=5", "reorder=4", "late=5"}) {
    rig.far().order(fault);
    ASSERT_TRUE(rig.runs(60, [](int) {})) << fault << rig.component.reason();
  }
  EXPECT_LE(rig.largest_jump(), 1e-9);
  for (std::size_t i = 0; i < 7; ++i) EXPECT_NEAR(rig.q()[i], before[i], 1e-9);
}

TEST(FrankaFaults, ALowShareOfCommandsInTimeIsNamedIfItIsJudged) {
  FrankaRig judged(Parameters{{"least_success", "0.8"}});
  ASSERT_TRUE(judged.start()) << judged.component.reason();
  judged.far().order("low_success=60");
  ASSERT_TRUE(judged.fails(500, [](int) {}));
  EXPECT_EQ(judged.component.cause(), Cause::low_success) << judged.component.reason();
  EXPECT_NE(judged.component.reason().find("60 %"), std::string::npos) << judged.component.reason();
  FrankaRig shown;
  ASSERT_TRUE(shown.start()) << shown.component.reason();
  shown.far().order("low_success=60");
  ASSERT_TRUE(shown.runs(500, [](int) {})) << shown.component.reason();
  EXPECT_NEAR(shown.state("controller/success_rate"), 0.6, 1e-9);
}

TEST(FrankaFaults, SilenceOfTheStatesIsNamed) {
  FrankaRig rig(Parameters{{"silence_ms", "200"}});
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  rig.far().order("silent");
  ASSERT_TRUE(rig.fails(100'000'000, [](int) {}));
  EXPECT_EQ(rig.component.cause(), Cause::silent) << rig.component.reason();
  expect_standing(rig);
}

TEST(FrankaFaults, AHandWhoseStatesEndIsNamed) {
  FrankaRig rig(Parameters{{"hand", "true"}, {"connect_timeout", "1"}});
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  rig.far().order("hand_silent");
  ASSERT_TRUE(rig.fails(100'000'000, [](int) {}));
  EXPECT_EQ(rig.component.cause(), Cause::hand_silent) << rig.component.reason();
  expect_standing(rig);
}

TEST(FrankaWords, EveryCauseSaysWhatToDo) {
  const auto name_of = [](Cause cause) { return franka::name(cause); };
  expect_words_for_every_cause(Cause::jump, franka::sentence, name_of, 36);
}

TEST(FrankaWords, EveryErrorFlagHasItsNameAndWordsOfItsOwn) {
  std::set<std::string> seen, names;
  for (int i = 0; i < static_cast<int>(franka::kErrors); ++i) {
    const auto& facts = franka::error_facts(i);
    EXPECT_TRUE(seen.insert(facts.words).second) << facts.name;
    EXPECT_TRUE(names.insert(facts.name).second);
    EXPECT_NE(std::string(facts.words).find(": "), std::string::npos) << "what to do: " << facts.words;
    franka::ErrorFlags flags;
    flags.set(static_cast<std::size_t>(i));
    EXPECT_EQ(franka::first_error(flags), i);
    EXPECT_EQ(franka::error_names(flags), facts.name);
    const std::string said = franka::sentence(facts.cause, i, "the controller at 10.0.0.1", facts.name);
    EXPECT_NE(said.find(facts.words), std::string::npos) << said;
    EXPECT_NE(said.find(facts.name), std::string::npos) << said;
  }
  EXPECT_EQ(seen.size(), 41u);
  EXPECT_NE(std::string(franka::error_facts(-1).words).find("Desk"), std::string::npos);
}

/// Faults drawn at random, in every state: always named, always standing, never a jump.
TEST(FrankaFaults, DrawnAtRandomTheyAreAlwaysNamedAndNothingJumps) {
  constexpr const char* kOrders[] = {
      "user_stop", "guide",     "brakes",        "safety",        "collision",       "error=7", "error=0",
      "error=14",  "error=25",  "force=60",      "deaf",          "drop=30",         "drop=3",  "late=40",
      "late=5",    "duplicate", "reorder",       "garbage",       "not_a_number",    "close",   "busy",
      "power_off", "singular",  "refuse_motion", "other_version", "refuse_settings", "push=1",  "sag=2"};
  FrankaRig rig(Parameters{{"load_mass", "0.5"}, {"load_center", "0 0 0.1"}, {"max_speed", "60"}});
  expect_random_faults_end_well(
      rig, kOrders, {.joint = "fr3_joint6", .step = 0.0004, .after = 90}, 60 * kDegree * 0.001 + 1e-6, mend,
      [](Machine& m) { m.step(); }, 400);
}

}  // namespace
}  // namespace polyarm
