/// Forward mode: the controller interpolates, the driver writes moves into the variables of its job and
/// follows.
#include <fmt/format.h>

#include <cmath>
#include <thread>

#include "drivers/wire/arcs.hpp"
#include "tests/support/realtime_guard.hpp"
#include "tests/support/wire_faults.hpp"
#include "tests/yaskawa/forward_rig.hpp"

namespace polyarm {
namespace {

using hardware::ForwardFlow;
using hardware::ForwardMove;
using namespace test;
using Rig = YaskawaForwardRig;

TEST(YaskawaForward, NothingMovesBeforeAMoveIsHandedOver) {
  Rig rig;
  const Six before = rig.q();
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(60));
  EXPECT_TRUE(rig.moves->flow().standing);
  EXPECT_TRUE(rig.moves->flow().idle);
  EXPECT_EQ(rig.q(), before);
  EXPECT_EQ(rig.state("controller/running"), 1) << "the job waits for moves";
}

TEST(YaskawaForward, JointMovesAndLinesEndWhereTheyShould) {
  Rig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  ASSERT_TRUE(rig.moves->accept(rig.turn(0.4)));
  ASSERT_TRUE(rig.moves->accept(rig.shift({0, 0.05, 0.1})));
  EXPECT_FALSE(rig.moves->flow().idle);
  ASSERT_TRUE(rig.passes_until([&] { return rig.done(); }, 1, 1000));
  expect_at(rig, *rig.target, 1e-4);
}

TEST(YaskawaForward, ALineIsStraight) {
  Rig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  const Vec3 from = rig.place();
  ASSERT_TRUE(rig.moves->accept(rig.shift({0, -0.1, -0.08})));
  const Vec3 way = normalized(Vec3{0, -0.1, -0.08});
  double off = 0;
  ASSERT_TRUE(rig.passes_until(
      [&] {
        const Vec3 gone = rig.place() - from;
        off = std::max(off, norm(gone - dot(gone, way) * way));
        return rig.done();
      },
      1, 1000));
  EXPECT_LT(off, 2e-4);
}

TEST(YaskawaForward, AToolThatOnlyTurnsTakesItsTime) {
  Rig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(20));
  ForwardMove turn = rig.turn(0);
  turn.joints[5] += 0.5;
  turn.at = yaskawa_chain().forward(std::span(turn.joints).first(6));
  turn.kind = ForwardMove::Kind::line;
  turn.speed = 0;
  turn.duration = 1.5;
  ASSERT_TRUE(rig.moves->accept(turn));
  int cycles = 0;
  ASSERT_TRUE(rig.passes_until([&] { return ++cycles, rig.done(); }, 1, 1000));
  EXPECT_NEAR(rig.q()[5], turn.joints[5], 1e-4);
  EXPECT_GT(cycles * 0.016, 1.3);
  EXPECT_LT(cycles * 0.016, 2.2);
}

TEST(YaskawaForward, AnArcPassesItsPoint) {
  Rig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  const ForwardMove arc = rig.arc();
  ASSERT_TRUE(rig.moves->accept(arc));
  double nearest = 1;
  ASSERT_TRUE(rig.passes_until(
      [&] {
        nearest = std::min(nearest, norm(rig.place() - arc.via.position));
        return rig.done();
      },
      1, 1000));
  EXPECT_LT(nearest, 0.004);
  EXPECT_LT(norm(rig.place() - arc.at.position), 1e-4);
}

/// The Ethernet server takes one move after the other, and its robot stops at each.
TEST(YaskawaForward, ABlendBecomesAStopAtTheCorner) {
  Rig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  const ForwardMove first = rig.shift({0, 0, -0.1}, 0.04);
  ASSERT_TRUE(rig.moves->accept(first));
  ASSERT_TRUE(rig.moves->accept(rig.shift({0, -0.1, 0})));
  double off = 1;
  ASSERT_TRUE(rig.passes_until(
      [&] {
        off = std::min(off, norm(rig.place() - first.at.position));
        return rig.done();
      },
      1, 1000));
  EXPECT_LT(off, 2e-4);
  expect_at(rig, *rig.target, 1e-4);
}

TEST(YaskawaForward, APauseStopsOnThePathAndGoesOnFromThere) {
  Rig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  const Vec3 from = rig.place();
  ASSERT_TRUE(rig.moves->accept(rig.shift({0, 0, -0.2})));
  ASSERT_TRUE(rig.passes_until([&] { return rig.place().z < from.z - 0.04; }, 1, 200));
  EXPECT_FALSE(rig.moves->flow().standing);
  ASSERT_TRUE(rig.passes_until([&] { return rig.moves->flow().standing; }, 0, 200));
  const Six at = rig.q();
  ASSERT_TRUE(rig.passes(100, 0));
  expect_at(rig, at, kStandsWithin);
  EXPECT_FALSE(rig.moves->flow().idle) << "the rest of the move is still to do";
  EXPECT_NEAR(rig.place().x, from.x, 2e-4);
  EXPECT_NEAR(rig.place().y, from.y, 2e-4);
  EXPECT_GT(rig.place().z, from.z - 0.195);
  ASSERT_TRUE(rig.passes_until([&] { return rig.done(); }, 1, 1000));
  EXPECT_NEAR(rig.place().z, from.z - 0.2, 1e-4);
}

TEST(YaskawaForward, APausedRobotDoesNotMoveWhenSomebodyStartsItsJob) {
  Rig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  ASSERT_TRUE(rig.moves->accept(rig.turn(1)));
  ASSERT_TRUE(rig.passes(15));
  ASSERT_TRUE(rig.passes_until([&] { return rig.moves->flow().standing; }, 0, 200));
  const Six at = rig.q();
  EXPECT_LT(at[0], 1.2) << "it has not come to its end";
  rig.far().order("unhold");
  EXPECT_TRUE(rig.far().with([](yaskawa::Machine& machine) { return machine.start_job(); }));
  for (int i = 0; i < 100; ++i) rig.far().step();
  expect_at(rig, at, kStandsWithin);
}

/// From one reading to the next it moves so little that it seems to stand while it still slows down.
TEST(YaskawaForward, APauseOfAVerySlowMoveIsNoFault) {
  Rig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  ForwardMove slow = rig.turn(1.4);
  slow.share = 1e-4;
  ASSERT_TRUE(rig.moves->accept(slow));
  ASSERT_TRUE(rig.passes(30));
  ASSERT_TRUE(rig.passes_until([&] { return rig.moves->flow().standing; }, 0, 200));
  const Six at = rig.q();
  ASSERT_TRUE(rig.passes(60, 0));
  expect_at(rig, at, kStandsWithin);
  EXPECT_FALSE(rig.moves->flow().idle) << "the rest of the move is still to do";
}

TEST(YaskawaForward, APauseInAnArcGoesOnOnTheArc) {
  Rig rig;
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
      [&] { return look(), circle.angle_of(rig.place()) > 1 && norm(rig.place() - from) > 0.05; }, 1, 1000));
  ASSERT_TRUE(rig.passes_until([&] { return look(), rig.moves->flow().standing; }, 0, 200));
  ASSERT_TRUE(rig.passes_until([&] { return look(), rig.done(); }, 1, 1000));
  EXPECT_LT(off, 1e-3);
  EXPECT_LT(norm(rig.place() - arc.at.position), 1e-4);
}

TEST(YaskawaForward, AfterClearTheRobotStandsAndTakesOtherMoves) {
  Rig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(rig.moves->accept(rig.turn(i % 2 ? -0.6 : 0.6)));
  ASSERT_TRUE(rig.passes(15));
  rig.moves->clear();
  EXPECT_FALSE(rig.moves->accept(rig.turn(0.1))) << "not before it is done";
  ASSERT_TRUE(rig.passes_until([&] { return rig.moves->flow().idle && rig.moves->flow().standing; }, 1, 300));
  const Six at = rig.q();
  ASSERT_TRUE(rig.passes(100));
  expect_at(rig, at, kStandsWithin);
  rig.target.reset();
  ASSERT_TRUE(rig.moves->accept(rig.turn(0.1)));
  ASSERT_TRUE(rig.passes_until([&] { return rig.done(); }, 1, 1000));
  EXPECT_NEAR(rig.q()[0], at[0] + 0.1, 1e-3);
}

TEST(YaskawaForward, AMoveHasThePaceAndAnotherPaceTakesEffectInItsMiddle) {
  const auto cycles_at = [](double pace, double then) {
    Rig rig;
    EXPECT_TRUE(rig.start()) << rig.component.reason();
    EXPECT_TRUE(rig.passes(5));
    rig.moves->accept(rig.turn(1.5));
    EXPECT_TRUE(rig.passes(20, pace));
    int cycles = 0;
    EXPECT_TRUE(rig.passes_until([&] { return ++cycles, rig.done(); }, then, 2000));
    expect_at(rig, *rig.target, 1e-4);
    return cycles;
  };
  const int full = cycles_at(1, 1), slow = cycles_at(0.2, 0.2), lowered = cycles_at(1, 0.2),
            raised = cycles_at(0.2, 1);
  EXPECT_GT(slow, 3 * full);
  EXPECT_GT(lowered, 2 * full) << "it does not end at full speed";
  EXPECT_LT(raised, 0.8 * slow) << "it does not end slowly";
}

TEST(YaskawaForward, DeactivatingWhileItMovesStopsTheRobotAndForgetsItsMoves) {
  Rig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  for (int i = 0; i < 4; ++i) ASSERT_TRUE(rig.moves->accept(rig.turn(i % 2 ? -0.8 : 0.8)));
  ASSERT_TRUE(rig.passes(20));
  EXPECT_EQ(rig.component.on_deactivate(), CallbackReturn::success);
  EXPECT_EQ(rig.component.cause(), Cause::none) << rig.component.reason();
  EXPECT_FALSE(rig.far().with([](yaskawa::Machine& m) { return m.panel().holds(); })) << "for other jobs";
  expect_standing(rig, 50);
  const Six at = rig.q();
  ASSERT_TRUE(rig.activate()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(60));
  EXPECT_TRUE(rig.moves->flow().idle);
  expect_at(rig, at, 1e-6);
}

TEST(YaskawaForward, ManyMovesPassThroughTheVariablesInOrder) {
  Rig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  for (int i = 0; i < 20; ++i)
    ASSERT_TRUE(rig.moves->accept(rig.turn(i % 2 ? -0.05 : 0.06, i % 3 && i < 19 ? 0.01 : 0)));
  std::uint64_t last = 0;
  ASSERT_TRUE(rig.passes_until(
      [&] {
        EXPECT_GE(rig.moves->flow().done, last);
        last = rig.moves->flow().done;
        return rig.done();
      },
      1, 4000));
  EXPECT_EQ(last, 20u);
}

TEST(YaskawaForward, AnswersThatGetLostChangeNothing) {
  Rig rig(Parameters{{"answer_ms", "300"}});
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  ASSERT_TRUE(rig.moves->accept(rig.turn(0.3)));
  rig.far().order("hses_lost=1");
  ASSERT_TRUE(rig.passes(10));
  rig.far().order("hses_twice");
  ASSERT_TRUE(rig.passes_until([&] { return rig.done(); }, 1, 1000));
  expect_at(rig, *rig.target, 1e-4);
}

TEST(YaskawaForward, OutputsAreSwitchedByTheJobAndInputsAreRead) {
  Rig rig(Parameters{{"wires", "1=4"}});
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  for (int round = 0; round < 4; ++round) {
    rig.command("io/digital_out_1") = round % 2;
    rig.command("io/digital_out_2") = 1 - round % 2;
    ASSERT_TRUE(rig.passes(10));
    EXPECT_EQ(rig.state("io/digital_out_1"), round % 2) << round;
    EXPECT_EQ(rig.state("io/digital_out_2"), 1 - round % 2) << round;
    EXPECT_EQ(rig.state("io/digital_in_4"), round % 2) << "wired to output 1";
  }
  rig.command("io/digital_out_1") = 0;
  ASSERT_TRUE(rig.moves->accept(rig.turn(0.3)));
  bool early = false;
  const double from = rig.q()[0];
  ASSERT_TRUE(rig.passes_until(
      [&] {
        early = early || (std::abs(rig.q()[0] - from) > 1e-3 && rig.state("io/digital_out_1") == 1);
        return rig.done();
      },
      1, 1000));
  EXPECT_FALSE(early) << "an output before a move is switched before it";
}

TEST(YaskawaForward, AControllerThatCommandsJointsIsRefused) {
  Rig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  const Six before = rig.q();
  rig.commands[1] += 0.3;
  EXPECT_EQ(rig.component.write(rig.cycle, rig.commands), ReturnType::error);
  EXPECT_EQ(rig.component.cause(), Cause::joint_commands);
  EXPECT_NE(rig.component.reason().find("takes only moves"), std::string::npos) << rig.component.reason();
  rig.component.on_error();
  expect_standing(rig, 50);
  EXPECT_EQ(rig.q(), before);
}

TEST(YaskawaForward, WithoutPulsesOrTheEthernetServerItIsRefused) {
  yaskawa::YaskawaComponent component;
  const auto refused = [&](Parameters more) {
    Parameters all{{"host", "x"}, {"motion", "forward"}, {"pulses", "1500 1500 1500 1200 1200 800"}};
    for (auto& [name, value] : more) all[name] = value;
    EXPECT_THROW(component.on_init(yaskawa_context(all)), Error);
  };
  refused({{"pulses", ""}});
  refused({{"pulses", "1500 1500 1500 1200 1200"}});
  refused({{"pulses", "1500 1500 1500 1200 1200 0"}});
  refused({{"hses", "false"}});
  refused({{"motion", "sideways"}});
}

// --- on a clock of its own --------------------------------------------------------------------------------

/// The driver alone in forward mode. The timer of the ladder is so long that other load of this machine does
/// not end it; while the driver waits for it, the controller's clock is hurried.
class AloneForward : public Alone {
 public:
  explicit AloneForward(Parameters more = {}) : Alone(options(), forward(std::move(more))) {}
  bool begin() {
    if (!configure()) return false;
    std::jthread hurry([this](const std::stop_token& stop) {
      const auto held = [](yaskawa::Machine& m) { return m.panel().external_hold; };
      while (!stop.stop_requested() && !far.with(held)) {
        far.step();
        std::this_thread::sleep_for(std::chrono::microseconds(100));
      }
    });
    return component.on_activate() == CallbackReturn::success;
  }

 private:
  static FarSideOptions options() {
    FarSideOptions out = far_options();
    out.watchdog = 5;
    return out;
  }
  static Parameters forward(Parameters more) {
    more.merge(Parameters{{"motion", "forward"},
                          {"pulses", "1500 1500 1500 1200 1200 800"},
                          {"answer_ms", "20000"},
                          {"watchdog_ms", "10000"}});
    return more;
  }
};

/// The controller's clock runs by itself, as a robot's does.
TEST(YaskawaForward, OnAFreeClockMovesArriveAndTheLoopNeitherAllocatesNorLocks) {
  AloneForward alone;
  auto& component = alone.component;
  ASSERT_TRUE(alone.begin()) << component.reason();
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
  for (std::size_t j = 0; j < 6; ++j) move.joints[j] = states[3 * j];
  move.joints[0] += 0.1;
  move.at = yaskawa_chain().forward(std::span(move.joints).first(6));
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

TEST(YaskawaForward, ALoopThatFallsSilentIsNamedAndTheRobotIsStopped) {
  AloneForward alone(Parameters{{"loop_silence_ms", "100"}});
  auto& component = alone.component;
  ASSERT_TRUE(alone.begin()) << component.reason();
  std::vector<double> states(component.state_interfaces().size()),
      commands(component.command_interfaces().size(), std::nan(""));
  hardware::Cycle cycle{0, 4'000'000, 0};
  component.write(cycle, commands);
  for (int i = 0; i < 4000 && component.cause() == Cause::none; ++i) component.await_cycle(100'000'000);
  EXPECT_EQ(component.cause(), Cause::loop_silent) << component.reason();
  EXPECT_EQ(component.read(cycle, states), ReturnType::error);
  component.on_error();
  EXPECT_FALSE(alone.far.with([](yaskawa::Machine& m) { return m.runs(yaskawa::kMovesJob); }));
}

// --- the job ----------------------------------------------------------------------------------------------

TEST(YaskawaJob, UsesTheVariablesThatTheDriverWrites) {
  const std::string job = yaskawa::moves_job();
  using S = yaskawa::SharedDoubles;
  using M = yaskawa::SharedMove;
  const auto has = [&](const std::string& line) {
    EXPECT_NE(job.find(line + "\r\n"), std::string::npos) << line;
  };
  const auto d = [](int number) { return fmt::format("D{:03}", number); };
  has("JUMP *MOVE IF " + d(S::put) + ">" + d(S::ended));
  has("JUMP *OUTPUT IF " + d(S::output) + "<>" + d(S::output_done));
  has("SET " + d(S::session_here) + " " + d(S::session));
  has("SET " + d(S::version) + " " + std::to_string(yaskawa::kMovesJobVersion));
  for (const int odd : {0, 1})
    has(fmt::format("MOVJ P{:03} VJ=I{:03} PL=0 ACC=I{:03} DEC=I{:03}", M::end + odd * M::places,
                    M::speed + odd * M::integers, M::ramp + odd * M::integers, M::ramp + odd * M::integers));
  EXPECT_NO_THROW(yaskawa::parse_job(job));
  for (std::size_t at = 0; (at = job.find('\n', at)) != std::string::npos; ++at) EXPECT_EQ(job[at - 1], '\r');
}

TEST(YaskawaJob, LinesThatTheSimulationDoesNotKnowAreRefused) {
  EXPECT_THROW(yaskawa::parse_job("NOP\r\nCALL JOB:X\r\nEND\r\n"), Error);
  EXPECT_THROW(yaskawa::parse_job("NOP\r\nJUMP *NOWHERE\r\nEND\r\n"), Error);
  EXPECT_THROW(yaskawa::parse_job("NOP\r\n*A\r\n*A\r\nEND\r\n"), Error);
}

TEST(YaskawaJob, MovesHaveItsUnits) {
  forward::MoveFrame frame;
  frame.flange = std::make_shared<const kinematics::Chain>(yaskawa_chain());
  frame.velocity.fill(3);
  frame.acceleration.fill(10);
  forward::MoveOrder order;
  order.from = {0.1, 0.2, 0.1, 0.1, -0.8, 0.4};
  order.move.share = 0.25;
  order.move.acceleration = 0.5;
  order.pace = 0.5;
  const auto joint = yaskawa::job_move(order, frame);
  EXPECT_EQ(joint.kind, yaskawa::JobMove::joint);
  EXPECT_EQ(joint.speed, 1250) << "0.01 %";
  EXPECT_EQ(joint.ramp, 50);
  order.move.kind = ForwardMove::Kind::line;
  Six q = order.from;
  q[0] += 0.05;
  std::copy(q.begin(), q.end(), order.move.joints.begin());
  order.move.at = yaskawa_chain().forward(q);
  order.move.speed = 0.2;
  const auto line = yaskawa::job_move(order, frame);
  EXPECT_EQ(line.kind, yaskawa::JobMove::line);
  EXPECT_EQ(line.speed, 1000) << "0.1 mm/s";
  const Six pulses{1000, 1000, -1000, 1000, 1000, 1000};
  EXPECT_EQ(yaskawa::pulses_of({0.5, 0, 0.5, 0, 0, 0}, pulses)[0], 500);
  EXPECT_EQ(yaskawa::pulses_of({0.5, 0, 0.5, 0, 0, 0}, pulses)[2], -500);
}

}  // namespace
}  // namespace polyarm
