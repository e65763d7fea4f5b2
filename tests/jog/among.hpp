#pragma once
/// Arms with a guard among random obstacles, with an exact judge of their distances. Metres, radians,
/// seconds.
#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "polyarm/jog/body_guard.hpp"
#include "tests/collision/judge.hpp"
#include "tests/jog/jog_rig.hpp"
#include "tests/surroundings/gantry.hpp"

namespace polyarm::jog {

using surroundings::GuardBodies;
using surroundings::GuardPair;
using surroundings::Moment;
using test::JogRig;

inline constexpr double kClearance = 0.005;
/// What curved motion may take of the margin, m.
inline constexpr double kSlip = 4e-4;

/// "gantry", three slides with a ball, or a robot of the catalogue.
inline description::RobotModel model_of(const std::string& arm) {
  if (arm != "gantry") return description::Catalogue({POLYARM_SOURCE_DIR "/robots"}).load(arm);
  description::RobotModel out = surroundings::gantry();
  for (description::Joint& joint : out.joints) joint.limits.lower = -0.4, joint.limits.upper = 0.4;
  return out;
}

/// An arm among random obstacles, with a guard that looks every 2 ms.
struct Among {
  Among(const std::string& arm, std::uint64_t seed, int obstacles) : rig(model_of(arm)), random(seed) {
    scene.floor = false;
    const double reach = std::isfinite(rig.chain.reach()) ? rig.chain.reach() : 1;
    while (static_cast<int>(world.size()) < obstacles) {
      collision::NamedShape one = collision::random_world(random, 0.8 * reach, 1).front();
      one.name = "obstacle " + std::to_string(world.size());
      if (norm(one.shape.pose.position) < 0.4 * reach) continue;  // the base stands there
      description::Fixture fixture;
      fixture.name = one.name;
      fixture.shapes = {one.shape};
      scene.fixtures.push_back(fixture);
      world.push_back(std::move(one));
    }
    robot = {"arm", &rig.model, nullptr, -1, false, {}};
    robot.body = surroundings::robot_body(robot);
    renew();
    nobody.assign(1, std::vector<double>(rig.chain.joints(), 0.0));
  }
  /// Takes over the robot and the scene.
  void renew() {
    bodies = std::make_unique<GuardBodies>(std::vector{robot}, scene);
    exact = std::make_unique<GuardBodies>(std::vector{robot}, scene);
    guard =
        std::make_unique<BodyGuard>(*bodies, 0, test::axis_limits(rig.model), BodyGuardOptions{kClearance});
  }
  static Moment at(const std::vector<double>& q) {
    Moment out;
    out.robots = {{{}, q}};
    return out;
  }
  double kept(const GuardPair& pair) const {
    return pair.own || exact->is_hand(pair.a) || exact->is_hand(pair.b) ? 0.001 : kClearance;
  }
  /// The smallest distance from an obstacle, and between links. Notes the pair that keeps the least of what
  /// it has to.
  double distance() {
    exact->look(at(rig.joints()));
    double out = 1e9;
    for (const GuardPair& pair : exact->pairs()) {
      if (!pair.active) continue;
      const double here = exact->gap_of(pair, 0.1).distance, more = here - kept(pair);
      out = std::min(out, here + (pair.own ? kClearance : 0));
      if (more >= excess) continue;
      excess = more;
      worst = exact->name(pair.a) + ", " + exact->name(pair.b);
    }
    return out;
  }
  /// A free state, or false.
  bool start() {
    for (int i = 0; i < 400; ++i) {
      rig.start(collision::random_state(rig.model, random));
      before = rig.joints();
      excess = 1e9;
      if (distance() > kClearance + 0.01) return true;
    }
    return false;
  }
  void look() {
    const std::vector<double> q = rig.joints();
    std::vector<double> v(q.size());
    for (std::size_t j = 0; j < q.size(); ++j) v[j] = (q[j] - before[j]) / 0.002;
    before = q;
    bodies->look(at(q));
    guard->fill(v, nobody, barriers);
    rig.generator.set_barriers(&barriers);
  }
  /// One wish for a time; false when a law is broken. Counts the nearest.
  bool run(const JogSetpoint& wish, double seconds) {
    for (int i = 0; i < seconds / rig.dt; ++i) {
      if (i % 2 == 0) look();
      if (!rig.step(wish)) return false;
      if (i % 20 == 0) nearest = std::min(nearest, distance());
      held += rig.generator.hold() == JogHold::body;
    }
    nearest = std::min(nearest, distance());
    return true;
  }

  JogRig rig;
  kinematics::Random random;
  description::Scene scene;
  std::vector<collision::NamedShape> world;
  surroundings::Robot robot;
  std::unique_ptr<GuardBodies> bodies, exact;
  std::unique_ptr<BodyGuard> guard;
  std::vector<std::vector<double>> nobody;
  std::vector<double> before;
  Barriers barriers;
  double nearest = 1e9, excess = 1e9;
  std::string worst;
  long held = 0;
};

}  // namespace polyarm::jog
