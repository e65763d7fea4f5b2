#include "polyarm/description/srdf.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <functional>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/description/urdf.hpp"
#include "tests/description/support.hpp"

namespace polyarm::description::srdf_test {
namespace {

using test::has;
using Pairs = std::vector<std::array<int, 2>>;

/// base – shoulder – upper – elbow – fore – wrist(fixed) – hand – grip – finger, and finger2 that follows.
const char* const kRobot = R"(<robot name="arm">
<link name="base"/><link name="upper"/><link name="fore"/><link name="hand"/><link name="finger"/><link name="finger2"/>
<joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><limit lower="-3" upper="3"/></joint>
<joint name="elbow" type="revolute"><parent link="upper"/><child link="fore"/><limit lower="-3" upper="-0.5"/></joint>
<joint name="wrist" type="fixed"><parent link="fore"/><child link="hand"/></joint>
<joint name="grip" type="prismatic"><parent link="hand"/><child link="finger"/><limit lower="0" upper="0.04"/></joint>
<joint name="grip2" type="prismatic"><parent link="hand"/><child link="finger2"/><limit lower="0" upper="0.04"/>
<mimic joint="grip"/></joint>
</robot>)";

const char* const kSrdf = R"(<?xml version="1.0"?>
<robot name="arm">
  <virtual_joint name="fixed_base" type="fixed" parent_frame="world" child_link="base"/>
  <group name="arm">
    <joint name="fixed_base"/>
    <chain base_link="base" tip_link="hand"/>
  </group>
  <group name="hand"><joint name="grip"/><link name="finger2"/></group>
  <group name="all"><group name="arm"/><group name="hand"/></group>
  <group_state name="up" group="arm"><joint name="shoulder" value="1"/></group_state>
  <group_state name="home" group="arm">
    <joint name="shoulder" value="0.5"/><joint name="elbow" value="-2"/>
  </group_state>
  <group_state name="open" group="hand"><joint name="grip" value="0.04"/></group_state>
  <end_effector name="gripper" parent_link="hand" group="hand" parent_group="arm"/>
  <passive_joint name="grip2"/>
  <disable_collisions link1="upper" link2="base" reason="Adjacent"/>
  <disable_collisions link1="base" link2="fore" reason="Never"/>
</robot>
)";

RobotModel robot() {
  Problems warnings;
  return read_urdf(kRobot, "arm.urdf", warnings);
}

RobotModel with(const std::string& text, Problems& problems, RobotModel model = robot()) {
  read_srdf(text, "arm.srdf", model, problems);
  return model;
}

RobotModel with(const std::string& text, RobotModel model = robot()) {
  Problems problems;
  RobotModel out = with(text, problems, std::move(model));
  EXPECT_TRUE(problems.list().empty()) << problems.list()[0].text();
  return out;
}

std::string srdf(const std::string& body) {
  return "<robot name=\"arm\">\n" + body + "</robot>";
}

std::vector<std::string> joints_of(const RobotModel& model, std::size_t group) {
  std::vector<std::string> out;
  for (const int j : model.groups.at(group).joints)
    out.push_back(model.joints[static_cast<std::size_t>(j)].name);
  return out;
}

void expect_groups(const RobotModel& model) {
  ASSERT_EQ(model.groups.size(), 3u);
  EXPECT_EQ(model.groups[0].name, "arm");
  EXPECT_EQ(joints_of(model, 0), (std::vector<std::string>{"shoulder", "elbow", "wrist"}));
  EXPECT_EQ(joints_of(model, 1), (std::vector<std::string>{"grip", "grip2"}));
  EXPECT_EQ(joints_of(model, 2), (std::vector<std::string>{"shoulder", "elbow", "wrist", "grip", "grip2"}));
  EXPECT_EQ(model.groups[1].links, (std::vector<int>{model.find_link("finger"), model.find_link("finger2")}));
  ASSERT_EQ(model.end_effectors.size(), 1u);
  EXPECT_EQ(model.end_effectors[0].name, "gripper");
  EXPECT_EQ(model.end_effectors[0].group, "hand");
  EXPECT_EQ(model.end_effectors[0].parent_group, "arm");
  EXPECT_EQ(model.end_effectors[0].parent_link, model.find_link("hand"));
}

TEST(Srdf, ReadsGroupsAndEndEffectors) {
  expect_groups(with(kSrdf));
}

TEST(Srdf, GroupsAreWrittenSoThatTheyReadBack) {
  Problems warnings;
  const RobotModel before = with(kSrdf), after = read_urdf(write_urdf(before), "w.urdf", warnings);
  expect_groups(after);
  test::expect_equal(before, after);
}

TEST(Srdf, MakesNamedStatesOfGroupStatesAndFillsThemFromHome) {
  const RobotModel model = with(kSrdf);
  EXPECT_EQ(model.named_states.at("home"), (std::vector<double>{0.5, -2, 0}));
  EXPECT_EQ(model.named_states.at("up"), (std::vector<double>{1, -2, 0}));
  EXPECT_EQ(model.named_states.at("open"), (std::vector<double>{0.5, -2, 0.04}));
}

TEST(Srdf, FillsFromZeroOrTheNearestLimitWithoutAHome) {
  const RobotModel model =
      with(srdf("<group name=\"g\"><joint name=\"grip\"/></group><group_state name=\"open\" group=\"g\">"
                "<joint name=\"grip\" value=\"0.01\"/></group_state>"));
  EXPECT_EQ(model.named_states.at("open"), (std::vector<double>{0, -0.5, 0.01}));
}

TEST(Srdf, PutsStatesOfOneNameAndDifferentGroupsTogether) {
  const RobotModel model = with(srdf(
      "<group name=\"g\"><joint name=\"grip\"/></group><group name=\"h\"><joint name=\"shoulder\"/></group>"
      "<group_state name=\"park\" group=\"g\"><joint name=\"grip\" value=\"0.01\"/></group_state>"
      "<group_state name=\"park\" group=\"h\"><joint name=\"shoulder\" value=\"2\"/></group_state>"));
  EXPECT_EQ(model.named_states.at("park"), (std::vector<double>{2, -0.5, 0.01}));
}

TEST(Srdf, AllowsDisabledCollisionsOnceAndBothWays) {
  const RobotModel once = with(kSrdf);
  EXPECT_EQ(once.allowed_collisions, (Pairs{{0, 1}, {0, 2}}));
  EXPECT_EQ(with(kSrdf, once).allowed_collisions, once.allowed_collisions);
  EXPECT_EQ(with(kSrdf, once).groups.size(), once.groups.size());
}

TEST(Srdf, DisablesAllPairsOfALinkExceptThoseEnabled) {
  const RobotModel model = with(
      srdf("<disable_default_collisions link=\"base\"/><enable_collisions link1=\"hand\" link2=\"base\"/>"));
  EXPECT_EQ(model.allowed_collisions, (Pairs{{0, 1}, {0, 2}, {0, 4}, {0, 5}}));
}

struct Line {
  const char* name;
  std::string body;  ///< starts on line 2
  int line;
  Severity severity;
  std::string code, piece;
};

void PrintTo(const Line& line, std::ostream* out) {
  *out << line.name;
}

class SrdfLine : public ::testing::TestWithParam<Line> {};

TEST_P(SrdfLine, IsNamedWithItsPlace) {
  Problems problems;
  with(srdf(GetParam().body), problems);
  ASSERT_EQ(problems.list().size(), 1u);
  const Problem& p = problems.list()[0];
  EXPECT_EQ(p.where.file, "arm.srdf");
  EXPECT_EQ(p.where.line, GetParam().line) << p.text();
  EXPECT_EQ(p.severity, GetParam().severity) << p.text();
  EXPECT_EQ(p.code, GetParam().code) << p.text();
  EXPECT_TRUE(has(p.text(), GetParam().piece));
}

std::vector<Line> lines() {
  constexpr auto error = Severity::error, warning = Severity::warning;
  const std::string group = "<group name=\"arm\"><joint name=\"shoulder\"/></group>\n";
  const auto state = [&](const std::string& joint) {
    return group + "<group_state name=\"s\" group=\"arm\">\n" + joint + "</group_state>";
  };
  return {
      {"UnknownJointInAGroup", "<group name=\"arm\">\n<joint name=\"sholder\"/></group>", 3, error,
       "unknown-joint", "did you mean 'shoulder'"},
      {"UnknownLinkInAChain", "<group name=\"arm\"><chain base_link=\"bse\" tip_link=\"hand\"/></group>", 2,
       error, "unknown-link", "did you mean 'base'"},
      {"ChainUpsideDown", "<group name=\"arm\"><chain base_link=\"hand\" tip_link=\"upper\"/></group>", 2,
       error, "bad-chain", "'upper' is not carried by 'hand'"},
      {"UnknownGroupInAGroup", group + "<group name=\"all\"><group name=\"amr\"/></group>", 3, error,
       "unknown-group", "did you mean 'arm'"},
      {"GroupWithinItself", "<group name=\"all\"><group name=\"all\"/></group>", 2, error, "circle",
       "contains itself"},
      {"TwoGroupsOfOneName", group + group, 3, error, "duplicate-name", "two groups are called 'arm'"},
      {"StateOfAnUnknownGroup", group + "<group_state name=\"s\" group=\"arms\"/>", 3, error, "unknown-group",
       "did you mean 'arm'"},
      {"StateOfAnUnknownJoint", state("<joint name=\"sholder\" value=\"1\"/>"), 4, error, "unknown-joint",
       "did you mean 'shoulder'"},
      {"StateWithoutAValue", state("<joint name=\"shoulder\"/>"), 4, error, "missing-attribute", "'value'"},
      {"StateOfWords", state("<joint name=\"shoulder\" value=\"up\"/>"), 4, error, "bad-number",
       "value=\"up\""},
      {"StateBeyondALimit", state("<joint name=\"shoulder\" value=\"9\"/>"), 4, warning, "beyond-limit",
       "shoulder: 9"},
      {"StateOfAFollower", state("<joint name=\"grip2\" value=\"0\"/>"), 4, warning, "no-effect", "'grip2'"},
      {"CollisionOfAnUnknownLink", "<disable_collisions link1=\"bose\" link2=\"hand\"/>", 2, warning,
       "unknown-link", "did you mean 'base'"},
      {"EndEffectorOnAnUnknownLink", group + "<end_effector name=\"e\" group=\"arm\" parent_link=\"hnd\"/>",
       3, error, "unknown-link", "did you mean 'hand'"},
      {"EndEffectorOfAnUnknownGroup",
       group + "<end_effector name=\"e\" group=\"arms\" parent_link=\"hand\"/>", 3, warning, "unknown-group",
       "did you mean 'arm'"},
      {"Slip", "<disable_colisions link1=\"base\" link2=\"hand\"/>", 2, error, "unknown-tag",
       "did you mean 'disable_collisions'"},
      {"ForeignTag", "<banana/>", 2, warning, "unknown-tag", "<banana>"},
  };
}

INSTANTIATE_TEST_SUITE_P(Table, SrdfLine, ::testing::ValuesIn(lines()),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(Srdf, SaysThatItIsOfAnotherRobot) {
  Problems problems;
  with("<robot name=\"leg\"/>", problems);
  ASSERT_EQ(problems.list().size(), 1u);
  EXPECT_EQ(problems.list()[0].severity, Severity::warning);
  EXPECT_TRUE(has(problems.list()[0].what, "'leg'"));
}

TEST(Srdf, SuggestsNoJointThatDoesNotMove) {
  for (const std::string& line : {std::string("<group name=\"g\"><joint name=\"wrst\"/></group>"),
                                  std::string("<group name=\"g\"><joint name=\"elbow\"/></group>"
                                              "<group_state name=\"s\" group=\"g\"><joint name=\"wrst\" value=\"1\"/></group_state>")}) {
    Problems problems;
    with("<robot name=\"arm\">" + line + "</robot>", problems);
    ASSERT_FALSE(problems.list().empty()) << line;
    EXPECT_EQ(problems.list().front().what.find("wrist"), std::string::npos) << problems.list().front().what;
  }
  Problems problems;
  with("<robot name=\"arm\"><group name=\"g\"><joint name=\"elbw\"/></group></robot>", problems);
  EXPECT_NE(problems.list().front().what.find("did you mean 'elbow'"), std::string::npos);
}

TEST(Srdf, RefusesWhatIsNoSrdf) {
  for (const char* text : {"", "<model/>", "<robot>",
                           "\x7f"
                           "ELF\x01"})
    EXPECT_THROW(with(text), Error) << text;
}

TEST(Srdf, SurvivesALongRowOfGroupsWithinGroups) {
  std::string body;
  for (int i = 0; i < 5000; ++i)
    body +=
        "<group name=\"g" + std::to_string(i) + "\"><group name=\"g" + std::to_string(i + 1) + "\"/></group>";
  Problems problems;
  with(srdf(body + "<group name=\"g5000\"><joint name=\"elbow\"/></group>"), problems);
  EXPECT_TRUE(problems.has_errors());
}

/// A long chain, as text.
std::string chain(int links) {
  std::string out = "<robot name=\"b\"><link name=\"l0\"/>";
  for (int i = 1; i < links; ++i) {
    const std::string at = std::to_string(i), before = std::to_string(i - 1);
    out += "<link name=\"l" + at + "\"/><joint name=\"j" + at + "\" type=\"continuous\"><parent link=\"l" + before +
           "\"/><child link=\"l" + at + "\"/></joint>";
  }
  return out + "</robot>";
}

std::string times(int count, const std::function<std::string(const std::string&)>& line) {
  std::string out;
  for (int i = 0; i < count; ++i) out += line(std::to_string(i));
  return out;
}

TEST(Srdf, SmallFilesThatSayMuchAreRefused) {
  const std::string whole = "<chain base_link=\"l0\" tip_link=\"l999\"/>";
  Problems warnings;
  const RobotModel model = read_urdf(chain(1000), "b.urdf", warnings);
  for (const std::string& body :
       {times(10000, [&](const std::string& i) { return "<group name=\"g" + i + "\">" + whole + "</group>"; }),
        "<group name=\"g\">" + whole + "</group>" +
            times(10000, [](const std::string& i) { return "<group name=\"h" + i + "\"><group name=\"g\"/></group>"; }),
        times(10000, [](const std::string& i) { return "<disable_default_collisions link=\"l" + std::to_string(std::stoi(i) % 1000) + "\"/>"; })}) {
    Problems problems;
    try {
      with("<robot name=\"b\">" + body + "</robot>", problems, model);
      ADD_FAILURE() << body.substr(0, 80);
    } catch (const Error& e) {
      EXPECT_EQ(e.problems().front().code, "too-large");
    }
  }
  Problems problems;
  with("<robot name=\"b\"><group name=\"g\">" + whole + "</group>" +
           times(500, [](const std::string& i) { return "<disable_collisions link1=\"l" + i + "\" link2=\"l7\"/>"; }) + "</robot>",
       problems, model);
  EXPECT_TRUE(problems.list().empty());
}

TEST(Srdf, OfThousandsOfWrongNamesTheFirstGetASuggestion) {
  Problems problems;
  with("<robot name=\"arm\">" +
           times(5000, [](const std::string& i) { return "<disable_collisions link1=\"uper\" link2=\"q" + i + "\"/>"; }) + "</robot>",
       problems);
  EXPECT_EQ(problems.list().size(), 10000u);
  EXPECT_NE(problems.list().front().what.find("did you mean 'upper'"), std::string::npos);
  std::size_t suggested = 0;
  for (const Problem& problem : problems.list()) suggested += problem.what.find("did you mean") != std::string::npos;
  EXPECT_LE(suggested, bounds::kSuggestions);
}

TEST(Srdf, BelongsToTheDescriptionOfItsName) {
  EXPECT_EQ(srdf_beside("x/arm.urdf"), "x/arm.srdf");
  EXPECT_EQ(srdf_beside("x/arm.urdf.xacro"), "x/arm.srdf");
  EXPECT_EQ(srdf_beside("arm.xacro"), "arm.srdf");
}

TEST(Srdf, IsTakenFromBesideTheDescription) {
  namespace fs = std::filesystem;
  std::string pattern = (fs::temp_directory_path() / "polyarm_srdf_XXXXXX").string();
  const fs::path folder = mkdtemp(pattern.data());
  write_file_atomically(folder / "arm.urdf", kRobot);
  Problems warnings;
  EXPECT_TRUE(load_robot((folder / "arm.urdf").string(), Catalogue({}), warnings).groups.empty());
  write_file_atomically(folder / "arm.srdf", kSrdf);
  EXPECT_EQ(load_robot((folder / "arm.urdf").string(), Catalogue({}), warnings).named_states.count("up"), 1u);
  write_file_atomically(folder / "arm.srdf",
                        "<robot><group name=\"g\"><joint name=\"elbw\"/></group></robot>");
  EXPECT_TRUE(load_robot((folder / "arm.urdf").string(), Catalogue({}), warnings).named_states.empty())
      << "what is wrong in it is left out";
  fs::remove_all(folder);
}

TEST(SrdfFuzz, DamagedTextEndsInAModelOrAnError) {
  const RobotModel plain = robot();
  test::Mutator mutate(41);
  int refused = 0, accepted = 0;
  for (int i = 0; i < 5000; ++i) {
    const std::string text = mutate(kSrdf);
    Problems problems;
    try {
      const RobotModel model = with(text, problems, plain);
      ++(problems.has_errors() ? refused : accepted);
      for (const auto& [name, values] : model.named_states)
        ASSERT_EQ(values.size(), model.actuated.size()) << text;
      for (const auto& [one, other] : model.allowed_collisions) ASSERT_TRUE(one >= 0 && one < other) << text;
    } catch (const Error&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 500);
  EXPECT_GT(accepted, 100);
}

}  // namespace
}  // namespace polyarm::description::srdf_test
