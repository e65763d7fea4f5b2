/// Forward mode: the controller interpolates, the driver sends moves and follows.
#include <cmath>

#include "drivers/wire/arcs.hpp"
#include "tests/support/realtime_guard.hpp"
#include "tests/support/wire_faults.hpp"
#include "tests/ur/forward_rig.hpp"

namespace polyarm {
namespace {

using hardware::ForwardFlow;
using hardware::ForwardMove;
using namespace test;

constexpr double kStandsWithin = 2e-4;  // rad: a robot that moves by less counts as standing

TEST(UrForward, NothingMovesBeforeAMoveIsHandedOver) {
  ForwardRig rig;
  const ur::Six before = rig.q();
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(100));
  EXPECT_TRUE(rig.moves->flow().standing);
  EXPECT_TRUE(rig.moves->flow().idle);
  EXPECT_EQ(rig.q(), before);
}

TEST(UrForward, JointMovesAndLinesEndWhereTheyShould) {
  ForwardRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  ASSERT_TRUE(rig.moves->accept(rig.turn(0.4)));
  ASSERT_TRUE(rig.moves->accept(rig.shift({0, 0.05, -0.1})));
  EXPECT_FALSE(rig.moves->flow().idle);
  ASSERT_TRUE(rig.passes_until([&] { return rig.done(); }));
  for (std::size_t j = 0; j < 6; ++j) EXPECT_NEAR(rig.q()[j], (*rig.target)[j], 1e-4) << j;
}

TEST(UrForward, ALineIsStraight) {
  ForwardRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  const Vec3 from = rig.place();
  ASSERT_TRUE(rig.moves->accept(rig.shift({0, 0.15, -0.2})));
  const Vec3 way = normalized(Vec3{0, 0.15, -0.2});
  double off = 0;
  ASSERT_TRUE(rig.passes_until([&] {
    const Vec3 gone = rig.place() - from;
    off = std::max(off, norm(gone - dot(gone, way) * way));
    return rig.done();
  }));
  EXPECT_LT(off, 1e-4);
}

TEST(UrForward, AnArcPassesItsPoint) {
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

TEST(UrForward, ABlendLeavesTheCornerByNoMoreThanItsRadiusAndSavesTime) {
  const auto run = [](double blend, double& off) {
    ForwardRig rig;
    EXPECT_TRUE(rig.start()) << rig.component.reason();
    EXPECT_TRUE(rig.passes(5));
    const ForwardMove first = rig.shift({0, 0, -0.15}, blend);
    rig.moves->accept(first);
    rig.moves->accept(rig.shift({0, 0.15, 0}));
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
  EXPECT_LT(exact, 1e-4);
  EXPECT_GT(rounded, 1e-3);
  EXPECT_LE(rounded, 0.04);
  EXPECT_LT(fast, slow);
}

TEST(UrForward, APauseStopsOnThePathAndGoesOnFromThere) {
  ForwardRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  const Vec3 from = rig.place();
  ASSERT_TRUE(rig.moves->accept(rig.shift({0, 0, -0.2})));
  ASSERT_TRUE(rig.passes(250));
  EXPECT_FALSE(rig.moves->flow().standing);
  ASSERT_TRUE(rig.passes_until([&] { return rig.moves->flow().standing; }, 0, 500));
  const ur::Six at = rig.q();
  ASSERT_TRUE(rig.passes(300, 0));
  for (std::size_t j = 0; j < 6; ++j) EXPECT_NEAR(rig.q()[j], at[j], kStandsWithin);
  EXPECT_FALSE(rig.moves->flow().idle) << "the rest of the move is still to do";
  EXPECT_NEAR(rig.place().x, from.x, 1e-4);
  EXPECT_NEAR(rig.place().y, from.y, 1e-4);
  EXPECT_LT(rig.place().z, from.z - 0.005);
  EXPECT_GT(rig.place().z, from.z - 0.195);
  ASSERT_TRUE(rig.passes_until([&] { return rig.done(); }));
  EXPECT_NEAR(rig.place().z, from.z - 0.2, 1e-4);
}

TEST(UrForward, APausedRobotDoesNotMoveWhenSomebodyRaisesTheSliderAtThePendant) {
  ForwardRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  ASSERT_TRUE(rig.moves->accept(rig.turn(1)));
  ASSERT_TRUE(rig.passes(250));
  ASSERT_TRUE(rig.passes_until([&] { return rig.moves->flow().standing; }, 0, 500));
  const ur::Six at = rig.q();
  rig.far().with([](ur::Machine& machine) {
    machine.input("speed_slider_mask", 1);
    machine.input("speed_slider_fraction", 1);
    machine.apply_inputs();
    return 0;
  });
  ASSERT_TRUE(rig.passes(500, 0));
  EXPECT_EQ(rig.q(), at);
}

TEST(UrForward, APauseInAnArcGoesOnOnTheArc) {
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

TEST(UrForward, AfterClearTheRobotStandsAndTakesOtherMoves) {
  ForwardRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(rig.moves->accept(rig.turn(i % 2 ? -0.3 : 0.3)));
  ASSERT_TRUE(rig.passes(100));
  rig.moves->clear();
  EXPECT_FALSE(rig.moves->accept(rig.turn(0.1))) << "not before it is done";
  ASSERT_TRUE(rig.passes_until([&] { return rig.moves->flow().idle && rig.moves->flow().standing; }, 1, 600));
  const ur::Six at = rig.q();
  ASSERT_TRUE(rig.passes(300));
  for (std::size_t j = 0; j < 6; ++j) EXPECT_NEAR(rig.q()[j], at[j], kStandsWithin);
  rig.target.reset();
  ASSERT_TRUE(rig.moves->accept(rig.turn(0.1)));
  ASSERT_TRUE(rig.passes_until([&] { return rig.done(); }));
  EXPECT_NEAR(rig.q()[0], at[0] + 0.1, 1e-3);
}

TEST(UrForward, ThePaceIsTheSpeedSliderAndIsGivenBack) {
  const auto cycles_at = [](double pace) {
    ForwardRig rig;
    EXPECT_TRUE(rig.start()) << rig.component.reason();
    EXPECT_TRUE(rig.passes(5));
    rig.moves->accept(rig.turn(0.8));
    int cycles = 0;
    EXPECT_TRUE(rig.passes_until([&] { return ++cycles, rig.done(); }, pace));
    EXPECT_NEAR(rig.state("controller/speed_slider"), pace, 1e-9);
    rig.component.on_deactivate();
    for (int i = 0; i < 100 && rig.slider() != 1; ++i) rig.far().step();
    EXPECT_EQ(rig.slider(), 1) << "for other programs";
    return cycles;
  };
  const int full = cycles_at(1), half = cycles_at(0.5);
  EXPECT_GT(half, 1.7 * full);
  EXPECT_LT(half, 2.3 * full);
}

TEST(UrForward, AfterAFaultInAHoldTheSliderIsGivenBackOnceAProgramEndsInOrder) {
  ForwardRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  ASSERT_TRUE(rig.moves->accept(rig.turn(0.8)));
  ASSERT_TRUE(rig.passes(200));
  ASSERT_TRUE(rig.passes_until([&] { return rig.moves->flow().standing; }, 0, 500));
  EXPECT_EQ(rig.slider(), 0);
  rig.far().order("program_stop");
  for (int i = 0; i < 100 && rig.component.cause() == Cause::none; ++i) rig.pass(0);
  EXPECT_EQ(rig.component.cause(), Cause::program_stopped) << rig.component.reason();
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5, 0));
  rig.component.on_deactivate();
  rig.far().step();
  EXPECT_EQ(rig.slider(), 1);
}

TEST(UrForward, ManyMovesPassThroughTheQueueInOrder) {
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

TEST(UrForward, JointsKeepTheirLimitsOnALineThatNeedsThem) {
  ForwardRig rig(Parameters{{"line_acceleration", "20"}});
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  ForwardMove line = rig.shift({-0.25, -0.3, 0});
  line.speed = 10;
  ASSERT_TRUE(rig.moves->accept(line));
  double most = 0;
  ASSERT_TRUE(rig.passes_until([&] {
    for (std::size_t j = 0; j < 6; ++j)
      most = std::max(most, std::abs(rig.states[4 * j + 1]) / ur::facts_of(ur_model()).velocity[j]);
    return rig.done();
  }));
  EXPECT_GT(most, 0.5);
  EXPECT_LE(most, 1.0);
}

TEST(UrForward, AControllerThatCommandsJointsIsRefused) {
  ForwardRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  const ur::Six before = rig.q();
  rig.commands[1] += 0.3;
  EXPECT_EQ(rig.component.write(rig.cycle, rig.commands), ReturnType::error);
  EXPECT_EQ(rig.component.cause(), Cause::joint_commands);
  EXPECT_NE(rig.component.reason().find("takes only moves"), std::string::npos) << rig.component.reason();
  rig.component.on_error();
  rig.expect_standing();
  EXPECT_EQ(rig.q(), before);
}

TEST(UrForward, WithoutTheSpeedSliderItIsRefused) {
  ur::FakeUr component;
  EXPECT_THROW(component.on_init(ur_context({{"motion", "forward"}, {"io", "false"}})), Error);
}

/// The controller's clock runs by itself, as a robot's does.
TEST(UrForward, OnAFreeClockMovesArriveAndTheLoopNeitherAllocatesNorLocks) {
  ForwardAlone alone({{"watchdog_ms", "5000"}, {"silence_ms", "10000"}});
  ASSERT_TRUE(alone.start()) << alone.component.reason();
  hardware::ForwardMoves& moves = *alone.component.forward_moves(hardware::kForwardLayout);
  EXPECT_EQ(alone.component.forward_moves(0), nullptr) << "for a module that was built with other types";
  const ForwardMove move = alone.turn(0.1);
  std::string violations;
  bool fine = true, accepted = false, done = false;
  for (int i = 0; i < 5000 && fine && !done; ++i) {
    alone.component.await_cycle(1'000'000'000);
    alone.cycle.time += alone.cycle.period;
    const RealtimeGuard guard;
    moves.set_pace(1);
    fine = alone.component.read(alone.cycle, alone.states) == ReturnType::ok &&
           alone.component.write(alone.cycle, alone.commands) == ReturnType::ok;
    accepted = accepted || moves.accept(move);
    const ForwardFlow flow = moves.flow();
    done = accepted && flow.idle && flow.standing && flow.done == 1;
    if (violations.empty()) violations = guard.violations();
  }
  EXPECT_TRUE(fine) << alone.component.reason();
  EXPECT_TRUE(done);
  EXPECT_EQ(violations, "");
  EXPECT_NEAR(alone.states[0], move.joints[0], 1e-3);
}

TEST(UrForward, ALoopThatFallsSilentIsNamedAndTheRobotStops) {
  ForwardAlone alone({{"watchdog_ms", "200"}, {"silence_ms", "10000"}});
  ASSERT_TRUE(alone.start()) << alone.component.reason();
  alone.component.write(alone.cycle, alone.commands);
  for (int i = 0; i < 4000 && alone.component.cause() == Cause::none; ++i)
    alone.component.await_cycle(100'000'000);
  EXPECT_TRUE(alone.component.cause() == Cause::loop_silent ||
              alone.component.cause() == Cause::commands_late)
      << alone.component.reason();
  EXPECT_EQ(alone.component.read(alone.cycle, alone.states), ReturnType::error);
  alone.component.on_error();
  expect_standing_of(alone.far);
}

/// As after `kill -9`: the socket closes while moves wait at the controller.
TEST(UrForward, WhenTheConnectionEndsTheControllerStops) {
  FarSide far(far_options());
  std::string why;
  const Descriptor listener = wire::listen_tcp("127.0.0.1", 0, why);
  const Descriptor primary = wire::connect_tcp("127.0.0.1", far.primary_port(), 5'000'000'000, why);
  ur::ScriptSettings script;
  script.host = "127.0.0.1";
  script.port = wire::local_port(listener.number());
  ASSERT_TRUE(wire::send_frame(primary.number(), ur::move_program_text(script)));
  ASSERT_TRUE(wire::wait_readable(listener.number(), 10'000'000'000));
  Descriptor stream = wire::accept_tcp(listener.number());
  ASSERT_TRUE(stream);
  far.hold_clock(true);
  const auto at = [&] { return far.with([](ur::Machine& machine) { return machine.q(); }); };
  const ur::Six start = at();
  ur::MoveMessage move;
  move.work = ur::Work::joint;
  move.timeout_ms = 5000;
  move.speed = 1, move.acceleration = 10;
  for (int k = 1; k <= 4; ++k) {
    move.sequence = move.number = k;
    move.goal = start;
    move.goal[0] += k % 2 ? 1.0 : 0.5;
    ASSERT_TRUE(wire::send_frame(stream.number(), ur::encode(move)));
  }
  ASSERT_TRUE(far.step(4));
  for (int i = 0; i < 150; ++i) far.step();
  EXPECT_GT(std::abs(at()[0] - start[0]), 0.1);
  stream = Descriptor();
  const auto state = [&] {
    return far.with([](ur::Machine& machine) { return machine.value("output_int_register_25").front(); });
  };
  while (state() != static_cast<int>(ur::ScriptState::timed_out)) std::this_thread::yield();
  expect_standing_of(far);
  EXPECT_LT(std::abs(at()[0] - start[0]), 0.8) << "not the end of the first move";
}

TEST(UrForward, AProgramDoesNotGoOnWhenASafeguardStopEnds) {
  ForwardRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(rig.moves->accept(rig.turn(i % 2 ? -0.3 : 0.3)));
  ASSERT_TRUE(rig.passes(100));
  rig.far().order("deaf");  // it reads no more that it shall end
  rig.far().order("safeguard_stop");
  bool failed = false;
  for (int i = 0; i < 2000 && !failed; ++i) failed = rig.pass() == ReturnType::error;
  ASSERT_TRUE(failed);
  EXPECT_EQ(rig.component.cause(), Cause::safeguard_stop) << rig.component.reason();
  rig.expect_standing();
  const ur::Six at = rig.q();
  rig.far().order("normal");
  rig.expect_standing();
  EXPECT_EQ(rig.q(), at);
}

class UrForwardWhileMoving : public testing::TestWithParam<FaultOf<Cause>> {};
INSTANTIATE_TEST_SUITE_P(
    Faults, UrForwardWhileMoving,
    testing::Values(FaultOf<Cause>{"protective_stop", Cause::protective_stop, "protective stop"},
                    FaultOf<Cause>{"safeguard_stop", Cause::safeguard_stop, "safeguard stop"},
                    FaultOf<Cause>{"emergency_stop", Cause::emergency_stop, "release the button"},
                    FaultOf<Cause>{"violation", Cause::safety_fault, "VIOLATION"},
                    FaultOf<Cause>{"power_off", Cause::robot_mode, "switched off"},
                    FaultOf<Cause>{"program_stop", Cause::program_stopped, "was stopped there"},
                    FaultOf<Cause>{"program_pause", Cause::program_paused, "was paused there"},
                    FaultOf<Cause>{"close_rtde", Cause::rtde_closed, "closed the RTDE connection"},
                    FaultOf<Cause>{"garbage", Cause::bad_data, "no RTDE"},
                    FaultOf<Cause>{"dead", Cause::rtde_closed, "switched off"},
                    FaultOf<Cause>{"deaf", Cause::not_reading, "does not read its commands"}),
    fault_name<Cause>);

TEST_P(UrForwardWhileMoving, IsNamedStandsAndMovesNothingWhenItIsRecovered) {
  ForwardRig rig(Parameters{{"watchdog_ms", "200"}});
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  for (int i = 0; i < 6; ++i) ASSERT_TRUE(rig.moves->accept(rig.turn(i % 2 ? -0.3 : 0.3)));
  ASSERT_TRUE(rig.passes(200));
  rig.far().order(GetParam().order);
  bool failed = false;
  for (int i = 0; i < 2000 && !failed; ++i) failed = rig.pass() == ReturnType::error;
  ASSERT_TRUE(failed);
  EXPECT_EQ(rig.component.cause(), GetParam().cause) << rig.component.reason();
  const std::string said = rig.component.reason();
  EXPECT_NE(said.find(GetParam().words), std::string::npos) << said;
  rig.expect_standing();
  mend(rig.far());
  rig.expect_standing();
  ASSERT_TRUE(rig.configure()) << rig.component.reason();
  rig.expect_standing();
  rig.forget_jumps();
  const ur::Six before = rig.q();
  ASSERT_TRUE(rig.activate()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(200));
  EXPECT_TRUE(rig.moves->flow().idle) << "what was left is forgotten";
  EXPECT_LE(rig.largest_jump(), 1e-6);
  for (std::size_t j = 0; j < 6; ++j) EXPECT_NEAR(rig.q()[j], before[j], 1e-6);
}

/// Faults drawn at random, before, during and after moves, pauses and clears. POLYARM_FAULT_ROUNDS: how many.
TEST(UrForwardFaults, DrawnAtRandomTheyAreAlwaysNamedAndNothingJumpsOrGoesOnByItself) {
  constexpr const char* kOrders[] = {"protective_stop", "safeguard_stop", "emergency_stop", "violation",
                                     "power_off",       "program_stop",   "program_pause",  "close_rtde",
                                     "garbage",         "dead",           "local",          "close_stream"};
  const int rounds = fault_rounds(30);
  Draw draw(30);
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
    const ur::Six before = rig.q();
    if (rig.component.cause() == Cause::none && rig.activate()) {
      rig.target.reset();
      const int moves = static_cast<int>(1 + draw(9)), until = static_cast<int>(draw(300));
      for (int i = 0; i < moves; ++i)
        rig.moves->accept(rig.turn(i % 2 ? -0.2 : 0.2, draw(2) && i + 1 < moves ? 0.02 : 0));
      const double pace = draw(3) == 0 ? 0 : 1;
      bool alive = true;
      for (int i = 0; alive && i < until; ++i) alive = rig.pass() == ReturnType::ok;
      if (alive && draw(4) == 0) rig.moves->clear();
      if (alive) rig.far().order(order);
      for (int i = 0; alive && i < 200; ++i) alive = rig.pass(pace) == ReturnType::ok;
    } else {
      for (std::size_t j = 0; j < 6; ++j) EXPECT_NEAR(rig.q()[j], before[j], 1e-6) << order;
    }
    if (rig.component.cause() != Cause::none) {
      ++named;
      EXPECT_GT(rig.component.reason().size(), 30u) << order;
    }
    EXPECT_LE(rig.largest_jump(), 0.008) << order;  // rad in 2 ms
    rig.component.on_error();
    rig.expect_standing();
    mend(rig.far());
    rig.expect_standing();
  }
  EXPECT_GT(named, rounds / 2);
}

}  // namespace
}  // namespace polyarm
