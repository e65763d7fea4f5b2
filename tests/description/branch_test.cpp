/// One arm of a description with two: what stays, what goes, and what both have in common.
#include "polyarm/description/branch.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "polyarm/description/srdf.hpp"
#include "polyarm/description/urdf.hpp"
#include "tests/description/support.hpp"
#include "tests/support/two_arms.hpp"

namespace polyarm::description::branch_test {
namespace {

using Names = std::vector<std::string>;

RobotModel pair_of_arms(const std::string& more = "") {
  Problems problems;
  RobotModel out = read_urdf(polyarm::test::two_arms(more), "pair.urdf", problems);
  EXPECT_TRUE(problems.list().empty());
  return out;
}

RobotModel pair_with_srdf() {
  RobotModel out = pair_of_arms();
  Problems problems;
  read_srdf(polyarm::test::two_arms_srdf(), "pair.srdf", out, problems);
  EXPECT_TRUE(problems.list().empty()) << problems.list().front().text();
  return out;
}

RobotModel branch_of(RobotModel model, const std::string& link) {
  keep_branch(model, link);
  return model;
}

Names links_of(const RobotModel& model) {
  Names out;
  for (const Link& link : model.links) out.push_back(link.name);
  std::sort(out.begin(), out.end());
  return out;
}

Problem refused(RobotModel model, const std::string& link) {
  const RobotModel before = model;
  try {
    keep_branch(model, link, {"cell.yaml", 4, 2});
  } catch (const Error& e) {
    test::expect_equal(before, model);
    return e.problems().front();
  }
  ADD_FAILURE() << "no error";
  return {};
}

TEST(Branch, HasTheWayFromTheRootAndAllThatIsFixedToItOrBehindIt) {
  const RobotModel left = branch_of(pair_of_arms(), "left_tool0");
  EXPECT_EQ(links_of(left), (Names{"left_arm", "left_finger", "left_hand", "left_lift", "left_mount",
                                   "left_rail", "left_thumb", "left_tool0", "right_mount", "torso"}));
  EXPECT_EQ(left.joint_names(), (Names{"left_x", "left_y", "left_z", "left_turn", "left_grip"}));
  EXPECT_EQ(left.links[static_cast<std::size_t>(left.tool_link())].name, "left_tool0");
}

TEST(Branch, IsTheSameForEachLinkOfTheArm) {
  const RobotModel whole = pair_of_arms(), tip = branch_of(whole, "right_tool0");
  for (const char* link : {"right_rail", "right_lift", "right_hand", "right_finger"})
    test::expect_equal(branch_of(whole, link), tip);
}

TEST(Branch, HasItsLinksWhereTheWholeHasThem) {
  const RobotModel whole = pair_with_srdf(), right = branch_of(whole, "right_hand");
  const std::vector<double> all{0.1, -0.2, 0.3, 0.4, 0.02, 0.5, 0.1, -0.3, -0.4, 0.03};
  std::vector<double> own;
  for (const std::string& name : right.joint_names()) {
    const Names names = whole.joint_names();
    own.push_back(all[static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin())]);
  }
  const std::vector<Pose> of_whole = test::walk(whole, all), of_right = test::walk(right, own);
  for (std::size_t i = 0; i < right.links.size(); ++i) {
    SCOPED_TRACE(right.links[i].name);
    test::expect_near(of_right[i], of_whole[static_cast<std::size_t>(whole.find_link(right.links[i].name))]);
  }
}

TEST(Branch, MimicJointsFollowTheirLeader) {
  const RobotModel right = branch_of(pair_of_arms(), "right_hand");
  const Joint& thumb = right.joints[static_cast<std::size_t>(right.find_joint("right_thumb_joint"))];
  ASSERT_TRUE(thumb.mimic);
  EXPECT_EQ(right.joints[static_cast<std::size_t>(thumb.mimic->joint)].name, "right_grip");
}

TEST(Branch, LeavesOutStatesPairsAndGroupsOfOtherBranches) {
  const RobotModel whole = pair_with_srdf();
  const RobotModel left = branch_of(whole, "left_hand"), right = branch_of(whole, "right_hand");
  EXPECT_EQ(left.named_states, (std::map<std::string, std::vector<double>>{{"home", {0.1, 0, 0, 0, 0}},
                                                                           {"wide", {0.1, 0.3, 0, 0, 0}}}));
  EXPECT_EQ(right.named_states.at("raised"), (std::vector<double>{0.2, 0, 0.3, 0, 0}));
  EXPECT_EQ(right.start(), (std::vector<double>{0.2, 0, 0, 0, 0}));
  const auto pairs = [](const RobotModel& model) {
    Names out;
    for (const auto& [a, b] : model.allowed_collisions)
      out.push_back(model.links[static_cast<std::size_t>(a)].name + "-" +
                    model.links[static_cast<std::size_t>(b)].name);
    return out;
  };
  EXPECT_EQ(pairs(left), (Names{"torso-left_rail", "left_arm-left_hand"}));
  EXPECT_EQ(pairs(right).size(), 2u);
  const auto groups = [](const RobotModel& model) {
    Names out;
    for (const GroupInfo& group : model.groups) out.push_back(group.name);
    return out;
  };
  EXPECT_EQ(groups(left), (Names{"left_arm", "right_arm", "left_fingers", "both"}))
      << "the fixed part of the right arm is in its group";
  EXPECT_TRUE(left.end_effectors.empty());
  ASSERT_EQ(right.end_effectors.size(), 1u);
  EXPECT_EQ(right.links[static_cast<std::size_t>(right.end_effectors[0].parent_link)].name, "right_tool0");
}

TEST(Branch, HasTheHardwareOfItsOwnJoints) {
  const RobotModel whole =
      pair_of_arms(polyarm::test::hardware_of_arm("left") + polyarm::test::hardware_of_arm("right"));
  const RobotModel left = branch_of(whole, "left_hand");
  ASSERT_EQ(left.hardware.size(), 1u);
  EXPECT_EQ(left.hardware[0].name, "left_hardware");
  EXPECT_EQ(left.hardware[0].components.size(), 5u);

  std::string one = polyarm::test::hardware_of_arm("left") + polyarm::test::hardware_of_arm("right");
  const std::string seam = one.substr(one.find("</ros2_control>"),
                                      one.find("<joint name=\"right_x\"") - one.find("</ros2_control>"));
  one.replace(one.find(seam), seam.size(), "");
  const RobotModel right = branch_of(pair_of_arms(one), "right_hand");
  ASSERT_EQ(right.hardware.size(), 1u);
  EXPECT_EQ(right.hardware[0].components.size(), 5u);
  EXPECT_EQ(right.hardware[0].components[0].name, "right_x");
}

TEST(Branch, BarsThatFollowTheArmBelongToIt) {
  const RobotModel left = branch_of(
      pair_of_arms("<link name=\"bar\"/><joint name=\"bar_joint\" type=\"revolute\"><parent "
                   "link=\"left_rail\"/><child "
                   "link=\"bar\"/><limit lower=\"-1\" upper=\"1\" velocity=\"1\" effort=\"1\"/><mimic "
                   "joint=\"left_turn\"/></joint>"),
      "left_hand");
  EXPECT_GE(left.find_link("bar"), 0);
}

TEST(Branch, ReadsBackEqual) {
  const RobotModel left = branch_of(pair_with_srdf(), "left_hand");
  Problems problems;
  test::expect_equal(left, read_urdf(write_urdf(left), "left.urdf", problems));
  EXPECT_TRUE(problems.list().empty());
}

TEST(Branch, RefusesLinksThatNameNone) {
  const Problem fixed = refused(pair_of_arms(), "torso");
  EXPECT_EQ(fixed.code, "bad-branch");
  EXPECT_EQ(fixed.where.line, 4);
  EXPECT_TRUE(test::has(fixed.what, "'torso' is fixed to the base"));
  EXPECT_TRUE(test::has(fixed.advice, "left_tool0 or right_tool0"));
  EXPECT_EQ(refused(pair_of_arms(), "left_mount").code, "bad-branch");
  const Problem unknown = refused(pair_of_arms(), "left_hnd");
  EXPECT_EQ(unknown.code, "unknown-link");
  EXPECT_TRUE(test::has(unknown.what, "did you mean 'left_hand'"));
}

TEST(Branch, RefusesAJointWhoseLeaderIsLeftOut) {
  const Problem problem = refused(
      pair_of_arms("<link name=\"odd\"/><joint name=\"odd_joint\" type=\"revolute\"><parent "
                   "link=\"left_hand\"/><child "
                   "link=\"odd\"/><limit lower=\"-1\" upper=\"1\" velocity=\"1\" effort=\"1\"/><mimic "
                   "joint=\"right_turn\"/></joint>"),
      "left_hand");
  EXPECT_EQ(problem.code, "bad-branch");
  EXPECT_TRUE(test::has(problem.what, "'odd_joint', which follows 'right_turn'"));
}

TEST(Arms, AreFoundWhereTheDescriptionParts) {
  const RobotModel whole = pair_of_arms();
  EXPECT_EQ(arms_of(whole).tools, (Names{"left_tool0", "right_tool0"}));
  EXPECT_TRUE(arms_of(whole).shared.empty());
  EXPECT_TRUE(arms_of(branch_of(whole, "left_hand")).tools.empty());
  EXPECT_TRUE(test::has(hint_of_arms(whole), "'branch: left_tool0', 'branch: right_tool0'"));
  EXPECT_EQ(hint_of_arms(branch_of(whole, "left_hand")), "");
}

TEST(Arms, OnATurningTorsoHaveItInCommon) {
  std::string text = polyarm::test::two_arms(
      "<link name=\"world\"/><joint name=\"waist\" type=\"revolute\"><parent link=\"world\"/><child "
      "link=\"torso\"/><axis xyz=\"0 0 1\"/><limit lower=\"-1\" upper=\"1\" velocity=\"1\" "
      "effort=\"1\"/></joint>");
  Problems problems;
  const RobotModel model = read_urdf(text, "turning.urdf", problems);
  EXPECT_EQ(arms_of(model).shared, (Names{"waist"}));
  EXPECT_TRUE(test::has(hint_of_arms(model), "where waist is fixed"));
  EXPECT_EQ(branch_of(model, "left_hand").joint_names().front(), "waist") << "one arm alone turns with it";
}

TEST(SharedLinks, AreTheFixedOnesAtTheSamePlace) {
  const RobotModel whole = pair_of_arms();
  const RobotModel left = branch_of(whole, "left_hand"), right = branch_of(whole, "right_hand");
  const std::vector<char> shared = shared_links(left, {}, right, {});
  Names names;
  for (std::size_t i = 0; i < shared.size(); ++i)
    if (shared[i]) names.push_back(left.links[i].name);
  std::sort(names.begin(), names.end());
  EXPECT_EQ(names, (Names{"left_mount", "right_mount", "torso"}));
  EXPECT_TRUE(shared_links(left, {}, right, Pose{{0.1, 0, 0}, {}}).empty()) << "another robot beside it";
  RobotModel wider = right;
  wider.links[static_cast<std::size_t>(wider.root)].collisions[0].size.x = 0.2;
  const std::vector<char> less = shared_links(left, {}, wider, {});
  EXPECT_FALSE(less.at(static_cast<std::size_t>(left.root))) << "another shape is another body";
}

}  // namespace
}  // namespace polyarm::description::branch_test
