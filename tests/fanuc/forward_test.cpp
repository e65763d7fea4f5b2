/// Forward mode: the controller interpolates, the driver sends moves and follows.
#include <cmath>

#include "polyarm/base/text.hpp"
#include "tests/fanuc/rig.hpp"
#include "tests/support/forward_calls.hpp"
#include "tests/support/realtime_guard.hpp"

namespace polyarm {
namespace {

using hardware::ForwardFlow;
using hardware::ForwardMove;
using namespace test;

/// rad: the interface has 0.001 degrees, and a robot that moves by less between two readings counts as
/// standing.
constexpr double kStandsWithin = 2e-4;

/// The driver on its simulated controller, with moves for it.
class ForwardRig : public ForwardCalls<FanucRig> {
 public:
  using ForwardCalls::ForwardCalls;
  /// A joint move to where the robot is, with joint 1 moved by so much.
  ForwardMove turn(double by, double blend = 0) {
    ForwardMove out;
    out.id = ++id;
    Six q = target ? *target : this->q();
    q[0] += by;
    target = q;
    std::copy(q.begin(), q.end(), out.joints.begin());
    out.at = chain().forward(q);
    out.share = 0.5;
    out.speed = 0.5;
    out.blend = blend;
    out.stops = !(blend > 0);
    return out;
  }
  /// A line of the TCP by so much.
  ForwardMove shift(const Vec3& by, double blend = 0) {
    ForwardMove out;
    out.kind = ForwardMove::Kind::line;
    out.id = ++id;
    const Six from = target ? *target : q();
    Pose at = chain().forward(from);
    at.position = at.position + by;
    target = joints_at(at, from);
    std::copy(target->begin(), target->end(), out.joints.begin());
    out.at = at;
    out.speed = 0.25;
    out.blend = blend;
    out.stops = !(blend > 0);
    return out;
  }
  Six joints_at(const Pose& pose, const Six& seed) {
    return far().with([&](fanuc::Machine& machine) {
      Six degrees = seed;
      for (double& one : degrees) one /= kDegree;
      Pose flange = pose;
      flange.position.z -= machine.options().facts.world_height;
      Six out = *machine.joints_for(flange, degrees);
      for (double& one : out) one *= kDegree;
      return out;
    });
  }
  const kinematics::Chain& chain() {
    return *far().with([](fanuc::Machine& m) { return m.options().facts.chain; });
  }

  std::optional<Six> target;
};

void expect_standing_alone(FarSide& far) {
  const auto at = [&] { return far.with([](fanuc::Machine& machine) { return machine.q(); }); };
  far.hold_clock(true);
  for (int i = 0; i < 200; ++i) far.step();
  const Six stopped = at();
  for (int i = 0; i < 100; ++i) far.step();
  for (std::size_t j = 0; j < 6; ++j) EXPECT_NEAR(at()[j], stopped[j], 1e-6);
}

TEST(FanucForward, NothingMovesBeforeAMoveIsHandedOver) {
  ForwardRig rig;
  const Six before = rig.q();
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(50));
  EXPECT_TRUE(rig.moves->flow().standing);
  EXPECT_TRUE(rig.moves->flow().idle);
  EXPECT_EQ(rig.q(), before);
}

TEST(FanucForward, JointMovesAndLinesEndWhereTheyShould) {
  ForwardRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  ASSERT_TRUE(rig.moves->accept(rig.turn(0.4)));
  ASSERT_TRUE(rig.moves->accept(rig.shift({0.05, 0, 0.1})));
  EXPECT_FALSE(rig.moves->flow().idle);
  ASSERT_TRUE(rig.passes_until([&] { return rig.done(); }));
  for (std::size_t j = 0; j < 6; ++j) EXPECT_NEAR(rig.q()[j], (*rig.target)[j], 1e-3) << j;
}

TEST(FanucForward, AnArcPassesItsPoint) {
  ForwardRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  const Pose from = rig.chain().forward(rig.q());
  ForwardMove arc = rig.shift({0, -0.2, 0});
  arc.kind = ForwardMove::Kind::arc;
  arc.via = from;
  arc.via.position = from.position + Vec3{0, -0.1, 0.1};
  ASSERT_TRUE(rig.moves->accept(arc));
  double nearest = 1;
  ASSERT_TRUE(rig.passes_until([&] {
    nearest = std::min(nearest, norm(rig.chain().forward(rig.q()).position - arc.via.position));
    return rig.done();
  }));
  EXPECT_LT(nearest, 0.003);
  EXPECT_LT(norm(rig.chain().forward(rig.q()).position - arc.at.position), 1e-3);
}

TEST(FanucForward, ABlendLeavesTheCornerByNoMoreThanItsRadiusAndSavesTime) {
  const auto run = [](double blend, double& off) {
    ForwardRig rig;
    EXPECT_TRUE(rig.start()) << rig.component.reason();
    EXPECT_TRUE(rig.passes(5));
    const ForwardMove first = rig.shift({0, 0, 0.15}, blend);
    rig.moves->accept(first);
    rig.moves->accept(rig.shift({0, 0.2, 0}));
    int cycles = 0;
    off = 1;
    EXPECT_TRUE(rig.passes_until([&] {
      ++cycles;
      off = std::min(off, norm(rig.chain().forward(rig.q()).position - first.at.position));
      return rig.done();
    }));
    return cycles;
  };
  double exact = 0, rounded = 0;
  const int slow = run(0, exact), fast = run(0.02, rounded);
  EXPECT_LT(exact, 1e-3);
  EXPECT_GT(rounded, 1e-3);
  EXPECT_LE(rounded, 0.02);
  EXPECT_LT(fast, slow);
}

TEST(FanucForward, APauseStopsOnThePathAndGoesOnFromThere) {
  ForwardRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  ASSERT_TRUE(rig.moves->accept(rig.shift({0, 0, 0.2})));
  const Vec3 from = rig.chain().forward(rig.q()).position;
  ASSERT_TRUE(rig.passes(40));
  EXPECT_FALSE(rig.moves->flow().standing);
  ASSERT_TRUE(rig.passes_until([&] { return rig.moves->flow().standing; }, 0, 200));
  const Six at = rig.q();
  ASSERT_TRUE(rig.passes(200, 0));
  for (std::size_t j = 0; j < 6; ++j) EXPECT_NEAR(rig.q()[j], at[j], kStandsWithin);
  EXPECT_FALSE(rig.moves->flow().idle) << "the rest of the move is still to do";
  const Vec3 held = rig.chain().forward(at).position;
  EXPECT_NEAR(held.x, from.x, 1e-3);
  EXPECT_NEAR(held.y, from.y, 1e-3);
  EXPECT_GT(held.z, from.z + 0.005);
  EXPECT_LT(held.z, from.z + 0.195);
  ASSERT_TRUE(rig.passes_until([&] { return rig.done(); }));
  EXPECT_NEAR(rig.chain().forward(rig.q()).position.z, from.z + 0.2, 1e-3);
}

TEST(FanucForward, AfterClearTheRobotStandsAndTakesOtherMoves) {
  ForwardRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(rig.moves->accept(rig.turn(i % 2 ? -0.3 : 0.3)));
  ASSERT_TRUE(rig.passes(60));
  rig.moves->clear();
  EXPECT_FALSE(rig.moves->accept(rig.turn(0.1))) << "not before it is done";
  ASSERT_TRUE(rig.passes_until([&] { return rig.moves->flow().idle && rig.moves->flow().standing; }, 1, 300));
  const Six at = rig.q();
  ASSERT_TRUE(rig.passes(100));
  for (std::size_t j = 0; j < 6; ++j) EXPECT_NEAR(rig.q()[j], at[j], kStandsWithin);
  rig.target.reset();
  ASSERT_TRUE(rig.moves->accept(rig.turn(0.1)));
  ASSERT_TRUE(rig.passes_until([&] { return rig.done(); }));
  EXPECT_NEAR(rig.q()[0], at[0] + 0.1, 1e-3);
}

TEST(FanucForward, AClearInTheMiddleOfAMoveStopsThereAndAnotherMoveBegins) {
  ForwardRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  const Six before = rig.q();
  ASSERT_TRUE(rig.moves->accept(rig.turn(1.2)));
  ASSERT_TRUE(rig.passes(40));
  rig.moves->clear();
  ASSERT_TRUE(rig.passes_until([&] { return rig.moves->flow().idle && rig.moves->flow().standing; }, 1, 300));
  const Six at = rig.q();
  EXPECT_GT(at[0], before[0] + 0.02);
  EXPECT_LT(at[0], before[0] + 1.1) << "in the middle";
  rig.target.reset();
  ASSERT_TRUE(rig.moves->accept(rig.turn(-0.1)));
  ASSERT_TRUE(rig.passes_until([&] { return rig.done(); }));
  EXPECT_NEAR(rig.q()[0], at[0] - 0.1, 1e-3);
}

TEST(FanucForward, ThePaceIsTheControllersOverride) {
  const auto cycles_at = [](double pace) {
    ForwardRig rig;
    EXPECT_TRUE(rig.start()) << rig.component.reason();
    EXPECT_TRUE(rig.passes(5));
    rig.moves->accept(rig.turn(0.5));
    int cycles = 0;
    EXPECT_TRUE(rig.passes_until([&] { return ++cycles, rig.done(); }, pace));
    return cycles;
  };
  const int full = cycles_at(1), half = cycles_at(0.5);
  EXPECT_GT(half, 1.7 * full);
  EXPECT_LT(half, 2.3 * full);
}

TEST(FanucForward, ManyMovesPassThroughTheWindowInOrder) {
  ForwardRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  for (int i = 0; i < 30; ++i) ASSERT_TRUE(rig.moves->accept(rig.turn(i % 2 ? -0.05 : 0.06)));
  std::uint64_t last = 0;
  ASSERT_TRUE(rig.passes_until(
      [&] {
        EXPECT_GE(rig.moves->flow().done, last);
        last = rig.moves->flow().done;
        return rig.done();
      },
      1, 8000));
  EXPECT_EQ(last, 30u);
}

TEST(FanucForward, OutputsAndInputsGoOverTheSameWire) {
  ForwardRig rig(Parameters{{"wires", "1=2"}});
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  rig.command("io/digital_out_1") = 1;
  ASSERT_TRUE(rig.passes_until([&] { return rig.state("io/digital_in_2") == 1; }, 1, 60));
  rig.command("io/digital_out_1") = 0;
  ASSERT_TRUE(rig.passes_until([&] { return rig.state("io/digital_in_2") == 0; }, 1, 60));
}

TEST(FanucForward, AControllerThatCommandsJointsIsRefused) {
  ForwardRig rig;
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  const Six before = rig.q();
  rig.commands[1] += 0.3;
  EXPECT_EQ(rig.component.write(rig.cycle, rig.commands), ReturnType::error);
  EXPECT_EQ(rig.component.cause(), Cause::joint_commands);
  rig.component.on_error();
  expect_standing(rig);
  EXPECT_EQ(rig.q(), before);
}

/// The controller's clock runs by itself, as a robot's does.
TEST(FanucForward, OnAFreeClockMovesArriveAndTheLoopNeitherAllocatesNorLocks) {
  FarSide far(far_options());
  fanuc::FanucComponent component;
  component.on_init(fanuc_context({{"host", "127.0.0.1"},
                                   {"motion", "forward"},
                                   {"rmi_port", std::to_string(far.rmi_port())},
                                   {"poll_ms", "8"},
                                   {"answer_ms", "10000"},
                                   {"loop_silence_ms", "10000"}}));
  EXPECT_FALSE(component.paces()) << "the interface has no clock";
  ASSERT_EQ(component.on_configure(), CallbackReturn::success) << component.reason();
  ASSERT_EQ(component.on_activate(), CallbackReturn::success) << component.reason();
  hardware::ForwardMoves& moves = *component.forward_moves(hardware::kForwardLayout);
  EXPECT_EQ(component.forward_moves(0), nullptr) << "for a module that was built with other types";
  std::vector<double> states(component.state_interfaces().size()),
      commands(component.command_interfaces().size(), std::nan(""));
  hardware::Cycle cycle{0, 8'000'000, 0};
  component.await_cycle(1'000'000'000);
  component.read(cycle, states);
  ForwardMove move;
  move.id = 1;
  for (std::size_t j = 0; j < 6; ++j) move.joints[j] = states[3 * j];
  move.joints[0] += 0.1;
  move.at = far.with([&](fanuc::Machine& machine) {
    return machine.options().facts.chain->forward(std::span(move.joints).first(6));
  });
  std::string violations;
  bool fine = true, accepted = false, done = false;
  for (int i = 0; i < 2000 && fine && !done; ++i) {
    component.await_cycle(1'000'000'000);
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
  component.await_cycle(1'000'000'000);
  component.read(cycle, states);
  EXPECT_NEAR(states[0], move.joints[0], 0.01);
  component.on_shutdown();
}

/// As after `kill -9`: the socket closes while instructions wait at the controller.
TEST(FanucForward, WhenTheConnectionEndsTheControllerStopsOnItsPath) {
  FarSide far(far_options());
  far.hold_clock(true);
  const auto at = [&] { return far.with([](fanuc::Machine& machine) { return machine.q(); }); };
  const Six start = at();
  {
    fanuc::RmiSession session;
    std::string why;
    int error = 0;
    ASSERT_TRUE(session.open("127.0.0.1", far.rmi_port(), "FRC_Connect", 2'000'000'000, why, error)) << why;
    ASSERT_TRUE(session.ask("Command", "FRC_Initialize", {"Command", "FRC_Initialize"}, 2'000'000'000));
    ForwardMove move;
    for (int k = 1; k <= 4; ++k) {
      for (std::size_t j = 0; j < 6; ++j) move.joints[j] = start[j] * kDegree;
      move.joints[0] += k % 2 ? 1.0 : 0.5;
      ASSERT_TRUE(session.send(fanuc::instruction_of(move, {}, k, false, {})));
    }
    ASSERT_TRUE(session.ask("Command", "FRC_GetStatus", {"Command", "FRC_GetStatus"}, 2'000'000'000));
    for (int i = 0; i < 60; ++i) far.step();
  }
  EXPECT_GT(std::abs(at()[0] - start[0]), 1);
  fanuc::RmiSession again;  // once it is accepted, the controller knows that the other one has gone
  std::string why;
  int error = 0;
  bool open = false;
  for (int i = 0; i < 100 && !open; ++i)
    open = again.open("127.0.0.1", far.rmi_port(), "FRC_Connect", 2'000'000'000, why, error);
  ASSERT_TRUE(open) << why;
  far.with([](fanuc::Machine& machine) { return machine.forget_jumps(), 0; });
  for (int i = 0; i < 200; ++i) far.step();
  const Six stopped = at();
  for (int i = 0; i < 200; ++i) far.step();
  for (std::size_t j = 0; j < 6; ++j) EXPECT_NEAR(at()[j], stopped[j], 1e-6);
  EXPECT_LT(std::abs(stopped[0] - start[0]), 55) << "not the end of the first move";
  EXPECT_LT(far.with([](fanuc::Machine& machine) { return machine.largest_jump(); }), 2) << "degrees in 8 ms";
}

TEST(FanucForward, ALoopThatFallsSilentIsNamedAndTheRobotStops) {
  FarSide far(far_options());
  fanuc::FanucComponent component;
  component.on_init(fanuc_context({{"host", "127.0.0.1"},
                                   {"motion", "forward"},
                                   {"rmi_port", std::to_string(far.rmi_port())},
                                   {"answer_ms", "10000"},
                                   {"loop_silence_ms", "200"}}));
  ASSERT_EQ(component.on_configure(), CallbackReturn::success) << component.reason();
  ASSERT_EQ(component.on_activate(), CallbackReturn::success) << component.reason();
  std::vector<double> states(component.state_interfaces().size()),
      commands(component.command_interfaces().size(), std::nan(""));
  hardware::Cycle cycle{0, 8'000'000, 0};
  component.await_cycle(1'000'000'000);
  component.read(cycle, states);
  component.write(cycle, commands);
  for (int i = 0; i < 200 && component.cause() == Cause::none; ++i) component.await_cycle(100'000'000);
  EXPECT_EQ(component.cause(), Cause::loop_silent) << component.reason();
  EXPECT_EQ(component.read(cycle, states), ReturnType::error);
  component.on_error();
  expect_standing_alone(far);
}

class ForwardWhileMoving : public testing::TestWithParam<FaultRow> {};
INSTANTIATE_TEST_SUITE_P(
    Faults, ForwardWhileMoving,
    testing::Values(FaultRow{"e_stop", Cause::emergency_stop, "release the button"},
                    FaultRow{"fence_open", Cause::fence, "fence"},
                    FaultRow{"t1", Cause::teach_mode, "teach pendant"},
                    FaultRow{"contact", Cause::contact, "contact"},
                    FaultRow{"alarm=65", Cause::alarm, "SRVO-065"},
                    FaultRow{"abort", Cause::program_stopped, "ended there without an alarm"},
                    FaultRow{"hold", Cause::program_stopped, "held by hand"},
                    FaultRow{"mute", Cause::rmi_silent, "does not answer"},
                    FaultRow{"terminate", Cause::terminated, "ended the remote session"},
                    FaultRow{"close_rmi", Cause::rmi_closed, "closed the Remote Motion Interface"},
                    FaultRow{"power_off", Cause::rmi_closed, "switched off"}),
    fault_name<Cause>);

TEST_P(ForwardWhileMoving, IsNamedStandsAndMovesNothingWhenItIsRecovered) {
  ForwardRig rig(Parameters{{"answer_ms", "300"}, {"connect_timeout", "0.5"}});
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(5));
  for (int i = 0; i < 6; ++i) ASSERT_TRUE(rig.moves->accept(rig.turn(i % 2 ? -0.3 : 0.3)));
  ASSERT_TRUE(rig.passes(60));
  rig.far().order(GetParam().order);
  bool failed = false;
  for (int i = 0; i < 400 && !failed; ++i) failed = rig.pass() == ReturnType::error;
  ASSERT_TRUE(failed);
  EXPECT_EQ(rig.component.cause(), GetParam().cause) << rig.component.reason();
  const std::string said = rig.component.reason();
  EXPECT_NE(said.find(GetParam().words), std::string::npos) << said;
  expect_standing(rig);
  for (const char* order : {"release", "fence_closed", "auto", "reset", "healthy"}) rig.far().order(order);
  expect_standing(rig);
  rig.forget_jumps();
  ASSERT_TRUE(rig.configure()) << rig.component.reason();
  expect_standing(rig);
  const Six before = rig.q();
  ASSERT_TRUE(rig.activate()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(100));
  EXPECT_TRUE(rig.moves->flow().idle) << "what was left is forgotten";
  EXPECT_LE(rig.largest_jump(), 1e-6);
  for (std::size_t j = 0; j < 6; ++j) EXPECT_NEAR(rig.q()[j], before[j], 1e-6);
}

/// Faults drawn at random, before, during and after moves, pauses and clears.
TEST(FanucForwardFaults, DrawnAtRandomTheyAreAlwaysNamedAndNothingJumpsOrGoesOnByItself) {
  constexpr const char* kOrders[] = {"e_stop",   "fence_open", "t1",   "t2",        "contact",   "motn=610",
                                     "alarm=65", "abort",      "hold", "terminate", "close_rmi", "power_off"};
  Draw draw(30);
  ForwardRig rig(Parameters{{"connect_timeout", "1"}});
  int named = 0;
  for (int round = 0; round < 40; ++round) {
    const std::string order = kOrders[draw(std::size(kOrders))];
    if (!rig.configure()) {
      ADD_FAILURE() << round << " " << rig.component.reason();
      break;
    }
    rig.forget_jumps();
    const bool early = draw(4) == 0;
    if (early) rig.far().order(order);
    const Six before = rig.q();
    if (rig.component.cause() == Cause::none && rig.activate()) {
      rig.target.reset();
      const int moves = static_cast<int>(1 + draw(9)), until = static_cast<int>(draw(120));
      for (int i = 0; i < moves; ++i)
        rig.moves->accept(rig.turn(i % 2 ? -0.2 : 0.2, draw(2) && i + 1 < moves ? 0.02 : 0));
      const double pace = draw(3) == 0 ? 0 : 1;
      bool alive = true;
      for (int i = 0; alive && i < until; ++i) alive = rig.pass() == ReturnType::ok;
      if (alive && draw(4) == 0) rig.moves->clear();
      if (alive) rig.far().order(order);
      for (int i = 0; alive && i < 120; ++i) alive = rig.pass(pace) == ReturnType::ok;
    } else {
      for (std::size_t j = 0; j < 6; ++j) EXPECT_NEAR(rig.q()[j], before[j], 1e-6) << order;
    }
    if (rig.component.cause() != Cause::none) {
      ++named;
      EXPECT_GT(rig.component.reason().size(), 30u) << order;
    }
    EXPECT_LE(rig.largest_jump(), 0.03) << order;  // rad in 8 ms
    rig.component.on_error();
    expect_standing(rig);
    for (const char* mend : {"release", "fence_closed", "auto", "reset", "healthy"}) rig.far().order(mend);
    expect_standing(rig);
  }
  EXPECT_GT(named, 20);
}

}  // namespace
}  // namespace polyarm
