#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/description/srdf.hpp"
#include "polyarm/description/urdf.hpp"

namespace polyarm::description::tool_link_test {
namespace {

/// A robot in lines "parent joint child": a joint turns, slides where its name begins with s:, is fixed with
/// f:, and follows another one with NAME>LEADER.
RobotModel robot_of(const std::string& lines) {
  std::vector<std::string> links;
  std::string joints;
  std::istringstream in(lines);
  for (std::string parent, name, child; in >> parent >> name >> child;) {
    if (child.ends_with(';')) child.pop_back();
    std::string mimic;
    const char* type = name.starts_with("f:") ? "fixed" : name.starts_with("s:") ? "prismatic" : "revolute";
    if (name[1] == ':') name.erase(0, 2);
    if (const auto at = name.find('>'); at != std::string::npos) {
      mimic = "<mimic joint=\"" + name.substr(at + 1) + "\"/>";
      name.erase(at);
    }
    for (const std::string& link : {parent, child})
      if (std::find(links.begin(), links.end(), link) == links.end()) links.push_back(link);
    joints += "<joint name=\"" + name + "\" type=\"" + type + "\"><parent link=\"" + parent +
              "\"/><child link=\"" + child +
              "\"/><limit lower=\"-1\" upper=\"1\" velocity=\"1\" effort=\"1\"/>" + mimic + "</joint>";
  }
  std::string text = "<robot name=\"r\">";
  for (const std::string& link : links) text += "<link name=\"" + link + "\"/>";
  Problems problems;
  return read_urdf(text + joints + "</robot>", "r.urdf", problems);
}

std::string tool_link_of(const RobotModel& model) {
  return model.links[static_cast<std::size_t>(model.tool_link())].name;
}

struct Hand {
  const char* name;
  const char* lines;
  const char* tool_link;
};

class ToolLink : public testing::TestWithParam<Hand> {};

const char* const kArm = "base j1 a; a j2 b; b j3 c; c j4 d; ";

TEST_P(ToolLink, IsWhereTheArmEnds) {
  EXPECT_EQ(tool_link_of(robot_of(kArm + std::string(GetParam().lines))), GetParam().tool_link);
}

INSTANTIATE_TEST_SUITE_P(
    Hands, ToolLink,
    testing::Values(
        Hand{"NoHand", "d j5 e; e f:fix last", "last"},  //
        Hand{"TwoFingers", "d f:m hand; hand s:f1 left; hand s:f2>f1 right", "hand"},
        Hand{"TwoFingersAndTheirPoint", "d f:m hand; hand f:t hand_tcp; hand s:f1 left; hand s:f2 right",
             "hand_tcp"},
        Hand{"ACameraIsNoPoint", "d f:m hand; d f:c cam; cam f:o optical; hand s:f1 left; hand s:f2 right",
             "hand"},
        Hand{"FingersThatDoNotMove", "d f:e end_effector; d f:a finger_1; finger_1 f:b finger_tip_1",
             "end_effector"},
        Hand{"OneJaw", "d roll e; e gripper moving_jaw", "e"},
        Hand{"OneJawAndItsFrame", "d roll e; e f:g gripper_frame_link; e gripper moving_jaw",
             "gripper_frame_link"},
        Hand{"JawCalledByItsLinkAlone", "d j5 e; e j6 jaw", "e"},
        Hand{"AWristCalledGripper", "d gripper_roll e; e f:t last", "last"},
        Hand{"ThreeFingersOfTwoJoints",
             "d f:m palm; palm a1 p1; p1 a2 p2; palm b1 q1; q1 b2 q2; palm c1 r1; r1 c2 r2", "palm"},
        Hand{"LinkageOfFingers",
             "d f:m hand; hand drive k1; k1 k1f>drive tip1; hand k2>drive i1; hand k3>drive k3", "hand"},
        Hand{"FingersBesideABar",
             "d f:m bar; bar f:m2 fingers; fingers f:t ee_gripper_link; d turn propeller; "
             "fingers s:f1 left; fingers s:f2 right",
             "ee_gripper_link"},
        Hand{"BarsThatTheArmMoves", "c bar>j2 rod; d j5 e; e f:x flange_plate", "flange_plate"},
        Hand{"TwoArms", "d l1 l1; l1 l2 l2; l2 l3 l3; l3 l4 l4; d r1 r1; r1 r2 r2; r2 r3 r3; r3 r4 r4", "l4"},
        Hand{"ToolZero", "d f:m hand; d f:t tool0; hand s:f1 left; hand s:f2 right", "tool0"},
        Hand{"PrefixedToolZero", "d f:m hand; d f:t left_tool0; hand s:f1 left; hand s:f2 right",
             "left_tool0"}),
    [](const auto& test) { return test.param.name; });

TEST(ToolLinkSaid, ComesBeforeEverything) {
  RobotModel model = robot_of(std::string(kArm) + "d f:t tool0; d s:f1 left");
  set_tip(model, "c");
  EXPECT_EQ(tool_link_of(model), "c");
  Problems problems;
  EXPECT_EQ(tool_link_of(read_urdf(write_urdf(model), "again.urdf", problems)), "c");
  set_tip(model, "");
  EXPECT_EQ(tool_link_of(model), "c");
  try {
    set_tip(model, "lft", {"cell.yaml", 3, 1});
    FAIL() << "no error";
  } catch (const Error& e) {
    EXPECT_EQ(e.problems().front().code, "unknown-link");
    EXPECT_NE(std::string(e.what()).find("did you mean 'left'"), std::string::npos) << e.what();
    EXPECT_NE(std::string(e.what()).find("cell.yaml:3"), std::string::npos) << e.what();
  }
}

TEST(ToolLinkSaid, TheEndEffectorOfAnSrdfHangsThere) {
  RobotModel model = robot_of(std::string(kArm) + "d f:m hand; hand s:f1 left; hand s:f2 right");
  Problems problems;
  read_srdf(R"(<robot name="r"><group name="hand"><joint name="f1"/></group>
<end_effector name="h" group="hand" parent_link="d"/></robot>)",
            "r.srdf", model, problems);
  EXPECT_TRUE(problems.list().empty());
  EXPECT_EQ(tool_link_of(model), "d");
}

}  // namespace
}  // namespace polyarm::description::tool_link_test
