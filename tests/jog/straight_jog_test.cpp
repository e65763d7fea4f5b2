/// A TCP that is jogged along a line, or turned about an axis, stays on it: where the world is empty,
/// whatever the arm, the pose and the speed.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <string>

#include "polyarm/description/tools.hpp"
#include "tests/jog/among.hpp"

namespace polyarm::jog::straight_jog_test {
namespace {

using test::tcp_setpoint;

/// The most that a TCP leaves its line, m, and its axis, rad.
constexpr double kOff = 1e-4, kTurned = 0.1 * M_PI / 180;

/// The same beside an obstacle, where the joints brake one by one if that is the only way to stop in time.
constexpr double kOffBeside = 5e-4;

/// How far a pose is from those that a jog from `start` may have: along `way`, and about `axis` (unit length
/// or 0).
struct Deviation {
  double off = 0, turned = 0;
};
Deviation deviation(const Pose& start, const Pose& now, const Vec3& way, const Vec3& axis) {
  const Twist by = between(start, now);
  const Vec3 d{by[0], by[1], by[2]}, r{by[3], by[4], by[5]};
  return {norm(d - dot(d, way) * way), norm(r - dot(r, axis) * axis)};
}

/// POLYARM_JOGS: how many jogs for each arm.
long jogs() {
  const char* const given = std::getenv("POLYARM_JOGS");
  return given ? std::atol(given) : 50;
}

struct Wish {
  Vec3 way, axis;
  double speed = 0, turning = 0;
  bool tool = false;
  Twist twist() const {
    return {speed * way.x,    speed * way.y,    speed * way.z,
            turning * axis.x, turning * axis.y, turning * axis.z};
  }
};

/// A translation, a rotation or both; along an axis or anywhere; slow and fast.
Wish random_wish(std::mt19937_64& engine) {
  std::uniform_real_distribution<double> even(-1, 1);
  const auto direction = [&] {
    if (engine() % 2) return normalized(Vec3{even(engine), even(engine), even(engine)});
    const double sign = engine() % 2 ? 1 : -1;
    const auto k = engine() % 3;
    return Vec3{k == 0 ? sign : 0, k == 1 ? sign : 0, k == 2 ? sign : 0};
  };
  Wish out;
  const auto kind = engine() % 5;
  const double fast = std::pow(10.0, 1.2 * even(engine));
  out.tool = kind < 4 && engine() % 2;
  if (kind < 3 || kind == 4) out.way = direction(), out.speed = 0.2 * fast;
  if (kind >= 3) out.axis = direction(), out.turning = 0.5 * fast;
  return out;
}

/// What came of one jog.
struct Course {
  Deviation most;
  double went = 0;
  bool held[kJogHolds] = {};
  bool starts_singular = false;  ///< no motion of the joints leads along the line there
  bool slides = false;           ///< the hand or the wrist came near something
  bool bends() const { return most.off > kOff || most.turned > kTurned; }
  bool says_singular() const {
    return held[static_cast<int>(JogHold::singularity)] || held[static_cast<int>(JogHold::direction)];
  }
};

/// Jogs for `lasts` s, then lets go. A broken law is in `among.rig.broken`.
Course jog(Among& among, const Wish& wish, double lasts) {
  const JogRig& rig = among.rig;
  const Pose start = rig.tcp();
  const Vec3 way = wish.tool ? start.rotation * wish.way : wish.way;
  const Vec3 axis = wish.tool ? start.rotation * wish.axis : wish.axis;
  const Twist twist = wish.twist();
  TwistSolver solver(rig.chain);
  solver.at(rig.joints());
  JogValues tangent;
  Course out;
  out.starts_singular = solver.exact(wish.tool ? turned(start.rotation, twist) : twist, tangent) > 1e-4;
  const bool turns_by_itself = rig.chain.joints() == 5;
  for (int k = 0; k < (lasts + 1) / rig.dt; ++k) {
    if (k % 2 == 0) among.look();
    const auto end = among.barriers.all.begin() + static_cast<std::ptrdiff_t>(among.barriers.count);
    out.slides =
        out.slides || std::any_of(among.barriers.all.begin(), end, [](const Barrier& b) { return b.slides; });
    if (!among.rig.step(k * rig.dt < lasts ? tcp_setpoint(twist, wish.tool) : JogSetpoint{})) break;
    out.held[static_cast<int>(rig.generator.hold())] = true;
    const Deviation now = deviation(start, rig.tcp(), way, axis);
    out.most.off = std::max(out.most.off, now.off);
    if (!turns_by_itself) out.most.turned = std::max(out.most.turned, now.turned);
  }
  out.went = norm(rig.tcp().position - start.position);
  return out;
}

class StraightJogsOf : public testing::TestWithParam<std::string> {};

TEST_P(StraightJogsOf, StayOnTheirLineWhateverTheSpeed) {
  const std::string arm = GetParam();
  std::mt19937_64 engine(5);
  std::uniform_real_distribution<double> even(0, 1);
  Among among(arm, 1, 0);
  Deviation most;
  double went = 0;
  long tried = 0, singular = 0, held[kJogHolds] = {};
  for (long i = 0; i < jogs(); ++i) {
    if (!among.start()) continue;
    const Wish wish = random_wish(engine);
    if (wish.turning > 0 && among.rig.chain.joints() < 6) continue;
    among.rig.limits = {};
    if (engine() % 3 == 0) among.rig.limits = {0.1, 0.25, 0.6};
    const double lasts = 0.2 + 1.2 * even(engine);
    const Course course = jog(among, wish, lasts);
    ASSERT_EQ(among.rig.broken, "") << arm << " " << i;
    ++tried;
    for (int k = 0; k < kJogHolds; ++k) held[k] += course.held[k];
    if (course.starts_singular) {
      EXPECT_TRUE(course.says_singular()) << arm << " " << i;
      ++singular;
      continue;
    }
    went += course.went;
    most.off = std::max(most.off, course.most.off), most.turned = std::max(most.turned, course.most.turned);
    EXPECT_FALSE(course.bends()) << arm << " " << i << ": " << 1e3 * course.most.off << " mm, "
                                 << course.most.turned * 180 / M_PI << " deg of " << 1e3 * course.went
                                 << " mm in " << lasts << " s at " << wish.speed << " m/s, " << wish.turning
                                 << " rad/s";
  }
  std::printf("%-28s %ld jogs, %.1f m, off %.4f mm, turned %.4f deg, %ld from singularities; held back by",
              arm.c_str(), tried, went, 1e3 * most.off, most.turned * 180 / M_PI, singular);
  for (int k = 1; k < kJogHolds; ++k) std::printf(" %s %ld", name(static_cast<JogHold>(k)), held[k]);
  std::printf("\n");
  EXPECT_GT(went, 0.02 * static_cast<double>(tried)) << arm;
}

/// A link that comes near an obstacle stops the TCP on its line; only the hand and the wrist slide.
TEST(StraightJogs, AmongObstaclesOnlyTheHandAndTheWristSlide) {
  std::mt19937_64 engine(9);
  long held = 0, judged = 0;
  double off = 0;
  for (const std::string arm : {"universal_robots/ur5e", "fanuc/lr_mate_200id"})
    for (int world = 0; world < 6; ++world) {
      Among among(arm, engine(), 10);
      for (int k = 0; k < 12; ++k) {
        if (!among.start()) continue;
        Wish wish = random_wish(engine);
        if (wish.speed == 0) continue;
        wish.turning = 0, wish.axis = {};
        const Course course = jog(among, wish, 0.7);
        ASSERT_EQ(among.rig.broken, "") << arm << " " << world << " " << k;
        if (course.slides || course.starts_singular) continue;
        ++judged;
        held += course.held[static_cast<int>(JogHold::body)];
        off = std::max(off, course.most.off);
        EXPECT_LT(course.most.off, kOffBeside) << arm << " " << world << " " << k;
      }
    }
  std::printf("%ld jogs, %ld held back by a body: off %.4f mm\n", judged, held, 1e3 * off);
  EXPECT_GT(held, 5);
}

/// Its own bodies are far enough from each other there: they are no reason to jog slowly.
TEST(StraightJogs, AnArmThatIsAloneReachesItsSpeed) {
  constexpr double kSpeed = 0.25;
  Among among("universal_robots/ur3", 1, 0);
  const description::Tool cup = description::find_tool("suction_cup", "");
  among.robot.tool = &cup;
  among.robot.body = surroundings::robot_body(among.robot);
  among.renew();
  for (const Vec3 way : {Vec3{0, 0, 1}, Vec3{0, 0, -1}, Vec3{0, 1, 0}, Vec3{0, -1, 0}}) {
    among.rig.start({0.3, -1.4, 1.9, -2.07, -M_PI / 2, 0.3});  // the cup points down
    among.before = among.rig.joints();
    among.rig.fastest = 0;
    const Course course = jog(among, {way, {}, kSpeed}, 0.7);
    ASSERT_EQ(among.rig.broken, "") << way.y << " " << way.z;
    EXPECT_FALSE(course.bends()) << way.y << " " << way.z;
    EXPECT_GT(among.rig.fastest, 0.95 * kSpeed) << way.y << " " << way.z;
  }
}

TEST(JogLine, BeginsALittleBesideTheJointsAtAnySpeed) {
  JogRig rig("universal_robots/ur5e");
  rig.start(rig.middle());
  Pose tcp = rig.tcp();
  tcp.position.z += 1e-4;
  JogLine line(rig.chain, rig.generator.axes(), rig.dt);
  ASSERT_TRUE(line.begin(rig.joints(), tcp, {1, 0, 0, 0, 0, 0}, false, 0, 0));
  for (int k = 0; k < 1000; ++k) {
    line.step(1e-3, 1, {});
    ASSERT_NE(line.hold(), JogHold::singularity) << k;
  }
  EXPECT_NEAR(line.speed(), 1e-3, 1e-6);
}

TEST(JogLine, AHelixGoesWhereItsDirectionPoints) {
  JogRig rig("universal_robots/ur5e");
  rig.start(rig.middle());
  const Pose tcp = rig.tcp();
  JogLine line(rig.chain, rig.generator.axes(), rig.dt);
  ASSERT_TRUE(line.begin(rig.joints(), tcp, {0.6, 0, 0.8, 0, 0, 2}, true, 0, 0));
  for (int k = 0; k < 600; ++k) {
    const Pose from = line.pose();
    const Twist before = line.direction();
    line.step(0.05, 1, {});
    const Twist after = line.direction(), by = between(from, line.pose());
    for (std::size_t i = 0; i < 6; ++i)
      ASSERT_NEAR(by[i], linear(by) * (before[i] + after[i]) / 2, 1e-9) << k << " " << i;
  }
  EXPECT_GT(linear(between(tcp, line.pose())), 0.005);
}

INSTANTIATE_TEST_SUITE_P(All, StraightJogsOf,
                         testing::Values("universal_robots/ur3", "universal_robots/ur5e",
                                         "fanuc/lr_mate_200id", "franka/fer_panda",
                                         "mitsubishi_electric/rh_6frh5520", "gantry",
                                         "the_robot_studio/so_101"),
                         [](const auto& of) { return of.param.substr(of.param.find('/') + 1); });

}  // namespace
}  // namespace polyarm::jog::straight_jog_test
