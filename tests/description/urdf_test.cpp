#include "polyarm/description/urdf.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "polyarm/base/text.hpp"
#include "tests/description/support.hpp"

namespace polyarm::description::urdf_test {
namespace {

using test::has;

/// Four links in a row: base, arm, hand, finger; the second joint slides, the third follows the first.
const char* const kGood = R"(<?xml version="1.0"?>
<robot name="sample">
  <link name="base"/>
  <link name="arm">
    <inertial>
      <origin xyz="0 0 0.1"/>
      <mass value="2"/>
      <inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.01"/>
    </inertial>
    <visual><origin rpy="0 0.5 0"/><geometry><mesh filename="package://maker/arm.stl" scale="2 2 2"/></geometry></visual>
    <collision><origin xyz="0 0 0.1"/><geometry><cylinder radius="0.05" length="0.2"/></geometry></collision>
  </link>
  <link name="hand">
    <collision><geometry><box size="0.1 0.2 0.3"/></geometry></collision>
    <collision><geometry><capsule radius="0.02" length="0.1"/></geometry></collision>
  </link>
  <link name="finger"><collision><geometry><sphere radius="0.01"/></geometry></collision></link>
  <joint name="turn" type="revolute">
    <parent link="base"/><child link="arm"/>
    <origin xyz="0 0 0.3" rpy="0 0 1"/>
    <axis xyz="0 0 1"/>
    <limit lower="-2" upper="2.5" velocity="3" effort="40"/>
    <dynamics damping="0.5" friction="0.25"/>
  </joint>
  <joint name="slide" type="prismatic">
    <parent link="arm"/><child link="hand"/>
    <axis xyz="1 0 0"/>
    <limit lower="0" upper="0.1" velocity="1" effort="10"/>
  </joint>
  <joint name="follow" type="continuous">
    <parent link="hand"/><child link="finger"/>
    <axis xyz="0 1 0"/>
    <mimic joint="turn" multiplier="-2" offset="0.1"/>
  </joint>
</robot>
)";

RobotModel read(const std::string& text) {
  Problems warnings;
  return read_urdf(text, "robot.urdf", warnings);
}

/// A robot of the links a, b, c in a row, with `body` after them.
std::string links_and(const std::string& body) {
  return "<robot name=\"r\">\n<link name=\"a\"/>\n<link name=\"b\"/>\n" + body + "</robot>\n";
}

std::string joint(const std::string& name, const std::string& parent, const std::string& child,
                  const std::string& inside = {}, const std::string& type = "continuous") {
  return "<joint name=\"" + name + "\" type=\"" + type + "\"><parent link=\"" + parent +
         "\"/><child link=\"" + child + "\"/>" + inside + "</joint>\n";
}

bool warned(const Problems& warnings, const std::string& code) {
  for (const Problem& p : warnings.list())
    if (p.code == code) return p.severity == Severity::warning;
  return false;
}

TEST(Urdf, ProcessingInstructionsAreValidAnywhere) {
  EXPECT_EQ(
      read("<?xml version=\"1.0\"?>\n<!-- a -->\n<?xml-model href=\"x\"?>\n<robot name=\"r\"><?foo it's?>"
           "<link name=\"a\"/></robot><?end?>")
          .links.size(),
      1u);
}

TEST(Urdf, ReadsLinksJointsLimitsMassesAndShapes) {
  const RobotModel model = read(kGood);
  EXPECT_EQ(model.name, "sample");
  ASSERT_EQ(model.links.size(), 4u);
  EXPECT_EQ(model.root, model.find_link("base"));
  EXPECT_EQ(model.joint_names(), (std::vector<std::string>{"turn", "slide"}));
  const Joint& turn = model.joints[0];
  EXPECT_EQ(turn.type, JointType::revolute);
  EXPECT_EQ(turn.limits.lower, -2);
  EXPECT_EQ(turn.limits.upper, 2.5);
  EXPECT_EQ(turn.limits.velocity, 3);
  EXPECT_EQ(turn.limits.effort, 40);
  EXPECT_EQ(turn.damping, 0.5);
  EXPECT_EQ(turn.friction, 0.25);
  test::expect_near(turn.origin, pose_xyz_rpy({0, 0, 0.3}, {0, 0, 1}));
  const Joint& follow = model.joints[2];
  ASSERT_TRUE(follow.mimic);
  EXPECT_EQ(follow.mimic->joint, 0);
  EXPECT_EQ(follow.mimic->multiplier, -2);
  EXPECT_EQ(follow.mimic->offset, 0.1);
  const Link& arm = model.links[1];
  ASSERT_TRUE(arm.inertial);
  EXPECT_EQ(arm.inertial->mass, 2);
  EXPECT_EQ(arm.inertial->center, (Vec3{0, 0, 0.1}));
  EXPECT_FALSE(arm.inertial->estimated);
  ASSERT_EQ(arm.collisions.size(), 1u);
  EXPECT_EQ(arm.collisions[0].kind, ShapeKind::cylinder);
  EXPECT_EQ(arm.collisions[0].length, 0.2);
  EXPECT_EQ(model.links[2].collisions[0].size, (Vec3{0.1, 0.2, 0.3}));
  EXPECT_EQ(model.links[2].collisions[1].kind, ShapeKind::capsule);
}

TEST(Urdf, ReadsWhatItWrote) {
  const RobotModel model = read(kGood);
  test::expect_equal(model, read(write_urdf(model)));
}

TEST(Urdf, WritesTheSameTextAgain) {
  const std::string once = write_urdf(read(kGood));
  EXPECT_EQ(once, write_urdf(read(once)));
}

/// Half of the rotations are within a hair of where roll and yaw turn about one axis.
TEST(Urdf, KeepsEveryRotation) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> angle(-3.14, 3.14), digits(-17, 0);
  RobotModel model = read(kGood);
  for (int i = 0; i < 500; ++i) {
    const double hair = std::pow(10, digits(random)), side = i % 4 == 0 ? 1 : -1;
    const double pitch = i % 2 == 0 ? side * (1.5707963267948966 - hair) : angle(random);
    model.joints[0].origin.rotation = from_rpy(angle(random), pitch, angle(random));
    test::expect_near(read(write_urdf(model)).joints[0].origin, model.joints[0].origin);
  }
}

TEST(Urdf, TurnsTheInertiaIntoTheAxesOfTheLink) {
  const RobotModel model = read(links_and(
      "<link name=\"c\"><inertial><origin rpy=\"0 0 1.5707963267948966\"/><mass value=\"1\"/>"
      "<inertia ixx=\"0.01\" iyy=\"0.03\" izz=\"0.035\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link>\n" +
      joint("j", "a", "b") + joint("k", "b", "c")));
  const auto& inertia = model.links[2].inertial.value().inertia;
  EXPECT_NEAR(inertia[0], 0.03, 1e-12);
  EXPECT_NEAR(inertia[3], 0.01, 1e-12);
  EXPECT_NEAR(inertia[5], 0.035, 1e-12);
}

// --- refused, with line and reason

struct Bad {
  const char* name;
  std::string text;
  int line;
  std::string code;
  std::string piece;
};

void PrintTo(const Bad& bad, std::ostream* out) {
  *out << bad.name;
}

class BadUrdf : public ::testing::TestWithParam<Bad> {};

TEST_P(BadUrdf, IsRefusedWithLineAndReason) {
  Problems warnings;
  try {
    read_urdf(GetParam().text, "bad.urdf", warnings);
    FAIL() << "was accepted";
  } catch (const Error& e) {
    const Problem& first = e.problems().at(0);
    EXPECT_EQ(first.where.file, "bad.urdf");
    EXPECT_EQ(first.where.line, GetParam().line) << first.text();
    EXPECT_EQ(first.code, GetParam().code) << first.text();
    EXPECT_TRUE(has(first.text(), GetParam().piece));
  }
}

TEST(Urdf, HardwareWithoutLinksGetsOneForEachJoint) {
  Problems warnings;
  const RobotModel model = read_urdf(
      "<robot name=\"r\"><ros2_control name=\"B\" type=\"system\"><hardware><plugin>p/P</plugin></hardware>"
      "<joint name=\"left\"><command_interface name=\"velocity\"/></joint>"
      "<joint name=\"right\"><command_interface name=\"velocity\"/></joint></ros2_control></robot>",
      "r.urdf", warnings);
  EXPECT_EQ(model.joint_names(), (std::vector<std::string>{"left", "right"}));
  EXPECT_EQ(model.links.size(), 3u);
  EXPECT_EQ(model.joints[0].type, JointType::continuous);
  ASSERT_EQ(warnings.list().size(), 1u);
  EXPECT_EQ(warnings.list()[0].code, "no-links");
  EXPECT_EQ(warnings.list()[0].severity, Severity::warning);
}

std::vector<Bad> bad_files() {
  const std::string ab = joint("j", "a", "b");
  return {
      {"NoRobot", "<model/>\n", 1, "no-robot", "<robot>"},
      {"NoLinks", "<robot name=\"r\"/>\n", 1, "no-links", "no links"},
      {"SeveralRoots", "<!-- two -->\n" + links_and(""), 2, "several-roots", "a, b"},
      {"UnknownLinkWithNearName",
       "<robot>\n<link name=\"shoulder\"/>\n<link name=\"elbow\"/>\n" + joint("j", "shoulder", "elbwo") +
           "</robot>",
       4, "unknown-link", "did you mean 'elbow'"},
      {"UnknownParent", links_and("\n" + joint("j", "nowhere", "b")), 5, "unknown-link", "'nowhere'"},
      {"TwoLinksOfOneName", links_and("<link name=\"a\"/>\n" + ab), 4, "duplicate-name",
       "two links are called 'a'"},
      {"TwoJointsOfOneName", links_and("<link name=\"c\"/>\n" + ab + joint("j", "b", "c")), 6,
       "duplicate-name", "two joints are called 'j'"},
      {"TwoParents", links_and("<link name=\"c\"/>\n" + ab + joint("k", "c", "b")), 6, "two-parents", "'b'"},
      {"Circle", links_and(ab + joint("k", "b", "a")), 1, "circle", "circle"},
      {"CircleBesideARoot", links_and("<link name=\"c\"/>\n" + joint("j", "b", "c") + joint("k", "c", "b")),
       1, "circle", "circle"},
      {"ItsOwnParent", links_and(ab + joint("k", "a", "a")), 1, "circle", "circle"},
      {"ZeroAxis", links_and(joint("j", "a", "b", "\n<axis xyz=\"0 0 0\"/>")), 5, "zero-axis",
       "no direction"},
      {"AxisOfTwoNumbers", links_and(joint("j", "a", "b", "\n<axis xyz=\"0 1\"/>")), 5, "bad-number",
       "three numbers"},
      {"NanInOrigin", links_and(joint("j", "a", "b", "\n<origin xyz=\"0 nan 0\"/>")), 5, "bad-number",
       "0 nan 0"},
      {"InfiniteLimit", links_and(joint("j", "a", "b", "\n<limit lower=\"-1\" upper=\"inf\"/>", "revolute")),
       5, "bad-number", "upper=\"inf\""},
      {"WordForANumber", links_and(joint("j", "a", "b", "\n\n<limit velocity=\"fast\"/>")), 6, "bad-number",
       "velocity=\"fast\""},
      {"NegativeMass",
       links_and("<link name=\"c\">\n<inertial><mass value=\"-3\"/></inertial></link>\n" + ab +
                 joint("k", "b", "c")),
       5, "bad-mass", "-3"},
      {"UnknownJointType", links_and(joint("j", "a", "b", "", "revolut")), 4, "bad-type",
       "did you mean 'revolute'"},
      {"NoJointType", links_and("<joint name=\"j\"><parent link=\"a\"/><child link=\"b\"/></joint>"), 4,
       "missing-attribute", "'type'"},
      {"NoChild", links_and("<joint name=\"j\" type=\"fixed\"><parent link=\"a\"/></joint>"), 4,
       "missing-tag", "<child>"},
      {"LinkWithoutName", links_and("<link/>\n" + ab), 4, "missing-attribute", "'name'"},
      {"XmlSyntax", "<robot>\n<link name=\"a\">\n</robot>\n", 2, "xml-syntax", "not valid XML"},
      {"EmptyFile", "", 0, "xml-syntax", "not valid XML"},
      {"NoXmlAtAll",
       std::string("\x7f"
                   "ELF\0\1\2\3",
                   8),
       1, "xml-syntax", "not valid XML"},
      {"Xacro",
       "<robot xmlns:xacro=\"http://ros.org/wiki/xacro\">\n\n<xacro:include filename=\"x\"/>\n</robot>\n", 3,
       "xacro", "name the xacro file itself"},
      {"XacroExpression", links_and("<!-- -->\n" + joint("j", "a", "b", "<origin xyz=\"${x} 0 0\"/>")), 5,
       "xacro", "expanded"},
  };
}

INSTANTIATE_TEST_SUITE_P(Table, BadUrdf, ::testing::ValuesIn(bad_files()),
                         [](const auto& test) { return std::string(test.param.name); });

// --- accepted with a warning, as other readers of URDF answer

RobotModel read_odd(const std::string& text, const char* code, const char* piece) {
  Problems found;
  RobotModel out = read_urdf(text, "robot.urdf", found);
  EXPECT_FALSE(found.has_errors());
  const auto said = std::find_if(found.list().begin(), found.list().end(),
                                 [&](const Problem& problem) { return problem.code == code; });
  EXPECT_NE(said, found.list().end()) << code;
  if (said == found.list().end()) return out;
  EXPECT_TRUE(test::has(said->text(), piece)) << said->text();
  EXPECT_GT(said->where.line, 0) << said->text();
  return out;
}

TEST(OddUrdf, LimitsTheWrongWayRoundAreExchanged) {
  const RobotModel model =
      read_odd(links_and(joint("j", "a", "b", "\n<limit lower=\"2\" upper=\"-2\"/>", "revolute")),
               "bad-limit", "above its upper limit -2");
  EXPECT_EQ(model.joints.at(0).limits.lower, -2);
  EXPECT_EQ(model.joints.at(0).limits.upper, 2);
}

TEST(OddUrdf, SoftLimitsTheWrongWayRoundAreExchanged) {
  const RobotModel model =
      read_odd(links_and(joint("j", "a", "b",
                               "<limit lower=\"-2\" upper=\"2\"/>\n<safety_controller soft_lower_limit=\"1\" "
                               "soft_upper_limit=\"-1\" k_velocity=\"1\"/>",
                               "revolute")),
               "bad-limit", "soft upper limit -1");
  EXPECT_EQ(model.joints.at(0).soft_limits.value().lower, -1);
}

TEST(OddUrdf, WhoCannotMimicMovesByItself) {
  const std::string c = "<link name=\"c\"/>\n";
  const RobotModel missing =
      read_odd(links_and(joint("turn", "a", "b") + c + joint("k", "b", "c", "<mimic joint=\"trun\"/>")),
               "bad-mimic", "did you mean 'turn'");
  EXPECT_FALSE(missing.joints.at(1).mimic);
  EXPECT_EQ(missing.joint_names(), (std::vector<std::string>{"turn", "k"}));

  const RobotModel of_fixed = read_odd(
      links_and(joint("turn", "a", "b", "", "fixed") + c + joint("k", "b", "c", "<mimic joint=\"turn\"/>")),
      "bad-mimic", "type fixed");
  EXPECT_EQ(of_fixed.joint_names(), std::vector<std::string>{"k"});

  const RobotModel circle = read_odd(links_and(c + joint("j", "a", "b", "<mimic joint=\"k\"/>") +
                                               joint("k", "b", "c", "<mimic joint=\"j\"/>")),
                                     "bad-mimic", "mimics itself");
  EXPECT_EQ(circle.actuated.size(), 1u);
  const RobotModel own =
      read_odd(links_and(joint("j", "a", "b", "<mimic joint=\"j\"/>")), "bad-mimic", "mimics itself");
  EXPECT_EQ(own.actuated.size(), 1u);
}

TEST(OddUrdf, OfJointsBetweenTheSameLinksTheLastByNameCarriesTheLink) {
  Problems warnings;
  const RobotModel model =
      read_urdf(links_and(joint("z", "a", "b", "<origin xyz=\"0 0 3\"/>") +
                          joint("x", "a", "b", "<origin xyz=\"1 0 0\"/>") + joint("y", "a", "b")),
                "robot.urdf", warnings);
  EXPECT_EQ(model.joint_names(), (std::vector<std::string>{"z", "x", "y"}));
  const Joint& carries = model.joints[static_cast<std::size_t>(
      model.links[static_cast<std::size_t>(model.find_link("b"))].parent_joint)];
  EXPECT_EQ(carries.name, "z");
  EXPECT_EQ(carries.origin.position.z, 3);
  EXPECT_TRUE(warned(warnings, "two-parents"));
}

TEST(OddUrdf, AFreeJointIsTold) {
  const RobotModel model = read_odd(links_and(joint("j", "a", "b", "", "floating")), "free-joint",
                                    "kinematics takes it as fixed at its origin");
  EXPECT_TRUE(model.actuated.empty());
}

TEST(Urdf, ReportsEverythingThatIsWrongAtOnce) {
  try {
    read(links_and(joint("j", "a", "b", "<axis xyz=\"0 0 0\"/>", "turning") +
                   "<link name=\"c\"><inertial><mass value=\"-1\"/></inertial></link>\n"));
    FAIL() << "was accepted";
  } catch (const Error& e) {
    std::vector<std::string> codes;
    for (const Problem& p : e.problems()) codes.push_back(p.code);
    EXPECT_EQ(codes, (std::vector<std::string>{"bad-type", "bad-mass"}));
  }
}

TEST(Urdf, RefusesElementsNestedWithoutEnd) {
  std::string deep = "<robot>";
  for (int i = 0; i < 200000; ++i) deep += "<link>";
  EXPECT_THROW(read(deep), Error);
}

// --- odd but legal

TEST(Urdf, NormalisesAnAxisThatIsNotUnit) {
  const RobotModel model = read(links_and(joint("j", "a", "b", "<axis xyz=\"0 3 4\"/>")));
  test::expect_near(model.joints[0].axis, {0, 0.6, 0.8}, 1e-15);
}

TEST(Urdf, SettlesAnglesThatAreRoundedMultiplesOfAnEighthOfATurn) {
  const auto turned = [](const std::string& rpy) {
    return read(links_and(joint("j", "a", "b", "<origin rpy=\"" + rpy + "\"/>")));
  };
  const double pi = std::numbers::pi;
  const RobotModel settled = turned("-1.5708 0.7854 3.14159");
  EXPECT_EQ(settled.joints[0].origin.rotation, from_rpy(-pi / 2, pi / 4, pi));
  EXPECT_TRUE(settled.provenance.notes.empty()) << "they are no doubts about facts: such an arm is armed";
  // A coarser number, one that is cut farther from it, one of a calibration, and another angle.
  for (const double other : {1.571, 1.5707, 1.5707995218837, 1.5711, 3.92, 0.00001})
    EXPECT_EQ(turned(format_number(other) + " 0 0").joints[0].origin.rotation, from_rpy(other, 0, 0))
        << other;
}

TEST(Urdf, TakesXForAnAxisThatIsNotStated) {
  EXPECT_EQ(read(links_and(joint("j", "a", "b"))).joints[0].axis, (Vec3{1, 0, 0}));
}

TEST(Urdf, EstimatesAMissingInertialAndSaysSo) {
  const RobotModel model = read(links_and(
      "<link name=\"c\"><collision><origin xyz=\"0 0 0.5\"/><geometry><box size=\"0.1 0.1 1\"/></geometry>"
      "</collision></link>\n" +
      joint("j", "a", "b") + joint("k", "b", "c")));
  const Link& c = model.links[2];
  ASSERT_TRUE(c.inertial);
  EXPECT_TRUE(c.inertial->estimated);
  EXPECT_GT(c.inertial->mass, 0);
  test::expect_near(c.inertial->center, {0, 0, 0.5});
  // A box of mass m has m (a² + b²) / 12 about each axis.
  EXPECT_NEAR(c.inertial->inertia[0], c.inertial->mass * (0.01 + 1) / 12, 1e-9);
  EXPECT_NEAR(c.inertial->inertia[5], c.inertial->mass * (0.01 + 0.01) / 12, 1e-9);
  ASSERT_FALSE(model.provenance.notes.empty());
  EXPECT_TRUE(has(model.provenance.notes[0], "estimated"));
  EXPECT_TRUE(has(model.provenance.notes[0], "c"));
}

TEST(Urdf, RepairsAnInertiaThatBelongsToNoBodyAndKeepsTheMass) {
  Problems warnings;
  const RobotModel model = read_urdf(
      links_and("<link name=\"c\"><inertial><mass value=\"4\"/>"
                "<inertia ixx=\"1\" iyy=\"1\" izz=\"9\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link>\n" +
                joint("j", "a", "b") + joint("k", "b", "c")),
      "r.urdf", warnings);
  const Inertial& inertial = model.links[2].inertial.value();
  EXPECT_EQ(inertial.mass, 4);
  EXPECT_TRUE(inertial.estimated);
  EXPECT_GE(inertial.inertia[0] + inertial.inertia[3], inertial.inertia[5]);
  EXPECT_TRUE(warned(warnings, "inertia"));
}

TEST(Urdf, AllowsBlanksEverywhere) {
  const RobotModel model = read(links_and(
      "<joint   name = ' j '\n type=\"\n continuous \" >\n <parent link=\" a \"/> <child\nlink=\"b\n\"/>\n"
      "<origin xyz=\"  1\t2\n3 \" rpy = \" 0 0  0\"/><limit velocity=\" 2 \"/></joint>\n"));
  EXPECT_EQ(model.joints[0].name, "j");
  EXPECT_EQ(model.joints[0].origin.position, (Vec3{1, 2, 3}));
  EXPECT_EQ(model.joints[0].limits.velocity, 2);
}

TEST(Urdf, SortsParentsBeforeChildrenAndOtherwiseKeepsTheOrder) {
  const RobotModel model = read("<robot>" + joint("third", "c", "d") + joint("second", "b", "c") +
                                joint("side", "a", "e") + joint("first", "a", "b") +
                                "<link name=\"d\"/><link name=\"e\"/><link name=\"c\"/><link name=\"b\"/>"
                                "<link name=\"a\"/></robot>");
  EXPECT_EQ(model.links[static_cast<std::size_t>(model.root)].name, "a");
  EXPECT_EQ(model.joint_names(), (std::vector<std::string>{"side", "first", "second", "third"}));
}

TEST(Urdf, AcceptsContinuousWithoutLimitsSilently) {
  Problems warnings;
  const RobotModel model = read_urdf(links_and(joint("j", "a", "b")), "r.urdf", warnings);
  EXPECT_FALSE(model.joints[0].limits.lower || model.joints[0].limits.upper);
  EXPECT_TRUE(warnings.list().empty());
}

TEST(Urdf, WarnsOfARevoluteJointWithoutLimitsAndLeavesItUnlimited) {
  Problems warnings;
  const RobotModel model = read_urdf(links_and(joint("j", "a", "b", "", "revolute")), "r.urdf", warnings);
  EXPECT_FALSE(model.joints[0].limits.lower || model.joints[0].limits.upper);
  ASSERT_EQ(warnings.list().size(), 1u);
  EXPECT_EQ(warnings.list()[0].code, "no-limit");
  EXPECT_EQ(warnings.list()[0].where.line, 4);
  EXPECT_EQ(warnings.list()[0].severity, Severity::warning);
}

TEST(Urdf, WarnsOfLimitsThatLookLikeDegrees) {
  const auto found = [](const std::string& limit, const char* type = "revolute") {
    Problems warnings;
    read_urdf(links_and(joint("j", "a", "b", "<limit " + limit + " velocity=\"1\" effort=\"1\"/>", type)),
              "r.urdf", warnings);
    return warnings.list().empty() ? std::string("none") : warnings.list()[0].code;
  };
  EXPECT_EQ(found("lower=\"-170\" upper=\"170\""), "degrees");
  EXPECT_EQ(found("lower=\"0\" upper=\"360\""), "degrees");
  for (const char* radians :
       {"lower=\"-3.1416\" upper=\"3.1416\"", "lower=\"-6\" upper=\"6\"", "lower=\"-31.4\" upper=\"31.4\"",
        "lower=\"-1000\" upper=\"1000\"", "lower=\"-1e16\" upper=\"1e16\""})
    EXPECT_EQ(found(radians), "none") << radians;
  EXPECT_EQ(found("lower=\"0\" upper=\"100\"", "prismatic"), "none");
}

TEST(Urdf, DoesNotNeedTheMeshesItNames) {
  const RobotModel model = read(kGood);
  const Shape& mesh = model.links[1].visuals.at(0);
  EXPECT_EQ(mesh.mesh, "package://maker/arm.stl");
  EXPECT_EQ(mesh.scale, (Vec3{2, 2, 2}));
  EXPECT_TRUE(mesh.mesh_path.empty());
}

TEST(Urdf, WarnsOnceOfEachUnknownTag) {
  Problems warnings;
  read_urdf(links_and("<banana/>\n<banana/>\n<gazebo/>\n" + joint("j", "a", "b")), "r.urdf", warnings);
  ASSERT_EQ(warnings.list().size(), 1u);
  EXPECT_TRUE(has(warnings.list()[0].what, "<banana>"));
  EXPECT_EQ(warnings.list()[0].where.line, 4);
}

TEST(Urdf, TiesFollowersOfFollowersToTheFirst) {
  const RobotModel model =
      read(links_and("<link name=\"c\"/><link name=\"d\"/>" + joint("lead", "a", "b") +
                     joint("one", "b", "c", "<mimic joint=\"lead\" multiplier=\"2\" offset=\"0.5\"/>") +
                     joint("two", "c", "d", "<mimic joint=\"one\" multiplier=\"3\" offset=\"1\"/>")));
  const Mimic& two = model.joints[2].mimic.value();
  EXPECT_EQ(two.joint, 0);
  EXPECT_NEAR(two.multiplier, 6, 1e-12);
  EXPECT_NEAR(two.offset, 2.5, 1e-12);
}

// --- <ros2_control>

const char* const kHardware = R"(<ros2_control name="arm" type="system">
  <hardware>
    <plugin> vendor/ArmDriver </plugin>
    <group>left</group>
    <param name="address">10.0.0.2</param>
  </hardware>
  <joint name="j">
    <command_interface name="position"><param name="min">-1.5</param><param name="max">2</param></command_interface>
    <state_interface name="position"><param name="initial_value">0.25</param></state_interface>
    <state_interface name="velocity"/>
    <param name="can_id">7</param>
  </joint>
  <sensor name="wrist"><state_interface name="force.z"/></sensor>
  <gpio name="valves"><command_interface name="air" data_type="bool"/></gpio>
</ros2_control>
)";

RobotModel with_hardware() {
  return read(links_and(joint("j", "a", "b") + kHardware));
}

TEST(Ros2Control, NamesPluginGroupAndParameters) {
  const RobotModel model = with_hardware();
  ASSERT_EQ(model.hardware.size(), 1u);
  const HardwareInfo& hardware = model.hardware[0];
  EXPECT_EQ(hardware.name, "arm");
  EXPECT_EQ(hardware.type, "system");
  EXPECT_EQ(hardware.plugin, "vendor/ArmDriver");
  EXPECT_EQ(hardware.group, "left");
  EXPECT_EQ(hardware.parameters.at("address"), "10.0.0.2");
  EXPECT_EQ(hardware.where.line, 5);
}

TEST(Ros2Control, ListsInterfacesWithTheirRanges) {
  const RobotModel model = with_hardware();
  ASSERT_EQ(model.hardware.at(0).components.size(), 3u);
  const ComponentInfo& j = model.hardware[0].components[0];
  EXPECT_EQ(j.kind, "joint");
  EXPECT_EQ(j.parameters.at("can_id"), "7");
  ASSERT_EQ(j.command_interfaces.size(), 1u);
  EXPECT_EQ(j.command_interfaces[0].min, -1.5);
  EXPECT_EQ(j.command_interfaces[0].max, 2);
  ASSERT_EQ(j.state_interfaces.size(), 2u);
  EXPECT_EQ(j.state_interfaces[0].initial_value, 0.25);
  EXPECT_FALSE(j.state_interfaces[1].initial_value);
  EXPECT_EQ(model.hardware[0].components[1].kind, "sensor");
  EXPECT_EQ(model.hardware[0].components[1].state_interfaces.at(0).name, "force.z");
  EXPECT_EQ(model.hardware[0].components[2].kind, "gpio");
  EXPECT_EQ(model.hardware[0].components[2].command_interfaces.at(0).data_type, "bool");
}

TEST(Ros2Control, IsWrittenSoThatItReadsBack) {
  const RobotModel before = with_hardware(), after = read(write_urdf(before));
  ASSERT_EQ(after.hardware.size(), 1u);
  EXPECT_EQ(after.hardware[0].plugin, before.hardware[0].plugin);
  EXPECT_EQ(after.hardware[0].group, before.hardware[0].group);
  EXPECT_EQ(after.hardware[0].parameters, before.hardware[0].parameters);
  ASSERT_EQ(after.hardware[0].components.size(), 3u);
  const auto& state = after.hardware[0].components[0].state_interfaces;
  const auto& command = after.hardware[0].components[0].command_interfaces;
  ASSERT_EQ(state.size(), 2u);
  ASSERT_EQ(command.size(), 1u);
  EXPECT_EQ(state[0].initial_value, 0.25);
  EXPECT_EQ(command[0].min, -1.5);
  EXPECT_EQ(command[0].max, 2);
  EXPECT_EQ(after.hardware[0].components[2].command_interfaces.at(0).data_type, "bool");
}

// --- damage

TEST(UrdfFuzz, DamagedTextEndsInAModelOrAnError) {
  const std::string good = links_and(joint("j", "a", "b") + kHardware);
  test::Mutator mutate(20240601);
  int refused = 0, accepted = 0;
  for (int i = 0; i < 2000; ++i) {
    const std::string text = mutate(i % 2 ? good : kGood);
    try {
      const RobotModel model = read(text);
      ++accepted;
      EXPECT_EQ(model.joints.size() + 1, model.links.size()) << text;
    } catch (const Error&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 200);
  EXPECT_GT(accepted, 20);
}

}  // namespace
}  // namespace polyarm::description::urdf_test
