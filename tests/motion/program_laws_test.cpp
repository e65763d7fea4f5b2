/// Random programs of joint moves, lines, arcs, splines and blends on arms of the catalogue, as they are
/// planned and followed: overrides, stops, steps back and resumes at random moments leave neither the way
/// that the moves describe nor a limit, and a change of speed in steady motion comes in time.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "polyarm/trajectory/path_override.hpp"
#include "tests/motion/arm_moves.hpp"

namespace polyarm::motion {
namespace {

using test::Arm;
using test::Values;
using trajectory::MotionLimits;
using trajectory::PathOverride;
using trajectory::TimedPath;
constexpr double kPeriod = 1e-3;

class Draw {
 public:
  explicit Draw(std::uint64_t seed) : engine_(seed) {}
  double operator()(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }

 private:
  std::mt19937_64 engine_;
};

/// Some moves about a joint state: of every kind, with and without blends, some with a stated speed.
std::vector<Move> random_program(const Arm& arm, const Values& q, Draw& draw) {
  const auto near = [&] {
    Values out = q;
    for (std::size_t j = 0; j < q.size(); ++j)
      out[j] =
          std::clamp(q[j] + draw(-0.3, 0.3), arm.chain().lower()[j] + 0.05, arm.chain().upper()[j] - 0.05);
    return out;
  };
  const auto pose = [&] { return MoveTarget{arm.chain().forward(near()), "a pose"}; };
  std::vector<Move> out;
  for (int i = 0; i < 5; ++i) {
    Move move;
    const double what = draw(0, 1);
    if (what < 0.3) {
      move = test::joint(near(), "a joint state");
    } else if (what < 0.6) {
      move.kind = MoveKind::line;
      move.targets = {pose()};
    } else if (what < 0.8) {
      move.kind = MoveKind::arc;
      move.targets = {pose(), pose()};
    } else {
      move.kind = MoveKind::spline;
      move.targets = {pose(), pose()};
    }
    if (draw(0, 1) < 0.7) move.blend = draw(0.002, 0.05);
    if (draw(0, 1) < 0.3) move.tcp_speed = draw(0.05, 0.4);
    out.push_back(std::move(move));
  }
  return out;
}

/// What the joints do in the cycle that began with these, ten times: the highest share of a limit; `harder`:
/// of an immediate stop.
double most_used(const TimedPath& path, const std::vector<MotionLimits>& limits, const PathOverride& o,
                 double time, double factor, double rate, double harder) {
  const std::size_t n = limits.size();
  Values q(n), v(n), a(n), j(n);
  std::size_t hint = 0;
  double most = 0;
  for (int k = 0; k <= 10; ++k) {
    const double t = kPeriod * k / 10, at = time + t * (factor + t * (rate / 2 + t * o.bend() / 6));
    if (at < 0 || at > path.duration()) continue;
    const double f = factor + t * (rate + t * o.bend() / 2), g = rate + t * o.bend();
    path.sample(at, q, v, a, j, hint);
    for (std::size_t i = 0; i < n; ++i) {
      const MotionLimits& l = limits[i];
      const double jerk = j[i] * f * f * f + 3 * a[i] * f * g + v[i] * o.bend();
      most = std::max({most, std::abs(v[i] * f) / l.max_velocity,
                       std::abs(a[i] * f * f + v[i] * g) / (harder * l.max_acceleration),
                       std::abs(jerk) / (harder * harder * l.max_jerk)});
    }
  }
  return most;
}

/// How far the TCP is from a line of the program where it is on one, outside of the balls that blends may
/// use.
std::optional<double> off_its_line(const Arm& arm, const PlannedMotion& motion,
                                   const std::vector<Move>& moves, double s, const Values& q) {
  double begin = 0;
  for (std::size_t i = 0; i < motion.ends.size(); ++i) {
    const double end = motion.ends[i];
    const std::size_t at = motion.first + i;
    if (s >= begin && s <= end && moves[at].kind == MoveKind::line && at > 0 && i > 0) {
      const Move& before = moves[at - 1];
      const auto place = [&](const MoveTarget& target) {
        const Pose* pose = std::get_if<Pose>(&target.at);
        return pose ? pose->position : arm.chain().forward(std::get<Values>(target.at)).position;
      };
      const Vec3 from = place(before.end()), way = place(moves[at].end()) - from;
      const Vec3 here = arm.chain().forward(q).position - from;
      if (norm(here) < before.blend || norm(here - way) < moves[at].blend) return std::nullopt;
      return norm(here - (dot(here, way) / dot(way, way)) * way);
    }
    begin = end;
  }
  return std::nullopt;
}

class ProgramLaws : public testing::TestWithParam<const char*> {};

TEST_P(ProgramLaws, WhateverIsAskedTheWayAndTheLimitsAreKept) {
  const Arm arm(GetParam());
  const Values q0 = test::bent(arm);
  const std::size_t n = q0.size();
  double most = 0, off_way = 0, off_line = 0;
  int programs = 0, changes = 0, on_lines = 0;
  for (std::uint64_t seed = 1; seed <= 40 && programs < 5; ++seed) {
    Draw draw(seed);
    const std::vector<Move> moves = random_program(arm, q0, draw);
    MovePlan plan;
    try {
      plan = plan_moves(*arm.facts, q0, moves);
    } catch (const MoveError&) {
      continue;  // leads where this arm does not go
    }
    ++programs;
    for (const PlannedMotion& motion : plan.motions) {
      PathOverride o(motion.path, plan.limits, kPeriod);
      Values q(n), v(n), a(n), way(n), none;
      double target = 1, harder = 1;
      bool immediate = false;
      std::size_t hint = 0;
      for (int cycle = 0, next = 0; cycle < 12'000 && !o.finished(); ++cycle) {
        if (cycle == next) {
          const double what = draw(0, 1);
          immediate = what < 0.1;
          target = what < 0.35 ? 0 : what < 0.45 ? -draw(0, 0.5) : what < 0.7 ? 1 : draw(0.1, 1);
          next += static_cast<int>(draw(5, 250));
          ++changes;
        }
        const double time = o.time(), factor = o.factor(), rate = o.rate();
        if (immediate) harder = PathOverride::kHarder;
        o.advance(target, immediate);
        if (o.time() > 0)
          most = std::max(most, most_used(motion.path, plan.limits, o, time, factor, rate, harder));
        if (o.stands()) immediate = false, harder = 1;
        o.sample(q, v, a);
        const double s = motion.path.profile().at(o.time(), hint).s;
        joints_on_path(motion.path.path(), {s, 0, 0, 0}, way, none, none, none);
        off_way =
            std::max(off_way, norm(arm.chain().forward(q).position - arm.chain().forward(way).position));
        if (const auto off = off_its_line(arm, motion, moves, s, q))
          off_line = std::max(off_line, *off), ++on_lines;
      }
    }
  }
  std::printf(
      "%d programs, %d changes, %d cycles on lines: %.1e m off the way, %.1e m off a line, limits %.1e\n",
      programs, changes, on_lines, off_way, off_line, most - 1);
  EXPECT_GE(programs, 3);
  EXPECT_GE(changes, 40);
  EXPECT_LT(off_way, 1e-6);
  EXPECT_LT(off_line, 1e-6);
  EXPECT_LE(most, 1 + 1e-6);
}

/// From one override to another where the plan is steady: beside what the joint needs that has the most to
/// change, by itself.
TEST_P(ProgramLaws, AChangeOfOverrideInSteadyMotionComesInTime) {
  const Arm arm(GetParam());
  const std::size_t n = arm.chain().joints();
  Values from(n), to(n);
  Draw draw(3);
  double latest = -1;
  for (int seed = 0; seed < 40; ++seed) {
    for (std::size_t j = 0; j < n; ++j) {
      const double low = std::max(arm.chain().lower()[j], -3.0), high = std::min(arm.chain().upper()[j], 3.0);
      from[j] = low + 0.02 * (high - low), to[j] = low + draw(0.5, 0.98) * (high - low);
    }
    Move move = test::joint(to, "there");
    move.speed = draw(0.1, 0.5);
    const MovePlan plan = plan_moves(*arm.facts, from, {&move, 1});
    const TimedPath& path = plan.motions.front().path;
    PathOverride o(path, plan.limits, kPeriod);
    const double first = draw(0.1, 1), second = draw(0.1, 1);
    o.begin(0.4 * path.duration(), first);
    Values q(n), v(n), a(n);
    o.sample(q, v, a);
    double needed = 0;
    for (std::size_t j = 0; j < n; ++j) {
      const double change = std::abs(v[j] / first * (second - first));
      const MotionLimits& l = plan.limits[j];
      const double ramp = l.max_acceleration / l.max_jerk;
      needed = std::max(needed, change > l.max_acceleration * ramp ? change / l.max_acceleration + ramp
                                                                   : 2 * std::sqrt(change / l.max_jerk));
    }
    int cycles = 0;
    while (!(o.factor() == second && o.rate() == 0) && !o.finished() && cycles < 5000)
      o.advance(second), ++cycles;
    if (o.finished()) continue;
    latest = std::max(latest, cycles * kPeriod - 1.1 * needed);
  }
  std::printf("at most %.1f ms more than 1.1 times what a joint needs\n", 1e3 * latest);
  EXPECT_GT(latest, -1);
  EXPECT_LE(latest, 0.1);
}

INSTANTIATE_TEST_SUITE_P(Catalogue, ProgramLaws,
                         testing::Values("universal_robots/ur5e", "universal_robots/ur3", "abb/irb_2400_10",
                                         "fanuc/m_10ia", "kuka/lbr_iiwa_7_r800", "franka/fer_panda",
                                         "ufactory/xarm_6", "yaskawa/gp7"),
                         [](const testing::TestParamInfo<const char*>& arm) {
                           std::string name = arm.param;
                           std::replace_if(
                               name.begin(), name.end(), [](char c) { return !std::isalnum(c); }, '_');
                           return name;
                         });

}  // namespace
}  // namespace polyarm::motion
