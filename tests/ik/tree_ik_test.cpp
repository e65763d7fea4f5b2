#include "polyarm/ik/tree_ik.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "polyarm/base/error.hpp"
#include "polyarm/descent/numeric_ik.hpp"
#include "polyarm/ik/inverse_kinematics.hpp"
#include "polyarm/kinematics/random.hpp"
#include "tests/kinematics/sample_robots.hpp"
#include "tests/support/realtime_guard.hpp"

namespace polyarm::ik {
namespace {

/// Adds the moving joints of `arm` on `link` of the tree; returns its last link.
int mount(description::RobotModel& tree, const description::RobotModel& arm, int link, const Pose& at,
          const std::string& prefix) {
  const int first = static_cast<int>(tree.links.size());
  for (std::size_t i = 0; i < arm.joints.size(); ++i) {
    description::Joint joint = arm.joints[i];
    joint.name = prefix + joint.name;
    joint.parent_link = i == 0 ? link : first + static_cast<int>(i) - 1;
    joint.child_link = first + static_cast<int>(i);
    if (i == 0) joint.origin = at * joint.origin;
    const int index = static_cast<int>(tree.joints.size());
    if (joint.moves()) tree.actuated.push_back(index);
    tree.joints.push_back(joint);
    tree.links.push_back({prefix + "link_" + std::to_string(i), {}, {}, {}, index});
  }
  return static_cast<int>(tree.links.size()) - 1;
}

/// A torso that turns and lifts, and an arm on either side.
struct TwoArms {
  description::RobotModel model;
  int left = 0, right = 0;

  explicit TwoArms(const description::RobotModel& arm) {
    model = test::serial_robot("two_arms", {{"turn", {0, 0, 0.5}, {0, 0, 0}, {0, 0, 1}, -1.5, 1.5},
                                            {"lift", {0, 0, 0.1}, {0, 0, 0}, {0, 0, 1}, 0, 0.4}});
    model.joints[1].type = description::JointType::prismatic;
    const int torso = static_cast<int>(model.links.size()) - 1;
    left = mount(model, arm, torso, {{0, 0.25, 0.3}, {}}, "left_");
    right = mount(model, arm, torso, {{0, -0.25, 0.3}, {}}, "right_");
  }
  std::array<TreeTip, 2> tips() const { return {TreeTip{left, {}}, TreeTip{right, {{0, 0, 0.1}, {}}}}; }
};

std::vector<double> random_state(const description::RobotModel& model, int tip, Random& random) {
  const Chain chain(model, tip);
  std::vector<double> q;
  for (std::size_t j = 0; j < chain.joints(); ++j) q.push_back(random_value(chain, j, random));
  return q;
}

void expect_there(const TreeIk& ik, std::size_t tip, const Pose& target, const TreeSolution& found) {
  const Pose there = ik.forward(tip, {found.q.data(), ik.joints()});
  EXPECT_LT(norm(there.position - target.position), 1.01e-6);
  EXPECT_LT(angle_between(there.rotation, target.rotation), 1.01e-6);
}

TEST(TreeIk, PutsTwoArmsOnASharedTorsoWhereTheyAreWanted) {
  for (const auto& arm : {test::ur3(), test::seven()}) {
    const TwoArms robot(arm);
    const TreeIk ik(robot.model, robot.tips());
    const Chain limits(robot.model, robot.left);
    Random random(50);
    for (int i = 0; i < 200; ++i) {
      const auto q = random_state(robot.model, robot.left, random);
      const TreeTask tasks[] = {{ik.forward(0, q), {}, 1}, {ik.forward(1, q), {}, 1}};
      TreeSolution found;
      ASSERT_EQ(ik.solve(tasks, random_state(robot.model, robot.left, random), found), IkOutcome::solved)
          << i << " " << testing::PrintToString(q);
      expect_there(ik, 0, tasks[0].target, found);
      expect_there(ik, 1, tasks[1].target, found);
      for (std::size_t j = 0; j < ik.joints(); ++j) {
        EXPECT_GE(found.q[j], limits.lower()[j]);
        EXPECT_LE(found.q[j], limits.upper()[j]);
      }
    }
  }
}

TEST(TreeIk, LeavesTheOtherArmAloneWhereItHasNoWeight) {
  const TwoArms robot(test::ur3());
  const TreeIk ik(robot.model, robot.tips());
  Random random(51);
  const auto q = random_state(robot.model, robot.left, random);
  const auto seed = random_state(robot.model, robot.left, random);
  const TreeTask tasks[] = {{ik.forward(0, q), {}, 1}, {{}, {}, 0}};
  TreeSolution found;
  ASSERT_EQ(ik.solve(tasks, seed, found), IkOutcome::solved);
  expect_there(ik, 0, tasks[0].target, found);
  for (std::size_t j = 8; j < 14; ++j) EXPECT_EQ(found.q[j], seed[j]);
}

TEST(TreeIk, TasksMayAskForPartsOfPoses) {
  const TwoArms robot(test::five());
  const TreeIk ik(robot.model, robot.tips());
  Random random(52);
  for (int i = 0; i < 100; ++i) {
    const auto q = random_state(robot.model, robot.left, random);
    TreeTask tasks[] = {{ik.forward(0, q), IkTask::free_spin(2), 1},
                        {ik.forward(1, q), IkTask::position_only(), 2}};
    tasks[0].target.rotation = tasks[0].target.rotation * from_axis_angle({0, 0, 1}, 1.3);
    tasks[1].target.rotation = from_rpy(0.3, 1, -2);
    TreeSolution found;
    ASSERT_EQ(ik.solve(tasks, random_state(robot.model, robot.left, random), found), IkOutcome::solved) << i;
    const Pose left = ik.forward(0, {found.q.data(), ik.joints()});
    const Pose right = ik.forward(1, {found.q.data(), ik.joints()});
    const Vec3 z{0, 0, 1};
    EXPECT_LT(norm(left.position - tasks[0].target.position), 1.01e-6);
    EXPECT_LT(norm(left.rotation * z - tasks[0].target.rotation * z), 2e-6);
    EXPECT_LT(norm(right.position - tasks[1].target.position), 1.01e-6);
  }
}

TEST(TreeIk, ComesAsNearAsItCanAndTheHeavierTipComesNearer) {
  const TwoArms robot(test::ur3());
  const TreeIk ik(robot.model, robot.tips(), {}, {.restarts = 8});
  const std::vector<double> seed(ik.joints(), 0.2);
  // The torso can turn one shoulder towards the place, and the other away from it.
  TreeTask tasks[] = {{{{3, 0, 1}, {}}, IkTask::position_only(), 1},
                      {{{3, 0, 1}, {}}, IkTask::position_only(), 1}};
  TreeSolution even, uneven;
  EXPECT_EQ(ik.solve(tasks, seed, even), IkOutcome::unreachable);
  EXPECT_FALSE(even.exact);
  tasks[1].weight = 0.1;
  EXPECT_EQ(ik.solve(tasks, seed, uneven), IkOutcome::unreachable);
  EXPECT_LT(uneven.position_error[0], even.position_error[0] - 0.05);
  EXPECT_GT(uneven.position_error[1], even.position_error[1] + 0.05);
  const Pose there = ik.forward(0, {even.q.data(), ik.joints()});
  EXPECT_NEAR(norm(there.position - tasks[0].target.position), even.position_error[0], 1e-9);
}

TEST(TreeIk, RefusesWhatIsNoQuestion) {
  const TwoArms robot(test::ur3());
  const TreeIk ik(robot.model, robot.tips());
  const std::vector<double> seed(ik.joints(), 0.2);
  TreeSolution found;
  const TreeTask good{{{0.3, 0.2, 1}, {}}, {}, 1};
  const TreeTask bad{{{NAN, 0, 0}, {}}, {}, 1};
  EXPECT_EQ(ik.solve(std::vector<TreeTask>{good, bad}, seed, found), IkOutcome::malformed);
  EXPECT_EQ(ik.solve(std::vector<TreeTask>{good}, seed, found), IkOutcome::malformed);
  EXPECT_EQ(ik.solve(std::vector<TreeTask>{good, good}, std::vector<double>(3), found), IkOutcome::malformed);
  EXPECT_THROW(TreeIk(robot.model, {}), Error);
}

TEST(TreeIk, AllocatesNothingAndIsTheSameEveryTime) {
  const TwoArms robot(test::seven());
  const TreeIk ik(robot.model, robot.tips());
  Random random(53);
  const auto q = random_state(robot.model, robot.left, random);
  const std::vector<double> seed(ik.joints(), 0.1);
  const TreeTask tasks[] = {{ik.forward(0, q), {}, 1}, {ik.forward(1, q), {}, 1}};
  TreeSolution first, second;
  ik.solve(tasks, seed, first);
  const test::RealtimeGuard guard;
  ik.solve(tasks, seed, second);
  EXPECT_EQ(guard.violations(), "");
  for (std::size_t j = 0; j < ik.joints(); ++j) EXPECT_EQ(first.q[j], second.q[j]);
}

/// `count` joints one after another behind a link: a finger of many.
void grow(description::RobotModel& model, int link, std::size_t count, const std::string& prefix) {
  for (std::size_t i = 0; i < count; ++i) {
    const auto finger = test::serial_robot("finger", {{"bend", {0.02, 0, 0}, {0, 0, 0}, {0, 1, 0}, -1, 1}});
    link = mount(model, finger, link, {}, prefix + std::to_string(i) + "_");
  }
}

TEST(TreeIk, HandsDoNotStandInTheWayOfArms) {
  const TwoArms bare(test::ur3());
  TwoArms robot(test::ur3());
  const int left_end = [&] {
    grow(robot.model, robot.left, 24, "left_hand_");
    return static_cast<int>(robot.model.links.size()) - 1;
  }();
  grow(robot.model, robot.right, 80, "right_hand_");
  const std::size_t bare_joints = bare.model.actuated.size(), joints = robot.model.actuated.size();
  ASSERT_EQ(joints, 14u + 104u);
  const TreeIk without(bare.model, bare.tips()), with(robot.model, robot.tips());
  const Chain arm(robot.model, robot.left), bare_arm(bare.model, bare.left);
  const InverseKinematics ik(arm), bare_ik(bare_arm);
  const NumericIk numeric(arm), bare_numeric(bare_arm);
  std::vector<double> J(6 * joints);
  Random random(54);
  for (int i = 0; i < 50; ++i) {
    const auto q = random_state(robot.model, robot.left, random);
    const auto seed = random_state(robot.model, robot.left, random);
    const std::span<const double> bare_seed(seed.data(), bare_joints);
    const TreeTask tasks[] = {{with.forward(0, q), {}, 1}, {with.forward(1, q), {}, 1}};
    TreeSolution found, expected;
    ASSERT_EQ(with.solve(tasks, seed, found), IkOutcome::solved);
    ASSERT_EQ(without.solve(tasks, bare_seed, expected), IkOutcome::solved);
    for (std::size_t j = 0; j < joints; ++j) EXPECT_EQ(found.q[j], j < bare_joints ? expected.q[j] : seed[j]);

    IkSolution one, bare_one;
    ASSERT_EQ(ik.solve(tasks[0].target, seed, one), bare_ik.solve(tasks[0].target, bare_seed, bare_one));
    for (std::size_t j = 0; j < joints; ++j) EXPECT_EQ(one.q[j], j < bare_joints ? bare_one.q[j] : seed[j]);
    ASSERT_EQ(numeric.solve(tasks[0].target, seed, one), IkOutcome::solved);
    ASSERT_EQ(bare_numeric.solve(tasks[0].target, bare_seed, bare_one), IkOutcome::solved);
    for (std::size_t j = 0; j < joints; ++j)
      EXPECT_NEAR(one.q[j], j < bare_joints ? bare_one.q[j] : seed[j], 1e-9);
    arm.jacobian(q, J);
    for (std::size_t j = bare_joints; j < joints; ++j) EXPECT_EQ(J[j], 0);
  }
  EXPECT_NO_THROW(Chain(robot.model, left_end)) << "all 32 of them move the fingertip";
}

TEST(TreeIk, TooManyJointsAreNamed) {
  const auto refused = [](const auto& make) {
    try {
      make();
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  TwoArms robot(test::ur3());
  grow(robot.model, robot.left, 25, "hand_");
  const int end = static_cast<int>(robot.model.links.size()) - 1;
  EXPECT_NE(
      refused([&] { Chain(robot.model, end); }).find("33 joints of the robot 'two_arms' move 'hand_24_"),
      std::string::npos);
  EXPECT_NO_THROW(Chain(robot.model, robot.left)) << "the arm alone";
  grow(robot.model, robot.right, 90, "other_hand_");
  EXPECT_NE(refused([&] { Chain(robot.model, robot.left); }).find("129 joints that move by themselves"),
            std::string::npos);
}

}  // namespace
}  // namespace polyarm::ik
