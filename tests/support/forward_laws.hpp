#pragma once
/// What a driver in forward mode owes its users, the same for each maker. `Rig` is a ForwardMoveRig.
/// `mend(far)` is what a person does at the controller.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <string>

#include "drivers/wire/arcs.hpp"
#include "tests/support/forward_moves.hpp"
#include "tests/support/realtime_guard.hpp"
#include "tests/support/wire_faults.hpp"

namespace polyarm::test {

/// rad: a robot that moves by less between two readings counts as standing.
inline constexpr double kStandsWithin = 2e-4;

template <class Joints>
void expect_at(const Joints& now, const Joints& then, double within, const std::string& what = {}) {
  for (std::size_t j = 0; j < then.size(); ++j)
    EXPECT_NEAR(now[j], then[j], within) << what << " joint " << j;
}

/// Started, and read a few times.
template <class Rig>
::testing::AssertionResult begins(Rig& rig, int cycles = 5) {
  if (!rig.start()) return ::testing::AssertionFailure() << rig.component.reason();
  return rig.passes(cycles);
}

/// The tool is not that of the flange: the controller gets it before the first move.
template <class Rig>
void expect_line_of_a_turned_tcp_ends_at_its_target(Rig& rig) {
  ASSERT_TRUE(begins(rig));
  hardware::ForwardMove line = rig.shift({0.02, -0.1, 0.05});
  line.at = line.at * Pose{{0.03, -0.01, 0.12}, from_rpy(0.3, -0.4, 0.5)};
  ASSERT_TRUE(rig.moves->accept(line));
  ASSERT_TRUE(rig.passes_until([&] { return rig.done(); }));
  expect_at(rig.q(), *rig.target, 1e-4);
}

/// Half a rad of the last joint in 1.5 s; `period`: of a cycle, s.
template <class Rig>
void expect_turn_of_the_tool_takes_its_time(Rig& rig, double period) {
  ASSERT_TRUE(begins(rig, 20));
  hardware::ForwardMove turn = rig.turn(0);
  turn.joints[5] += 0.5;
  turn.at = Rig::chain().forward(std::span(turn.joints).first(6));
  turn.kind = hardware::ForwardMove::Kind::line;
  turn.speed = 0;
  turn.duration = 1.5;
  ASSERT_TRUE(rig.moves->accept(turn));
  int cycles = 0;
  ASSERT_TRUE(rig.passes_until([&] { return ++cycles, rig.done(); }));
  EXPECT_NEAR(rig.q()[5], turn.joints[5], 1e-4);
  EXPECT_GT(cycles * period, 1.3);
  EXPECT_LT(cycles * period, 2.2);
}

template <class Rig>
void expect_nothing_moves_before_a_move(Rig& rig, int cycles = 100) {
  const auto before = rig.q();
  ASSERT_TRUE(begins(rig, cycles));
  EXPECT_TRUE(rig.moves->flow().standing);
  EXPECT_TRUE(rig.moves->flow().idle);
  EXPECT_EQ(rig.q(), before);
}

template <class Rig>
void expect_moves_end_where_they_should(Rig& rig, const Vec3& by, double within) {
  ASSERT_TRUE(begins(rig));
  ASSERT_TRUE(rig.moves->accept(rig.turn(0.4)));
  ASSERT_TRUE(rig.moves->accept(rig.shift(by)));
  EXPECT_FALSE(rig.moves->flow().idle);
  ASSERT_TRUE(rig.passes_until([&] { return rig.done(); }));
  expect_at(rig.q(), *rig.target, within);
}

template <class Rig>
void expect_line_is_straight(Rig& rig, const Vec3& by, double within) {
  ASSERT_TRUE(begins(rig));
  const Vec3 from = rig.place();
  ASSERT_TRUE(rig.moves->accept(rig.shift(by)));
  const Vec3 way = normalized(by);
  double off = 0;
  ASSERT_TRUE(rig.passes_until([&] {
    const Vec3 gone = rig.place() - from;
    off = std::max(off, norm(gone - dot(gone, way) * way));
    return rig.done();
  }));
  EXPECT_LT(off, within);
}

/// `by`: to the end of the arc; `via`: to its point.
template <class Rig>
void expect_arc_passes_its_point(Rig& rig, const Vec3& by, const Vec3& via, double near_via,
                                 double near_end) {
  ASSERT_TRUE(begins(rig));
  const hardware::ForwardMove arc = rig.arc(by, via);
  ASSERT_TRUE(rig.moves->accept(arc));
  double nearest = 1;
  ASSERT_TRUE(rig.passes_until([&] {
    nearest = std::min(nearest, norm(rig.place() - arc.via.position));
    return rig.done();
  }));
  EXPECT_LT(nearest, near_via);
  EXPECT_LT(norm(rig.place() - arc.at.position), near_end);
}

/// `first(rig, blend)` is the move before the corner; `by`: the line behind it.
template <class Rig, typename First>
void expect_blend_stays_near_the_corner(First first, const Vec3& by, double blend, double near_corner) {
  const auto run = [&](double radius, double& off) {
    Rig rig;
    EXPECT_TRUE(begins(rig));
    const hardware::ForwardMove corner = first(rig, radius);
    rig.moves->accept(corner);
    rig.moves->accept(rig.shift(by));
    int cycles = 0;
    off = 1;
    EXPECT_TRUE(rig.passes_until([&] {
      ++cycles;
      off = std::min(off, norm(rig.place() - corner.at.position));
      return rig.done();
    }));
    return cycles;
  };
  double exact = 0, rounded = 0;
  const int slow = run(0, exact), fast = run(blend, rounded);
  EXPECT_LT(exact, near_corner);
  EXPECT_GT(rounded, 1e-3);
  EXPECT_LE(rounded, blend);
  EXPECT_LT(fast, slow);
}

/// A line along z, by `z` m. `before`: cycles until the pause; `held_now`: called in it.
template <class Rig, typename Held>
void expect_pause_stops_on_the_path(Rig& rig, double z, int before, double within, Held held_now) {
  ASSERT_TRUE(begins(rig));
  const Vec3 from = rig.place();
  ASSERT_TRUE(rig.moves->accept(rig.shift({0, 0, z})));
  ASSERT_TRUE(rig.passes(before));
  EXPECT_FALSE(rig.moves->flow().standing);
  ASSERT_TRUE(rig.passes_until([&] { return rig.moves->flow().standing; }, 0, 500));
  held_now();
  const auto at = rig.q();
  ASSERT_TRUE(rig.passes(300, 0));
  expect_at(rig.q(), at, kStandsWithin);
  EXPECT_FALSE(rig.moves->flow().idle) << "the rest of the move is still to do";
  const Vec3 held = rig.place();
  EXPECT_NEAR(held.x, from.x, within);
  EXPECT_NEAR(held.y, from.y, within);
  const double gone = std::copysign(1, z) * (held.z - from.z);
  EXPECT_GT(gone, 0.005);
  EXPECT_LT(gone, std::abs(z) - 0.005);
  ASSERT_TRUE(rig.passes_until([&] { return rig.done(); }));
  EXPECT_NEAR(rig.place().z, from.z + z, within);
}

template <class Rig>
void expect_pause_stops_on_the_path(Rig& rig, double z, int before, double within) {
  expect_pause_stops_on_the_path(rig, z, before, within, [] {});
}

template <class Rig>
void expect_pause_in_an_arc_stays_on_it(Rig& rig, const Vec3& by, const Vec3& via) {
  ASSERT_TRUE(begins(rig));
  const Vec3 from = rig.place();
  const hardware::ForwardMove arc = rig.arc(by, via);
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

/// A cleared robot stands, and takes other moves from there.
template <class Rig>
void expect_clear_ends_all_moves(Rig& rig, int before) {
  ASSERT_TRUE(begins(rig));
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(rig.moves->accept(rig.turn(i % 2 ? -0.3 : 0.3)));
  ASSERT_TRUE(rig.passes(before));
  rig.moves->clear();
  EXPECT_FALSE(rig.moves->accept(rig.turn(0.1))) << "not before it is done";
  ASSERT_TRUE(rig.passes_until([&] { return rig.moves->flow().idle && rig.moves->flow().standing; }, 1, 600));
  const auto at = rig.q();
  ASSERT_TRUE(rig.passes(300));
  expect_at(rig.q(), at, kStandsWithin);
  rig.target.reset();
  ASSERT_TRUE(rig.moves->accept(rig.turn(0.1)));
  ASSERT_TRUE(rig.passes_until([&] { return rig.done(); }));
  EXPECT_NEAR(rig.q()[0], at[0] + 0.1, 1e-3);
}

/// Half the pace takes twice the time. `look(rig, pace)` is called when the move of `by` rad is done.
template <class Rig, typename Look>
void expect_pace_sets_the_time(double by, Look look) {
  const auto cycles_at = [&](double pace) {
    Rig rig;
    EXPECT_TRUE(begins(rig));
    rig.moves->accept(rig.turn(by));
    int cycles = 0;
    EXPECT_TRUE(rig.passes_until([&] { return ++cycles, rig.done(); }, pace));
    look(rig, pace);
    return cycles;
  };
  const int full = cycles_at(1), half = cycles_at(0.5);
  EXPECT_GT(half, 1.7 * full);
  EXPECT_LT(half, 2.3 * full);
}

/// Thirty moves to and fro; `blend` rounds most of them, m.
template <class Rig>
void expect_many_moves_pass_in_order(Rig& rig, double blend) {
  ASSERT_TRUE(begins(rig));
  for (int i = 0; i < 30; ++i)
    ASSERT_TRUE(rig.moves->accept(rig.turn(i % 2 ? -0.1 : 0.11, i % 3 && i < 29 ? blend : 0)));
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

template <class Rig, class Cause>
void expect_joint_commands_are_refused(Rig& rig, Cause joint_commands) {
  ASSERT_TRUE(begins(rig));
  const auto before = rig.q();
  rig.commands[1] += 0.3;
  EXPECT_EQ(rig.component.write(rig.cycle, rig.commands), ReturnType::error);
  EXPECT_EQ(rig.component.cause(), joint_commands);
  EXPECT_NE(rig.component.reason().find("takes only moves"), std::string::npos) << rig.component.reason();
  rig.component.on_error();
  expect_standing(rig);
  EXPECT_EQ(rig.q(), before);
}

/// The controller's clock runs by itself, as a robot's does. `component` is active and has read once.
template <class Component>
void expect_move_on_a_free_clock(Component& component, const hardware::ForwardMove& move,
                                 hardware::Cycle& cycle, std::vector<double>& states, double within,
                                 int most = 20'000) {
  hardware::ForwardMoves& moves = *component.forward_moves(hardware::kForwardLayout);
  EXPECT_EQ(component.forward_moves(0), nullptr) << "for a module that was built with other types";
  const std::vector<double> commands(component.command_interfaces().size(), std::nan(""));
  std::string violations;
  bool fine = true, accepted = false, done = false;
  for (int i = 0; i < most && fine && !done; ++i) {
    component.await_cycle(60'000'000'000);
    cycle.time += cycle.period;
    const RealtimeGuard guard;
    moves.set_pace(1);
    fine =
        component.read(cycle, states) == ReturnType::ok && component.write(cycle, commands) == ReturnType::ok;
    accepted = accepted || moves.accept(move);
    const hardware::ForwardFlow flow = moves.flow();
    done = accepted && flow.idle && flow.standing && flow.done == 1;
    if (violations.empty()) violations = guard.violations();
  }
  EXPECT_TRUE(fine) << component.reason();
  EXPECT_TRUE(done);
  EXPECT_EQ(violations, "");
  EXPECT_NEAR(states[0], move.joints[0], within);
}

/// Joint 1 by `by` rad from where it was read. `kStates`: of each joint.
inline hardware::ForwardMove turn_from(const std::vector<double>& states, std::size_t kStates,
                                       const kinematics::Chain& chain, double by) {
  hardware::ForwardMove out;
  out.id = 1;
  for (std::size_t j = 0; j < 6; ++j) out.joints[j] = states[kStates * j];
  out.joints[0] += by;
  out.at = chain.forward(std::span(out.joints).first(6));
  return out;
}

/// `before`: cycles until the fault.
template <class Rig, class Row, class Mend>
void expect_fault_ends_all_moves(Rig& rig, const Row& row, int before, Mend mend) {
  ASSERT_TRUE(begins(rig));
  for (int i = 0; i < 6; ++i) ASSERT_TRUE(rig.moves->accept(rig.turn(i % 2 ? -0.3 : 0.3)));
  ASSERT_TRUE(rig.passes(before));
  rig.far().order(row.order);
  bool failed = false;
  for (int i = 0; i < 3000 && !failed; ++i) failed = rig.pass() == ReturnType::error;
  ASSERT_TRUE(failed);
  expect_named(rig, row);
  expect_standing(rig);
  mend(rig.far());
  expect_standing(rig);
  ASSERT_TRUE(rig.configure()) << rig.component.reason();
  expect_standing(rig);
  rig.forget_jumps();
  const auto at = rig.q();
  ASSERT_TRUE(rig.activate()) << rig.component.reason();
  ASSERT_TRUE(rig.passes(200));
  EXPECT_TRUE(rig.moves->flow().idle) << "what was left is forgotten";
  EXPECT_LE(rig.largest_jump(), 1e-6);
  expect_at(rig.q(), at, 1e-6);
}

struct ForwardFaults {
  std::uint32_t seed = 30;
  int until = 200;           ///< cycles at most, until the fault
  int after = 150;           ///< cycles with it
  double most_jump = 0;      ///< rad in a cycle, of the fastest joint
  double least_named = 0.5;  ///< share of the rounds
};

/// Faults drawn at random, before, during and after moves, pauses and clears. POLYARM_FAULT_ROUNDS: how many.
template <class Rig, class Mend>
void expect_random_faults_end_all_moves(Rig& rig, std::span<const char* const> orders,
                                        const ForwardFaults& faults, Mend mend) {
  const int rounds = fault_rounds(30);
  Draw draw(faults.seed);
  int named = 0;
  const auto well = [&] { return static_cast<int>(rig.component.cause()) == 0; };
  for (int round = 0; round < rounds; ++round) {
    const std::string order = orders[draw(static_cast<std::uint32_t>(orders.size()))];
    ASSERT_TRUE(rig.configure()) << round << " " << rig.component.reason();
    rig.forget_jumps();
    if (draw(4) == 0) rig.far().order(order);
    const auto before = rig.q();
    if (well() && rig.activate()) {
      rig.target.reset();
      const int moves = static_cast<int>(1 + draw(9));
      const int until = static_cast<int>(draw(static_cast<std::uint32_t>(faults.until)));
      for (int i = 0; i < moves; ++i)
        rig.moves->accept(rig.turn(i % 2 ? -0.2 : 0.2, draw(2) && i + 1 < moves ? 0.02 : 0));
      const double pace = draw(3) == 0 ? 0 : 1;
      bool alive = true;
      for (int i = 0; alive && i < until; ++i) alive = rig.pass() == ReturnType::ok;
      if (alive && draw(4) == 0) rig.moves->clear();
      if (alive) rig.far().order(order);
      for (int i = 0; alive && i < faults.after; ++i) alive = rig.pass(pace) == ReturnType::ok;
    } else {
      expect_at(rig.q(), before, 1e-6, order);
    }
    if (!well()) {
      ++named;
      EXPECT_GT(rig.component.reason().size(), 30u) << order;
    }
    EXPECT_LE(rig.largest_jump(), faults.most_jump) << order;
    rig.component.on_error();
    expect_standing(rig);
    mend(rig.far());
    expect_standing(rig);
  }
  EXPECT_GT(named, faults.least_named * rounds);
}

}  // namespace polyarm::test
