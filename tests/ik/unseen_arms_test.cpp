// Arms that are in no catalogue: every answer of the closed forms against descent from many seeds, which
// knows nothing of them.
#include "tests/kinematics/unseen_arms.hpp"

#include <gtest/gtest.h>

#include <map>

#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/descent/numeric_ik.hpp"
#include "tests/ik/asking.hpp"

namespace polyarm::ik {
namespace {

/// What was asked of one kind of arm, and what came out.
struct Unseen {
  int arms = 0, asked = 0, unsolved = 0, known = 0, lost = 0;
  test::Tally found_again;
};

using UnseenByWay = std::map<IkWay, Unseen>;

/// Poses of random states: is there an answer, is the state among the answers, and is whatever descent from
/// random seeds finds.
void compare(const std::string& robot, const Chain& chain, const InverseKinematics& arm, int poses, int seeds,
             Random& random, Unseen& out) {
  ++out.arms;
  const std::size_t n = chain.joints();
  NumericSettings settings;
  settings.position_tolerance = settings.orientation_tolerance = 1e-9;
  const NumericIk descent(chain, settings);
  for (int i = 0; i < poses; ++i) {
    const auto q = test::random_state(chain, random), seed = test::random_state(chain, random);
    const Pose target = chain.forward(q);
    IkSolution one;
    ++out.asked;
    const bool solved = arm.solve(target, seed, one) == IkOutcome::solved && one.exact &&
                        test::error_of(chain, {one.q.data(), n}, target) < 3e-9;
    out.unsolved += !solved;
    if (!solved)
      fmt::print("{} ({}) unsolved (smallest singular value {:.2g}): q = {} seed = {}\n", robot, arm.report(),
                 smallest_singular_value(chain, q), q, seed);
    if (!arm.complete() && arm.way() != IkWay::search) continue;
    test::ask(chain, arm, q, seed, robot + " (" + arm.report() + ")", out.found_again);
    IkSolutions all;
    arm.solve_all(target, seed, all);
    for (int k = 0; k < seeds; ++k) {
      IkSolution other;
      if (descent.solve(target, test::random_state(chain, random), other) != IkOutcome::solved) continue;
      if (smallest_singular_value(chain, {other.q.data(), n}) < 1e-3) continue;
      ++out.known;
      bool there = false;
      for (const IkSolution& branch : all)
        there |= test::difference(chain, {branch.q.data(), n}, {other.q.data(), n}) < 1e-5;
      out.lost += !there;
      if (!there && out.lost < 4)
        fmt::print("{} ({}) lost {} of the pose of {}\n", robot, arm.report(),
                   std::vector<double>(other.q.begin(), other.q.begin() + static_cast<std::ptrdiff_t>(n)), q);
    }
  }
}

const char* words(IkWay way) {
  constexpr const char* kWords[] = {"none", "closed form", "search", "algebra", "spare axis", "descent"};
  return kWords[static_cast<std::size_t>(way)];
}

void expect_none_missed(const UnseenByWay& all) {
  for (const auto& [way, one] : all) {
    fmt::print("{}: {} arms, {} poses, {} unsolved, {} not found again; descent found {}, {} of them lost\n",
               words(way), one.arms, one.asked, one.unsolved, one.found_again.missed, one.known, one.lost);
    EXPECT_EQ(one.unsolved, 0) << words(way);
    EXPECT_EQ(one.found_again.missed, 0) << words(way);
    EXPECT_EQ(one.lost, 0) << words(way);
    test::expect_clean(one.found_again);
  }
}

/// Of the arms of the catalogue every `step`th.
template <typename With>
void with_catalogue(std::size_t step, const With& with) {
  const description::Catalogue catalogue({POLYARM_SOURCE_DIR "/robots"});
  const auto names = catalogue.names();
  for (std::size_t i = 0; i < names.size(); i += step) with(names[i], catalogue.load(names[i]));
}

Pose any_pose(Random& random, double size) {
  return {test::random_vector(random, size),
          from_axis_angle(test::random_direction(random), random.between(-3, 3))};
}

TEST(UnseenArms, AnArmIsTheSameHoweverItIsDescribedAndMounted) {
  Random random(61);
  UnseenByWay all;
  with_catalogue(3, [&](const std::string& robot, description::RobotModel model) {
    const int tip = model.tool_link();
    const InverseKinematics before(Chain(model, tip));
    for (const int j : test::moving_joints(model, tip)) {
      if (random.unit() < 0.5) test::turn_round(model, j);
      if (random.unit() < 0.5) test::split_before(model, j, any_pose(random, 0.3));
    }
    const Chain chain(model, tip, any_pose(random, 2), any_pose(random, 0.3));
    const InverseKinematics arm(chain);
    EXPECT_EQ(arm.way(), before.way()) << robot << ": " << arm.report() << "; was " << before.report();
    EXPECT_EQ(arm.family(), before.family()) << robot << ": " << arm.report() << "; was " << before.report();
    compare(robot, chain, arm, test::poses_per_arm(10), 10, random, all[arm.way()]);
  });
  expect_none_missed(all);
}

TEST(UnseenArms, SpoiledArmsAreStillSolvedWhateverIsLeftOfTheirFamily) {
  Random random(62);
  UnseenByWay all;
  with_catalogue(3, [&](const std::string& robot, description::RobotModel model) {
    const int tip = model.tool_link();
    if (test::moving_joints(model, tip).size() < 6) return;
    const double size = std::pow(10, random.between(-5, -2));
    test::spoil(model, size, random);
    const Chain chain(model, tip);
    const InverseKinematics arm(chain);
    compare(fmt::format("{} spoiled by {:.2g}", robot, size), chain, arm, test::poses_per_arm(10), 20, random,
            all[arm.way()]);
  });
  expect_none_missed(all);
}

TEST(UnseenArms, OddLimitsHideNoAnswer) {
  Random random(63);
  UnseenByWay all;
  with_catalogue(3, [&](const std::string& robot, description::RobotModel model) {
    const int tip = model.tool_link();
    for (const int j : test::moving_joints(model, tip))
      if (random.unit() < 0.6) test::limit_oddly(model.joints[static_cast<std::size_t>(j)], random);
    const Chain chain(model, tip);
    const InverseKinematics arm(chain);
    compare(robot, chain, arm, test::poses_per_arm(10), 10, random, all[arm.way()]);
  });
  expect_none_missed(all);
}

TEST(UnseenArms, WithOneJointHeldArmsOfFiveAxesAndSixAreSolved) {
  Random random(64);
  UnseenByWay all;
  with_catalogue(3, [&](const std::string& robot, description::RobotModel model) {
    const int tip = model.tool_link();
    const auto joints = test::moving_joints(model, tip);
    if (joints.size() < 5) return;
    const std::size_t k = static_cast<std::size_t>(random.between(0, static_cast<double>(joints.size())));
    const Chain whole(model, tip);
    const double value = random.unit() < 0.5 ? 0 : random.between(-1, 1);
    test::hold(model, joints[k], value);
    const Chain chain(model, tip);
    const InverseKinematics arm(chain);
    compare(fmt::format("{} without joint {} ({:.3f})", robot, k + 1, value), chain, arm,
            test::poses_per_arm(10), 10, random, all[arm.way()]);
  });
  expect_none_missed(all);
}

TEST(UnseenArms, RailsAndSlidingJointsAreSolved) {
  Random random(65);
  UnseenByWay all;
  with_catalogue(5, [&](const std::string& robot, description::RobotModel model) {
    const int tip = model.tool_link();
    const auto joints = test::moving_joints(model, tip);
    if (joints.size() > 6) return;
    const std::size_t k = static_cast<std::size_t>(random.between(0, static_cast<double>(joints.size())));
    description::Joint& joint = model.joints[static_cast<std::size_t>(joints[k])];
    joint.type = description::JointType::prismatic;
    joint.limits.lower = -0.4, joint.limits.upper = 0.5;
    const Chain chain(model, tip);
    // Some arms are then singular wherever they are, but for the rounding of their descriptions.
    if (smallest_singular_value(chain, test::random_state(chain, random)) < 1e-5) return;
    const InverseKinematics arm(chain);
    compare(fmt::format("{} whose joint {} slides", robot, k + 1), chain, arm, test::poses_per_arm(10), 10,
            random, all[arm.way()]);
  });
  expect_none_missed(all);
}

TEST(UnseenArms, ArmsOnTwoSlidesAreSolvedWhateverTheyHaveOfTheirJoints) {
  Random random(66);
  UnseenByWay all;
  with_catalogue(5, [&](const std::string& robot, description::RobotModel model) {
    const int tip = model.tool_link();
    auto joints = test::moving_joints(model, tip);
    const Vec3 one = test::random_direction(random), two = cross(one, test::random_direction(random));
    const bool square = random.unit() < 0.5;
    test::slide_before(model, joints[0], square ? Vec3{1, 0, 0} : one);
    test::slide_before(model, joints[0], square ? Vec3{0, 1, 0} : normalized(two));
    // Five to eight axes are left.
    const std::size_t left = static_cast<std::size_t>(random.between(3, 7));
    while (joints.size() > left) {
      const auto k = static_cast<std::ptrdiff_t>(random.between(0, static_cast<double>(joints.size())));
      test::hold(model, joints[static_cast<std::size_t>(k)], random.between(-1, 1));
      joints.erase(joints.begin() + k);
    }
    const Chain chain(model, tip);
    if (smallest_singular_value(chain, test::random_state(chain, random)) < 1e-5) return;
    const InverseKinematics arm(chain);
    compare(fmt::format("{} of {} joints on two slides", robot, joints.size()), chain, arm,
            test::poses_per_arm(10), 10, random, all[arm.way()]);
  });
  expect_none_missed(all);
}

TEST(UnseenArms, JointsThatFollowOthersAreSolved) {
  Random random(67);
  UnseenByWay linked, geared;
  with_catalogue(3, [&](const std::string& robot, description::RobotModel model) {
    const int tip = model.tool_link();
    const auto joints = test::moving_joints(model, tip);
    if (joints.size() < 5) return;
    const auto any = [&] {
      return static_cast<std::size_t>(random.between(0, static_cast<double>(joints.size())));
    };
    const std::size_t k = any();
    std::size_t other = any();
    while (other == k) other = any();
    // Parallelograms and gears, in front of the joint that is followed and behind it.
    const double kind = random.unit(), multiplier = kind < 0.4 ? -1 : kind < 0.5 ? 1 : random.between(-2, 2);
    test::follow(model, joints[k], joints[other], multiplier, random.between(-1, 1));
    const Chain chain(model, tip);
    if (smallest_singular_value(chain, test::random_state(chain, random)) < 1e-5) return;
    const InverseKinematics arm(chain);
    compare(fmt::format("{} whose joint {} follows joint {}", robot, k + 1, other + 1), chain, arm,
            test::poses_per_arm(10), 10, random, (kind < 0.5 ? linked : geared)[arm.way()]);
  });
  expect_none_missed(linked);
  expect_none_missed(geared);
}

}  // namespace
}  // namespace polyarm::ik
