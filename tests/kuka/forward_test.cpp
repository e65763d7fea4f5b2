/// Forward mode: the controller interpolates, the driver sends moves and follows.
#include <cmath>

#include "drivers/wire/arcs.hpp"
#include "tests/kuka/forward_rig.hpp"
#include "tests/support/realtime_guard.hpp"
#include "tests/support/wire_faults.hpp"

namespace polyarm {
namespace {

using hardware::ForwardFlow;
using hardware::ForwardMove;
using namespace test;

constexpr double kStandsWithin = 2e-4;  // rad: a robot that moves by less counts as standing

TEST(KukaForward, NothingMovesBeforeAMoveIsHandedOver) {
  ForwardRig rig;
  const Six before = rig.q();
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(100));
  EXPECT_TRUE(rig.moves->flow().standing);
  EXPECT_TRUE(rig.moves->flow().idle);
  EXPECT_EQ(rig.q(), before);
}

TEST(KukaForward, JointMovesAndLinesEndWhereTheyShould) {
  ForwardRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  ASSERT_TRUE(rig.moves->accept(rig.turn(0.4)));
  ASSERT_TRUE(rig.moves->accept(rig.shift({0, 0.05, 0.1})));
  EXPECT_FALSE(rig.moves->flow().idle);
  ASSERT_TRUE(rig.passes_until([&] { return rig.done(); }));
  for (std::size_t j = 0; j < 6; ++j) EXPECT_NEAR(rig.q()[j], (*rig.target)[j], 1e-4) << j;
}

TEST(KukaForward, ALineIsStraight) {
  ForwardRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  const Vec3 from = rig.place();
  ASSERT_TRUE(rig.moves->accept(rig.shift({0, -0.1, -0.08})));
  const Vec3 way = normalized(Vec3{0, -0.1, -0.08});
  double off = 0;
  ASSERT_TRUE(rig.passes_until([&] {
    const Vec3 gone = rig.place() - from;
    off = std::max(off, norm(gone - dot(gone, way) * way));
    return rig.done();
  }));
  EXPECT_LT(off, 2e-4);
}

/// The tool is not that of the flange: the controller gets it before the first move.
TEST(KukaForward, ALineOfATcpThatIsTurnedEndsWhereItShould) {
  ForwardRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  ForwardMove line = rig.shift({0.02, -0.1, 0.05});
  const Pose tool{{0.03, -0.01, 0.12}, from_rpy(0.3, -0.4, 0.5)};
  line.at = line.at * tool;
  ASSERT_TRUE(rig.moves->accept(line));
  ASSERT_TRUE(rig.passes_until([&] { return rig.done(); }));
  for (std::size_t j = 0; j < 6; ++j) EXPECT_NEAR(rig.q()[j], (*rig.target)[j], 1e-4) << j;
}

TEST(KukaForward, AToolThatOnlyTurnsTakesItsTime) {
  ForwardRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(20));
  ForwardMove turn = rig.turn(0);
  turn.joints[5] += 0.5;
  turn.at = kuka_chain().forward(std::span(turn.joints).first(6));
  turn.kind = ForwardMove::Kind::line;
  turn.speed = 0;
  turn.duration = 1.5;
  ASSERT_TRUE(rig.moves->accept(turn));
  int cycles = 0;
  ASSERT_TRUE(rig.passes_until([&] { return ++cycles, rig.done(); }));
  EXPECT_NEAR(rig.q()[5], turn.joints[5], 1e-4);
  EXPECT_GT(cycles * 0.004, 1.3);
  EXPECT_LT(cycles * 0.004, 2.2);
}

TEST(KukaForward, AnArcPassesItsPoint) {
  ForwardRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  const ForwardMove arc = rig.arc();
  ASSERT_TRUE(rig.moves->accept(arc));
  double nearest = 1;
  ASSERT_TRUE(rig.passes_until([&] {
    nearest = std::min(nearest, norm(rig.place() - arc.via.position));
    return rig.done();
  }));
  EXPECT_LT(nearest, 0.002);
  EXPECT_LT(norm(rig.place() - arc.at.position), 1e-4);
}

TEST(KukaForward, ABlendLeavesTheCornerByNoMoreThanItsRadiusAndSavesTime) {
  for (const bool joint : {false, true}) {
    const auto run = [joint](double blend, double& off) {
      ForwardRig rig;
      EXPECT_TRUE(rig.start()) << rig.component.reason();
      EXPECT_TRUE(rig.passes(5));
      const ForwardMove first = joint ? rig.turn(-0.3, blend) : rig.shift({0, 0, -0.15}, blend);
      rig.moves->accept(first);
      rig.moves->accept(rig.shift({0, -0.15, 0}));
      int cycles = 0;
      off = 1;
      EXPECT_TRUE(rig.passes_until([&] {
        ++cycles;
        off = std::min(off, norm(rig.place() - first.at.position));
        return rig.done();
      }));
      return cycles;
    };
    double exact = 0, rounded = 0;
    const int slow = run(0, exact), fast = run(0.04, rounded);
    EXPECT_LT(exact, 2e-4) << joint;
    EXPECT_GT(rounded, 1e-3) << joint;
    EXPECT_LE(rounded, 0.04) << joint;
    EXPECT_LT(fast, slow) << joint;
  }
}

TEST(KukaForward, APauseStopsOnThePathAndGoesOnFromThere) {
  ForwardRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  const Vec3 from = rig.place();
  ASSERT_TRUE(rig.moves->accept(rig.shift({0, 0, -0.2})));
  ASSERT_TRUE(rig.passes(120));
  EXPECT_FALSE(rig.moves->flow().standing);
  ASSERT_TRUE(rig.passes_until([&] { return rig.moves->flow().standing; }, 0, 500));
  EXPECT_EQ(rig.override_percent(), 0);
  const Six at = rig.q();
  ASSERT_TRUE(rig.passes(300, 0));
  for (std::size_t j = 0; j < 6; ++j) EXPECT_NEAR(rig.q()[j], at[j], kStandsWithin);
  EXPECT_FALSE(rig.moves->flow().idle) << "the rest of the move is still to do";
  EXPECT_NEAR(rig.place().x, from.x, 2e-4);
  EXPECT_NEAR(rig.place().y, from.y, 2e-4);
  EXPECT_LT(rig.place().z, from.z - 0.005);
  EXPECT_GT(rig.place().z, from.z - 0.195);
  ASSERT_TRUE(rig.passes_until([&] { return rig.done(); }));
  EXPECT_NEAR(rig.place().z, from.z - 0.2, 1e-4);
}

TEST(KukaForward, APausedRobotDoesNotMoveWhenSomebodyRaisesTheOverrideOrPressesStart) {
  ForwardRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  ASSERT_TRUE(rig.moves->accept(rig.turn(1)));
  ASSERT_TRUE(rig.passes(50));
  ASSERT_TRUE(rig.passes_until([&] { return rig.moves->flow().standing; }, 0, 500));
  const Six at = rig.q();
  rig.far().with([](kuka::Machine& machine) { return machine.set_override(100); });
  rig.far().order("play");
  ASSERT_TRUE(rig.passes(300, 0));
  EXPECT_LT(at[0], 1.2) << "it has not come to its end";
  for (std::size_t j = 0; j < 6; ++j) EXPECT_NEAR(rig.q()[j], at[j], kStandsWithin);
}

TEST(KukaForward, APauseInAnArcGoesOnOnTheArc) {
  ForwardRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  const Vec3 from = rig.place();
  const ForwardMove arc = rig.arc();
  const auto circle = *wire::Circle::through(from, arc.via.position, arc.at.position);
  ASSERT_TRUE(rig.moves->accept(arc));
  double off = 0;
  const auto look = [&] {
    off = std::max(off, std::abs(norm(rig.place() - circle.center) - norm(circle.arm)));
  };
  ASSERT_TRUE(rig.passes_until(
      [&] { return look(), circle.angle_of(rig.place()) > 1 && norm(rig.place() - from) > 0.05; }));
  ASSERT_TRUE(rig.passes_until([&] { return look(), rig.moves->flow().standing; }, 0, 500));
  ASSERT_TRUE(rig.passes_until([&] { return look(), rig.done(); }));
  EXPECT_LT(off, 1e-3);
  EXPECT_LT(norm(rig.place() - arc.at.position), 1e-4);
}

TEST(KukaForward, AfterClearTheRobotStandsAndTakesOtherMoves) {
  ForwardRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(rig.moves->accept(rig.turn(i % 2 ? -0.3 : 0.3)));
  ASSERT_TRUE(rig.passes(100));
  rig.moves->clear();
  EXPECT_FALSE(rig.moves->accept(rig.turn(0.1))) << "not before it is done";
  ASSERT_TRUE(rig.passes_until([&] { return rig.moves->flow().idle && rig.moves->flow().standing; }, 1, 600));
  const Six at = rig.q();
  ASSERT_TRUE(rig.passes(300));
  for (std::size_t j = 0; j < 6; ++j) EXPECT_NEAR(rig.q()[j], at[j], kStandsWithin);
  rig.target.reset();
  ASSERT_TRUE(rig.moves->accept(rig.turn(0.1)));
  ASSERT_TRUE(rig.passes_until([&] { return rig.done(); }));
  EXPECT_NEAR(rig.q()[0], at[0] + 0.1, 1e-3);
}

TEST(KukaForward, ThePaceIsTheOverrideAndIsGivenBack) {
  const auto cycles_at = [](double pace) {
    ForwardRig rig;
    rig.far().with([](kuka::Machine& machine) { return machine.set_override(80); });
    EXPECT_TRUE(rig.start()) << rig.component.reason();
    EXPECT_TRUE(rig.passes(5));
    rig.moves->accept(rig.turn(0.8));
    int cycles = 0;
    EXPECT_TRUE(rig.passes_until([&] { return ++cycles, rig.done(); }, pace));
    EXPECT_NEAR(rig.state("controller/speed_override"), pace, 1e-9);
    rig.component.on_deactivate();
    EXPECT_EQ(rig.override_percent(), 80) << "for other programs";
    return cycles;
  };
  const int full = cycles_at(1), half = cycles_at(0.5);
  EXPECT_GT(half, 1.7 * full);
  EXPECT_LT(half, 2.3 * full);
}

TEST(KukaForward, DeactivatingWhileItMovesStopsTheRobotAndForgetsItsMoves) {
  ForwardRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  for (int i = 0; i < 4; ++i) ASSERT_TRUE(rig.moves->accept(rig.turn(i % 2 ? -0.5 : 0.5)));
  ASSERT_TRUE(rig.passes(100));
  EXPECT_EQ(rig.component.on_deactivate(), CallbackReturn::success);
  EXPECT_EQ(rig.component.cause(), Cause::none) << rig.component.reason();
  expect_standing(rig);
  const Six at = rig.q();
  ASSERT_TRUE(rig.activate()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(100));
  EXPECT_TRUE(rig.moves->flow().idle);
  for (std::size_t j = 0; j < 6; ++j) EXPECT_NEAR(rig.q()[j], at[j], 1e-6);
}

TEST(KukaForward, ManyMovesPassThroughTheQueueInOrder) {
  ForwardRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  for (int i = 0; i < 30; ++i)
    ASSERT_TRUE(rig.moves->accept(rig.turn(i % 2 ? -0.1 : 0.11, i % 3 && i < 29 ? 0.01 : 0)));
  std::uint64_t last = 0;
  ASSERT_TRUE(rig.passes_until(
      [&] {
        EXPECT_GE(rig.moves->flow().done, last);
        last = rig.moves->flow().done;
        return rig.done();
      },
      1, 20000));
  EXPECT_EQ(last, 30u);
}

TEST(KukaForward, AxesKeepTheirSpeedOnALineThatNeedsThem) {
  ForwardRig rig(Parameters{{"line_acceleration", "20"}});
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  ForwardMove line = rig.shift({-0.15, -0.35, 0});
  line.speed = 10;
  ASSERT_TRUE(rig.moves->accept(line));
  double most = 0;
  const Six velocity = kuka::facts_of(kuka_model()).velocity;
  ASSERT_TRUE(rig.passes_until([&] {
    for (std::size_t j = 0; j < 6; ++j)
      most = std::max(most, std::abs(rig.states[2 * j + 1]) / (velocity[j] * kDegree));
    return rig.done();
  }));
  EXPECT_GT(most, 0.3);
  EXPECT_LE(most, 1.0);
}

TEST(KukaForward, OutputsAreSwitchedAndInputsAreRead) {
  ForwardRig rig(Parameters{{"wires", "1=4"}});
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  for (int round = 0; round < 4; ++round) {
    rig.command("io/digital_out_1") = round % 2;
    ASSERT_TRUE(rig.passes(10));
    EXPECT_EQ(rig.state("io/digital_out_1"), round % 2) << round;
    EXPECT_EQ(rig.state("io/digital_in_4"), round % 2) << "wired to output 1";
  }
}

TEST(KukaForward, AControllerThatCommandsJointsIsRefused) {
  ForwardRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  const Six before = rig.q();
  rig.commands[1] += 0.3;
  EXPECT_EQ(rig.component.write(rig.cycle, rig.commands), ReturnType::error);
  EXPECT_EQ(rig.component.cause(), Cause::joint_commands);
  EXPECT_NE(rig.component.reason().find("takes only moves"), std::string::npos) << rig.component.reason();
  rig.component.on_error();
  expect_standing(rig);
  EXPECT_EQ(rig.q(), before);
}

TEST(KukaForward, WithoutEthernetKrlItIsRefused) {
  kuka::KukaComponent component;
  EXPECT_THROW(component.on_init(kuka_context({{"host", "x"}, {"motion", "forward"}, {"eki", "false"}})),
               Error);
  EXPECT_THROW(component.on_init(kuka_context({{"host", "x"}, {"motion", "sideways"}})), Error);
}

/// The controller's clock runs by itself, as a robot's does.
TEST(KukaForward, OnAFreeClockMovesArriveAndTheLoopNeitherAllocatesNorLocks) {
  Alone alone(far_options(), {{"motion", "forward"}, {"answer_ms", "20000"}, {"watchdog_ms", "10000"}});
  auto& component = alone.component;
  ASSERT_EQ(component.on_configure(), CallbackReturn::success) << component.reason();
  ASSERT_EQ(component.on_activate(), CallbackReturn::success) << component.reason();
  EXPECT_FALSE(component.paces());
  hardware::ForwardMoves& moves = *component.forward_moves(hardware::kForwardLayout);
  EXPECT_EQ(component.forward_moves(0), nullptr) << "for a module that was built with other types";
  std::vector<double> states(component.state_interfaces().size()),
      commands(component.command_interfaces().size(), std::nan(""));
  hardware::Cycle cycle{0, 4'000'000, 0};
  component.await_cycle(60'000'000'000);
  ASSERT_EQ(component.read(cycle, states), ReturnType::ok);
  ForwardMove move;
  move.id = 1;
  for (std::size_t j = 0; j < 6; ++j) move.joints[j] = states[2 * j];
  move.joints[0] += 0.1;
  move.at = kuka_chain().forward(std::span(move.joints).first(6));
  std::string violations;
  bool fine = true, accepted = false, done = false;
  for (int i = 0; i < 20'000 && fine && !done; ++i) {
    component.await_cycle(60'000'000'000);
    cycle.time += cycle.period;
    const RealtimeGuard guard;
    moves.set_pace(1);
    fine =
        component.read(cycle, states) == ReturnType::ok && component.write(cycle, commands) == ReturnType::ok;
    accepted = accepted || moves.accept(move);
    const ForwardFlow flow = moves.flow();
    done = accepted && flow.idle && flow.standing && flow.done == 1;
    if (violations.empty()) violations = guard.violations();
  }
  EXPECT_TRUE(fine) << component.reason();
  EXPECT_TRUE(done);
  EXPECT_EQ(violations, "");
  EXPECT_NEAR(states[0], move.joints[0], 1e-3);
}

TEST(KukaForward, ALoopThatFallsSilentIsNamedAndTheRobotStops) {
  Alone alone(
      far_options(),
      {{"motion", "forward"}, {"answer_ms", "20000"}, {"watchdog_ms", "10000"}, {"loop_silence_ms", "200"}});
  auto& component = alone.component;
  ASSERT_EQ(component.on_configure(), CallbackReturn::success) << component.reason();
  ASSERT_EQ(component.on_activate(), CallbackReturn::success) << component.reason();
  std::vector<double> states(component.state_interfaces().size()),
      commands(component.command_interfaces().size(), std::nan(""));
  hardware::Cycle cycle{0, 4'000'000, 0};
  component.write(cycle, commands);
  for (int i = 0; i < 4000 && component.cause() == Cause::none; ++i) component.await_cycle(100'000'000);
  EXPECT_EQ(component.cause(), Cause::loop_silent) << component.reason();
  EXPECT_EQ(component.read(cycle, states), ReturnType::error);
  component.on_error();
  EXPECT_FALSE(alone.far.with([](kuka::Machine& m) { return m.rsi(); }));
}

TEST(KukaForward, SilenceOfTheControllerIsNamed) {
  ForwardRig rig(Parameters{{"answer_ms", "1000"}});
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  ASSERT_TRUE(rig.moves->accept(rig.turn(1)));
  ASSERT_TRUE(rig.passes(50));
  rig.far().order("mute");
  for (int i = 0; i < 50 && rig.component.cause() == Cause::none; ++i) rig.pass();
  EXPECT_EQ(rig.component.cause(), Cause::eki_silent) << rig.component.reason();
  expect_standing(rig);
}

class KukaForwardWhileMoving : public testing::TestWithParam<FaultRow> {};
INSTANTIATE_TEST_SUITE_P(Faults, KukaForwardWhileMoving,
                         testing::Values(FaultRow{"e_stop", Cause::emergency_stop, "release the button"},
                                         FaultRow{"guard_open", Cause::guard_stop, "guard"},
                                         FaultRow{"t1", Cause::manual_mode, "mode T1"},
                                         FaultRow{"aut", Cause::drives_off, "drives"},
                                         FaultRow{"drives_off", Cause::drives_off, "switch them on"},
                                         FaultRow{"stop", Cause::program_stopped, "was stopped there"},
                                         FaultRow{"cancel", Cause::program_ended, "deselected"},
                                         FaultRow{"collision", Cause::message, "read it at its smartPAD"},
                                         FaultRow{"nonsense", Cause::eki_bad_data,
                                                  "no message of PolyarmEki"},
                                         FaultRow{"close_eki", Cause::eki_closed, "closed the connection"},
                                         FaultRow{"refuse_moves", Cause::moves_refused, "takes no move"},
                                         FaultRow{"power_off", Cause::eki_closed, "switched off"}),
                         fault_name<Cause>);

TEST_P(KukaForwardWhileMoving, IsNamedStandsAndMovesNothingWhenItIsRecovered) {
  ForwardRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  for (int i = 0; i < 8; ++i) ASSERT_TRUE(rig.moves->accept(rig.turn(i % 2 ? -0.3 : 0.3)));
  ASSERT_TRUE(rig.passes(60));
  rig.far().order(GetParam().order);
  bool failed = false;
  for (int i = 0; i < 3000 && !failed; ++i) failed = rig.pass() == ReturnType::error;
  ASSERT_TRUE(failed);
  expect_named(rig, GetParam());
  expect_standing(rig);
  mend(rig.far());
  expect_standing(rig);
  rig.far().order("play");
  expect_standing(rig);  // nobody who presses Start sets it in motion
  ASSERT_TRUE(rig.configure()) << rig.component.reason();
  expect_standing(rig);
  rig.forget_jumps();
  const Six before = rig.q();
  ASSERT_TRUE(rig.activate()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(200));
  EXPECT_TRUE(rig.moves->flow().idle) << "what was left is forgotten";
  EXPECT_LE(rig.largest_jump(), 1e-6);
  for (std::size_t j = 0; j < 6; ++j) EXPECT_NEAR(rig.q()[j], before[j], 1e-6);
}

TEST(KukaForward, AHaltThatTheProgramDoesNotConfirmIsNamed) {
  ForwardRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  ASSERT_TRUE(rig.moves->accept(rig.turn(1)));
  ASSERT_TRUE(rig.passes(60));
  rig.far().order("silent_halts");
  bool failed = false;
  for (int i = 0; i < 6000 && !failed; ++i) failed = rig.pass(0) == ReturnType::error;
  ASSERT_TRUE(failed);
  EXPECT_EQ(rig.component.cause(), Cause::halt_unconfirmed) << rig.component.reason();
  expect_standing(rig);
}

/// Faults drawn at random, before, during and after moves, pauses and clears. POLYARM_FAULT_ROUNDS: how many.
TEST(KukaForwardFaults, DrawnAtRandomTheyAreAlwaysNamedAndNothingJumpsOrGoesOnByItself) {
  constexpr const char* kOrders[] = {"e_stop",  "guard_open",  "t1",           "t2",        "aut",
                                     "cancel",  "drives_off",  "stop",         "collision", "nonsense",
                                     "busy",    "close_eki",   "refuse_moves", "power_off", "refuse_drives",
                                     "old_rsi", "refuse_start"};
  const int rounds = fault_rounds(30);
  Draw draw(31);
  ForwardRig rig;
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
      const int moves = static_cast<int>(1 + draw(9)), until = static_cast<int>(draw(200));
      for (int i = 0; i < moves; ++i)
        rig.moves->accept(rig.turn(i % 2 ? -0.2 : 0.2, draw(2) && i + 1 < moves ? 0.02 : 0));
      const double pace = draw(3) == 0 ? 0 : 1;
      bool alive = true;
      for (int i = 0; alive && i < until; ++i) alive = rig.pass() == ReturnType::ok;
      if (alive && draw(4) == 0) rig.moves->clear();
      if (alive) rig.far().order(order);
      for (int i = 0; alive && i < 150; ++i) alive = rig.pass(pace) == ReturnType::ok;
    } else {
      for (std::size_t j = 0; j < 6; ++j) EXPECT_NEAR(rig.q()[j], before[j], 1e-6) << order;
    }
    if (rig.component.cause() != Cause::none) {
      ++named;
      EXPECT_GT(rig.component.reason().size(), 30u) << order;
    }
    EXPECT_LE(rig.largest_jump(), 6 * 0.004) << order;  // rad in 4 ms, of the fastest axis
    rig.component.on_error();
    expect_standing(rig);
    mend(rig.far());
    expect_standing(rig);
  }
  EXPECT_GT(named, rounds / 3);
}

}  // namespace
}  // namespace polyarm
