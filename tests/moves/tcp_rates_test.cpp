#include "polyarm/moves/tcp_rates.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <random>
#include <vector>

#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/moves/cartesian_joints.hpp"
#include "polyarm/paths/joint_path.hpp"
#include "tests/kinematics/sample_robots.hpp"
#include "tests/support/path_laws.hpp"
#include "tests/support/realtime_guard.hpp"

namespace polyarm::moves::tcp_rates_test {
namespace {

using kinematics::Chain;
using Values = std::vector<double>;

Chain chain_of(const description::RobotModel& model) {
  return Chain(model, static_cast<int>(model.links.size()) - 1,
               Pose{{1, 2, 3}, from_axis_angle({0.6, 0, 0.8}, 1)});
}
Chain ur5e() {
  const auto model = description::Catalogue({POLYARM_SOURCE_DIR "/robots"}).load("universal_robots/ur5e");
  for (std::size_t i = 0; i < model.links.size(); ++i)
    if (model.links[i].name == "tool0") return Chain(model, static_cast<int>(i));
  return chain_of(model);
}

/// Revolute, prismatic and mimic joints; a base that stands anywhere.
TEST(TcpRates, AreTheDerivativesOfWhereTheTcpIs) {
  std::mt19937_64 engine(1);
  std::uniform_real_distribution<double> even(-1, 1);
  for (const auto& model :
       {polyarm::test::ur3(), polyarm::test::seven(), polyarm::test::five(), polyarm::test::gantry()}) {
    const Chain chain = chain_of(model);
    std::vector<paths::JointWaypoint> waypoints(5);
    for (auto& w : waypoints) {
      w.radius = 0.4;
      for (std::size_t j = 0; j < chain.joints(); ++j) w.q.push_back(even(engine));
    }
    auto made = paths::joint_lines(waypoints);
    ASSERT_EQ(made.sections.size(), 1u);
    const std::shared_ptr<const paths::Path> joints = std::move(made.sections[0]);
    const TcpPath moves(chain, joints, TcpPart::translation), turns(chain, joints, TcpPart::rotation);
    polyarm::test::expect_derivatives(moves, 9, 1e-4);
    polyarm::test::expect_continuous(moves, 1e-7);
    const double h = 1e-5;
    for (int n = 1; n < 200; ++n) {
      const double s = joints->length() * n / 200;
      const auto near = [&](double b) { return std::abs(b - s) < 2 * h; };
      if (std::any_of(joints->breaks().begin(), joints->breaks().end(), near)) continue;
      const Pose at = chain.forward(polyarm::test::point_at(*joints, s).q);
      const Values told = polyarm::test::point_at(moves, s).q;
      ASSERT_LE(norm(at.position - Vec3{told[0], told[1], told[2]}), 1e-12);
      const Quaternion turned = chain.forward(polyarm::test::point_at(*joints, s + h).q).rotation *
                                inverse(chain.forward(polyarm::test::point_at(*joints, s - h).q).rotation);
      const Vec3 rate = 1 / (2 * h) * to_rotation_vector(turned);
      const auto here = polyarm::test::point_at(turns, s), low = polyarm::test::point_at(turns, s - h),
                 high = polyarm::test::point_at(turns, s + h);
      ASSERT_LE(norm(rate - Vec3{here.first[0], here.first[1], here.first[2]}), 1e-7);
      for (std::size_t k = 0; k < 3; ++k) {
        ASSERT_NEAR((high.first[k] - low.first[k]) / (2 * h), here.second[k], 1e-5);
        ASSERT_NEAR((high.second[k] - low.second[k]) / (2 * h), here.third[k], 1e-4);
      }
    }
  }
}

/// Along a Cartesian path the joints move the TCP as the path says, to the third derivative.
TEST(TcpRates, AlongAPathOfTheTcpAreThoseOfThePath) {
  const Chain ur = ur5e();
  const Values q{0, -1.4, 1.8, -2.0, -1.57, 0.3};
  const Pose start = ur.forward(q);
  Pose a = start, b = start;
  a.position = a.position + Vec3{0.1, 0.1, 0};
  b.position = a.position + Vec3{-0.1, 0.1, 0.1};
  b.rotation = b.rotation * from_axis_angle({1, 0, 0}, 0.5);
  const auto made = paths::CartesianPathBuilder(start).line(a, {0.03, ""}).line(b).build();
  const paths::CartesianPath& path = made.sections[0];
  const std::shared_ptr<const paths::Path> joints = joints_along(ur, path, q);
  const TcpPath moves(ur, joints, TcpPart::translation), turns(ur, joints, TcpPart::rotation);
  double worst[3] = {0, 0, 0};
  polyarm::test::PathPoint at = polyarm::test::point_at(moves, 0), turn = at;
  polyarm::test::RealtimeGuard guard;
  for (int n = 0; n < 2000; ++n) {
    const double s = path.length() * (n + 0.5) / 2000;
    moves.at(s, {at.q, at.first, at.second, at.third});
    turns.at(s, {turn.q, turn.first, turn.second, turn.third});
    const auto told = path.at(s);
    const Values* is[3] = {&at.first, &at.second, &at.third};
    const Values* turning[3] = {&turn.first, &turn.second, &turn.third};
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 off{(*is[k])[0] - told.linear[k].x, (*is[k])[1] - told.linear[k].y,
                     (*is[k])[2] - told.linear[k].z};
      const Vec3 off_turn{(*turning[k])[0] - told.angular[k].x, (*turning[k])[1] - told.angular[k].y,
                          (*turning[k])[2] - told.angular[k].z};
      worst[k] = std::max({worst[k], norm(off), norm(off_turn)});
    }
  }
  EXPECT_EQ(guard.violations(), "");
  std::printf("off the path's derivatives by %.1e, %.1e, %.1e\n", worst[0], worst[1], worst[2]);
  EXPECT_LE(worst[0], 1e-5);
  EXPECT_LE(worst[1], 1e-3);
  EXPECT_LE(worst[2], 0.2);
}

}  // namespace
}  // namespace polyarm::moves::tcp_rates_test
