#include "polyarm/ros2/options.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <map>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/participant/participant.hpp"
#include "tests/ros2/domain.hpp"

namespace polyarm::ros2 {
namespace {

using Environment = std::map<std::string, std::string>;

/// What the variables of ROS 2 make of a participant, with nothing else of them in the environment.
ParticipantOptions of(const Environment& environment, const Options& said = {}) {
  for (const char* name : {"ROS_DOMAIN_ID", "ROS_AUTOMATIC_DISCOVERY_RANGE", "ROS_STATIC_PEERS",
                           "ROS_LOCALHOST_ONLY", "ROS_DISTRO"})
    ::unsetenv(name);
  for (const auto& [name, value] : environment) ::setenv(name.c_str(), value.c_str(), 1);
  return participant_options(said);
}

TEST(Ros2Options, NothingSaidIsThisMachineAlone) {
  const ParticipantOptions out = of({});
  EXPECT_EQ(out.domain, 0u);
  EXPECT_TRUE(out.loopback);
  EXPECT_TRUE(out.discovery);
  EXPECT_TRUE(out.peers.empty());
}

TEST(Ros2Options, TheTypesOfCmdVelAreThoseThatItsKeySays) {
  using Types = std::vector<std::string>;
  const std::string stamped = "geometry_msgs/TwistStamped", plain = "geometry_msgs/Twist";
  EXPECT_EQ(twists_of({}), Types{stamped});
  EXPECT_EQ(twists_of({{"cmd_vel", "TwistStamped"}}), Types{stamped});
  EXPECT_EQ(twists_of({{"cmd_vel", "Twist"}}), Types{plain});
  EXPECT_EQ(twists_of({{"cmd_vel", "both"}}), (Types{stamped, plain}));
  EXPECT_THROW(twists_of({{"cmd_vel", "Pose"}}), Error);
}

TEST(Ros2Options, EachRangeOfRos2IsUnderstood) {
  const char* const range = "ROS_AUTOMATIC_DISCOVERY_RANGE";
  EXPECT_FALSE(of({{range, "OFF"}}).discovery);
  EXPECT_TRUE(of({{range, "OFF"}}).loopback);
  EXPECT_TRUE(of({{range, "LOCALHOST"}}).loopback);
  EXPECT_FALSE(of({{range, "SUBNET"}}).loopback);
  EXPECT_FALSE(of({{range, "SYSTEM_DEFAULT"}}).loopback);
  EXPECT_TRUE(of({{range, "SYSTEM_DEFAULT"}}).discovery);
  EXPECT_THROW(of({{range, "WORLD"}}), Error);
  EXPECT_FALSE(of({{range, "LOCALHOST"}}, {{"range", "subnet"}}).loopback) << "the cell has the last word";
}

TEST(Ros2Options, AnOlderVariableKeepsItToThisMachine) {
  const ParticipantOptions out = of({{"ROS_LOCALHOST_ONLY", "1"},
                                     {"ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET"},
                                     {"ROS_STATIC_PEERS", "10.0.0.7"}});
  EXPECT_TRUE(out.loopback);
  EXPECT_TRUE(out.peers.empty());
  EXPECT_FALSE(of({{"ROS_LOCALHOST_ONLY", "0"}, {"ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET"}}).loopback);
}

TEST(Ros2Options, PeersAreForThoseWhoMayBeReached) {
  const Environment peers{{"ROS_STATIC_PEERS", "10.0.0.7;robot.local"},
                          {"ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET"}};
  EXPECT_EQ(of(peers).peers, (std::vector<std::string>{"10.0.0.7", "robot.local"}));
  EXPECT_TRUE(of({{"ROS_STATIC_PEERS", "10.0.0.7;robot.local"}}).peers.empty()) << "on loopback";
}

TEST(Ros2Options, DomainsAreThoseOfRos2) {
  EXPECT_EQ(of({{"ROS_DOMAIN_ID", "42"}}).domain, 42u);
  EXPECT_EQ(of({{"ROS_DOMAIN_ID", "42"}}, {{"domain", "7"}}).domain, 7u);
  for (const char* wrong : {"-1", "233", "1.5", "x"}) EXPECT_THROW(of({{"ROS_DOMAIN_ID", wrong}}), Error);
}

TEST(Ros2Options, ADistributionThatTheCellNamesIsKnown) {
  of({{"ROS_DISTRO", "humble"}});
  EXPECT_EQ(distribution_of({}), messages::Distribution::humble);
  EXPECT_EQ(distribution_of({{"distribution", "kilted"}}), messages::Distribution::kilted);
  EXPECT_THROW(distribution_of({{"distribution", "melodic"}}), Error);
  of({{"ROS_DISTRO", "noetic"}});
  EXPECT_EQ(distribution_of({}), messages::Distribution::jazzy) << "the environment is meant for others, too";
}

TEST(Ros2Options, APeerThatIsNobodyIsRefusedByName) {
  ParticipantOptions out;
  out.domain = test::own_domain();
  out.loopback = false;
  out.peers = {"localhost"};
  EXPECT_NO_THROW(Participant{out}) << "a name that has an address";
  out.peers = {"no-such-host.invalid"};
  try {
    Participant participant{out};
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("no-such-host.invalid"), std::string::npos);
  }
}

}  // namespace
}  // namespace polyarm::ros2
