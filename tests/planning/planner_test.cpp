#include "polyarm/planning/planner.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/paths/joint_path.hpp"
#include "polyarm/planning/pose_goals.hpp"
#include "polyarm/timing/timing.hpp"
#include "tests/planning/worlds.hpp"

namespace polyarm::planning {
namespace {

using collision::Checker;
using collision::Probe;
using collision::RobotBody;
using collision::World;
using kinematics::Chain;
using kinematics::Random;

/// One arm in one world.
struct Arm {
  Arm(const std::string& name, const World& world)
      : model(description::Catalogue({POLYARM_SOURCE_DIR "/robots"}).load(name)),
        chain(model, model.tool_link()),
        checker(std::make_shared<const RobotBody>(model), world),
        probe(checker) {}

  JointState draw(Random& random) {
    JointState q;
    for (std::size_t j = 0; j < chain.joints(); ++j) q.push_back(random_value(chain, j, random));
    return q;
  }
  JointState draw_free(Random& random) {
    for (;;)
      if (JointState q = draw(random); !probe.touches(q)) return q;
  }
  PlanQuery query(const JointState& from, const JointState& to) {
    return {from, {to}, chain.lower(), chain.upper()};
  }
  /// A pair whose straight lines are blocked, to every turn of the goal.
  PlanQuery hard_query(Random& random) {
    for (;;) {
      PlanQuery out = query(draw_free(random), draw_free(random));
      out.goals = with_turns(chain, std::move(out.goals), out.start);
      if (std::none_of(out.goals.begin(), out.goals.end(), [&](const JointState& goal) {
            return probe.edge(out.start, goal, {true}).verdict == collision::EdgeVerdict::free;
          }))
        return out;
    }
  }
  /// The same with a way. Some pairs have none: a robot in the way of itself.
  PlanQuery solvable_query(Random& random) {
    for (int i = 0; i < 20; ++i)
      if (PlanQuery out = hard_query(random); plan(probe, out, few()).outcome == PlanOutcome::found)
        return out;
    ADD_FAILURE() << "no query of 20 has a way";
    return query(draw_free(random), draw_free(random));
  }
  static PlanOptions few() {
    PlanOptions out;
    out.most_samples = 1500;
    return out;
  }
  description::RobotModel model;
  Chain chain;
  Checker checker;
  Probe probe;
};

void expect_free(Arm& arm, const Plan& plan) {
  JointState q;
  for (std::size_t i = 1; i < plan.waypoints.size(); ++i)
    for (int k = 0; k <= 100; ++k) {
      q = plan.waypoints[i - 1];
      for (std::size_t j = 0; j < q.size(); ++j) q[j] += k / 100.0 * (plan.waypoints[i][j] - q[j]);
      ASSERT_FALSE(arm.probe.touches_exactly(q)) << "edge " << i << " at " << k;
      for (std::size_t j = 0; j < q.size(); ++j) {
        ASSERT_GE(q[j], arm.chain.lower()[j] - 1e-9);
        ASSERT_LE(q[j], arm.chain.upper()[j] + 1e-9);
      }
    }
}

TEST(Planner, FindsFreeWaysBetweenRandomStates) {
  const std::pair<const char*, World> worlds[] = {{"universal_robots/ur5e", table_world()},
                                                  {"universal_robots/ur5e", shelf_world()},
                                                  {"franka/fer_panda", cage_world()}};
  for (const auto& [name, world] : worlds) {
    Arm arm(name, world);
    Random random(3);
    int found = 0;
    for (int i = 0; i < 8; ++i) {
      const PlanQuery query = arm.hard_query(random);
      const Plan made = plan(arm.probe, query, Arm::few());
      if (made.outcome != PlanOutcome::found) continue;
      ++found;
      EXPECT_EQ(made.waypoints.front(), query.start);
      EXPECT_EQ(made.waypoints.back(), query.goals[made.goal]);
      EXPECT_LE(made.length, made.length_found * (1 + 1e-9));
      expect_free(arm, made);
    }
    EXPECT_GE(found, 6) << name;
  }
}

TEST(Planner, TheSameSeedGivesTheSamePlan) {
  Arm arm("universal_robots/ur5e", shelf_world());
  Random random(4);
  const PlanQuery query = arm.solvable_query(random);
  PlanOptions other;
  other.seed = 2;
  const Plan first = plan(arm.probe, query), second = plan(arm.probe, query),
             third = plan(arm.probe, query, other);
  EXPECT_EQ(first.waypoints, second.waypoints);
  EXPECT_EQ(first.samples, second.samples);
  EXPECT_NE(first.waypoints, third.waypoints);
}

TEST(Planner, SaysWhatTheStartOrGoalTouchesAndHowDeep) {
  Arm arm("universal_robots/ur5e", table_world());
  const JointState up{0, -M_PI / 2, 0, 0, 0, 0}, deep{0, 0.3, 0, 0, 0, 0};
  const Plan bad_start = plan(arm.probe, arm.query(deep, up)),
             bad_goal = plan(arm.probe, arm.query(up, deep));
  EXPECT_EQ(bad_start.outcome, PlanOutcome::start_touches);
  EXPECT_EQ(bad_goal.outcome, PlanOutcome::goal_touches);
  EXPECT_LT(bad_start.contact.distance, 0);
  EXPECT_NE(bad_start.reason.find("the start collides: "), std::string::npos) << bad_start.reason;
  EXPECT_NE(bad_start.reason.find(" mm inside "), std::string::npos) << bad_start.reason;
  EXPECT_NE(bad_goal.reason.find("the goal collides: "), std::string::npos) << bad_goal.reason;
}

TEST(Planner, TakesAGoalThatIsFree) {
  Arm arm("universal_robots/ur5e", table_world());
  const JointState up{0, -M_PI / 2, 0, 0, 0, 0}, deep{0, 0.3, 0, 0, 0, 0}, side{1, -1.8, 0.5, 0, 0, 0};
  PlanQuery query = arm.query(up, deep);
  query.goals.push_back(side);
  const Plan made = plan(arm.probe, query);
  ASSERT_EQ(made.outcome, PlanOutcome::found) << made.reason;
  EXPECT_EQ(made.goal, 1u);
}

/// A wall between start and goal that nothing passes, because the robot cannot lift its arm over it.
World closed_world() {
  World out = table_world();
  add_box(out, "left wall", {3, 0.02, 3}, {0, 0.25, 0});
  add_box(out, "right wall", {3, 0.02, 3}, {0, -0.25, 0});
  add_box(out, "roof", {3, 3, 0.02}, {0, 0, 1.4});
  return out;
}

TEST(Planner, EndsWithABoundedNumberOfSamplesOrWhenStopped) {
  Arm arm("universal_robots/ur5e", closed_world());
  const JointState forwards{0, -1.2, 0.3, 0, 0, 0}, backwards{M_PI, -1.2, 0.3, 0, 0, 0};
  ASSERT_FALSE(arm.probe.touches_exactly(forwards)) << text_of(arm.probe.nearest(forwards));
  ASSERT_FALSE(arm.probe.touches_exactly(backwards));
  PlanQuery query = arm.query(forwards, backwards);
  for (std::size_t j = 1; j < 6; ++j) {  // so that it cannot pass upright
    query.lower[j] = query.start[j] - 0.1;
    query.upper[j] = query.start[j] + 0.1;
  }
  PlanOptions options;
  options.most_samples = 500;
  const Plan made = plan(arm.probe, query, options);
  EXPECT_EQ(made.outcome, PlanOutcome::out_of_samples);
  EXPECT_NE(made.reason.find("start and goal are free"), std::string::npos);
  EXPECT_LE(made.samples, 1000u);
  int asked = 0;
  options.most_samples = 1'000'000;
  options.stop = [&] { return ++asked > 5; };
  EXPECT_EQ(plan(arm.probe, query, options).outcome, PlanOutcome::out_of_time);
}

TEST(Planner, RefusesQueriesThatMakeNoSense) {
  Arm arm("universal_robots/ur5e", table_world());
  const JointState up{0, -M_PI / 2, 0, 0, 0, 0};
  JointState broken = up, beyond = up;
  broken[2] = NAN;
  beyond[2] = 5;
  for (const PlanQuery& query :
       {arm.query(broken, up), arm.query(up, broken), arm.query(up, beyond), arm.query({0, 0}, up),
        PlanQuery{up, {}, arm.chain.lower(), arm.chain.upper()}}) {
    const Plan made = plan(arm.probe, query);
    EXPECT_EQ(made.outcome, PlanOutcome::bad_query);
    EXPECT_FALSE(made.reason.empty());
  }
  EXPECT_NE(plan(arm.probe, arm.query(up, beyond)).reason.find("joint 3 is at 5"), std::string::npos);
}

TEST(Planner, ReachesAPoseByAnyBranchThatIsFree) {
  Arm arm("universal_robots/ur5e", shelf_world());
  const ik::InverseKinematics solver(arm.chain);
  Random random(8);
  int reached = 0;
  for (int i = 0; i < 30; ++i) {
    const JointState start = arm.draw_free(random);
    const Pose pose = arm.chain.forward(arm.draw_free(random));
    PlanQuery query{start, goals_for(solver, pose, start), arm.chain.lower(), arm.chain.upper()};
    ASSERT_GT(query.goals.size(), 1u);
    const Plan made = plan(arm.probe, query, Arm::few());
    if (made.outcome != PlanOutcome::found) continue;
    ++reached;
    const Pose there = arm.chain.forward(made.waypoints.back());
    EXPECT_LT(norm(there.position - pose.position), 1e-8);
    EXPECT_LT(angle_between(there.rotation, pose.rotation), 1e-7);
  }
  EXPECT_GE(reached, 28);
}

TEST(Planner, RoundedCornersAndTheirTimedMotionStayFree) {
  Arm arm("universal_robots/ur5e", shelf_world());
  Random random(12);
  const std::vector<trajectory::MotionLimits> limits(6, trajectory::MotionLimits::symmetric(3, 10, 100));
  int rounded = 0;
  for (int i = 0; i < 10; ++i) {
    const Plan made = plan(arm.probe, arm.solvable_query(random), Arm::few());
    ASSERT_EQ(made.outcome, PlanOutcome::found);
    const std::vector<double> radii = corner_radii(arm.probe, made.waypoints, made.exact);
    std::vector<paths::JointWaypoint> points;
    for (std::size_t k = 0; k < radii.size(); ++k) {
      points.push_back({made.waypoints[k], radii[k], {}});
      rounded += radii[k] > 0;
    }
    paths::PathSections path = paths::joint_lines(points);
    EXPECT_TRUE(path.warnings.empty());
    for (auto& section : path.sections) {
      const timing::TimedPath timed = timing::timed(std::move(section), limits);
      std::vector<double> q(6), v(6), a(6), jerk(6);
      std::size_t hint = 0;
      for (double t = 0; t < timed.duration(); t += 0.004) {
        timed.sample(t, q, v, a, jerk, hint);
        ASSERT_FALSE(arm.probe.touches_exactly(q)) << i << " at " << t;
      }
    }
  }
  EXPECT_GT(rounded, 5);
}

}  // namespace
}  // namespace polyarm::planning
