#include "polyarm/trajectory/state_to_state.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "tests/support/realtime_guard.hpp"
#include "tests/support/state_cases.hpp"

namespace polyarm::trajectory::state_to_state_test {
namespace {

using namespace test::states;

class OfAnyKind : public testing::TestWithParam<Kind> {};

TEST_P(OfAnyKind, ArrivesWithinLimitsAndTogether) {
  Draw draw(1);
  StateToState plan;
  for (int k = 0; k < 20'000; ++k) {
    const std::size_t n = 1 + static_cast<std::size_t>(k % 7);
    std::vector<MotionState> from, to;
    std::vector<MotionLimits> limits;
    for (std::size_t i = 0; i < n; ++i) {
      limits.push_back(limits_of(GetParam(), draw, k % 3 == 0));
      const double way = draw.logarithmic(GetParam().distance[0], GetParam().distance[1]);
      from.push_back(draw.state(limits.back(), draw.even(-3, 3)));
      const double there = from.back().position + (draw.coin() ? way : -way);
      to.push_back(k % 2 ? draw.state(limits.back(), there) : MotionState{there, 0, 0});
      if (k % 5 == 0) from.back().velocity = from.back().acceleration = 0;
    }
    ASSERT_EQ(plan.plan(from, to, limits), MotionStatus::ok) << k;
    for (std::size_t i = 0; i < n; ++i) {
      const AxisMotion& m = plan.axis(i);
      ASSERT_EQ(m.duration(), plan.duration()) << k << " axis " << i;
      ASSERT_LE(miss(m, from[i], to[i], limits[i]), 1e-9)
          << shown(from[i], to[i], limits[i]) << " in " << m.duration();
      ASSERT_LE(excess(m, limits[i]), 1e-9) << k << " axis " << i;
      ASSERT_EQ(m.at(0).position, from[i].position);
      ASSERT_EQ(m.at(plan.duration()).position, to[i].position);
    }
  }
}

/// Any motion within limits shows that there is one of its duration: none may be faster than what is planned,
/// and where its duration is asked for, it must be met, whatever lies between.
TEST_P(OfAnyKind, NoOtherMotionIsFasterAndNoDurationIsMissed) {
  Draw draw(2);
  StateToState plan;
  int compared = 0;
  for (int k = 0; k < 40'000; ++k) {
    const MotionLimits l = limits_of(GetParam(), draw, k % 3 == 0);
    MotionState from = draw.state(l, draw.even(-3, 3)), at = from;
    double duration = 0;
    bool within = true;
    const int phases = 1 + k % 5;
    const bool gentle = k % 2 == 0;  // then no duration near its own is the only one
    for (int i = 0; i < phases && within; ++i) {
      const double jerk = (gentle ? draw.even(-0.9, 0.9) : draw.coin() ? 1 : -1) * l.max_jerk;
      const double time = draw.even(0, 1) * (l.max_acceleration - l.min_acceleration) / l.max_jerk;
      const double zero = jerk != 0 ? -at.acceleration / jerk : -1;
      for (const double t : {time, zero > 0 && zero < time ? zero : time}) {
        const MotionState s = passed(at, t, jerk);
        within &= s.velocity <= l.max_velocity && s.velocity >= l.min_velocity &&
                  s.acceleration <= l.max_acceleration && s.acceleration >= l.min_acceleration;
      }
      at = passed(at, time, jerk);
      duration += time;
    }
    // Two phases between accelerations of one sign are the only motion of their time, and of their square
    // root.
    if (!within || (!gentle && phases <= 2 && from.acceleration * at.acceleration > 0)) continue;
    const MotionStatus status = plan.plan({&from, 1}, {&at, 1}, {&l, 1});
    if (status == MotionStatus::target_outside) continue;  // it came here, and could only leave the limits
    ASSERT_EQ(status, MotionStatus::ok);
    ASSERT_LE(plan.duration(), duration * (1 + 1e-9) + 1e-12) << shown(from, at, l) << " in " << duration;
    if (gentle && l.max_jerk * duration * duration * duration > 1e-9) {  // else rounding alone decides
      MotionOptions options;
      options.minimum_duration = duration;
      ASSERT_EQ(plan.plan({&from, 1}, {&at, 1}, {&l, 1}, options), MotionStatus::ok);
      ASSERT_EQ(plan.duration(), duration) << shown(from, at, l);
      ASSERT_LE(miss(plan.axis(0), from, at, l), 1e-9) << shown(from, at, l) << " in " << duration;
    }
    ++compared;
  }
  EXPECT_GT(compared, 3000);
}

/// A target that moves by a random walk, met anew in every cycle: the command has no step in acceleration
/// beyond what the jerk allows, and stays within limits.
TEST_P(OfAnyKind, FollowsATargetThatMoves) {
  Draw draw(3);
  for (int k = 0; k < 40; ++k) {
    const std::size_t n = 3;
    const double cycle = 0.001;
    std::vector<MotionLimits> limits(n);
    std::vector<MotionState> at(n), to(n), next(n);
    for (std::size_t i = 0; i < n; ++i) limits[i] = limits_of(GetParam(), draw, k % 2 == 0);
    StateToState plan;
    for (int step = 0; step < 1000; ++step) {
      for (std::size_t i = 0; i < n; ++i)
        if (step % 10 == 0) to[i].position += draw.even(-1, 1) * limits[i].max_velocity * 0.02;
      ASSERT_EQ(plan.plan(at, to, limits), MotionStatus::ok);
      plan.sample(cycle, next);
      for (std::size_t i = 0; i < n; ++i) {
        const MotionLimits& l = limits[i];
        ASSERT_LE(std::abs(next[i].acceleration - at[i].acceleration), l.max_jerk * cycle * (1 + 1e-9));
        ASSERT_LE(next[i].velocity, l.max_velocity * (1 + 1e-9));
        ASSERT_GE(next[i].velocity, l.min_velocity * (1 + 1e-9));
        ASSERT_LE(next[i].acceleration, l.max_acceleration * (1 + 1e-9));
        ASSERT_GE(next[i].acceleration, l.min_acceleration * (1 + 1e-9));
      }
      at = next;
    }
    // It stands still: planning anew in every cycle arrives when the first of these plans said.
    ASSERT_EQ(plan.plan(at, to, limits), MotionStatus::ok);
    const double promised = plan.duration();
    double passed = 0;
    while (plan.duration() > cycle && passed < 2 * promised) {
      plan.sample(cycle, next);
      at = next;
      passed += cycle;
      ASSERT_EQ(plan.plan(at, to, limits), MotionStatus::ok);
    }
    EXPECT_NEAR(passed + plan.duration(), promised, 1e-5);  // the cube root of the last digit
  }
}

/// Starts that cannot help leaving the limits brake first and still arrive.
TEST_P(OfAnyKind, AStartBeyondTheLimitsBrakesFirst) {
  Draw draw(4);
  StateToState plan;
  for (int k = 0; k < 5000; ++k) {
    const MotionLimits l = limits_of(GetParam(), draw, k % 3 == 0);
    const double v = draw.even(-2, 2) * l.max_velocity, a = draw.even(-2, 2) * l.max_acceleration;
    const MotionState from{draw.even(-3, 3), v, a}, to{from.position + draw.even(-1, 1), 0, 0};
    ASSERT_EQ(plan.plan({&from, 1}, {&to, 1}, {&l, 1}), MotionStatus::ok);
    const AxisMotion& m = plan.axis(0);
    const double worst_v =
        std::max({std::abs(v), l.max_velocity, -l.min_velocity}) + a * a / (2 * l.max_jerk);
    const MotionLimits seen =
        MotionLimits::symmetric(worst_v, std::max(std::abs(a), l.max_acceleration), l.max_jerk);
    ASSERT_LE(miss(m, from, to, seen), 1e-9) << shown(from, to, l);
    for (std::size_t i = 0; i < m.pieces(); ++i) {
      ASSERT_LE(std::abs(m.jerk_of(i)), l.max_jerk * (1 + 1e-9));
      ASSERT_LE(std::abs(m.state_of(i).velocity), worst_v * (1 + 1e-9));
    }
    // Once inside, it stays inside.
    bool inside = false;
    for (int s = 0; s <= 200; ++s) {
      const MotionState x = m.at(m.duration() * s / 200);
      const bool now = x.velocity <= l.max_velocity * (1 + 1e-9) &&
                       x.velocity >= l.min_velocity * (1 + 1e-9) &&
                       x.acceleration <= l.max_acceleration * (1 + 1e-9) &&
                       x.acceleration >= l.min_acceleration * (1 + 1e-9);
      const double ahead = x.velocity + x.acceleration * std::abs(x.acceleration) / (2 * l.max_jerk);
      ASSERT_TRUE(now || !inside) << k << " at " << s;
      inside = inside || (now && ahead < l.max_velocity && ahead > l.min_velocity);
    }
  }
}

/// Whether the axis is inside its limits and can stay there.
bool is_inside(const MotionState& s, const MotionLimits& l, double room) {
  const double settles = s.velocity + s.acceleration * std::abs(s.acceleration) / (2 * l.max_jerk);
  const double up = 1 + room, width = room * (l.max_velocity - l.min_velocity);
  return s.acceleration <= l.max_acceleration * up && s.acceleration >= l.min_acceleration * up &&
         std::max(s.velocity, settles) <= l.max_velocity + width &&
         std::min(s.velocity, settles) >= l.min_velocity - width;
}

/// From a start beyond the limits: the acceleration comes back to its limits at full jerk and stays within
/// them, along random jerks. After how long the axis is inside; infinite if that does not happen.
double random_way_back(const MotionState& from, const MotionLimits& l, Draw& draw) {
  MotionState at = from;
  double t = 0;
  const double limit = std::clamp(at.acceleration, l.min_acceleration, l.max_acceleration);
  const double turn = std::abs(limit - at.acceleration) / l.max_jerk;
  if (turn > 0) at = passed(at, turn, limit < at.acceleration ? -l.max_jerk : l.max_jerk);
  at.acceleration = limit, t += turn;
  if (is_inside(at, l, 0)) return t;
  for (int piece = 0; piece < 4; ++piece) {
    const double jerk = (draw.coin() ? draw.even(-1, 1) : draw.coin() ? 1 : -1) * l.max_jerk;
    const double time = draw.even(0, 1) * 4 * std::max(l.max_acceleration, -l.min_acceleration) / l.max_jerk;
    constexpr int kSteps = 64;
    for (int k = 1; k <= kSteps; ++k) {
      const MotionState s = passed(at, time * k / kSteps, jerk);
      if (is_inside(s, l, 0)) return t + time * k / kSteps;
      if (s.acceleration > l.max_acceleration || s.acceleration < l.min_acceleration)
        return std::numeric_limits<double>::infinity();
    }
    at = passed(at, time, jerk), t += time;
  }
  return std::numeric_limits<double>::infinity();
}

TEST_P(OfAnyKind, NoOtherWayBackInsideIsShorter) {
  Draw draw(9);
  StateToState plan;
  int compared = 0;
  for (int k = 0; k < 300; ++k) {
    const MotionLimits l = limits_of(GetParam(), draw, k % 3 == 0);
    const double v = draw.even(-2, 2) * l.max_velocity, a = draw.even(-2, 2) * l.max_acceleration;
    const MotionState from{0, v, a}, to{draw.even(-1, 1), 0, 0};
    ASSERT_EQ(plan.plan({&from, 1}, {&to, 1}, {&l, 1}), MotionStatus::ok);
    const AxisMotion& m = plan.axis(0);
    double back = 0;  // when it is inside, to a thousandth of the first pieces
    for (std::size_t i = 0; i < m.pieces() && !is_inside(m.at(back), l, 1e-9); ++i)
      for (int s = 0; s <= 1000 && !is_inside(m.at(back), l, 1e-9); ++s)
        back = m.begin_of(i) + (end_of(m, i) - m.begin_of(i)) * s / 1000;
    const double step = m.duration() / 1000;
    for (int way = 0; way < 200; ++way) {
      const double other = random_way_back(from, l, draw);
      compared += std::isfinite(other);
      ASSERT_GE(other, (back - step) * (1 - 1e-9)) << shown(from, to, l);
    }
  }
  EXPECT_GT(compared, 1000);
}

TEST_P(OfAnyKind, BetweenTwoRestsItNeverTurnsBack) {
  Draw draw(10);
  StateToState plan;
  for (int k = 0; k < 2000; ++k) {
    const std::size_t n = 1 + static_cast<std::size_t>(k % 7);
    std::vector<MotionState> from(n), to(n);
    std::vector<MotionLimits> limits(n);
    for (std::size_t i = 0; i < n; ++i) {
      limits[i] = limits_of(GetParam(), draw, k % 2 == 0);
      from[i].position = to[i].position = draw.even(-3, 3);
      const double way = draw.logarithmic(GetParam().distance[0], GetParam().distance[1]);
      if (i != 2) to[i].position += draw.coin() ? way : -way;  // one of them stays
    }
    ASSERT_EQ(plan.plan(from, to, limits), MotionStatus::ok);
    for (std::size_t i = 0; i < n; ++i) {
      const AxisMotion& m = plan.axis(i);
      ASSERT_EQ(m.duration(), plan.duration());
      ASSERT_LE(miss(m, from[i], to[i], limits[i]), 1e-9) << shown(from[i], to[i], limits[i]);
      ASSERT_LE(excess(m, limits[i]), 1e-9) << shown(from[i], to[i], limits[i]);
      const double side = to[i].position >= from[i].position ? 1 : -1;
      for (std::size_t p = 0; p < m.pieces(); ++p)
        ASSERT_GE(side * m.state_of(p).velocity, -1e-9 * limits[i].max_velocity);
      if (n > 2) {
        ASSERT_EQ(plan.axis(2).at(plan.duration() / 2).position, from[2].position);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(StateToState, OfAnyKind, testing::ValuesIn(kKinds),
                         [](const testing::TestParamInfo<Kind>& kind) { return kind.param.name; });

TEST(StateToState, FromRestToRestIsTheKnownSevenPhases) {
  const MotionState from{}, to{10, 0, 0};
  const MotionLimits l = MotionLimits::symmetric(2, 4, 8);
  StateToState plan;
  ASSERT_EQ(plan.plan({&from, 1}, {&to, 1}, {&l, 1}), MotionStatus::ok);
  EXPECT_NEAR(plan.duration(), 10.0 / 2 + 2.0 / 4 + 4.0 / 8, 1e-12);  // way / v + v / a + a / j
  EXPECT_NEAR(plan.axis(0).at(plan.duration() / 2).position, 5, 1e-12);
  EXPECT_NEAR(plan.axis(0).at(plan.duration() / 2).velocity, 2, 1e-12);
}

TEST(StateToState, PhaseKeepsToTheStraightLine) {
  Draw draw(5);
  StateToState plan;
  for (int k = 0; k < 500; ++k) {
    const std::size_t n = 6;
    std::vector<MotionState> from(n), to(n), at(n);
    std::vector<MotionLimits> limits(n);
    for (std::size_t i = 0; i < n; ++i) {
      limits[i] = limits_of(kKinds[0], draw, true);
      from[i].position = draw.even(-3, 3);
      to[i].position = i == 3 ? from[i].position : draw.even(-3, 3);
    }
    MotionOptions options;
    options.synchronization = Synchronization::phase;
    ASSERT_EQ(plan.plan(from, to, limits, options), MotionStatus::ok);
    ASSERT_TRUE(plan.straight());
    for (int s = 0; s <= 50; ++s) {
      plan.sample(plan.duration() * s / 50, at);
      const double share = (at[0].position - from[0].position) / (to[0].position - from[0].position);
      for (std::size_t i = 0; i < n; ++i)
        ASSERT_NEAR(at[i].position, from[i].position + share * (to[i].position - from[i].position), 1e-9);
    }
    for (std::size_t i = 0; i < n; ++i) ASSERT_LE(excess(plan.axis(i), limits[i]), 1e-9);
    from[1].velocity = 0.1;
    ASSERT_EQ(plan.plan(from, to, limits, options), MotionStatus::ok);
    EXPECT_FALSE(plan.straight()) << "it is not on the line";
  }
}

TEST(StateToState, WithoutSynchronizationEachIsAsFastAsAlone) {
  Draw draw(6);
  for (int k = 0; k < 1000; ++k) {
    const std::size_t n = 4;
    std::vector<MotionState> from(n), to(n);
    std::vector<MotionLimits> limits(n);
    for (std::size_t i = 0; i < n; ++i) {
      limits[i] = limits_of(kKinds[0], draw, false);
      from[i] = draw.state(limits[i], draw.even(-3, 3));
      to[i] = draw.state(limits[i], draw.even(-3, 3));
    }
    MotionOptions options;
    options.synchronization = Synchronization::none;
    StateToState all, one;
    ASSERT_EQ(all.plan(from, to, limits, options), MotionStatus::ok);
    double longest = 0;
    for (std::size_t i = 0; i < n; ++i) {
      ASSERT_EQ(one.plan({&from[i], 1}, {&to[i], 1}, {&limits[i], 1}), MotionStatus::ok);
      EXPECT_EQ(all.axis(i).duration(), one.duration());
      longest = std::max(longest, one.duration());
    }
    EXPECT_EQ(all.duration(), longest);
  }
}

TEST(StateToState, AVelocityIsReachedWhereverThatIs) {
  Draw draw(7);
  StateToState plan;
  MotionOptions options;
  options.target = TargetKind::velocity;
  for (int k = 0; k < 3000; ++k) {
    const std::size_t n = 3;
    std::vector<MotionState> from(n), to(n);
    std::vector<MotionLimits> limits(n);
    for (std::size_t i = 0; i < n; ++i) {
      limits[i] = limits_of(kKinds[0], draw, true);
      from[i] = draw.state(limits[i], 0);
      to[i] = draw.state(limits[i], 0);
      if (k % 2) to[i].acceleration = 0;
    }
    ASSERT_EQ(plan.plan(from, to, limits, options), MotionStatus::ok);
    for (std::size_t i = 0; i < n; ++i) {
      EXPECT_LE(excess(plan.axis(i), limits[i]), 1e-9);
      const MotionState end = plan.axis(i).at(plan.duration());
      EXPECT_EQ(end.velocity, to[i].velocity);
      const AxisMotion& m = plan.axis(i);
      const MotionState last = passed(m.state_of(m.pieces() - 1), m.duration() - m.begin_of(m.pieces() - 1),
                                      m.jerk_of(m.pieces() - 1));
      EXPECT_NEAR(last.velocity, to[i].velocity, 1e-9);
      EXPECT_NEAR(last.position, end.position, 1e-9);
    }
  }
}

TEST(StateToState, ADurationThatWasAskedForIsKept) {
  const MotionState from{}, to{1, 0, 0};
  const MotionLimits l = MotionLimits::symmetric(2, 4, 8);
  MotionOptions options;
  options.minimum_duration = 20;
  StateToState plan;
  ASSERT_EQ(plan.plan({&from, 1}, {&to, 1}, {&l, 1}, options), MotionStatus::ok);
  EXPECT_EQ(plan.duration(), 20);
  double fastest = 0;
  for (int i = 0; i <= 100; ++i) {
    const MotionState s = plan.axis(0).at(0.2 * i);
    EXPECT_GE(s.velocity, -1e-12) << "never back";
    fastest = std::max(fastest, s.velocity);
  }
  EXPECT_LT(fastest, 0.08) << "no faster than it must";
}

TEST(StateToState, RefusesWhatItCannotPlan) {
  MotionState from{}, to{1, 0, 0};
  MotionLimits l = MotionLimits::symmetric(2, 4, 8);
  StateToState plan;
  const auto status = [&] { return plan.plan({&from, 1}, {&to, 1}, {&l, 1}); };
  EXPECT_EQ(status(), MotionStatus::ok);
  EXPECT_EQ(plan.plan({}, {}, {}), MotionStatus::wrong_size);
  to.velocity = 2.5;
  EXPECT_EQ(status(), MotionStatus::target_outside);
  to.velocity = 1.9;
  to.acceleration = -3;  // it must have been faster than 2 before
  EXPECT_EQ(status(), MotionStatus::target_outside);
  EXPECT_EQ(plan.axis(0).at(100).position, 1) << "the last plan stands";
  to = {1, 0, 0};
  l.min_velocity = 0;
  EXPECT_EQ(status(), MotionStatus::bad_limit);
  l = MotionLimits::symmetric(2, 4, std::numeric_limits<double>::infinity());
  EXPECT_EQ(status(), MotionStatus::bad_number);
  l = MotionLimits::symmetric(2, 4, 8);
  from.position = std::nan("");
  EXPECT_EQ(status(), MotionStatus::bad_number);
  EXPECT_STRNE(name(MotionStatus::bad_number), "");
}

TEST(StateToState, GoesOnWithTheTargetsVelocityAfterTheEnd) {
  const MotionState from{}, to{1, 0.5, 0};
  const MotionLimits l = MotionLimits::symmetric(2, 4, 8);
  StateToState plan;
  ASSERT_EQ(plan.plan({&from, 1}, {&to, 1}, {&l, 1}), MotionStatus::ok);
  EXPECT_NEAR(plan.axis(0).at(plan.duration() + 2).position, 2, 1e-12);
  EXPECT_EQ(plan.axis(0).at(-1).position, 0);
}

TEST(StateToState, PlansInTheControlCycle) {
  Draw draw(8);
  StateToState plan;
  std::vector<MotionState> from(6), to(6), at(6);
  std::vector<MotionLimits> limits(6);
  for (std::size_t i = 0; i < 6; ++i) {
    limits[i] = limits_of(kKinds[0], draw, true);
    from[i] = draw.state(limits[i], 0);
    to[i] = draw.state(limits[i], 1);
  }
  test::RealtimeGuard guard;
  plan.plan(from, to, limits);
  plan.sample(0.1, at);
  EXPECT_EQ(guard.violations(), "");
}

}  // namespace
}  // namespace polyarm::trajectory::state_to_state_test
