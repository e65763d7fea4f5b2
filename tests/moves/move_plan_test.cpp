#include "polyarm/moves/move_plan.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/moves/rounded_poses.hpp"
#include "tests/ik/answers.hpp"
#include "tests/moves/arm_moves.hpp"

namespace polyarm::moves::move_plan_test {
namespace {

using test::Arm;
using test::bent;
using test::joint;
using test::line;
using test::shifted;
using test::Values;

struct State {
  Values q, v, a, j;
};
State at(const PlannedMotion& motion, double t) {
  const std::size_t n = motion.path.joints();
  State out{Values(n), Values(n), Values(n), Values(n)};
  std::size_t hint = 0;
  motion.path.sample(t, out.q, out.v, out.a, out.j, hint);
  return out;
}

/// Limits, continuity up to the acceleration, rest at both ends.
void keeps_the_laws(const MovePlan& plan, const Values& from) {
  Values where = from;
  for (const PlannedMotion& motion : plan.motions) {
    const double end = motion.path.duration();
    State before = at(motion, 0);
    const int samples = std::max(200, static_cast<int>(end / 1e-4));
    for (std::size_t j = 0; j < where.size(); ++j) {
      EXPECT_NEAR(before.q[j], where[j], 1e-9);
      EXPECT_NEAR(before.v[j], 0, 1e-9);
    }
    for (int i = 1; i <= samples; ++i) {
      const State now = at(motion, end * i / samples);
      const double dt = end / samples;
      for (std::size_t j = 0; j < where.size(); ++j) {
        const trajectory::MotionLimits& l = plan.limits[j];
        ASSERT_LE(std::abs(now.v[j]), l.max_velocity * (1 + 1e-6));
        ASSERT_LE(std::abs(now.a[j]), l.max_acceleration * (1 + 1e-6));
        ASSERT_LE(std::abs(now.j[j]), l.max_jerk * (1 + 1e-6));
        ASSERT_LE(std::abs(now.q[j] - before.q[j]), l.max_velocity * dt * (1 + 1e-6) + 1e-9);
        ASSERT_LE(std::abs(now.v[j] - before.v[j]), l.max_acceleration * dt * (1 + 1e-6) + 1e-9);
        ASSERT_LE(std::abs(now.a[j] - before.a[j]), l.max_jerk * dt * (1 + 1e-6) + 1e-9);
      }
      before = now;
    }
    where = before.q;
    for (const double v : before.v) EXPECT_NEAR(v, 0, 1e-9);
  }
  for (std::size_t j = 0; j < where.size(); ++j) EXPECT_NEAR(where[j], plan.end[j], 1e-9);
}

double tcp_speed(const Arm& arm, const PlannedMotion& motion, double t) {
  const double h = 1e-5, end = motion.path.duration();
  const double a = std::max(0.0, t - h), b = std::min(end, t + h);
  return norm(arm.chain().forward(at(motion, b).q).position - arm.chain().forward(at(motion, a).q).position) /
         (b - a);
}
double fastest_tcp(const Arm& arm, const PlannedMotion& motion, double from = 0, double to = 1) {
  double most = 0;
  for (int i = 0; i <= 400; ++i)
    most = std::max(most, tcp_speed(arm, motion, motion.path.duration() * (from + (to - from) * i / 400)));
  return most;
}

TEST(MovePlan, AJointMoveIsTheFastestThatItsLimitsAllow) {
  const Arm arm("universal_robots/ur5e");
  const Values from = bent(arm);
  Values to = from;
  to[0] += 1.2;
  to[3] -= 0.4;
  const Move move = joint(to, "there");
  const MovePlan plan = plan_moves(*arm.facts, from, {&move, 1});
  ASSERT_EQ(plan.motions.size(), 1u);
  keeps_the_laws(plan, from);
  EXPECT_NEAR(plan.duration(), trajectory::fastest_duration(from, to, arm.facts->limits), 1e-3);
  EXPECT_EQ(plan.end, to);
}

/// Joint states in a row, all but the last to be gone through.
std::vector<Move> through(const std::vector<Values>& points) {
  std::vector<Move> out;
  for (std::size_t i = 0; i < points.size(); ++i) {
    out.push_back(joint(points[i], "point " + std::to_string(i + 1)));
    out.back().through = i + 1 < points.size();
  }
  return out;
}
/// How near the motion comes to a joint state, and when.
std::pair<double, double> nearest(const PlannedMotion& motion, const Values& q) {
  double best = 1e9, when = 0;
  for (int i = 0; i <= 20000; ++i) {
    const double t = motion.path.duration() * i / 20000;
    const State now = at(motion, t);
    double off = 0;
    for (std::size_t j = 0; j < q.size(); ++j) off = std::max(off, std::abs(now.q[j] - q[j]));
    if (off < best) best = off, when = t;
  }
  return {best, when};
}
std::vector<Values> zigzag(const Values& from) {
  Values a = from, b = from, c = from;
  a[0] += 0.5, a[2] -= 0.2;
  b[0] += 0.7, b[1] += 0.3;
  c[0] += 0.2, c[4] += 0.6;
  return {a, b, c};
}

TEST(MovePlan, MovesThroughPointsAreOneMotionThatMeetsThemAllWithoutAStop) {
  for (const char* name : {"universal_robots/ur5e", "fanuc/lr_mate_200id", "franka/fr3"}) {
    const Arm arm(name);
    const Values from = bent(arm);
    const std::vector<Values> points = zigzag(from);
    const MovePlan plan = plan_moves(*arm.facts, from, through(points));
    ASSERT_EQ(plan.motions.size(), 1u) << name;
    keeps_the_laws(plan, from);
    double before = 0;
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
      const auto [off, when] = nearest(plan.motions[0], points[i]);
      EXPECT_LT(off, 1e-3) << name;
      EXPECT_GT(when, before) << name << ": in their order";
      before = when;
      const State now = at(plan.motions[0], when);
      EXPECT_GT(*std::max_element(now.v.begin(), now.v.end()), 0.05) << name << ": it does not stop there";
    }
  }
}

TEST(MovePlan, EachMoveThroughAPointTakesAsLongAsItSays) {
  const Arm arm("universal_robots/ur5e");
  const Values from = bent(arm);
  std::vector<Move> moves = through(zigzag(from));
  moves[0].duration = 1, moves[1].duration = 3, moves[2].duration = 2;
  const MovePlan plan = plan_moves(*arm.facts, from, moves);
  ASSERT_EQ(plan.motions.size(), 1u);
  keeps_the_laws(plan, from);
  const double first = nearest(plan.motions[0], zigzag(from)[0]).second;
  const double second = nearest(plan.motions[0], zigzag(from)[1]).second;
  EXPECT_GE(first, 1 - 1e-3);
  EXPECT_GE(second - first, 3 - 1e-3);
  EXPECT_GE(plan.duration() - second, 2 - 1e-3);
  EXPECT_LT(plan.duration(), 6.8) << "and not much longer";
  for (Move& move : moves) move.duration = 0, move.speed = 0.2;
  const MovePlan slow = plan_moves(*arm.facts, from, moves);
  double fastest = 0;
  for (int i = 0; i <= 1000; ++i)
    for (const double v : at(slow.motions[0], slow.duration() * i / 1000).v)
      fastest = std::max(fastest, std::abs(v));
  EXPECT_LE(fastest, 0.2 * 3 * (1 + 1e-3));
  EXPECT_GT(fastest, 0.15 * 3);
}

TEST(MovePlan, APointThatComesTwiceIsGoneThroughOnce) {
  const Arm arm("universal_robots/ur5e");
  const Values from = bent(arm);
  const std::vector<Values> p = zigzag(from);
  const MovePlan once = plan_moves(*arm.facts, from, through(p));
  const MovePlan twice = plan_moves(*arm.facts, from, through({from, p[0], p[0], p[1], p[2], p[2]}));
  ASSERT_EQ(twice.motions.size(), 1u);
  EXPECT_NEAR(twice.duration(), once.duration(), 1e-6);
  EXPECT_EQ(twice.end, once.end);
}

TEST(MovePlan, ACurveThatWouldLeaveALimitBetweenItsPointsIsRefusedWithTheMove) {
  const Arm arm("universal_robots/ur5e");
  Values from = bent(arm);
  const double top = arm.chain().upper()[2];
  from[2] = top - 1;
  Values a = from, b = from, c = from;
  a[2] = top - 0.001, a[0] += 0.2;
  b[2] = top - 0.001, b[0] += 0.9;
  c[2] = top - 1, c[0] += 1.1;
  try {
    plan_moves(*arm.facts, from, through({a, b, c}));
    FAIL() << "it was planned";
  } catch (const MoveError& why) {
    EXPECT_EQ(why.move, 1u);
    EXPECT_EQ(why.problems().front().code, "limit");
    EXPECT_NE(why.problems().front().what.find("from point 1 to point 2"), std::string::npos) << why.what();
  }
}

TEST(MovePlan, NowhereToGoIsNoMotion) {
  const Arm arm("universal_robots/ur5e");
  const Values from = bent(arm);
  const std::vector<Move> moves{joint(from, "here"), line(arm.chain().forward(from), "here too")};
  const MovePlan plan = plan_moves(*arm.facts, from, moves);
  EXPECT_TRUE(plan.motions.empty());
  EXPECT_EQ(plan.duration(), 0);
}

TEST(MovePlan, WithoutABlendEveryMoveComesToRest) {
  const Arm arm("universal_robots/ur5e");
  const Values from = bent(arm);
  const Pose start = arm.chain().forward(from);
  const std::vector<Move> moves{line(shifted(start, {0, 0, 0.1}), "up"),
                                line(shifted(start, {0.1, 0, 0.1}), "on")};
  const MovePlan plan = plan_moves(*arm.facts, from, moves);
  ASSERT_EQ(plan.motions.size(), 2u);
  keeps_the_laws(plan, from);
}

TEST(MovePlan, ALineIsALineAtTheSpeedThatIsStated) {
  const Arm arm("universal_robots/ur5e");
  const Values from = bent(arm);
  const Pose start = arm.chain().forward(from);
  Move move = line(shifted(start, {0.05, -0.2, 0.1}), "there");
  move.tcp_speed = 0.1;
  const MovePlan plan = plan_moves(*arm.facts, from, {&move, 1});
  ASSERT_EQ(plan.motions.size(), 1u);
  keeps_the_laws(plan, from);
  EXPECT_LE(fastest_tcp(arm, plan.motions[0]), 0.1 * (1 + 1e-5));
  EXPECT_GE(fastest_tcp(arm, plan.motions[0]), 0.1 * 0.99);
  const Vec3 way = std::get<Pose>(move.end().at).position - start.position;
  for (int i = 0; i <= 200; ++i) {
    const Vec3 p = arm.chain().forward(at(plan.motions[0], plan.duration() * i / 200).q).position;
    EXPECT_LE(norm(cross(p - start.position, way)) / norm(way), 1e-6);
  }
}

/// The blend of lines, of joint moves, and of one kind with the other.
TEST(MovePlan, ABlendStaysWithinItsRadiusAndNeverStops) {
  for (const char* name : {"universal_robots/ur5e", "kuka/kr_4_r600", "franka/fr3"}) {
    const Arm arm(name);
    const Values from = bent(arm);
    const Pose start = arm.chain().forward(from);
    const Pose up = shifted(start, {0, 0, 0.08}), over = shifted(start, {0.06, 0.06, 0.08});
    const Values joints_up = polyarm::test::move(*arm.facts->solver, up, from, from).q;
    const Values joints_over = polyarm::test::move(*arm.facts->solver, over, from, from).q;
    ASSERT_FALSE(joints_up.empty() || joints_over.empty()) << name;
    const double radius = 0.02;
    for (int kinds = 0; kinds < 4; ++kinds) {
      const std::vector<Move> moves{kinds & 1 ? line(up, "up", radius) : joint(joints_up, "up", radius),
                                    kinds & 2 ? line(over, "over") : joint(joints_over, "over")};
      const MovePlan plan = plan_moves(*arm.facts, from, moves);
      ASSERT_EQ(plan.motions.size(), 1u) << name << kinds;
      keeps_the_laws(plan, from);
      const PlannedMotion& motion = plan.motions[0];
      double nearest = 1;
      for (int i = 0; i <= 1000; ++i) {
        const double t = motion.path.duration() * i / 1000;
        const Vec3 p = arm.chain().forward(at(motion, t).q).position;
        nearest = std::min(nearest, norm(p - up.position));
        if (norm(p - up.position) < radius) {
          EXPECT_GT(tcp_speed(arm, motion, t), 1e-3);
        }
      }
      EXPECT_LE(nearest, 0.6 * radius) << name << kinds;
      EXPECT_GT(nearest, 1e-4) << name << kinds;
      EXPECT_EQ(motion.first, 0u);
      EXPECT_EQ(motion.last, 1u);
      EXPECT_LT(motion.ends[0], motion.ends[1]);
    }
  }
}

TEST(MovePlan, EachMoveHasItsOwnSpeed) {
  const Arm arm("universal_robots/ur5e");
  const Values from = bent(arm);
  const Pose start = arm.chain().forward(from);
  std::vector<Move> moves{line(shifted(start, {0, 0, 0.15}), "fast", 0.01),
                          line(shifted(start, {0, 0.15, 0.15}), "slow")};
  moves[0].tcp_speed = 0.4;
  moves[1].tcp_speed = 0.05;
  const MovePlan plan = plan_moves(*arm.facts, from, moves);
  ASSERT_EQ(plan.motions.size(), 1u);
  keeps_the_laws(plan, from);
  const PlannedMotion& motion = plan.motions[0];
  const double corner = motion.path.profile().time_at(motion.ends[0]) / motion.path.duration();
  EXPECT_GT(fastest_tcp(arm, motion, 0, corner), 0.3);
  EXPECT_LE(fastest_tcp(arm, motion, 0, corner), 0.4 * (1 + 1e-5));
  EXPECT_LE(fastest_tcp(arm, motion, corner, 1), 0.05 * (1 + 1e-5));
  EXPECT_GE(fastest_tcp(arm, motion, corner, 1), 0.05 * 0.97);
}

TEST(MovePlan, SharesOfSpeedAndDurationsHold) {
  const Arm arm("universal_robots/ur5e");
  const Values from = bent(arm);
  Values to = from;
  to[1] += 0.9;
  Move move = joint(to, "there");
  const double fast = plan_moves(*arm.facts, from, {&move, 1}).duration();
  move.speed = 0.25;
  const MovePlan slow = plan_moves(*arm.facts, from, {&move, 1});
  double most = 0;
  for (int i = 0; i <= 1000; ++i)
    most = std::max(most, std::abs(at(slow.motions[0], slow.duration() * i / 1000).v[1]));
  EXPECT_NEAR(most, 0.25 * 3, 1e-6);
  move.speed = 1;
  move.duration = 2 * fast;
  EXPECT_NEAR(plan_moves(*arm.facts, from, {&move, 1}).duration(), 2 * fast, 1e-9);
  move.duration = 0.5 * fast;
  EXPECT_NEAR(plan_moves(*arm.facts, from, {&move, 1}).duration(), fast, 1e-9);
  move.duration = 0;
  move.tcp_speed = 0.1;
  EXPECT_LE(fastest_tcp(arm, plan_moves(*arm.facts, from, {&move, 1}).motions[0]), 0.1 * (1 + 1e-5));
}

TEST(MovePlan, TheCeilingHoldsForEverything) {
  const Arm arm("universal_robots/ur5e");
  const Values from = bent(arm);
  Values to = from;
  to[0] += 1;
  std::vector<Move> moves{joint(to, "there", 0.05),
                          line(shifted(arm.chain().forward(to), {0, 0, 0.2}), "up")};
  moves[1].tcp_speed = 1;
  const MovePlan plan = plan_moves(*arm.facts, from, moves, {.tcp_ceiling = 0.25});
  for (const PlannedMotion& motion : plan.motions) EXPECT_LE(fastest_tcp(arm, motion), 0.25 * (1 + 1e-5));
}

TEST(MovePlan, ManyBlendedPointsAreOneSmoothPath) {
  const Arm arm("universal_robots/ur5e");
  const Values from = bent(arm);
  const Pose start = arm.chain().forward(from);
  std::vector<Move> moves;
  for (int i = 1; i <= 40; ++i) {
    const double x = 0.003 * i, side = i % 2 ? 0.01 : 0;
    moves.push_back(line(shifted(start, {x, side, 0}), "p" + std::to_string(i), 0.004));
  }
  const MovePlan plan = plan_moves(*arm.facts, from, moves);
  ASSERT_EQ(plan.motions.size(), 1u);
  keeps_the_laws(plan, from);
  EXPECT_EQ(plan.motions[0].ends.size(), 40u);
}

std::size_t failing(const Arm& arm, const Values& from, const std::vector<Move>& moves, std::string& code,
                    std::string& text) {
  try {
    plan_moves(*arm.facts, from, moves);
  } catch (const MoveError& e) {
    code = e.problems().front().code;
    text = e.what();
    return e.move;
  }
  return 99;
}

TEST(MovePlan, AnErrorNamesItsMove) {
  const Arm arm("universal_robots/ur5e");
  const Values from = bent(arm);
  const Pose start = arm.chain().forward(from);
  const Pose up = shifted(start, {0, 0, 0.1}), far = shifted(start, {3, 0, 0});
  std::string code, text;
  EXPECT_EQ(
      failing(arm, from, {line(up, "up", 0.01), line(far, "far", 0.01), line(start, "back")}, code, text),
      1u);
  EXPECT_EQ(code, "unreachable") << text;
  Move wrong = joint({0, 1}, "two");
  EXPECT_EQ(failing(arm, from, {line(up, "up", 0.01), wrong}, code, text), 1u);
  EXPECT_EQ(code, "wrong-size") << text;
  wrong = joint(from, "here");
  wrong.speed = 0;
  EXPECT_EQ(failing(arm, from, {wrong}, code, text), 0u);
  EXPECT_EQ(code, "bad-move") << text;
  Values beyond = from;
  beyond[2] = 40;
  EXPECT_EQ(failing(arm, from, {joint(from, "here", 0.1), joint(beyond, "beyond")}, code, text), 1u);
  EXPECT_EQ(code, "limit") << text;
}

TEST(MovePlan, NoMoveLeavesTheWorkspace) {
  Arm arm("universal_robots/ur5e");
  const Values from = bent(arm);
  const Pose start = arm.chain().forward(from);
  WorkspaceZone table{"table", {}, ZoneKind::plane, start.position - Vec3{0, 0, 0.05}, {0, 0, 1}, {}, {}};
  arm.facts->workspace = Workspace({table});
  const auto wrong = [&](const std::vector<Move>& moves) {
    try {
      plan_moves(*arm.facts, from, moves);
    } catch (const MoveError& e) {
      EXPECT_EQ(e.problems().front().code, "workspace");
      return std::to_string(e.move) + " " + e.problems().front().what;
    }
    return std::string("none");
  };
  const Pose low = shifted(start, {0.02, 0, -0.1}), beside = shifted(start, {0, 0.1, 0}),
             above = shifted(start, {0.02, 0, -0.049});
  EXPECT_EQ(wrong({line(beside, "beside"), line(start, "back"), line(above, "above")}), "none");
  const std::string told = wrong({line(beside, "beside", 0.02), line(start, "back"), line(low, "low")});
  EXPECT_EQ(told.find("2 the move to low leaves the workspace: after 50.0 % of the way the TCP, at ("), 0u)
      << told;
  EXPECT_NE(told.find(fmt::format(", {:.4f}) m, crosses 'table'", start.position.z - 0.05)),
            std::string::npos)
      << told;
  EXPECT_EQ(wrong({line(beside, "beside", 0.02), line(low, "low", 0.02), line(start, "back")}).substr(0, 18),
            "1 the move to low ");

  // A joint move between two good places, whose way is not.
  Values there = from;
  there[0] += 2.4;
  const Move across = joint(there, "across");
  Values middle = from;
  middle[0] += 1.2;
  const Vec3 far = arm.chain().forward(middle).position;
  const Vec3 out = normalized(Vec3{far.x, far.y, 0});
  const double ends = dot(start.position, out);
  ASSERT_GT(dot(far, out), ends + 0.05);
  arm.facts->workspace = Workspace({{"wall", {}, ZoneKind::plane, (ends + 0.02) * out, -out, {}, {}}});
  EXPECT_NE(wrong({across}).find("crosses 'wall'"), std::string::npos);
  there[0] = from[0] + 0.02;
  EXPECT_EQ(wrong({joint(there, "near")}), "none");

  // Another tool, another TCP.
  arm.facts->workspace = Workspace({table});
  const auto longer =
      with_chain(*arm.facts, kinematics::Chain(arm.model, arm.model.tool_link(), {}, Pose{{0, 0, 0.2}, {}}));
  EXPECT_THROW(
      plan_moves(*longer, from, std::vector{line(shifted(longer->chain.forward(from), {0, 0, -0.3}), "low")}),
      MoveError);
}

TEST(MovePlan, ArmsWithFewerThanSixAxesTakeRoundedPoses) {
  struct Case {
    const char* robot;
    Vec3 from, to;
  };
  for (const Case& c : {Case{"denso/hsr065a1_n32", {0.358, 0.196, 0.008}, {0.358, 0.196, -0.074}},
                        Case{"fanuc/lr_mate_200ic_5f", {0.4, 0.1, 0.2}, {0.45, -0.05, 0.1}},
                        Case{"trossen_robotics/rx200", {0.25, 0.05, 0.15}, {0.27, -0.02, 0.1}}})
    for (const double roll : {3.14159265, 3.141593, 3.1416, 3.142}) {
      const Arm arm(c.robot);
      const Pose from{c.from, from_rpy(roll, 0, 0)}, to{c.to, from_rpy(roll, 0, 0)};
      Values q = bent(arm);
      const std::vector<Move> moves{joint(joints_for(*arm.facts, from, q, "from"), "from"), line(to, "to")};
      const MovePlan plan = plan_moves(*arm.facts, q, moves);
      keeps_the_laws(plan, q);
      const PlannedMotion& last = plan.motions.back();
      const Pose end = arm.chain().forward(at(last, last.path.duration()).q);
      EXPECT_LE(norm(end.position - to.position), kRoundedPosition) << c.robot << ", " << roll;
      EXPECT_LE(angle_between(end.rotation, to.rotation), kRoundedOrientation) << c.robot << ", " << roll;
    }
}

TEST(MovePlan, ArmsWithFewerThanSixAxesRefusePosesThatAreMoreThanRounded) {
  const Arm arm("denso/hsr065a1_n32");
  EXPECT_THROW(joints_for(*arm.facts, {{0.358, 0.196, 0.008}, from_rpy(3.145, 0, 0)}, bent(arm), "leaning"),
               Error);
  EXPECT_THROW(joints_for(*arm.facts, {{0.358, 0.196, 0.508}, from_rpy(3.1416, 0, 0)}, bent(arm), "too high"),
               Error);
}

TEST(MovePlan, ABlendThatHasNoRoomIsShrunkAndSaysSo) {
  const Arm arm("universal_robots/ur5e");
  const Values from = bent(arm);
  const Pose up = shifted(arm.chain().forward(from), {0, 0, 0.02});
  Values to = from;
  to[0] += 0.5;
  const std::vector<Move> moves{line(up, "up", 0.3), joint(to, "there")};
  const MovePlan plan = plan_moves(*arm.facts, from, moves);
  keeps_the_laws(plan, from);
  ASSERT_FALSE(plan.warnings.empty());
  EXPECT_EQ(plan.warnings[0].problem.code, "blend-shrunk");
  EXPECT_NE(plan.warnings[0].problem.what.find("up"), std::string::npos);
}

TEST(MovePlan, AWarningBelongsToItsMoveWhateverThePointsAreCalled) {
  const Arm arm("universal_robots/ur5e");
  const Values from = bent(arm);
  const Pose start = arm.chain().forward(from);
  // The third line is short. Points have one name, or a name that ends another's.
  for (const char* name : {"p", "above p"}) {
    const std::vector<Move> moves{line(shifted(start, {0, 0, 0.1}), "p", 0.01),
                                  line(shifted(start, {0, 0.1, 0.1}), "p"),
                                  line(shifted(start, {0, 0.1, 0.11}), name, 0.02),
                                  line(shifted(start, {0, 0.2, 0.11}), "p")};
    const MovePlan plan = plan_moves(*arm.facts, from, moves);
    ASSERT_EQ(plan.warnings.size(), 1u) << plan.warnings[0].problem.what;
    EXPECT_EQ(plan.warnings[0].move, 2u) << plan.warnings[0].problem.what;
  }
  const auto turned = [&](double by) {
    Values q = from;
    q[0] += by;
    return q;
  };
  Values bent_more = turned(0.45);
  bent_more[1] += 0.4;
  const std::vector<Move> joints{joint(turned(0.2), "p", 0.01), joint(turned(0.4), "p", 0.01),
                                 joint(turned(0.45), "p", 0.3), joint(bent_more, "p")};
  const MovePlan plan = plan_moves(*arm.facts, from, joints);
  ASSERT_EQ(plan.warnings.size(), 1u);
  EXPECT_EQ(plan.warnings[0].move, 2u) << plan.warnings[0].problem.what;
}

}  // namespace
}  // namespace polyarm::moves::move_plan_test
