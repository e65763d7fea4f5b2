#include "polyarm/moves/cartesian_joints.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/kinematics/singularity.hpp"
#include "polyarm/moves/arm_derivatives.hpp"
#include "tests/ik/answers.hpp"
#include "tests/kinematics/sample_robots.hpp"
#include "tests/support/path_laws.hpp"
#include "tests/support/realtime_guard.hpp"

namespace polyarm::moves::cartesian_joints_test {
namespace {

using kinematics::Chain;
using paths::ArcOrientation;
using paths::CartesianPath;
using paths::CartesianPathBuilder;
using paths::Corner;
using Values = std::vector<double>;
constexpr double kPi = std::numbers::pi;

Chain arm(const std::string& name) {
  const auto model = description::Catalogue({POLYARM_SOURCE_DIR "/robots"}).load(name);
  for (const char* tip : {"tool0", "flange", "ee_link", "tool_link"})
    for (std::size_t i = 0; i < model.links.size(); ++i)
      if (model.links[i].name == tip) return Chain(model, static_cast<int>(i));
  return Chain(model, static_cast<int>(model.links.size()) - 1);
}

class Draw {
 public:
  explicit Draw(std::uint64_t seed) : engine_(seed) {}
  double even(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine_); }
  Values state(const Chain& chain) {
    Values q(chain.joints());
    for (std::size_t j = 0; j < q.size(); ++j) {
      const double low = std::max(chain.lower()[j], -kPi), high = std::min(chain.upper()[j], kPi);
      q[j] = even(low + 0.1 * (high - low), high - 0.1 * (high - low));
    }
    return q;
  }
  /// Not near a singularity.
  Values good_state(const Chain& chain) {
    for (;;) {
      const Values q = state(chain);
      if (kinematics::smallest_singular_value(chain, q) > 0.06) return q;
    }
  }
  Values near(const Values& q, double by) {
    Values out = q;
    for (double& v : out) v += even(-by, by);
    return out;
  }

 private:
  std::mt19937_64 engine_;
};

/// Lines and arcs between poses of joint states that are near each other.
CartesianPathBuilder path_near(const Chain& chain, const Values& q, Draw& draw, int segments, double radius) {
  const double by = 0.25;
  CartesianPathBuilder path(chain.forward(q));
  for (int i = 0; i < segments; ++i) {
    const Pose to = chain.forward(draw.near(q, by)), via = chain.forward(draw.near(q, by));
    if (i % 3 < 2)
      path.line(to, {radius, ""});
    else
      path.arc(via.position, to, i % 2 ? ArcOrientation::interpolated : ArcOrientation::fixed, {radius, ""});
  }
  return path;
}

/// The furthest that the TCP is off its path, m and rad.
std::pair<double, double> off_path(const Chain& chain, const paths::Path& joints, const CartesianPath& path,
                                   int samples) {
  double position = 0, turn = 0;
  for (int n = 0; n <= samples; ++n) {
    const double s = path.length() * n / samples;
    const Pose is = chain.forward(polyarm::test::point_at(joints, s).q), should = path.at(s).pose;
    position = std::max(position, norm(is.position - should.position));
    turn = std::max(turn, angle_between(is.rotation, should.rotation));
  }
  return {position, turn};
}

std::string code_of(auto&& act, std::string* text = nullptr) {
  try {
    act();
  } catch (const Error& e) {
    if (text) *text = e.what();
    return e.problems().front().code;
  }
  return "";
}

const char* const kArms[] = {"universal_robots/ur5e", "abb/irb_120", "fanuc/lr_mate_200id",
                             "kuka/lbr_iiwa_7_r800", "franka/fr3"};

TEST(ArmDerivatives, AreThoseOfTheJacobian) {
  Draw draw(1);
  std::vector<Chain> chains;
  for (const char* name : kArms) chains.push_back(arm(name));
  const auto gantry = polyarm::test::gantry();
  chains.emplace_back(gantry, static_cast<int>(gantry.links.size()) - 1,
                      Pose{{1, 2, 3}, from_axis_angle({0.6, 0, 0.8}, 1)});
  for (const Chain& chain : chains) {
    ArmDerivatives a(chain), low(chain), high(chain);
    const std::size_t n = a.columns();
    for (int k = 0; k < 50; ++k) {
      Values q(chain.joints()), d1(n), d2(n);
      for (double& v : q) v = draw.even(-1, 1);
      for (Values* v : {&d1, &d2})
        for (double& x : *v) x = draw.even(-1, 1);
      const double h = 1e-5;
      const auto at = [&](ArmDerivatives& arm, double t) {
        Values moved = q, rate = d1;
        for (std::size_t c = 0; c < n; ++c) {
          moved[a.joints()[c]] += t * d1[c] + t * t / 2 * d2[c];
          rate[c] += t * d2[c];
        }
        arm.at(moved);
        arm.move(rate);
        arm.move_on(rate, d2);
      };
      at(a, 0), at(low, -h), at(high, h);
      const Pose pose = chain.forward(q);
      EXPECT_LE(norm(a.position() - pose.position), 1e-12);
      EXPECT_LE(norm(a.rotation()[1] - pose.rotation * Vec3{0, 1, 0}), 1e-12);
      Values J(6 * chain.joints());
      chain.jacobian(q, J);
      for (std::size_t c = 0; c < n; ++c)
        for (std::size_t row = 0; row < 6; ++row) {
          const std::size_t i = 6 * c + row;
          ASSERT_NEAR(a.J()[i], J[row * chain.joints() + a.joints()[c]], 1e-12);
          ASSERT_NEAR(a.dJ()[i], (high.J()[i] - low.J()[i]) / (2 * h), 1e-7);
          ASSERT_NEAR(a.ddJ()[i], (high.dJ()[i] - low.dJ()[i]) / (2 * h), 1e-7);
        }
    }
  }
}

class OnAnyArm : public testing::TestWithParam<const char*> {};

TEST_P(OnAnyArm, TheTcpStaysOnItsPathAndTheJointsAreSmooth) {
  const Chain chain = arm(GetParam());
  Draw draw(2);
  int done = 0, refused = 0;
  double position = 0, turn = 0;
  for (int k = 0; k < 60; ++k) {
    const Values q = draw.good_state(chain);
    const auto made = path_near(chain, q, draw, 5, 0.03).build();
    ASSERT_EQ(made.sections.size(), 1u);
    const CartesianPath& path = made.sections[0];
    std::unique_ptr<const paths::PolynomialPath> joints;
    std::string text;
    const std::string code = code_of([&] { joints = joints_along(chain, path, q); }, &text);
    if (!joints) {
      EXPECT_TRUE(code == "limit" || code == "singular" || code == "unreachable" || code == "branch") << text;
      ++refused;
      continue;
    }
    ++done;
    ASSERT_EQ(joints->length(), path.length());
    ASSERT_EQ(Values(joints->breaks().begin(), joints->breaks().end()),
              Values(path.breaks().begin(), path.breaks().end()));
    const auto [p, r] = off_path(chain, *joints, path, 5000);
    position = std::max(position, p);
    turn = std::max(turn, r);
    ASSERT_LE(p, 1e-7) << k;
    ASSERT_LE(r, 1e-7) << k;
    polyarm::test::expect_continuous(*joints, 1e-6);
    if (testing::Test::HasFatalFailure()) return;
    for (int n = 0; n <= 500; ++n) {
      const Values at = polyarm::test::point_at(*joints, path.length() * n / 500).q;
      for (std::size_t j = 0; j < at.size(); ++j) {
        ASSERT_GE(at[j], chain.lower()[j] - 1e-8);
        ASSERT_LE(at[j], chain.upper()[j] + 1e-8);
      }
    }
  }
  std::printf("%s: %d followed, %d refused; off the path by at most %.1e m, %.1e rad\n", GetParam(), done,
              refused, position, turn);
  EXPECT_GT(done, 40);
}

/// Inside a piece of the path, at nodes too: the values, their differences and the third derivative.
TEST_P(OnAnyArm, ThirdDerivativesGoOnBetweenBreaks) {
  const Chain chain = arm(GetParam());
  Draw draw(3);
  int looked = 0;
  for (int k = 0; k < 20; ++k) {
    const Values q = draw.good_state(chain);
    const auto made = CartesianPathBuilder(chain.forward(q)).line(chain.forward(draw.near(q, 0.4))).build();
    std::unique_ptr<const paths::PolynomialPath> joints;
    if (!code_of([&] { joints = joints_along(chain, made.sections[0], q); }).empty()) continue;
    ++looked;
    polyarm::test::expect_derivatives(*joints, 40, 3e-4);
    const double length = joints->length();
    double most = 0, jump = 0;
    Values before;
    for (int n = 0; n <= 20000; ++n) {
      const auto at = polyarm::test::point_at(*joints, length * n / 20000);
      for (std::size_t j = 0; j < at.third.size(); ++j) {
        most = std::max(most, std::abs(at.third[j]));
        if (n > 0) jump = std::max(jump, std::abs(at.third[j] - before[j]));
      }
      before = at.third;
    }
    EXPECT_LE(jump, 0.02 * most) << k;
  }
  EXPECT_GT(looked, 10);
}

TEST_P(OnAnyArm, TheSameQuestionHasTheSameAnswer) {
  const Chain chain = arm(GetParam());
  for (int k = 0; k < 3; ++k) {
    std::vector<std::unique_ptr<const paths::PolynomialPath>> made;
    for (int twice = 0; twice < 2; ++twice) {
      Draw draw(static_cast<std::uint64_t>(40 + k));
      const Values q = draw.good_state(chain);
      const auto path = path_near(chain, q, draw, 3, 0.02).build();
      code_of([&] { made.push_back(joints_along(chain, path.sections[0], q)); });
    }
    if (made.size() < 2) continue;
    polyarm::test::RealtimeGuard guard;
    bool same = made[0]->length() == made[1]->length();
    double a[kinematics::Chain::kMaxJoints], b[kinematics::Chain::kMaxJoints];
    for (int n = 0; n <= 1000; ++n) {
      const double s = made[0]->length() * n / 1000;
      made[0]->at(s, {{a, chain.joints()}, {}, {}, {}});
      made[1]->at(s, {{b, chain.joints()}, {}, {}, {}});
      same &= std::equal(a, a + chain.joints(), b);
    }
    EXPECT_EQ(guard.violations(), "");
    EXPECT_TRUE(same);
  }
}

/// Corners of joint lines whose radius is measured at the TCP.
TEST_P(OnAnyArm, KeepsARadiusAtTheTcpOfJointLines) {
  const Chain chain = arm(GetParam());
  Draw draw(5);
  int tight = 0;
  for (int k = 0; k < 40; ++k) {
    const double radius = draw.even(0.01, 0.15);
    const Values a = draw.state(chain), b = draw.state(chain), c = draw.state(chain);
    const std::vector<paths::JointWaypoint> waypoints{{a, 0, ""}, {b, radius, ""}, {c, 0, ""}};
    paths::JointPathOptions options;
    options.tcp_distance = tcp_distance(chain);
    const auto made = paths::joint_lines(waypoints, options);
    ASSERT_EQ(made.sections.size(), 1u);
    const paths::Path& path = *made.sections[0];
    polyarm::test::expect_continuous(path);
    const auto breaks = path.breaks();
    ASSERT_EQ(breaks.size(), 4u);
    double furthest = 0;
    for (int n = 0; n <= 1000; ++n) {
      const Values q = polyarm::test::point_at(path, breaks[1] + (breaks[2] - breaks[1]) * n / 1000).q;
      furthest = std::max(furthest, norm(chain.forward(q).position - chain.forward(b).position));
    }
    ASSERT_LE(furthest, radius);
    tight += furthest > 0.95 * radius;
  }
  EXPECT_GT(tight, 30);
}

INSTANTIATE_TEST_SUITE_P(Catalogue, OnAnyArm, testing::ValuesIn(kArms), [](const auto& named) {
  std::string name = named.param;
  std::replace_if(
      name.begin(), name.end(), [](char c) { return !std::isalnum(static_cast<unsigned char>(c)); }, '_');
  return name;
});

const Values kBent{0, -1.4, 1.8, -2.0, -1.57, 0.3};

TEST(CartesianJoints, SayWhereThePathLeavesTheReach) {
  const Chain ur = arm("universal_robots/ur5e");
  const Pose start = ur.forward(kBent);
  Pose end = start;
  const Vec3 outward = normalized(Vec3{start.position.x, start.position.y, 0});
  end.position = start.position + 2.0 * outward;
  std::string text;
  EXPECT_EQ(
      code_of([&] { joints_along(ur, CartesianPathBuilder(start).line(end).build().sections[0], kBent); },
              &text),
      "unreachable")
      << text;
  const auto at = text.find("reach at ");
  ASSERT_NE(at, std::string::npos) << text;
  const double told = std::stod(text.substr(at + 9));
  // Just before it a solution is there, just behind it none.
  Pose before = start, after = start;
  before.position = start.position + (told - 1e-3) * outward;
  after.position = start.position + (told + 1e-3) * outward;
  EXPECT_TRUE(polyarm::test::descend(ur, before, kBent));
  EXPECT_FALSE(polyarm::test::descend(ur, after, kBent));
  EXPECT_EQ(
      code_of([&] { joints_along(ur, CartesianPathBuilder(end).line(start).build().sections[0], kBent); }),
      "unreachable");
}

TEST(CartesianJoints, NameTheJointThatReachesItsLimit) {
  const Chain ur = arm("universal_robots/ur5e");
  Values q = kBent;
  q[5] = 6.0;  // the last joint has 0.28 rad left
  const Pose start = ur.forward(q);
  const auto turn = [&](double angle) {
    Pose end = start;
    end.position = end.position + Vec3{0, 0, 0.2};
    end.rotation = end.rotation * from_axis_angle({0, 0, 1}, angle);
    return CartesianPathBuilder(start).line(end).build();
  };
  std::string text;
  const bool forward = code_of([&] { joints_along(ur, turn(1).sections[0], q); }, &text) == "limit";
  const double angle = forward ? 1 : -1;
  ASSERT_EQ(code_of([&] { joints_along(ur, turn(angle).sections[0], q); }, &text), "limit");
  EXPECT_NE(text.find("wrist_3_joint reaches its upper limit of 6.2832 rad"), std::string::npos) << text;
  EXPECT_NE(text.find("at 0.05"), std::string::npos) << text;  // 0.2 m for 1 rad
  EXPECT_EQ(code_of([&] { joints_along(ur, turn(-angle).sections[0], q); }, &text), "") << text;
}

/// Where the TCP only turns, places are angles, after the way before.
TEST(CartesianJoints, SayWhereInATurnTheyCannotGoOn) {
  const Chain ur = arm("universal_robots/ur5e");
  Values q = kBent;
  q[5] = 6.0;
  const Pose start = ur.forward(q);
  Pose ahead = start;
  ahead.position = ahead.position + Vec3{0, 0, 0.05};
  const auto reason = [&](const Pose& from, bool line_first, double angle) {
    Pose end = from;
    end.rotation = end.rotation * from_axis_angle({0, 0, 1}, angle);
    CartesianPathBuilder builder(start);
    if (line_first) builder.line(from);
    std::string text;
    EXPECT_EQ(code_of([&] { joints_along(ur, builder.line(end).build(), q); }, &text), "limit");
    return text;
  };
  std::string text;
  const Pose turned{start.position, start.rotation * from_axis_angle({0, 0, 1}, 1)};
  const bool forward = code_of([&] { joints_along(ur, CartesianPathBuilder(start).line(turned).build(), q); },
                               &text) == "limit";
  const double angle = forward ? 1 : -1;
  text = reason(start, false, angle);
  EXPECT_NE(text.find("at 16.2 deg of the turn, wrist_3_joint"), std::string::npos) << text;
  text = reason(ahead, true, angle);
  EXPECT_NE(text.find(" deg of the turn after 0.0500 m, wrist_3_joint"), std::string::npos) << text;
}

/// The wrist is straight in the middle of a line that does not let it turn aside.
TEST(CartesianJoints, TellWhichJointWouldTurnHowFastAtASingularity) {
  const Chain ur = arm("universal_robots/ur5e");
  Values straight = kBent;
  straight[4] = 0;
  const Pose middle = ur.forward(straight);
  Values J(36);
  ur.jacobian(straight, J);
  int singular = 0;
  std::string text;
  for (const Vec3& way : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}, Vec3{1, 1, 0}, Vec3{1, -1, 0}}) {
    Pose from = middle, to = middle;
    from.position = middle.position - 0.1 * way;
    to.position = middle.position + 0.1 * way;
    const auto path = CartesianPathBuilder(from).line(to).build();
    const std::string code = code_of([&] { joints_along(ur, path.sections[0], kBent); }, &text);
    if (code.empty()) continue;  // in the plane in which the wrist stays straight, or bends through
    ++singular;
    EXPECT_EQ(code, "singular") << text;
    EXPECT_NE(text.find("would turn by"), std::string::npos) << text;
    EXPECT_NE(text.find("_joint"), std::string::npos) << text;
  }
  EXPECT_GE(singular, 1);
}

TEST(CartesianJoints, ThatBeginSingularSayWhichJointIsInTheWay) {
  const Chain ur = arm("universal_robots/ur5e");
  Values straight = kBent;
  straight[4] = 0;
  const Pose start = ur.forward(straight);
  Pose end = start;
  end.rotation = from_axis_angle(start.rotation * Vec3{0, 1, 0}, 0.3) * end.rotation;
  end.position = end.position + Vec3{0.1, 0.2, 0};
  std::string text;
  const auto path = CartesianPathBuilder(start).line(end).build();
  EXPECT_EQ(code_of([&] { joints_along(ur, path.sections[0], straight); }, &text), "singular");
  EXPECT_NE(text.find("at 0.0000 m: wrist_"), std::string::npos) << text;
  EXPECT_NE(text.find("without bound"), std::string::npos) << text;
}

TEST(CartesianJoints, PassASingularityAsideSlowlyButOnThePath) {
  const Chain ur = arm("universal_robots/ur5e");
  Values q = kBent;
  q[4] = -2e-3;  // the wrist nearly straight
  const Pose middle = ur.forward(q);
  Pose from = middle, to = middle;
  from.position = middle.position - Vec3{0.02, 0.05, 0};
  to.position = middle.position + Vec3{0.02, 0.05, 0};
  const auto made = CartesianPathBuilder(from).line(to).build();
  std::string text;
  q[3] += 2 * kPi;  // room for half a turn
  std::unique_ptr<const paths::PolynomialPath> joints;
  const std::string code = code_of([&] { joints = joints_along(ur, made.sections[0], q); }, &text);
  ASSERT_EQ(code, "") << text;
  const auto [p, r] = off_path(ur, *joints, made.sections[0], 200000);
  EXPECT_LE(p, 1e-7);
  EXPECT_LE(r, 1e-7);
  double fastest = 0;
  for (int n = 0; n <= 10000; ++n)
    for (const double d : polyarm::test::point_at(*joints, joints->length() * n / 10000).first)
      fastest = std::max(fastest, std::abs(d));
  std::printf("beside the singularity: %zu pieces, up to %.0f rad/m\n", joints->pieces(), fastest);
}

TEST(CartesianJoints, GoOnFromSectionToSection) {
  const Chain ur = arm("universal_robots/ur5e");
  const Pose start = ur.forward(kBent);
  CartesianPathBuilder builder(start);
  Pose a = start, b = start;
  a.position = a.position + Vec3{0, 0.1, 0.05};
  b.position = a.position + Vec3{0.05, 0, 0.1};
  const auto made = joints_along(ur, builder.line(a).line(b, {0.5, "far"}).line(start).build(), kBent);
  ASSERT_EQ(made.sections.size(), 2u);
  ASSERT_EQ(made.warnings.size(), 1u);
  const auto& first = *made.sections[0];
  EXPECT_EQ(polyarm::test::point_at(first, first.length()).q,
            polyarm::test::point_at(*made.sections[1], 0).q);
  const Values back = polyarm::test::point_at(*made.sections[1], 99).q;
  for (std::size_t j = 0; j < 6; ++j) EXPECT_NEAR(back[j], kBent[j], 1e-9);
  EXPECT_EQ(code_of([&] { joints_along(ur, builder.build(), Values(5)); }), "wrong-size");
}

/// A five-joint arm can follow only paths that its joints can: those it has made itself.
TEST(CartesianJoints, OfFewerThanSixJointsFollowWhatTheyCan) {
  const auto model = polyarm::test::five();
  const Chain five(model, static_cast<int>(model.links.size()) - 1);
  const Values q{0.3, 0.4, 0.9, 0.5, 0.2};
  const Pose start = five.forward(q);
  // About the vertical axis through the base, everything turns along.
  const auto round =
      CartesianPathBuilder(start).arc_about({0, 0, 0}, {0, 0, 1}, 1.5, ArcOrientation::tangent).build();
  const auto joints = joints_along(five, round.sections[0], q);
  EXPECT_NEAR(polyarm::test::point_at(*joints, joints->length()).q[0], 1.8, 1e-6);
  Pose tilted = start;
  tilted.rotation = from_axis_angle({0, 0, 1}, 0.5) * tilted.rotation;
  EXPECT_EQ(
      code_of([&] { joints_along(five, CartesianPathBuilder(start).line(tilted).build().sections[0], q); }),
      "unreachable");
}

/// Lines, arcs and corners on a UR5e, as bench/geometry_bench measures them.
TEST(CartesianJoints, TwentySegmentsWithCorners) {
  const Chain ur = arm("universal_robots/ur5e");
  CartesianPathBuilder builder(ur.forward(kBent));
  Pose at = ur.forward(kBent);
  const Pose start = at;
  for (int i = 0; i < 20; ++i) {
    const double side = i % 4 < 2 ? 0.1 : -0.1;
    Pose to = at;
    to.position = to.position + (i % 2 ? Vec3{0, side, 0.02} : Vec3{side, 0, -0.02});
    to.rotation = start.rotation * from_axis_angle({0.6, 0.8, 0}, 0.2 * std::sin(i));
    if (i % 3 == 2)
      builder.arc(0.5 * (at.position + to.position) + Vec3{0, 0, 0.03}, to, ArcOrientation::interpolated,
                  {0.02, ""});
    else
      builder.line(to, {0.02, ""});
    at = to;
  }
  const auto path = builder.build();
  ASSERT_EQ(path.sections.size(), 1u);
  EXPECT_TRUE(path.warnings.empty());
  const auto joints = joints_along(ur, path.sections[0], kBent);
  const auto [p, r] = off_path(ur, *joints, path.sections[0], 100000);
  EXPECT_LE(p, 1e-7);
  EXPECT_LE(r, 1e-7);
  EXPECT_LT(joints->pieces(), 150u);
  std::printf("20 segments, %.2f m, %zu pieces: off the path by %.1e m, %.1e rad\n",
              path.sections[0].length(), joints->pieces(), p, r);
}

/// Every arm of the catalogue follows lines, or says why not.
TEST(CartesianJoints, WholeCatalogue) {
  const description::Catalogue catalogue({POLYARM_SOURCE_DIR "/robots"});
  int arms = 0, done = 0, refused = 0, branch = 0;
  double position = 0, turn = 0;
  for (const std::string& name : catalogue.names()) {
    const Chain chain = arm(name);
    Draw draw(7);
    ++arms;
    for (int k = 0; k < 4; ++k) {
      Values q = draw.state(chain);
      for (int more = 0; more < 50 && kinematics::smallest_singular_value(chain, q) < 0.03; ++more)
        q = draw.state(chain);
      const auto made = CartesianPathBuilder(chain.forward(q)).line(chain.forward(draw.near(q, 0.3))).build();
      std::unique_ptr<const paths::PolynomialPath> joints;
      std::string text;
      const std::string code = code_of([&] { joints = joints_along(chain, made.sections[0], q); }, &text);
      if (!joints) {
        ++refused;
        branch += code == "branch";
        continue;
      }
      ++done;
      const auto [p, r] = off_path(chain, *joints, made.sections[0], 500);
      position = std::max(position, p);
      turn = std::max(turn, r);
      EXPECT_LE(p, 1e-7) << name;
      EXPECT_LE(r, 1e-7) << name;
    }
  }
  std::printf(
      "%d arms: %d followed, %d refused (%d for the branch); off the path by at most %.1e m, %.1e rad\n",
      arms, done, refused, branch, position, turn);
  EXPECT_GT(done, 3 * refused);
}

}  // namespace
}  // namespace polyarm::moves::cartesian_joints_test
