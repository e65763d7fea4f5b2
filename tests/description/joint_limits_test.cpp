#include "polyarm/description/joint_limits.hpp"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "polyarm/base/text.hpp"
#include "polyarm/description/urdf.hpp"
#include "tests/description/support.hpp"

namespace polyarm::description {
namespace {

using test::has;
constexpr double kPi = std::numbers::pi;

/// A robot of one joint `j` of the type, with `inside` in the joint and `control` in its <ros2_control>.
std::string robot(const std::string& inside, const std::string& control,
                  const std::string& type = "revolute") {
  return "<robot name=\"r\"><link name=\"a\"/><link name=\"b\"/>\n<joint name=\"j\" type=\"" + type +
         "\"><parent link=\"a\"/><child link=\"b\"/>" + inside + "</joint>\n<ros2_control name=\"h\" " +
         "type=\"system\"><hardware><plugin>p</plugin></hardware>\n<joint name=\"j\">" + control +
         "</joint></ros2_control></robot>";
}

const char* const kLimit = "<limit lower=\"-3\" upper=\"3\" velocity=\"2\" effort=\"50\"/>";

std::string command(const std::string& name, const std::string& min, const std::string& max,
                    const std::string& more = {}) {
  std::string out = "<command_interface name=\"" + name + "\">" + more;
  if (!min.empty()) out += "<param name=\"min\">" + min + "</param>";
  if (!max.empty()) out += "<param name=\"max\">" + max + "</param>";
  return out + "</command_interface>";
}

RobotModel model_of(const std::string& text) {
  Problems warnings;
  return read_urdf(text, "r.urdf", warnings);
}

JointLimitSet merged(const std::string& text, Problems& problems) {
  return merge_limits(model_of(text), problems).at(0);
}

JointLimitSet merged(const std::string& text) {
  Problems problems;
  const JointLimitSet out = merged(text, problems);
  EXPECT_TRUE(problems.list().empty()) << problems.list()[0].text();
  return out;
}

TEST(MergedLimits, AreThoseOfTheRobotWhereNothingElseIsSaid) {
  const JointLimitSet set = merged(robot(kLimit, command("position", "", "")));
  EXPECT_EQ(set.lower, -3);
  EXPECT_EQ(set.upper, 3);
  EXPECT_EQ(set.velocity, 2);
  EXPECT_EQ(set.effort, 50);
  EXPECT_FALSE(set.acceleration || set.deceleration || set.jerk || set.soft);
  EXPECT_EQ(set.disabled, JointLimitSet::Disabled{});
}

/// A six-axis robot whose URDF says ±π and 2.5 rad/s, its hardware ±2π and ±3.15.
TEST(MergedLimits, AreTheTighterOfBoth) {
  const std::string two_pi = format_number(2 * kPi), pi = format_number(kPi);
  const JointLimitSet set =
      merged(robot("<limit lower=\"-" + pi + "\" upper=\"" + pi + "\" velocity=\"2.5\" effort=\"1000\"/>",
                   command("position", "-" + two_pi, two_pi) + command("velocity", "-3.15", "3.15")));
  EXPECT_EQ(set.lower, -kPi);
  EXPECT_EQ(set.upper, kPi);
  EXPECT_EQ(set.velocity, 2.5);
  const JointLimitSet other =
      merged(robot(kLimit, command("position", "-1", "4") + command("velocity", "-1.5", "1.75")));
  EXPECT_EQ(other.lower, -1);
  EXPECT_EQ(other.upper, 3);
  EXPECT_EQ(other.velocity, 1.5);
}

TEST(MergedLimits, CollapseVelocityAndEffortToTheSmallerSide) {
  EXPECT_EQ(merged(robot(kLimit, command("velocity", "-0.5", "1"))).velocity, 0.5);
  EXPECT_EQ(merged(robot(kLimit, command("velocity", "-1", "0.5"))).velocity, 0.5);
  EXPECT_EQ(merged(robot(kLimit, command("velocity", "-0.25", ""))).velocity, 0.25);
  EXPECT_EQ(merged(robot(kLimit, command("velocity", "", "0.75"))).velocity, 0.75);
  EXPECT_EQ(merged(robot(kLimit, command("effort", "-10", "20"))).effort, 10);
}

TEST(MergedLimits, TakeAccelerationAndDecelerationFromMaxAndMin) {
  const auto of = [](const std::string& min, const std::string& max) {
    const JointLimitSet set = merged(robot(kLimit, command("acceleration", min, max)));
    return std::pair{set.acceleration, set.deceleration};
  };
  EXPECT_EQ(of("-7", "5"), (std::pair{std::optional(5.0), std::optional(7.0)}));
  EXPECT_EQ(of("-7", ""), (std::pair{std::optional(7.0), std::optional(7.0)}));
  EXPECT_EQ(of("", "5"), (std::pair{std::optional(5.0), std::optional(5.0)}));
}

TEST(MergedLimits, TakeJerkFromMaxAlone) {
  EXPECT_EQ(merged(robot(kLimit, command("jerk", "-9", "4"))).jerk, 4);
  EXPECT_FALSE(merged(robot(kLimit, command("jerk", "-9", ""))).jerk);
}

TEST(MergedLimits, BoundAContinuousJointWhoseHardwareIsBounded) {
  const JointLimitSet set = merged(robot("", command("position", "-1", "2"), "continuous"));
  EXPECT_EQ(set.lower, -1);
  EXPECT_EQ(set.upper, 2);
}

TEST(MergedLimits, DisableWhatTheInterfaceDisables) {
  const std::string off = "<limits enable=\"false\"/>";
  const JointLimitSet set =
      merged(robot(kLimit, command("position", "-1", "1", off) + command("velocity", "-1", "1")));
  EXPECT_FALSE(set.lower || set.upper);
  EXPECT_TRUE(set.disabled.position);
  EXPECT_EQ(set.velocity, 1);
  EXPECT_FALSE(set.disabled.velocity);
  const JointLimitSet accel = merged(robot(kLimit, command("acceleration", "-1", "1", off)));
  EXPECT_FALSE(accel.acceleration || accel.deceleration);
  EXPECT_TRUE(accel.disabled.acceleration && accel.disabled.deceleration);
}

TEST(MergedLimits, DisableEverythingOfAComponentThatSaysSo) {
  const JointLimitSet set =
      merged(robot(kLimit, "<limits enable=\"false\"/>" + command("velocity", "-1", "1")));
  EXPECT_FALSE(set.lower || set.upper || set.velocity || set.effort);
  EXPECT_TRUE(set.disabled.position && set.disabled.velocity && set.disabled.effort && set.disabled.jerk);
}

TEST(MergedLimits, ClipSoftLimitsToTheHardOnes) {
  const JointLimitSet set = merged(
      robot(std::string(kLimit) + "<safety_controller soft_lower_limit=\"-5\" soft_upper_limit=\"2.5\" "
                                  "k_position=\"20\" k_velocity=\"100\"/>",
            command("position", "-1", "1")));
  ASSERT_TRUE(set.soft);
  EXPECT_EQ(set.soft->lower, -1);
  EXPECT_EQ(set.soft->upper, 1);
  EXPECT_EQ(set.soft->k_position, 20);
  EXPECT_EQ(set.soft->k_velocity, 100);
}

TEST(MergedLimits, DropSoftLimitsOutsideTheHardOnes) {
  Problems problems;
  const JointLimitSet set = merged(
      robot(std::string(kLimit) + "<safety_controller soft_lower_limit=\"6\" soft_upper_limit=\"7\"/>", ""),
      problems);
  EXPECT_FALSE(set.soft);
  ASSERT_EQ(problems.list().size(), 1u);
  EXPECT_TRUE(has(problems.list()[0].text(), "'j' lie wholly outside"));
}

TEST(MergedLimits, RefuseRangesThatDoNotMeet) {
  Problems problems;
  const JointLimitSet set = merged(robot(kLimit, command("position", "4", "5")), problems);
  ASSERT_TRUE(problems.has_errors());
  EXPECT_EQ(problems.list()[0].where.line, 4);
  EXPECT_TRUE(has(problems.list()[0].text(), "from 4 to 3"));
  EXPECT_EQ(set.upper, 3);
}

TEST(MergedLimits, DoNotFreezeAJointWhoseLimitIsZero) {
  Problems problems;
  const JointLimitSet set = merged(robot(kLimit, command("velocity", "0", "0")), problems);
  EXPECT_EQ(set.velocity, 2);
  ASSERT_EQ(problems.list().size(), 1u);
  EXPECT_EQ(problems.list()[0].severity, Severity::warning);
  EXPECT_TRUE(has(problems.list()[0].text(), "<limits enable=\"false\"/>"));
}

TEST(MergedLimits, CanOnlyGetTighter) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> size(0.1, 6);
  for (int i = 0; i < 500; ++i) {
    const double low = -size(random), high = size(random), v = size(random);
    Problems problems;
    const JointLimitSet set =
        merged(robot(kLimit, command("position", format_number(low), format_number(high)) +
                                 command("velocity", format_number(-v), format_number(v))),
               problems);
    ASSERT_EQ(set.lower, std::max(low, -3.0));
    ASSERT_EQ(set.upper, std::min(high, 3.0));
    ASSERT_EQ(set.velocity, std::min(v, 2.0));
  }
}

TEST(MergedLimits, AreTakenOverByTheModelOnceAndForAll) {
  RobotModel model =
      model_of(robot(kLimit, command("position", "-1", "4") + command("acceleration", "-7", "5")));
  Problems problems;
  const auto once = merge_limits(model, problems);
  take_over(once, model);
  EXPECT_EQ(model.joints[0].limits.lower, -1);
  EXPECT_EQ(model.joints[0].limits.acceleration, 5);
  EXPECT_EQ(model.joints[0].limits.deceleration, 7);
  const auto twice = merge_limits(model, problems);
  EXPECT_EQ(twice[0].lower, once[0].lower);
  EXPECT_EQ(twice[0].deceleration, once[0].deceleration);
}

TEST(SoftLimits, AreReadAndWritten) {
  const std::string soft =
      "<safety_controller soft_lower_limit=\"-2\" soft_upper_limit=\"2.5\" k_position=\"15\" "
      "k_velocity=\"10\"/>";
  const RobotModel model = model_of(robot(kLimit + soft, ""));
  for (const RobotModel& m : {model, model_of(write_urdf(model))}) {
    ASSERT_TRUE(m.joints[0].soft_limits);
    EXPECT_EQ(m.joints[0].soft_limits->lower, -2);
    EXPECT_EQ(m.joints[0].soft_limits->upper, 2.5);
    EXPECT_EQ(m.joints[0].soft_limits->k_position, 15);
    EXPECT_EQ(m.joints[0].soft_limits->k_velocity, 10);
  }
}

TEST(SoftLimits, WithoutARangeHaveNone) {
  const RobotModel model =
      model_of(robot(std::string(kLimit) + "<safety_controller k_velocity=\"10\"/>", ""));
  ASSERT_TRUE(model.joints[0].soft_limits);
  EXPECT_FALSE(model.joints[0].soft_limits->lower || model.joints[0].soft_limits->upper);
}

// --- joint_limits.yaml

const char* const kFile = R"(joint_limits:
  j:
    has_velocity_limits: true
    max_velocity: 1.5
    has_position_limits: true
    min_position: -1
    max_position: 2
    has_acceleration_limits: true
    max_acceleration: 3.14
    has_deceleration_limits: true
    max_deceleration: 4
    has_jerk_limits: true
    max_jerk: 100
    has_effort_limits: true
    max_effort: 20
    has_soft_limits: true
    k_position: 10
    k_velocity: 20
    soft_lower_limit: -0.5
    soft_upper_limit: 1.75
    angle_wraparound: true
)";

JointLimitsFile file_of(const std::string& text, Problems& problems) {
  return read_joint_limits(text, "joint_limits.yaml", problems);
}

JointLimitsFile file_of(const std::string& text) {
  Problems problems;
  const JointLimitsFile out = file_of(text, problems);
  EXPECT_TRUE(problems.list().empty()) << problems.list()[0].text();
  return out;
}

JointLimitSet overridden(const std::string& yaml, const std::string& urdf = robot(kLimit, "")) {
  const RobotModel model = model_of(urdf);
  Problems problems;
  std::vector<JointLimitSet> limits = merge_limits(model, problems);
  override_limits(file_of(yaml), model, limits, problems);
  EXPECT_TRUE(problems.list().empty()) << problems.list()[0].text();
  return limits.at(0);
}

TEST(JointLimitsFile, ReadsEveryKey) {
  const JointLimitSet set = file_of(kFile).joints.at("j").limits;
  EXPECT_EQ(set.lower, -1);
  EXPECT_EQ(set.upper, 2);
  EXPECT_EQ(set.velocity, 1.5);
  EXPECT_EQ(set.acceleration, 3.14);
  EXPECT_EQ(set.deceleration, 4);
  EXPECT_EQ(set.jerk, 100);
  EXPECT_EQ(set.effort, 20);
  ASSERT_TRUE(set.soft);
  EXPECT_EQ(set.soft->lower, -0.5);
  EXPECT_EQ(set.soft->upper, 1.75);
  EXPECT_EQ(set.soft->k_position, 10);
  EXPECT_EQ(set.soft->k_velocity, 20);
  EXPECT_EQ(set.angle_wraparound, true);
  EXPECT_EQ(set.disabled, JointLimitSet::Disabled{});
}

TEST(JointLimitsFile, ReplacesWhatTheRobotSays) {
  const JointLimitSet set = overridden(kFile);
  EXPECT_EQ(set.lower, -1);
  EXPECT_EQ(set.velocity, 1.5);
  EXPECT_EQ(set.effort, 20);
  ASSERT_TRUE(set.soft);
  EXPECT_EQ(set.soft->upper, 1.75);
}

TEST(JointLimitsFile, DoesNotFreezeAJointWithoutVelocityLimitsAndAMaximumOfZero) {
  const JointLimitSet set = overridden("joint_limits: {j: {has_velocity_limits: false, max_velocity: 0}}");
  EXPECT_FALSE(set.velocity.has_value());
  EXPECT_TRUE(set.disabled.velocity);
  EXPECT_EQ(set.upper, 3);
  EXPECT_EQ(set.effort, 50);
}

TEST(JointLimitsFile, LetsTheDecelerationFollowAnAccelerationThatStandsAlone) {
  const JointLimitSet set =
      overridden("joint_limits: {j: {has_acceleration_limits: true, max_acceleration: 2}}",
                 robot(kLimit, command("acceleration", "-7", "5")));
  EXPECT_EQ(set.acceleration, 2);
  EXPECT_EQ(set.deceleration, 2);
}

TEST(JointLimitsFile, IsFoundBelowNameSpacesAndBesideControllers) {
  for (const char* text : {"MyRobot:\n  ctrl: {type: x/Y, joint: j, pid: {p: 1}}\n  joint_limits: {j: "
                           "{has_velocity_limits: true, max_velocity: 1.5}}\n",
                           "/**:\n  ros__parameters:\n    joint_limits:\n      j: {has_velocity_limits: "
                           "true, max_velocity: 1.5}\n",
                           "robot_description_planning:\n  joint_limits:\n    j: {has_velocity_limits: true, "
                           "max_velocity: 1.5}\n"})
    EXPECT_EQ(file_of(text).joints.at("j").limits.velocity, 1.5) << text;
}

TEST(JointLimitsFile, ReadsTheScalingOfMoveItAndDegrees) {
  const JointLimitsFile file = file_of(
      "default_velocity_scaling_factor: 0.1\ndefault_acceleration_scaling_factor: 0.5\n"
      "joint_limits:\n  j:\n    has_position_limits: true\n    min_position: !degrees -360.0\n"
      "    max_position: !degrees 90\n    has_velocity_limits: true\n    max_velocity: !radians 2\n");
  EXPECT_EQ(file.velocity_scaling, 0.1);
  EXPECT_EQ(file.acceleration_scaling, 0.5);
  EXPECT_NEAR(file.joints.at("j").limits.lower.value(), -2 * kPi, 1e-12);
  EXPECT_NEAR(file.joints.at("j").limits.upper.value(), kPi / 2, 1e-12);
  EXPECT_EQ(file.joints.at("j").limits.velocity, 2);
}

struct Line {
  const char* name;
  std::string entry;  ///< starts on line 3
  int line;
  Severity severity;
  std::string code, piece;
};

void PrintTo(const Line& line, std::ostream* out) {
  *out << line.name;
}

class JointLimitsLine : public ::testing::TestWithParam<Line> {};

TEST_P(JointLimitsLine, IsNamedWithItsPlace) {
  Problems problems;
  file_of("joint_limits:\n  j:\n" + GetParam().entry, problems);
  ASSERT_EQ(problems.list().size(), 1u);
  const Problem& p = problems.list()[0];
  EXPECT_EQ(p.where.file, "joint_limits.yaml");
  EXPECT_EQ(p.where.line, GetParam().line) << p.text();
  EXPECT_EQ(p.severity, GetParam().severity) << p.text();
  EXPECT_EQ(p.code, GetParam().code) << p.text();
  EXPECT_TRUE(has(p.text(), GetParam().piece));
}

std::vector<Line> lines() {
  const std::string velocity = "    has_velocity_limits: true\n";
  constexpr auto error = Severity::error, warning = Severity::warning;
  return {
      {"UnknownKey", "    has_velocity_limit: true\n", 3, error, "unknown-key",
       "did you mean 'has_velocity_limits'"},
      {"WordForANumber", velocity + "    max_velocity: fast\n", 4, error, "bad-value", "max_velocity of 'j'"},
      {"NumberOfNoEnd", velocity + "    max_velocity: .inf\n", 4, error, "bad-value", "max_velocity"},
      {"ListForANumber", velocity + "    max_velocity: [1, 2]\n", 4, error, "bad-value", "single value"},
      {"NumberForAFlag", "    has_velocity_limits: 3\n", 3, error, "bad-value", "has_velocity_limits of 'j'"},
      {"VelocityOfZero", velocity + "    max_velocity: 0\n", 4, error, "bad-limit",
       "has_velocity_limits: false"},
      {"JerkBelowZero", "    has_jerk_limits: true\n    max_jerk: -1\n", 4, error, "bad-limit", "-1"},
      {"FlagWithoutNumber", velocity, 3, warning, "no-effect", "without max_velocity"},
      {"NumberWithoutFlag", "    max_velocity: 1\n", 3, warning, "no-effect", "has_velocity_limits: true"},
      {"HalfARange", "    has_position_limits: true\n    min_position: 1\n", 3, warning, "no-effect",
       "max_position"},
      {"RangeUpsideDown", "    has_position_limits: true\n    min_position: 1\n    max_position: -1\n", 4,
       error, "bad-limit", "not below"},
      {"SoftUpsideDown",
       "    has_soft_limits: true\n    k_position: 1\n    k_velocity: 1\n    soft_lower_limit: 1\n"
       "    soft_upper_limit: 0\n",
       6, error, "bad-limit", "below the upper"},
      {"NoMap", "    5\n", 3, error, "bad-value", "'j' needs a map"},
  };
}

INSTANTIATE_TEST_SUITE_P(Table, JointLimitsLine, ::testing::ValuesIn(lines()),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(JointLimitsFile, NamesJointsThatTheRobotDoesNotHave) {
  const RobotModel model = model_of(
      "<robot name=\"r\"><link name=\"a\"/><link name=\"b\"/><joint name=\"elbow\" "
      "type=\"continuous\"><parent "
      "link=\"a\"/><child link=\"b\"/></joint></robot>");
  Problems problems;
  std::vector<JointLimitSet> limits = merge_limits(model, problems);
  override_limits(file_of("joint_limits:\n  elbwo: {has_velocity_limits: false}\n"), model, limits, problems);
  ASSERT_EQ(problems.list().size(), 1u);
  EXPECT_TRUE(has(problems.list()[0].text(), "joint_limits.yaml:2"));
  EXPECT_TRUE(has(problems.list()[0].text(), "did you mean 'elbow'"));
}

TEST(JointLimitsFile, RefusesAFileWithoutJointLimits) {
  Problems problems;
  try {
    file_of("a: 1\njoint_limit:\n  j: {}\n", problems);
    FAIL() << "was accepted";
  } catch (const Error& e) {
    EXPECT_EQ(e.problems().at(0).where.line, 2);
    EXPECT_TRUE(has(e.what(), "did you mean 'joint_limits'"));
  }
  EXPECT_THROW(file_of("", problems), Error);
  EXPECT_THROW(file_of("[", problems), Error);
  EXPECT_THROW(file_of("\x7f"
                       "ELF\x01\x02",
                       problems),
               Error);
}

TEST(JointLimitsFile, WalksThroughNestingWithoutEnd) {
  std::string deep, same = "a: &a {b: 1}\n";
  for (int i = 0; i < 200; ++i) deep += std::string(static_cast<std::size_t>(i), ' ') + "x:\n";
  Problems problems;
  EXPECT_THROW(file_of(deep, problems), Error);
  for (char c = 'b'; c < 'z'; ++c)  // doubles with each line
    same += std::string(1, c) + ": &" + c + " {l: *" + static_cast<char>(c - 1) + ", r: *" +
            static_cast<char>(c - 1) + "}\n";
  EXPECT_THROW(file_of(same, problems), Error);
}

TEST(JointLimitsFuzz, DamagedTextEndsInLimitsOrAnError) {
  const RobotModel model = model_of(robot(kLimit, ""));
  test::Mutator mutate(99);
  int refused = 0, accepted = 0;
  for (int i = 0; i < 4000; ++i) {
    const std::string text = mutate(kFile);
    Problems problems;
    try {
      const JointLimitsFile file = file_of(text, problems);
      std::vector<JointLimitSet> limits = merge_limits(model, problems);
      override_limits(file, model, limits, problems);
      for (const auto& value : {limits[0].velocity, limits[0].effort, limits[0].acceleration, limits[0].jerk})
        EXPECT_GT(value.value_or(1), 0) << text;
      ++(problems.has_errors() ? refused : accepted);
    } catch (const Error&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 400);
  EXPECT_GT(accepted, 100);
}

}  // namespace
}  // namespace polyarm::description
