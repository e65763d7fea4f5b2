#include <gtest/gtest.h>

#include "polyarm/description/urdf.hpp"
#include "tests/description/support.hpp"

namespace polyarm::description::gazebo_test {
namespace {

using test::has;

/// Two links and a joint; `body` starts on line 5.
std::string robot(const std::string& body) {
  return "<robot name=\"r\">\n<link name=\"base\"/><link name=\"arm\"/>\n<joint name=\"elbow\" "
         "type=\"continuous\">\n"
         "<parent link=\"base\"/><child link=\"arm\"/><dynamics damping=\"1\" friction=\"2\"/></joint>\n" +
         body + "</robot>\n";
}

RobotModel read(const std::string& body, Problems& warnings) {
  return read_urdf(robot(body), "r.urdf", warnings);
}

RobotModel read(const std::string& body) {
  Problems warnings;
  const RobotModel out = read(body, warnings);
  EXPECT_TRUE(warnings.list().empty()) << warnings.list()[0].text();
  return out;
}

TEST(Gazebo, GivesLinksFrictionAndSelfCollision) {
  const RobotModel model = read(
      "<gazebo reference=\"arm\"><mu1>0.2</mu1><mu2 "
      "value=\"0.3\"/><selfCollide>true</selfCollide></gazebo>\n");
  Problems warnings;
  for (const RobotModel& m : {model, read_urdf(write_urdf(model), "w.urdf", warnings)}) {
    EXPECT_EQ(m.links[1].contact.mu1, 0.2);
    EXPECT_EQ(m.links[1].contact.mu2, 0.3);
    EXPECT_EQ(m.links[1].contact.self_collide, true);
    EXPECT_FALSE(m.links[0].contact.mu1 || m.links[0].contact.self_collide);
  }
}

TEST(Gazebo, NamesTheControllersFilesOfItsPlugins) {
  Problems warnings;
  const RobotModel model = read_urdf(
      "<robot name=\"r\"><link name=\"a\"/><gazebo><plugin filename=\"libgz_ros2_control.so\" name=\"c\">"
      "<parameters>/ws/c.yaml</parameters><parameters>/ws/d.yml</parameters><parameters>/ws/c.yaml</"
      "parameters>"
      "<parameters>words</parameters></plugin></gazebo></robot>",
      "r.urdf", warnings);
  EXPECT_EQ(model.controller_files, (std::vector<std::string>{"/ws/c.yaml", "/ws/d.yml"}));
}

TEST(Gazebo, GivesJointsDampingAndFrictionOverWhatTheyHave) {
  EXPECT_EQ(read("").joints[0].damping, 1);
  const RobotModel model =
      read("<gazebo reference=\"elbow\"><damping>0.5</damping><friction>0.25</friction></gazebo>\n");
  EXPECT_EQ(model.joints[0].damping, 0.5);
  EXPECT_EQ(model.joints[0].friction, 0.25);
  const RobotModel other = read(
      "<gazebo reference=\"elbow\"><dynamics damping=\"0.75\"><friction>0</friction></dynamics></gazebo>\n");
  EXPECT_EQ(other.joints[0].damping, 0.75);
  EXPECT_EQ(other.joints[0].friction, 0);
}

TEST(Gazebo, LetsTheWholeRobotCollideWithItselfUnlessALinkSaysOtherwise) {
  for (const char* order : {"<gazebo><self_collide>true</self_collide></gazebo>"
                            "<gazebo reference=\"arm\"><selfCollide>false</selfCollide></gazebo>",
                            "<gazebo reference=\"arm\"><selfCollide>0</selfCollide></gazebo>"
                            "<gazebo><self_collide>1</self_collide></gazebo>"}) {
    const RobotModel model = read(order);
    EXPECT_EQ(model.links[0].contact.self_collide, true);
    EXPECT_EQ(model.links[1].contact.self_collide, false);
  }
}

TEST(Gazebo, MayStandBeforeWhatItNames) {
  Problems warnings;
  const RobotModel model = read_urdf(
      "<robot><gazebo reference=\"a\"><mu1>2</mu1></gazebo><link name=\"a\"/></robot>", "r.urdf", warnings);
  EXPECT_EQ(model.links[0].contact.mu1, 2);
}

TEST(Gazebo, ListsWhatIsPassedOverInOneWarning) {
  Problems warnings;
  read(
      "<gazebo reference=\"arm\"><material>Gazebo/Red</material><mu1>1</mu1>\n<kp>1e6</kp></gazebo>\n"
      "<gazebo reference=\"base\"><material>Gazebo/Blue</material></gazebo>\n"
      "<gazebo>\n<plugin name=\"p\" filename=\"libp.so\"><x/></plugin></gazebo>\n",
      warnings);
  ASSERT_EQ(warnings.list().size(), 1u);
  EXPECT_EQ(warnings.list()[0].where.line, 5);
  EXPECT_TRUE(has(warnings.list()[0].what, "<material> (line 5), <kp> (line 6), <plugin> (line 9) ignored"));
}

TEST(Gazebo, SaysThatGravityIsNotTurnedOff) {
  Problems warnings;
  read(
      "<gazebo reference=\"arm\"><gravity>false</gravity></gazebo>\n"
      "<gazebo reference=\"base\"><turnGravityOff>true</turnGravityOff></gazebo>\n",
      warnings);
  ASSERT_EQ(warnings.list().size(), 1u);
  EXPECT_EQ(warnings.list()[0].where.line, 5);
  EXPECT_TRUE(
      has(warnings.list()[0].what, "turns gravity off for arm, base; physics here applies it to them"));
  read("<gazebo reference=\"arm\"><gravity>1</gravity><turnGravityOff>0</turnGravityOff></gazebo>\n");
}

TEST(Gazebo, WarnsOfNamesThatAreNotThere) {
  Problems warnings;
  read("<gazebo reference=\"elbw\"><mu1>1</mu1></gazebo>\n", warnings);
  ASSERT_EQ(warnings.list().size(), 1u);
  EXPECT_TRUE(has(warnings.list()[0].text(), "did you mean 'elbow'"));
}

TEST(Gazebo, LeavesOutValuesThatAreNone) {
  for (const char* bad : {"<mu1>slippery</mu1>", "<mu1>-1</mu1>", "<mu2 value=\"\"/>", "<mu1/>",
                          "<selfCollide>perhaps</selfCollide>", "<turnGravityOff value=\"no\"/>"}) {
    Problems warnings;
    const RobotModel model =
        read(std::string("\n<gazebo reference=\"arm\">\n") + bad + "</gazebo>\n", warnings);
    EXPECT_FALSE(model.links[1].contact.mu1) << bad;
    EXPECT_FALSE(model.links[1].contact.self_collide) << bad;
    ASSERT_EQ(warnings.list().size(), 1u) << bad;
    EXPECT_EQ(warnings.list()[0].severity, Severity::warning) << bad;
    EXPECT_EQ(warnings.list()[0].where.line, 7) << bad;
    EXPECT_TRUE(has(warnings.list()[0].text(), "; it is ignored")) << warnings.list()[0].text();
  }
}

TEST(Gazebo, ReadsBooleansInTheAttributeValue) {
  EXPECT_EQ(read("<gazebo reference=\"arm\"><selfCollide value=\"true\"/></gazebo>\n")
                .links[1]
                .contact.self_collide,
            true);
  Problems warnings;
  read("<gazebo reference=\"arm\"><turnGravityOff value=\"true\"/></gazebo>\n", warnings);
  ASSERT_EQ(warnings.list().size(), 1u);
  EXPECT_TRUE(has(warnings.list()[0].text(), "turns gravity off for arm")) << warnings.list()[0].text();
}

TEST(GazeboFuzz, DamagedTextEndsInAModelOrAnError) {
  const std::string good = robot(
      "<gazebo reference=\"arm\"><mu1>0.2</mu1><mu2 value=\"0.3\"/><selfCollide>true</selfCollide></gazebo>"
      "<gazebo><self_collide>true</self_collide><plugin/></gazebo><gazebo reference=\"elbow\">"
      "<dynamics damping=\"1\"/><damping>2</damping></gazebo>"
      "<transmission name=\"t\"><type>T</type><joint name=\"elbow\"><hardwareInterface>x</hardwareInterface>"
      "</joint><actuator name=\"m\"><mechanicalReduction>5</mechanicalReduction></actuator></transmission>");
  test::Mutator mutate(5);
  int refused = 0, accepted = 0;
  for (int i = 0; i < 4000; ++i) {
    const std::string text = mutate(good);
    Problems warnings;
    try {
      const RobotModel model = read_urdf(text, "r.urdf", warnings);
      ++accepted;
      for (const Link& link : model.links) EXPECT_GE(link.contact.mu1.value_or(0), 0) << text;
    } catch (const Error&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 400);
  EXPECT_GT(accepted, 100);
}

}  // namespace
}  // namespace polyarm::description::gazebo_test
