/// Random programs of joint moves, lines, arcs, splines and blends on arms of the catalogue, as they are
/// planned and followed: overrides, stops, steps back and resumes at random moments leave neither the way
/// that the moves describe nor a limit, and a change of speed in steady motion comes in time.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "polyarm/timing/path_override.hpp"
#include "tests/moves/arm_moves.hpp"
#include "tests/support/limit_extrema.hpp"

namespace polyarm::moves::program_laws_test {
namespace {

using test::Arm;
using test::Values;
using timing::PathOverride;
using timing::TimedPath;
using trajectory::MotionLimits;
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

/// What random programs of an arm showed.
struct Seen {
  double most = 0, off_way = 0, off_line = 0,
         beyond = 0;  ///< share of a limit; m; m; rad or m outside of joint limits
  int programs = 0, changes = 0, on_lines = 0;
};

/// Follows one motion while overrides, stops, immediate stops, steps back and resumes come at random moments.
void follow(const Arm& arm, const MovePlan& plan, const PlannedMotion& motion, const std::vector<Move>& moves,
            Draw& draw, Seen& seen) {
  const std::size_t n = plan.limits.size();
  PathOverride o(motion.path, plan.limits, kPeriod);
  polyarm::test::LimitExtrema extrema(motion.path, plan.limits);
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
      ++seen.changes;
    }
    const double time = o.time(), factor = o.factor(), rate = o.rate();
    if (immediate) harder = PathOverride::kHarder;
    o.advance(target, immediate);
    if (o.time() > 0)
      seen.most = std::max(seen.most, extrema.most({time, factor, rate, o.bend(), kPeriod, harder}));
    if (o.stands()) immediate = false, harder = 1;
    o.sample(q, v, a);
    for (std::size_t j = 0; j < n; ++j)
      seen.beyond = std::max({seen.beyond, q[j] - arm.chain().upper()[j], arm.chain().lower()[j] - q[j]});
    const double s = motion.path.profile().at(o.time(), hint).s;
    timing::joints_on_path(motion.path.path(), {s, 0, 0, 0}, way, none, none, none);
    seen.off_way =
        std::max(seen.off_way, norm(arm.chain().forward(q).position - arm.chain().forward(way).position));
    if (const auto off = off_its_line(arm, motion, moves, s, q))
      seen.off_line = std::max(seen.off_line, *off), ++seen.on_lines;
  }
}

Seen random_programs(const Arm& arm, int programs, std::uint64_t seed) {
  const Values q0 = test::bent(arm);
  Seen out;
  for (const std::uint64_t end = seed + 8 * std::uint64_t(programs); seed < end && out.programs < programs;
       ++seed) {
    Draw draw(seed);
    const std::vector<Move> moves = random_program(arm, q0, draw);
    MovePlan plan;
    try {
      plan = plan_moves(*arm.facts, q0, moves);
    } catch (const MoveError&) {
      continue;  // leads where this arm does not go
    }
    ++out.programs;
    for (const PlannedMotion& motion : plan.motions) follow(arm, plan, motion, moves, draw, out);
  }
  return out;
}

void judge(const Seen& seen, const std::string& name) {
  std::printf(
      "%s: %d programs, %d changes, %d cycles on lines: %.1e m off the way, %.1e m off a line, limits %.1e\n",
      name.c_str(), seen.programs, seen.changes, seen.on_lines, seen.off_way, seen.off_line, seen.most - 1);
  EXPECT_LT(seen.off_way, 1e-6) << name;
  EXPECT_LT(seen.off_line, 1e-6) << name;
  EXPECT_LE(seen.most, 1 + 1e-6) << name;
  EXPECT_LE(seen.beyond, 1e-9) << name;
}

/// A number from the environment, for long runs by hand.
int asked(const char* variable, int otherwise) {
  const char* text = std::getenv(variable);
  return text ? std::atoi(text) : otherwise;
}

class ProgramLaws : public testing::TestWithParam<const char*> {};

/// POLYARM_LAWS_PROGRAMS, POLYARM_LAWS_SEED: how many programs, and which.
TEST_P(ProgramLaws, WhateverIsAskedTheWayAndTheLimitsAreKept) {
  const Seen seen = random_programs(Arm(GetParam()), asked("POLYARM_LAWS_PROGRAMS", 5),
                                    static_cast<std::uint64_t>(asked("POLYARM_LAWS_SEED", 1)));
  judge(seen, GetParam());
  EXPECT_GE(seen.programs, 3);
  EXPECT_GE(seen.changes, 40);
}

/// One program each of every twentieth arm of six or seven joints; POLYARM_LAWS_EVERY=1: of every one.
TEST(ProgramLawsOfTheCatalogue, WhateverIsAskedTheWayAndTheLimitsAreKept) {
  const description::Catalogue catalogue({POLYARM_SOURCE_DIR "/robots"});
  const std::vector<std::string> names = catalogue.names();
  const int every = asked("POLYARM_LAWS_EVERY", 20);
  int arms = 0, programs = 0;
  for (std::size_t k = 0; k < names.size(); k += std::size_t(every)) {
    const description::RobotModel model = catalogue.load(names[k]);
    if (model.actuated.size() < 6 || model.actuated.size() > 7) continue;
    const Seen seen = random_programs(Arm(names[k]), asked("POLYARM_LAWS_PROGRAMS", 1), k + 1);
    judge(seen, names[k]);
    ++arms, programs += seen.programs;
  }
  std::printf("%d arms, %d programs\n", arms, programs);
  EXPECT_GE(programs, arms / 2);
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
}  // namespace polyarm::moves::program_laws_test
