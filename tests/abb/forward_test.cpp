/// Forward mode: the controller interpolates, the driver sends moves and follows.
#include <cmath>

#include "tests/abb/forward_rig.hpp"
#include "tests/support/forward_laws.hpp"

namespace polyarm {
namespace {

using hardware::ForwardMove;
using namespace test;

constexpr Vec3 kArc{0, -0.2, 0}, kVia{0, -0.1, 0.1};  // half a circle upwards

/// The driver alone, as for a real controller: the far side ticks on its own thread.
class FreeClock {
 public:
  explicit FreeClock(Parameters more = {}) : far(forward_options()) {
    Parameters parameters{{"host", "127.0.0.1"},       {"motion", "forward"},   {"answer_ms", "20000"},
                          {"watchdog_ms", "10000"},    {"start_timeout", "60"}, {"connect_timeout", "60"},
                          {"loop_silence_ms", "10000"}};
    parameters["rws_port"] = std::to_string(far.rws_port());
    parameters["moves_port"] = std::to_string(far.moves_port());
    more.merge(parameters);
    component.on_init(abb_context(more));
    states.resize(component.state_interfaces().size());
  }
  ~FreeClock() { component.on_shutdown(); }
  bool start() {
    return component.on_configure() == CallbackReturn::success &&
           component.on_activate() == CallbackReturn::success;
  }
  static FarSideOptions forward_options() {
    FarSideOptions options = far_options();
    options.machine.modules = {abb::kMovesModule};
    return options;
  }
  FarSide far;
  abb::AbbComponent component;
  std::vector<double> states;
  hardware::Cycle cycle{0, 4'000'000, 0};
};

TEST(AbbForward, NothingMovesBeforeAMoveIsHandedOver) {
  ForwardRig rig;
  expect_nothing_moves_before_a_move(rig);
}

TEST(AbbForward, JointMovesAndLinesEndWhereTheyShould) {
  ForwardRig rig;
  expect_moves_end_where_they_should(rig, {0, 0.05, 0.1}, 1e-4);
}

TEST(AbbForward, ALineIsStraight) {
  ForwardRig rig;
  expect_line_is_straight(rig, {0, -0.1, -0.08}, 2e-4);
}

/// The tool is not that of the flange: the controller gets it, with its load, before the first move.
TEST(AbbForward, ALineOfATcpThatIsTurnedEndsWhereItShould) {
  ForwardRig rig(Parameters{{"tool_mass", "1.25"}, {"tool_centre", "0.01 0 0.08"}});
  expect_line_of_a_turned_tcp_ends_at_its_target(rig);
  const abb::RapidLoad load = rig.far().tool_load();
  EXPECT_NEAR(load.mass, 1.25, 1e-6);
  EXPECT_NEAR(load.centre[0], 10, 1e-5);
  EXPECT_NEAR(load.centre[2], 80, 1e-5);
}

TEST(AbbForward, AToolThatOnlyTurnsTakesItsTime) {
  ForwardRig rig;
  expect_turn_of_the_tool_takes_its_time(rig, 0.004);
}

TEST(AbbForward, AnArcPassesItsPoint) {
  ForwardRig rig;
  expect_arc_passes_its_point(rig, kArc, kVia, 0.002, 1e-4);
}

/// MoveC does not take three quarters of a circle.
TEST(AbbForward, AnArcThatIsTooLongIsNamedAndNothingMoves) {
  ForwardRig rig;
  ASSERT_TRUE(begins(rig));
  ASSERT_TRUE(rig.moves->accept(rig.arc({0, -0.05, -0.05}, {0, -0.1, 0})));
  const Six at = rig.q();
  bool failed = false;
  for (int i = 0; i < 100 && !failed; ++i) failed = rig.pass() == ReturnType::error;
  ASSERT_TRUE(failed);
  EXPECT_EQ(rig.component.cause(), Cause::arc_too_long) << rig.component.reason();
  EXPECT_NE(rig.component.reason().find("arc of 270 degrees"), std::string::npos) << rig.component.reason();
  expect_at(rig.q(), at, kStandsWithin);
}

TEST(AbbForward, ABlendLeavesTheCornerByNoMoreThanItsRadiusAndSavesTime) {
  const auto joints = [](ForwardRig& rig, double blend) { return rig.turn(-0.3, blend); };
  const auto line = [](ForwardRig& rig, double blend) { return rig.shift({0, 0, -0.1}, blend); };
  expect_blend_stays_near_the_corner<ForwardRig>(line, {0, -0.1, 0}, 0.03, 2e-4);
  expect_blend_stays_near_the_corner<ForwardRig>(joints, {0, 0, -0.1}, 0.03, 2e-4);
}

TEST(AbbForward, APauseStopsOnThePathAndGoesOnFromThere) {
  ForwardRig rig;
  expect_pause_stops_on_the_path(rig, -0.15, 100, 2e-4);
}

TEST(AbbForward, APausedRobotDoesNotMoveWhenSomebodyPressesStart) {
  ForwardRig rig;
  ASSERT_TRUE(begins(rig));
  ASSERT_TRUE(rig.moves->accept(rig.turn(1)));
  ASSERT_TRUE(rig.passes(50));
  ASSERT_TRUE(rig.passes_until([&] { return rig.moves->flow().standing; }, 0, 500));
  const Six at = rig.q();
  rig.far().order("play");
  ASSERT_TRUE(rig.passes(300, 0));
  EXPECT_LT(at[0], 1.2) << "it has not come to its end";
  expect_at(rig.q(), at, kStandsWithin);
}

TEST(AbbForward, APauseInAnArcGoesOnOnTheArc) {
  ForwardRig rig;
  expect_pause_in_an_arc_stays_on_it(rig, kArc, kVia);
}

TEST(AbbForward, AfterClearTheRobotStandsAndTakesOtherMoves) {
  ForwardRig rig;
  expect_clear_ends_all_moves(rig, 100);
}

TEST(AbbForward, ThePaceSetsTheTime) {
  expect_pace_sets_the_time<ForwardRig>(0.8, [](ForwardRig&, double) {});
}

TEST(AbbForward, DeactivatingWhileItMovesStopsTheRobotAndForgetsItsMoves) {
  ForwardRig rig;
  ASSERT_TRUE(begins(rig));
  for (int i = 0; i < 4; ++i) ASSERT_TRUE(rig.moves->accept(rig.turn(i % 2 ? -0.5 : 0.5)));
  ASSERT_TRUE(rig.passes(100));
  EXPECT_EQ(rig.component.on_deactivate(), CallbackReturn::success);
  EXPECT_EQ(rig.component.cause(), Cause::none) << rig.component.reason();
  EXPECT_FALSE(rig.far().with([](abb::Machine& m) { return m.program_runs(); }));
  expect_standing(rig);
  rig.far().order("play");
  expect_standing(rig);
  const Six at = rig.q();
  ASSERT_TRUE(rig.activate()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(100));
  EXPECT_TRUE(rig.moves->flow().idle);
  expect_at(rig.q(), at, 1e-6);
}

TEST(AbbForward, ManyMovesPassThroughTheProgramsPlacesInOrder) {
  ForwardRig rig;
  expect_many_moves_pass_in_order(rig, 0.01);
}

TEST(AbbForward, JointsKeepTheirSpeedOnALineThatNeedsThem) {
  ForwardRig rig(Parameters{{"line_acceleration", "20"}});
  ASSERT_TRUE(begins(rig));
  ForwardMove line = rig.shift({-0.1, -0.25, 0});
  line.speed = 10;
  ASSERT_TRUE(rig.moves->accept(line));
  double most = 0;
  const Six velocity = abb::facts_of(abb_model()).velocity;
  ASSERT_TRUE(rig.passes_until([&] {
    for (std::size_t j = 0; j < 6; ++j)
      most = std::max(most, std::abs(rig.states[2 * j + 1]) / (velocity[j] * kDegree));
    return rig.done();
  }));
  EXPECT_GT(most, 0.3);
  EXPECT_LE(most, 1.0);
}

TEST(AbbForward, SignalsGoOverRobotWebServices) {
  ForwardRig rig(Parameters{{"wires", "doA=diA"}});
  ASSERT_TRUE(begins(rig));
  for (int round = 0; round < 4; ++round) {
    rig.command("io/doA") = round % 2;
    ASSERT_TRUE(rig.passes(40));
    EXPECT_EQ(rig.state("io/doA"), round % 2) << round;
    EXPECT_EQ(rig.state("io/diA"), round % 2) << "wired to doA";
  }
  EXPECT_EQ(rig.state("controller/motors_on"), 1);
  EXPECT_EQ(rig.state("controller/egm"), 0);
}

TEST(AbbForward, AControllerThatCommandsJointsIsRefused) {
  ForwardRig rig;
  expect_joint_commands_are_refused(rig, Cause::joint_commands);
}

TEST(AbbForward, WrongParametersAreNamed) {
  for (const auto& [name, value] :
       std::initializer_list<std::pair<std::string, std::string>>{{"motion", "sideways"},
                                                                  {"tool_centre", "1 2"},
                                                                  {"tool_centre", "a b c"},
                                                                  {"tool_mass", "0"},
                                                                  {"poll_ms", "200"}}) {
    abb::AbbComponent component;
    Parameters parameters{{"host", "x"}, {"motion", "forward"}};
    parameters[name] = value;
    EXPECT_THROW(component.on_init(abb_context(parameters)), Error) << name << " " << value;
  }
}

/// Without a session the joints come over Robot Web Services: a robot that is jogged is shown where it is.
TEST(AbbForward, ARobotThatIsJoggedBeforeActivatingIsShown) {
  FreeClock alone;
  ASSERT_EQ(alone.component.on_configure(), CallbackReturn::success) << alone.component.reason();
  alone.component.read(alone.cycle, alone.states);
  const double from = alone.states[0];
  alone.far.with([](abb::Machine& m) { return m.push_by_hand({2, 0, 0, 0, 0, 0}), 0; });
  for (int i = 0; i < 20'000 && std::abs(alone.states[0] - from - 2 * kDegree) > 1e-5; ++i) {
    alone.component.await_cycle(20'000'000);
    alone.component.read(alone.cycle, alone.states);
  }
  EXPECT_NEAR(alone.states[0], from + 2 * kDegree, 1e-5);
}

/// A trap that stands in StopMove serves nothing until the robot stands. Signals keep Robot Web Services
/// busy.
TEST(AbbForward, AProgramThatAnswersLateWhileTheRobotStopsKeepsTheLink) {
  FreeClock alone({{"answer_ms", "2000"}, {"digital_out", "doA"}, {"digital_in", "diA"}});
  ASSERT_TRUE(alone.start()) << alone.component.reason();
  hardware::ForwardMoves& moves = *alone.component.forward_moves(hardware::kForwardLayout);
  const std::vector<double> commands(alone.component.command_interfaces().size(), std::nan(""));
  const auto passes_until = [&](double pace, auto fulfilled) {
    for (int i = 0; i < 20'000; ++i) {
      alone.component.await_cycle(60'000'000'000);
      alone.cycle.time += alone.cycle.period;
      moves.set_pace(pace);
      if (alone.component.read(alone.cycle, alone.states) != ReturnType::ok ||
          alone.component.write(alone.cycle, commands) != ReturnType::ok)
        return false;
      if (fulfilled()) return true;
    }
    return false;
  };
  ASSERT_TRUE(passes_until(1, [] { return true; }));
  const ForwardMove move = turn_from(alone.states, 2, abb_chain(), 1.5);
  alone.far.order("slow_stop");
  ASSERT_TRUE(moves.accept(move));
  const double start = alone.states[0];
  for (int hold = 1; hold <= 3; ++hold) {
    ASSERT_TRUE(passes_until(1, [&] { return alone.states[0] > start + 0.3 * hold; }))
        << hold << alone.component.reason();
    ASSERT_TRUE(passes_until(0, [&] { return moves.flow().standing; })) << hold << alone.component.reason();
  }
  EXPECT_LT(alone.states[0], move.joints[0] - 0.01);
  ASSERT_TRUE(passes_until(1, [&] { return moves.flow().idle; })) << alone.component.reason();
  EXPECT_NEAR(alone.states[0], move.joints[0], 1e-3);
}

/// The controller's clock runs by itself, as a robot's does.
TEST(AbbForward, OnAFreeClockMovesArriveAndTheLoopNeitherAllocatesNorLocks) {
  FreeClock alone;
  ASSERT_TRUE(alone.start()) << alone.component.reason();
  EXPECT_FALSE(alone.component.paces());
  alone.component.await_cycle(60'000'000'000);
  ASSERT_EQ(alone.component.read(alone.cycle, alone.states), ReturnType::ok);
  const ForwardMove move = turn_from(alone.states, 2, abb_chain(), 0.1);
  expect_move_on_a_free_clock(alone.component, move, alone.cycle, alone.states, 1e-3);
}

}  // namespace
}  // namespace polyarm
