#include "polyarm/jog/jog_generator.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
#include <string>
#include <vector>

#include "tests/jog/jog_rig.hpp"
#include "tests/support/realtime_guard.hpp"

namespace polyarm::jog::jog_generator_test {
namespace {

using polyarm::test::JogRig;
using polyarm::test::joint_setpoint;
using polyarm::test::tcp_setpoint;
using Kind = JogSetpoint::Kind;

const std::vector<std::string> kArms = {"universal_robots/ur5e", "kuka/kr_10_r1100_2",
                                        "franka/fer_panda",      "ufactory/xarm_6",
                                        "ufactory/xarm5",        "mitsubishi_electric/rh_6frh5520"};

moves::Workspace table_and_box(const JogRig& rig, const Vec3& tcp) {
  const double reach = rig.chain.reach();
  return moves::Workspace(
      {{"table", {}, moves::ZoneKind::plane, tcp - Vec3{0, 0, 0.2 * reach}, {0, 0, 1}, {}, {}},
       {"wall", {}, moves::ZoneKind::plane, tcp + Vec3{0.15 * reach, 0, 0}, {-1, 0.2, 0}, {}, {}},
       {"post",
        {},
        moves::ZoneKind::outside,
        {},
        {},
        tcp + Vec3{-0.1 * reach, 0.1 * reach, -reach},
        tcp + Vec3{0.05 * reach, 0.2 * reach, reach}}});
}

JogSetpoint random_setpoint(const JogRig& rig, std::mt19937_64& engine) {
  std::uniform_real_distribution<double> even(-1, 1);
  JogSetpoint wish;
  wish.kind = static_cast<Kind>(std::uniform_int_distribution<int>(0, 4)(engine));
  wish.at_once = even(engine) > 0.5;
  wish.tool_frame = even(engine) > 0;
  const double size = std::pow(10.0, 1.5 * even(engine) - 0.5);
  for (std::size_t j = 0; j < rig.chain.joints(); ++j) {
    const AxisLimits& a = rig.generator.axes()[j];
    const double low = std::max(a.lower, -4.0), high = std::min(a.upper, 4.0);
    wish.joints[j] = wish.kind == Kind::joint_target ? (low + high) / 2 + 0.6 * (high - low) * even(engine)
                                                     : 1.5 * a.velocity * even(engine);
    wish.joint_speed[j] = even(engine) > 0.5 ? a.velocity * even(engine) : 0;
  }
  const int only = std::uniform_int_distribution<int>(0, 8)(engine);
  for (int k = 0; k < 6; ++k)
    if (only > 5 || only == k) wish.twist[static_cast<std::size_t>(k)] = size * even(engine);
  const Pose here = rig.tcp();
  wish.target = here;
  wish.target.position = here.position + Vec3{0.3 * even(engine), 0.3 * even(engine), 0.3 * even(engine)};
  wish.target.rotation =
      from_axis_angle(normalized(Vec3{even(engine), even(engine), even(engine)}), 2 * even(engine)) *
      here.rotation;
  wish.speed = 0.55 + 0.45 * even(engine);
  return wish;
}

/// Joints that go straight to a target are nearly in proportion towards another one beside it.
TEST(JogGenerator, ATargetThatShiftsALittleKeepsTheJerk) {
  for (const std::string& arm : kArms) {
    std::mt19937_64 engine(3);
    std::uniform_real_distribution<double> even(-1, 1);
    JogRig rig(arm);
    for (int i = 0; i < 40; ++i) {
      rig.start(rig.middle());
      JogSetpoint wish;
      wish.kind = Kind::joint_target;
      for (std::size_t j = 0; j < rig.chain.joints(); ++j)
        wish.joints[j] = rig.joints()[j] + 0.5 * even(engine);
      ASSERT_TRUE(rig.run(wish, 0.1 + 0.2 * std::abs(even(engine)))) << arm << " " << rig.broken;
      for (int k = 0; k < 5; ++k) {
        for (std::size_t j = 0; j < rig.chain.joints(); ++j)
          wish.joints[j] += std::pow(10.0, -3 + 1.5 * even(engine)) * even(engine);
        ASSERT_TRUE(rig.run(wish, 0.02)) << arm << " " << i << ": " << rig.broken;
      }
    }
  }
}

/// The law that matters most: whatever is wished, at whatever moment, no limit is exceeded.
TEST(JogGenerator, KeepsEveryLimitWhateverIsWished) {
  for (const std::string& arm : kArms) {
    for (const double dt : {0.001, 0.004}) {
      std::mt19937_64 engine(7);
      std::uniform_real_distribution<double> even(0, 1);
      JogRig bare(arm);
      JogRig rig(arm, table_and_box(bare, bare.chain.forward(bare.middle()).position), dt);
      rig.limits = {1, 0.5, 1.5};
      rig.start(rig.middle());
      double moved = 0;
      for (int i = 0; i < 120; ++i) {
        if (i % 40 == 0) rig.start(rig.middle());
        const Vec3 before = rig.tcp().position;
        ASSERT_TRUE(rig.run(random_setpoint(rig, engine), 0.02 + 0.7 * even(engine) * even(engine)))
            << arm << " " << dt << ": " << rig.broken;
        moved += norm(rig.tcp().position - before);
      }
      EXPECT_GE(rig.nearest, 0) << arm;
      EXPECT_LE(rig.fastest, 0.5 * 1.001) << arm;
      EXPECT_GT(moved, 2) << arm;
      std::printf("%-24s dt %.3f: %zu cycles, %.1f m, nearest %.2f mm, fastest %.4f m/s\n", arm.c_str(), dt,
                  rig.cycles, moved, 1e3 * rig.nearest, rig.fastest);
    }
  }
}

/// A joint state of arms whose middle is singular.
std::vector<double> bent(const JogRig& rig) {
  std::vector<double> q = rig.middle();
  if (rig.model.name.find("ur5e") != std::string::npos) q = {0.3, -1.2, 1.6, -1.9, -1.4, 0.5};
  if (rig.model.name.find("kr") != std::string::npos) q = {0.3, -1.3, 1.5, 0.2, 0.9, 0.5};
  if (rig.model.name.find("rh") != std::string::npos) q[1] = 1.2;
  return q;
}

TEST(JogGenerator, GoesStraightWhereNothingIsInTheWay) {
  for (const std::string& arm : kArms) {
    for (const Twist& twist :
         {Twist{0.1, 0, 0}, Twist{0, -0.1, 0}, Twist{0.05, 0.07, 0}, Twist{0, 0, 0.05}}) {
      JogRig rig(arm);
      rig.start(bent(rig));
      const Pose start = rig.tcp();
      const Vec3 way = normalized(Vec3{twist[0], twist[1], twist[2]});
      double off = 0, turned = 0;
      const auto look = [&] {
        const Vec3 d = rig.tcp().position - start.position;
        off = std::max(off, norm(d - dot(d, way) * way));
        turned = std::max(turned, angle_between(rig.tcp().rotation, start.rotation));
      };
      for (int i = 0; i < 700; ++i) {
        ASSERT_TRUE(rig.step(tcp_setpoint(twist))) << arm << rig.broken;
        look();
      }
      EXPECT_EQ(rig.generator.hold(), JogHold::none) << arm;
      EXPECT_NEAR(rig.generator.tcp_speed(), norm(Vec3{twist[0], twist[1], twist[2]}), 1e-4) << arm;
      for (int i = 0; i < 700; ++i) {
        ASSERT_TRUE(rig.step({})) << arm << rig.broken;
        look();
      }
      EXPECT_TRUE(rig.generator.standing()) << arm;
      EXPECT_LT(off, 1e-6) << arm;
      if (rig.chain.joints() >= 6) {
        EXPECT_LT(turned, 1e-6) << arm;
      }
    }
  }
}

/// A target of the TCP that does not wait until the arm has caught up.
TEST(JogGenerator, ATargetThatStartsAtFullSpeedIsCaughtUpWithSoon) {
  for (const Vec3& way : {Vec3{-1, 0, 0}, Vec3{0, -1, 0}, Vec3{-0.6, 0, 0.8}}) {
    JogRig rig("universal_robots/ur5e");
    rig.start(bent(rig));
    JogSetpoint wish;
    wish.kind = JogSetpoint::Kind::tcp_target;
    const Pose start = wish.target = rig.tcp();
    constexpr double kSpeed = 0.25;
    double near = 0;  // since when it has been within 2 mm, s
    wish.twist = {kSpeed * way.x, kSpeed * way.y, kSpeed * way.z};
    for (int i = 0; i < 1000; ++i) {
      wish.target.position = start.position + (kSpeed * i * rig.dt) * way;
      ASSERT_TRUE(rig.step(wish)) << rig.broken;
      const double lag = norm(rig.tcp().position - wish.target.position);
      EXPECT_LT(lag, 0.04);
      if (lag > 2e-3) near = (i + 1) * rig.dt;
      if (i * rig.dt > 0.45) {
        EXPECT_LT(lag, 2e-3) << i;
      }
    }
    std::printf("within 2 mm after %.3f s\n", near);
  }
}

/// Pushed into whatever is there, singular starts among them, and then the other way; where that is in the
/// way of a limit or a singularity, too, some other way leads out.
TEST(JogGenerator, AlwaysHasAWayOut) {
  constexpr double kOut = 0.015;  // m in 3 s: on a straight line out of a singularity the joints begin slowly
  for (const std::string& arm : kArms) {
    std::mt19937_64 engine(11);
    std::uniform_real_distribution<double> even(-1, 1);
    JogRig rig(arm, {}, 0.004);
    int back = 0, tried = 0;
    for (int i = 0; i < 24; ++i, ++tried) {
      std::vector<double> q;
      for (const AxisLimits& a : rig.generator.axes()) {
        const double low = std::max(a.lower, -2.8), high = std::min(a.upper, 2.8);
        q.push_back(i % 4 == 0 ? std::clamp(0.0, low, high)
                               : (low + high) / 2 + 0.45 * (high - low) * even(engine));
      }
      rig.start(q);
      Twist twist{};
      twist[static_cast<std::size_t>(i) % 3] = i % 2 ? 0.2 : -0.2;
      const auto came = [&](const Twist& t) {
        const Vec3 before = rig.tcp().position;
        EXPECT_TRUE(rig.run(tcp_setpoint(t), 3)) << arm << " " << rig.broken;
        const Vec3 d = rig.tcp().position - before;
        return (d.x * t[0] + d.y * t[1] + d.z * t[2]) / 0.2;
      };
      ASSERT_TRUE(rig.run(tcp_setpoint(twist), 5)) << arm << " " << rig.broken;
      ASSERT_TRUE(rig.run({}, 0.5)) << arm << " " << rig.broken;
      for (double& x : twist) x = -x;
      double best = came(twist);
      back += best > kOut;
      for (std::size_t k = 0; k < 6 && best < kOut; ++k) {
        Twist other{};
        other[k % 3] = k < 3 ? 0.2 : -0.2;
        best = std::max(best, came(other));
      }
      EXPECT_GT(best, kOut) << arm << " " << i << ": " << name(rig.generator.hold()) << " "
                            << rig.generator.which();
    }
    EXPECT_GT(back, 0.8 * tried) << arm;
    std::printf("%-32s %d of %d straight back\n", arm.c_str(), back, tried);
  }
}

/// The all-zero pose of a UR5e is singular: stretched out, and its wrist folded.
TEST(JogGenerator, LeavesTheStretchedPoseInwards) {
  JogRig rig("universal_robots/ur5e", {}, 0.002);
  rig.start({0, 0, 0, 0, 0, 0});
  const Vec3 start = rig.tcp().position;
  const double inwards = start.x > 0 ? -0.1 : 0.1;
  ASSERT_TRUE(rig.run(tcp_setpoint({inwards, 0, 0}), 4)) << rig.broken;
  EXPECT_GT((rig.tcp().position.x - start.x) * inwards / 0.1, 0.05);
}

TEST(JogGenerator, StopsAtAJointLimitExactlyAndLeavesIt) {
  JogRig rig("universal_robots/ur5e");
  rig.start(bent(rig));
  const double upper = rig.generator.axes()[2].upper;
  ASSERT_TRUE(rig.run(joint_setpoint(2, 3), 4)) << rig.broken;
  EXPECT_NEAR(rig.generator.axis(2).position, upper, 1e-6);
  EXPECT_EQ(rig.generator.hold(), JogHold::joint_limit);
  EXPECT_EQ(rig.generator.which(), 2);
  ASSERT_TRUE(rig.run(joint_setpoint(2, -0.5), 1)) << rig.broken;
  EXPECT_LT(rig.generator.axis(2).position, upper - 0.2);
}

/// What an arm of too few joints cannot do is said; what it can do besides is done exactly.
TEST(JogGenerator, SaysWhatAScaraCannotDo) {
  JogRig rig(kArms.back());
  rig.start(bent(rig));
  const Pose start = rig.tcp();
  ASSERT_TRUE(rig.run(tcp_setpoint({0, 0, 0, 0.5, 0, 0}), 1)) << rig.broken;
  EXPECT_EQ(rig.generator.hold(), JogHold::direction);
  EXPECT_LT(norm(rig.tcp().position - start.position), 1e-6);
  ASSERT_TRUE(rig.run({}, 0.5));
  ASSERT_TRUE(rig.run(tcp_setpoint({0, 0, 0, 0, 0, 0.3}), 1)) << rig.broken;
  EXPECT_LT(norm(rig.tcp().position - start.position), 1e-5);
  EXPECT_GT(angle_between(rig.tcp().rotation, start.rotation), 0.1);
}

moves::WorkspaceZone cone_around(const JogRig& rig, const std::vector<double>& q, double within) {
  moves::WorkspaceZone out;
  out.name = "upright";
  out.kind = moves::ZoneKind::cone;
  out.normal = rig.chain.forward(q).rotation * Vec3{0, 0, 1};
  out.within = within;
  return out;
}

moves::WorkspaceZone range_of(int joint, double lower, double upper) {
  moves::WorkspaceZone out;
  out.name = "narrow";
  out.kind = moves::ZoneKind::range;
  out.joint = "joint";
  out.index = joint;
  out.lower = lower;
  out.upper = upper;
  return out;
}

/// Random motion keeps the tool within its cone and a joint in its range, and every limit of the joints.
TEST(JogGenerator, KeepsConesAndRangesWhateverIsWished) {
  for (const std::string& arm : kArms) {
    std::mt19937_64 engine(8);
    std::uniform_real_distribution<double> even(0, 1);
    for (int k = 0; k < 4; ++k) {
      const JogRig plain(arm);
      const std::vector<double> middle = plain.middle();
      moves::WorkspaceZone range = range_of(1, middle[1] - 0.3, middle[1] + 0.2);
      range.profile = moves::ZoneProfile::full;
      JogRig rig(arm, moves::Workspace({cone_around(plain, middle, 0.15 + 0.2 * even(engine)), range}));
      rig.start(middle);
      for (int i = 0; i < 40; ++i)
        ASSERT_TRUE(rig.run(random_setpoint(rig, engine), 0.05 + 0.4 * even(engine)))
            << arm << " " << rig.broken;
      EXPECT_GT(rig.nearest, 0) << arm;
    }
  }
}

TEST(JogGenerator, AToolStopsAtItsConeAndSlidesAlong) {
  const JogRig plain("universal_robots/ur5e");
  const std::vector<double> start{0.3, -1.2, 1.6, -1.9708, -1.5708, 0.5};  // the tool looks down
  JogRig rig("universal_robots/ur5e", moves::Workspace({cone_around(plain, start, 0.2)}));
  const auto tilt = [&] { return rig.generator.workspace().distance(0, rig.tcp(), {}).distance; };
  rig.start(start);
  ASSERT_TRUE(rig.run(tcp_setpoint({0, 0, 0, 0.5, 0, 0}), 2)) << rig.broken;
  EXPECT_EQ(rig.generator.hold(), JogHold::workspace);
  EXPECT_EQ(rig.generator.which(), 0);
  EXPECT_GT(tilt(), 0);
  EXPECT_LT(tilt(), 0.01);
  const Vec3 axis = rig.tcp().rotation * Vec3{0, 0, 1};
  ASSERT_TRUE(rig.run(tcp_setpoint({0, 0, 0, 0.5, 0.5, 0}), 0.7)) << rig.broken;
  EXPECT_GT(norm(rig.tcp().rotation * Vec3{0, 0, 1} - axis), 0.05) << "it goes on along the border";
  EXPECT_GT(tilt(), 0);
  const Vec3 place = rig.tcp().position;
  ASSERT_TRUE(rig.run(tcp_setpoint({0, 0.1, 0, 0, 0, 0}), 1)) << rig.broken;
  EXPECT_GT(norm(rig.tcp().position - place), 0.05) << "it moves freely";
  ASSERT_TRUE(rig.run(tcp_setpoint({0, 0, 0, -0.5, -0.5, 0}), 0.4)) << rig.broken;
  EXPECT_GT(tilt(), 0.05) << "and comes back";
}

TEST(JogGenerator, ARangeHoldsWhileItsProfileDoes) {
  const std::vector<double> start{0.3, -1.2, 1.6, -1.9708, -1.5708, 0.5};
  moves::WorkspaceZone range = range_of(0, 0, 0.5);
  range.profile = moves::ZoneProfile::reduced;
  JogRig narrow("universal_robots/ur5e", moves::Workspace({range}));
  narrow.start(start);
  ASSERT_TRUE(narrow.run(joint_setpoint(0, 0.5), 2)) << narrow.broken;
  EXPECT_GT(narrow.joints()[0], 0.8);
  narrow.limits.reduced = true;  // it is outside now: it stops, and may only come back
  ASSERT_TRUE(narrow.run(joint_setpoint(0, 0.5), 1)) << narrow.broken;
  const double there = narrow.joints()[0];
  ASSERT_TRUE(narrow.run(joint_setpoint(0, 0.5), 1)) << narrow.broken;
  EXPECT_NEAR(narrow.joints()[0], there, 1e-6);
  EXPECT_EQ(narrow.generator.hold(), JogHold::workspace);
  ASSERT_TRUE(narrow.run(joint_setpoint(0, -0.5), 2)) << narrow.broken;
  EXPECT_LT(narrow.joints()[0], 0.4);
  ASSERT_TRUE(narrow.run(joint_setpoint(0, 0.5), 2)) << narrow.broken;
  EXPECT_LT(narrow.joints()[0], 0.5);
  EXPECT_GT(narrow.joints()[0], 0.49);
}

TEST(JogGenerator, AllocatesAndLocksNothing) {
  std::mt19937_64 engine(3);
  for (const std::string& arm : kArms) {
    JogRig bare(arm);
    JogRig rig(arm, table_and_box(bare, bare.chain.forward(bare.middle()).position));
    rig.limits = {1, 0.5, 1.5};
    rig.start(rig.middle());
    for (int i = 0; i < 40; ++i) {
      const JogSetpoint wish = random_setpoint(rig, engine);
      const polyarm::test::RealtimeGuard guard;
      for (int k = 0; k < 30; ++k) rig.generator.step(wish, rig.limits);
      ASSERT_EQ(guard.violations(), "") << arm;
    }
  }
}

}  // namespace
}  // namespace polyarm::jog::jog_generator_test
