#include "polyarm/collision/checker.hpp"

#include <gtest/gtest.h>

#include "polyarm/catalogue/catalogue.hpp"
#include "tests/collision/judge.hpp"

namespace polyarm::collision {
namespace {

using kinematics::InstructionSet;

constexpr InstructionSet kSets[] = {InstructionSet::portable, InstructionSet::avx2, InstructionSet::avx512};

RobotModel catalogue_robot(const std::string& name) {
  return description::Catalogue({POLYARM_SOURCE_DIR "/robots"}).load(name);
}

/// Draws states and compares every verdict with the judge's. Adds what was seen to the counts.
struct Counts {
  int states = 0, contacts = 0, free_by_spheres = 0, false_alarms = 0;
};
void compare(const RobotModel& model, double reach, Random& random, int states, Counts& counts) {
  const auto robot = std::make_shared<const RobotBody>(model);
  const std::vector<NamedShape> shapes = random_world(random, reach, 6);
  const World world = world_from(shapes);
  Judge judge(model, *robot, shapes);
  std::vector<std::vector<double>> all;
  std::vector<double> flat;
  std::vector<Bracket> truth;
  for (int i = 0; i < states; ++i) {
    all.push_back(random_state(model, random));
    flat.insert(flat.end(), all.back().begin(), all.back().end());
    truth.push_back(judge.distance(all.back()));
  }
  for (const InstructionSet set : kSets) {
    if (kinematics::supported(set) != set) continue;
    CheckerOptions options;
    options.instructions = set;
    const Checker checker(robot, world, options);
    Probe probe(checker);
    std::vector<std::uint8_t> touching(all.size());
    probe.touches(flat, touching);
    for (std::size_t i = 0; i < all.size(); ++i) {
      ++counts.states;
      const bool contact = truth[i].upper < 1e-7;
      counts.contacts += contact;
      counts.free_by_spheres += touching[i] == 0;
      counts.false_alarms += touching[i] && truth[i].lower > 1e-6;
      if (contact) {
        ASSERT_TRUE(touching[i]) << name(set) << " calls state " << i << " free";
        ASSERT_TRUE(probe.touches_exactly(all[i]));
      }
      ASSERT_EQ(probe.touches(all[i]), touching[i] != 0);
      if (truth[i].lower > 1e-6) {
        ASSERT_FALSE(probe.touches_exactly(all[i]));
        const double nearest = probe.nearest(all[i]).distance;
        ASSERT_LE(nearest, truth[i].upper + 1e-6);
        ASSERT_GE(nearest, truth[i].lower - 1e-6);
      }
    }
  }
}

TEST(Checker, MissesNoContactOfRandomRobotsInRandomWorlds) {
  Random random(21);
  Counts counts;
  for (int round = 0; round < 10; ++round)
    compare(random_robot(random, 4 + round % 3), 0.9, random, 50, counts);
  EXPECT_GT(counts.contacts, 200);
  EXPECT_GT(counts.free_by_spheres, 200);
  RecordProperty("states", counts.states);
}

TEST(Checker, MissesNoContactOfCatalogueRobots) {
  Random random(22);
  Counts counts;
  for (const char* name : {"universal_robots/ur5e", "franka/fer_panda", "staubli/tx2_60"})
    for (int round = 0; round < 2; ++round) compare(catalogue_robot(name), 0.9, random, 100, counts);
  EXPECT_GT(counts.contacts, 300);
  EXPECT_GT(counts.free_by_spheres, 300);
  EXPECT_LT(counts.false_alarms, counts.states / 10);
}

class InWorld : public ::testing::Test {
 protected:
  RobotModel model = catalogue_robot("universal_robots/ur5e");
  std::shared_ptr<const RobotBody> robot = std::make_shared<const RobotBody>(model);
  Random random{31};

  static World table() {
    World out;
    Shape box;
    box.size = {2, 2, 0.1};
    out.add("table", box, {{0, 0, -0.05}, {}});
    return out;
  }
};

TEST_F(InWorld, NoPointOfALinkMovesFartherThanItsLeverSays) {
  std::vector<Pose> before(robot->frames().size()), after(robot->frames().size());
  for (int i = 0; i < 300; ++i) {
    const std::vector<double> from = random_state(model, random), to = random_state(model, random);
    robot->place(from, before);
    robot->place(to, after);
    for (std::size_t l = 0; l < robot->links().size(); ++l) {
      const LinkBody& link = robot->links()[l];
      if (link.frame < 0) continue;
      double bound = 0;
      for (std::size_t j = 0; j < from.size(); ++j) bound += robot->lever(l, j) * std::abs(to[j] - from[j]);
      const auto k = static_cast<std::size_t>(link.frame);
      for (const Ball& ball : link.spheres)
        EXPECT_LE(norm(after[k] * ball.center - before[k] * ball.center), bound + 1e-12);
    }
  }
}

TEST_F(InWorld, AFreeEdgeHasNoStateInContact) {
  int free = 0, blocked = 0;
  for (int round = 0; round < 8; ++round) {
    const std::vector<NamedShape> shapes = random_world(random, 0.9, 5);
    const Checker checker(robot, world_from(shapes));
    Probe probe(checker);
    for (int i = 0; i < 60; ++i) {
      const std::vector<double> from = random_state(model, random);
      std::vector<double> to = from;
      for (double& v : to) v += random.between(-0.6, 0.6);
      const EdgeAnswer answer = probe.edge(from, to), exact = probe.edge(from, to, {true});
      if (answer.verdict == EdgeVerdict::free) EXPECT_EQ(exact.verdict, EdgeVerdict::free);
      std::vector<double> q(from.size());
      const auto at = [&](double t) {
        for (std::size_t j = 0; j < q.size(); ++j) q[j] = from[j] + t * (to[j] - from[j]);
      };
      if (exact.verdict == EdgeVerdict::touches) {
        ++blocked;
        at(exact.at);
        EXPECT_TRUE(probe.touches_exactly(q));
        EXPECT_NE(answer.verdict, EdgeVerdict::free);
      }
      if (exact.verdict != EdgeVerdict::free) continue;
      ++free;
      for (int k = 0; k <= 200; ++k) {
        at(k / 200.0);
        ASSERT_FALSE(probe.touches_exactly(q)) << round << " " << i << " at " << k / 200.0;
        if (answer.verdict == EdgeVerdict::free) ASSERT_FALSE(probe.touches(q));
      }
    }
  }
  EXPECT_GT(free, 30);
  EXPECT_GT(blocked, 30);
}

TEST_F(InWorld, AThinPlateBetweenSamplesIsFoundByAProvenEdgeAlone) {
  World world;
  Shape plate;
  plate.size = {1, 0.002, 1};
  world.add("plate", plate, {{0.6, 0, 0.5}, {}});
  const Checker checker(robot, world);
  Probe probe(checker);
  const std::vector<double> from{0.5, -0.6, 0.8, -0.3, 0, 0}, to{-0.5 - 2 * M_PI, -0.6, 0.8, -0.3, 0, 0};
  std::vector<double> near_side = from;
  near_side[0] = to[0] + 2 * M_PI;
  EXPECT_TRUE(probe.touches(std::vector<double>{0, -0.6, 0.8, -0.3, 0, 0}));
  EXPECT_EQ(probe.edge(from, near_side).verdict, EdgeVerdict::touches);
  EXPECT_EQ(probe.edge(from, near_side, {true}).verdict, EdgeVerdict::touches);
}

TEST_F(InWorld, SaysWhatIsTouchedAndHowDeep) {
  const Checker checker(robot, table());
  Probe probe(checker);
  const std::vector<double> deep{0, 0.3, 0, 0, 0, 0}, up{0, -M_PI / 2, 0, 0, 0, 0};
  const Contact contact = probe.nearest(deep);
  EXPECT_EQ(contact.second, "table");
  EXPECT_LT(contact.distance, 0);
  const Contact clear = probe.nearest(up);
  EXPECT_GT(clear.distance, 0);
  EXPECT_NEAR(norm(clear.on_first - clear.on_second), clear.distance, 1e-6);
}

TEST_F(InWorld, ABaseElsewhereMovesRobotAndResult) {
  const Pose base{{300, -200, 1}, from_rpy(0.3, 0.1, 2)};
  World world;
  for (const NamedShape& s : random_world(random, 0.9, 6)) world.add(s.name, s.shape, base);
  World plain;
  Random again(31);
  for (const NamedShape& s : random_world(again, 0.9, 6)) plain.add(s.name, s.shape);
  CheckerOptions there;
  there.T_world_base = base;
  const Checker far(robot, world, there), here(robot, plain);
  Probe a(far), b(here);
  for (int i = 0; i < 300; ++i) {
    const std::vector<double> q = random_state(model, random);
    const Contact x = a.nearest(q), y = b.nearest(q);
    EXPECT_NEAR(x.distance, y.distance, 1e-5);
    if (std::abs(y.distance) < 1e-3) continue;
    EXPECT_EQ(a.touches(q), b.touches(q));
    EXPECT_LT(norm(x.on_first - base * y.on_first), 1e-3);
  }
}

TEST_F(InWorld, ClearanceIsKept) {
  const Checker touching(robot, table());
  CheckerOptions options;
  options.clearance = 0.1;
  const Checker careful(robot, table(), options);
  Probe a(touching), b(careful);
  int between = 0;
  for (int i = 0; i < 2000; ++i) {
    const std::vector<double> q = random_state(model, random);
    if (a.touches_exactly(q)) EXPECT_TRUE(b.touches_exactly(q));
    if (!a.touches_exactly(q) && b.touches_exactly(q)) {
      ++between;
      EXPECT_TRUE(b.touches(q));
    }
  }
  EXPECT_GT(between, 50);
}

TEST_F(InWorld, AllowedPairsMayTouch) {
  const std::vector<double> deep{0, 0.3, 0, 0, 0, 0};
  CheckerOptions options;
  for (const LinkBody& link : robot->links()) options.allowed.push_back({link.name, "table"});
  const Checker checker(robot, table(), options);
  Probe probe(checker);
  EXPECT_FALSE(probe.touches(deep));
  EXPECT_FALSE(probe.touches_exactly(deep));
}

TEST_F(InWorld, WhatTheGripperHoldsBelongsToTheRobot) {
  RobotBodyOptions with;
  Shape rod;
  rod.kind = ShapeKind::capsule;
  rod.radius = 0.02, rod.length = 0.5;
  with.attached.push_back({"rod", model.tool_link(), {{0, 0, 0.27}, {}}, {rod}, {}});
  const auto holding = std::make_shared<const RobotBody>(model, with);
  const Checker empty(robot, table()), loaded(holding, table());
  Probe a(empty), b(loaded);
  int only_rod = 0;
  for (int i = 0; i < 2000; ++i) {
    const std::vector<double> q = random_state(model, random);
    if (a.touches_exactly(q)) EXPECT_TRUE(b.touches_exactly(q));
    only_rod += !a.touches(q) && b.touches(q) && b.nearest(q).first == "rod";
  }
  EXPECT_GT(only_rod, 20);
}

TEST_F(InWorld, HalfSpacesAreSolidBelow) {
  World world;
  world.add("floor", HalfSpace{{0, 0, 2}, 0.1});  // z <= 0.05
  const Checker checker(robot, world);
  Probe probe(checker);
  int solid = 0;
  for (int i = 0; i < 1000; ++i) {
    const std::vector<double> q = random_state(model, random);
    const bool exact = probe.touches_exactly(q);
    if (exact) EXPECT_TRUE(probe.touches(q));
    if (exact && probe.nearest(q).second == "floor") ++solid;
  }
  EXPECT_GT(solid, 100);
}

TEST_F(InWorld, StatesThatAreNotNumbersTouch) {
  const Checker checker(robot, table());
  Probe probe(checker);
  const std::vector<double> up{0, -M_PI / 2, 0, 0, 0, 0};
  std::vector<double> bad = up;
  bad[3] = NAN;
  EXPECT_FALSE(probe.touches(up));
  EXPECT_TRUE(probe.touches(bad));
  EXPECT_TRUE(probe.touches_exactly(bad));
  EXPECT_EQ(probe.edge(up, bad).verdict, EdgeVerdict::touches);
  EXPECT_FALSE(probe.sampled_edge(bad, up, 32));
  EXPECT_TRUE(probe.touches(std::vector<double>{0, 0}));
}

TEST_F(InWorld, WholeTurnsOfAJointChangeNothing) {
  const Checker checker(robot, world_from(random_world(random, 0.9, 6)));
  Probe probe(checker);
  for (int i = 0; i < 300; ++i) {
    const std::vector<double> q = random_state(model, random);
    std::vector<double> turned = q;
    turned[5] += 4 * M_PI, turned[0] -= 2 * M_PI;
    const double d = probe.nearest(q).distance;
    EXPECT_NEAR(probe.nearest(turned).distance, d, 1e-6);
    if (std::abs(d) > 0.02) EXPECT_EQ(probe.touches(q), probe.touches(turned));
  }
}

TEST_F(InWorld, WorldsWithBadNumbersAreRefused) {
  World world;
  Shape box;
  box.size = {1, 1, 1};
  EXPECT_THROW(world.add("box", box, {{NAN, 0, 0}, {}}), Error);
  EXPECT_THROW(world.add("box", box, {{0, 0, 0}, {0, 0, 0, 0}}), Error);
  EXPECT_THROW(world.add("plane", HalfSpace{{0, 0, 0}, 0}), Error);
  CheckerOptions options;
  options.clearance = -1;
  EXPECT_THROW(Checker(robot, world, options), Error);
  options.clearance = NAN;
  EXPECT_THROW(Checker(robot, world, options), Error);
}

TEST(RobotBody, LeavesOutNeighboursAndSrdfPairs) {
  const RobotModel model = catalogue_robot("universal_robots/ur5e");
  const RobotBody robot(model);
  for (const LinkPairBody& pair : robot.pairs())
    for (const auto& allowed : model.allowed_collisions) {
      const int a = robot.links()[pair.first].link, b = robot.links()[pair.second].link;
      EXPECT_FALSE((a == allowed[0] && b == allowed[1]) || (a == allowed[1] && b == allowed[0]));
    }
  EXPECT_GT(robot.pairs().size(), 5u);
}

TEST(RobotBody, NamesLinksWhoseMeshHasNoPieces) {
  RobotModel model = catalogue_robot("universal_robots/ur5e");
  Shape mesh;
  mesh.kind = ShapeKind::mesh;
  const auto wrist = static_cast<std::size_t>(model.find_link("wrist_3_link"));
  model.links[wrist].collisions = {mesh};
  EXPECT_EQ(RobotBody(model).without_body(), std::vector<std::string>{"wrist_3_link"});
}

}  // namespace
}  // namespace polyarm::collision
