/// Moves of a base whose surroundings a test knows.
#include "polyarm/moves/base_motion.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <utility>

#include "polyarm/kinematics/random.hpp"
#include "polyarm/wheels/steering_controllers.hpp"
#include "tests/controllers/diff_drive_rig.hpp"
#include "tests/controllers/wheels_rig.hpp"

namespace polyarm::moves {
namespace {

/// A base at rest on its way to a place; the search is a job that the test runs when it wants.
struct SearchingBase {
  controllers::Base base;
  std::unique_ptr<BaseMotion> motion;
  std::function<void()> job;
  std::function<bool()> dropped;  ///< as the search sees it

  SearchingBase() {
    base.rig.start();
    base.rig.steps(5);
    motion = std::make_unique<BaseMotion>(base.drive, 0.01);
    BaseSurroundings around;
    around.T_world_odometry = [] { return Pose{}; };
    around.post = [this](std::function<void()> posted) { job = std::move(posted); };
    around.look = [this](const Pose&) {
      return [this](const std::function<bool()>& is_dropped) {
        dropped = is_dropped;
        EXPECT_EQ(is_dropped(), expects_drop);
        return std::vector<BaseLeg>{{false, {}, {1, 0, 0}, 0, false, 0, 1}};
      };
    };
    motion->set_surroundings(std::move(around));
    BaseMove move;
    move.to = Pose{{1, 0, 0}, {}};
    motion->start(move);
    tick();
    tick();
  }
  void tick() {
    base.rig.steps(1);
    motion->tick(base.rig.cycle.time, true, 1);
  }
  bool expects_drop = false;
};

TEST(BaseSearch, GoesOnWhileItsMoveWaits) {
  SearchingBase at;
  ASSERT_TRUE(at.job) << "the search was begun";
  at.job();
  EXPECT_TRUE(at.dropped);
  at.tick();
  EXPECT_FALSE(at.motion->idle());
}

TEST(BaseSearch, EndsWhenTheMoveIsDropped) {
  SearchingBase at;
  ASSERT_TRUE(at.job);
  at.motion->drop();
  at.expects_drop = true;
  at.job();
  EXPECT_TRUE(at.dropped);
  EXPECT_TRUE(at.motion->idle());
}

TEST(BaseSearch, EndsWithTheMotion) {
  SearchingBase at;
  ASSERT_TRUE(at.job);
  at.motion.reset();
  at.expects_drop = true;
  at.job();
  EXPECT_TRUE(at.dropped);
}

// ---- bases that steer

struct PlaneAt {
  double x = 0, y = 0, heading = 0;
};

PlaneAt driven(const PlaneAt& from, double curvature, double length) {
  const double turn = curvature * length / 2, chord = turn == 0 ? length : length * std::sin(turn) / turn;
  return {from.x + chord * std::cos(from.heading + turn), from.y + chord * std::sin(from.heading + turn),
          from.heading + 2 * turn};
}

double away(const PlaneAt& a, const PlaneAt& b) {
  return std::hypot(a.x - b.x, a.y - b.y);
}

/// A truck whose steering takes its time; each cycle it rolls without slip.
struct Truck {
  static constexpr double kWheelbase = 0.9, kRadius = 0.1, kCycle = 0.01, kSteeringSpeed = 1.5;
  controllers::WheelsRig<controllers::BicycleSteeringController> rig{
      {"wheel", "steering"},
      {{"traction_joints_names", {"wheel"}},
       {"steering_joints_names", {"steering"}},
       {"wheelbase", {"0.9"}},
       {"traction_wheel_radius", {"0.1"}},
       {"linear.x.max_velocity", {"0.5"}},
       {"linear.x.max_acceleration", {"0.5"}}}};
  std::unique_ptr<BaseMotion> motion;
  std::vector<BaseLeg> way;
  int searches = 0;
  PlaneAt at;

  Truck() {
    rig.rig.start();
    motion = std::make_unique<BaseMotion>(rig.base, kCycle);
    BaseSurroundings around;
    around.T_world_odometry = [] { return Pose{}; };
    around.post = [](const std::function<void()>& job) { job(); };
    around.look = [this](const Pose&) {
      ++searches;
      return [this](const std::function<bool()>&) { return way; };
    };
    motion->set_surroundings(std::move(around));
  }
  void add(double curvature, double length) {
    const PlaneAt from = way.empty() ? PlaneAt{} : end();
    const PlaneAt to = driven(from, curvature, length);
    way.push_back(
        {false, {from.x, from.y, 0}, {to.x, to.y, 0}, to.heading, length < 0, curvature, std::abs(length)});
  }
  PlaneAt end() const { return {way.back().to.x, way.back().to.y, way.back().heading}; }
  /// The distance of a place from the way.
  double beside() const {
    double out = 1e9;
    for (const BaseLeg& leg : way)
      for (int k = 0; k <= 100; ++k)
        out = std::min(
            out, away(at, driven({leg.from.x, leg.from.y,
                                  leg.heading - leg.curvature * (leg.backwards ? -leg.length : leg.length)},
                                 leg.curvature, (leg.backwards ? -leg.length : leg.length) * k / 100)));
    return out;
  }
  void start() {
    BaseMove move;
    move.to = Pose{{end().x, end().y, 0}, from_rpy(0, 0, end().heading)};
    motion->start(move);
  }
  void tick() {
    rig.rig.steps(1);
    double& angle = rig.rig.state("steering/position");
    const double wanted = rig.angle("steering"), most = kSteeringSpeed * kCycle;
    angle += std::clamp(wanted - angle, -most, most);
    const double speed = rig.velocity("wheel") * kRadius;
    rig.measure("wheel", rig.velocity("wheel"));
    at = driven(at, std::tan(angle) / kWheelbase, speed * kCycle);
    motion->tick(rig.rig.cycle.time, true, 1);
  }
};

TEST(SteeredMotion, StaysOnRandomWaysWithinItsSteering) {
  kinematics::Random random(9);
  for (int w = 0; w < 20; ++w) {
    Truck truck;
    const double sharpest = truck.motion->sharpest();
    const int legs = 1 + w % 5;
    for (int k = 0; k < legs; ++k)
      truck.add(k % 3 == 1 ? 0 : random.between(-sharpest, sharpest),
                random.between(0.2, 1.2) * (random.between(-1, 1) < 0 ? -1 : 1));
    truck.start();
    double most = 0;
    for (int k = 0; k < 6000 && !truck.motion->idle(); ++k) {
      truck.tick();
      if (k % 20 == 0) most = std::max(most, truck.beside());
      ASSERT_LE(std::abs(truck.rig.base.curvature()), truck.rig.base.sharpest() * (1 + 1e-9));
    }
    ASSERT_TRUE(truck.motion->idle()) << w;
    EXPECT_EQ(truck.motion->state_of(truck.motion->last_id()), BaseMotion::State::done) << w;
    EXPECT_LT(most, 0.01) << w;
    EXPECT_LT(away(truck.at, truck.end()), 0.01) << w;
    EXPECT_NEAR(truck.at.heading, truck.end().heading, 0.018) << w;
    EXPECT_EQ(truck.searches, 1) << w;
  }
}

TEST(SteeredMotion, BesideItsGoalItLooksForAnotherWay) {
  Truck truck;
  truck.add(0, 1);
  truck.start();
  bool pushed = false;
  for (int k = 0; k < 1000 && truck.searches <= 1 && !truck.motion->idle(); ++k) {
    truck.tick();
    if (pushed || truck.at.x < 0.97) continue;
    pushed = true;  // to the side, and the rest of its line is too short to come back
    truck.rig.base.receive("set_odometry", controllers::Numbers{{0.97, 0.04, 0}}, false);
  }
  EXPECT_EQ(truck.searches, 2);
}

}  // namespace
}  // namespace polyarm::moves
