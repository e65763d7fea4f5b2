#include "polyarm/ros2/options.hpp"

#include <algorithm>
#include <cstdlib>

#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::ros2 {

namespace {

std::string environment(const char* name) {
  const char* value = std::getenv(name);
  return value ? value : "";
}

std::string option(const Options& options, const char* key, const char* variable) {
  const auto at = options.find(key);
  return at == options.end() ? environment(variable) : at->second;
}

}  // namespace

std::string option_of(const Options& options, const std::string& key) {
  const auto at = options.find(key);
  return at == options.end() ? "" : at->second;
}

ParticipantOptions participant_options(const Options& options) {
  ParticipantOptions out;
  const std::string domain = option(options, "domain", "ROS_DOMAIN_ID");
  if (const auto number = parse_number(domain.empty() ? "0" : domain);
      number && *number >= 0 && *number <= 232 && *number == static_cast<int>(*number))
    out.domain = static_cast<std::uint32_t>(*number);
  else
    throw Error("bad-value", "the domain '" + domain + "' is not a number from 0 to 232",
                "check `ros2: {domain: …}` and ROS_DOMAIN_ID");
  std::string range = lower(option(options, "range", "ROS_AUTOMATIC_DISCOVERY_RANGE"));
  std::string peers = option(options, "peers", "ROS_STATIC_PEERS");
  // The older variable takes precedence over other environment variables.
  if (!options.contains("range") && environment("ROS_LOCALHOST_ONLY") == "1")
    range = "localhost", peers.clear();
  if (!range.empty() && range != "localhost" && range != "subnet" && range != "system_default" &&
      range != "off")
    throw Error("bad-value",
                "the range '" + range + "' is not one of OFF, LOCALHOST, SUBNET and SYSTEM_DEFAULT",
                "SUBNET lets the robot be reached from other machines");
  out.loopback = range != "subnet" && range != "system_default";
  out.discovery = range != "off";
  for (const std::string& peer : split_words(peers, ";, ")) out.peers.push_back(peer);
  if (out.loopback)
    std::erase_if(out.peers, [](const std::string& peer) { return !peer.starts_with("127."); });
  return out;
}

std::vector<std::string> twists_of(const Options& options) {
  const std::string said = option_of(options, "cmd_vel"), name = lower(said);
  if (name.empty() || name == "twiststamped") return {"geometry_msgs/TwistStamped"};
  if (name == "twist") return {"geometry_msgs/Twist"};
  if (name == "both") return {"geometry_msgs/TwistStamped", "geometry_msgs/Twist"};
  throw Error("bad-value", "cmd_vel has no type '" + said + "'",
              "write `ros2: {cmd_vel: …}` with TwistStamped, Twist or both");
}

bool has_move_group(const Options& options) {
  const std::string said = option_of(options, "move_group"), name = lower(said);
  if (name.empty() || name == "false" || name == "off" || name == "no") return false;
  if (name == "true" || name == "on" || name == "yes") return true;
  throw Error("bad-value", "move_group is '" + said + "'", "write `ros2: {move_group: true}` or false");
}

messages::Distribution distribution_of(const Options& options) {
  const std::string name = lower(option(options, "distribution", "ROS_DISTRO"));
  if (name == "humble") return messages::Distribution::humble;
  for (const char* newer : {"kilted", "lyrical", "rolling"})
    if (name == newer) return messages::Distribution::kilted;
  // The environment variable is also meant for other programs, so an unknown name is not an error.
  if (name == "jazzy" || !options.contains("distribution")) return messages::Distribution::jazzy;
  throw Error("bad-value", "the distribution '" + name + "' is not known",
              "humble, jazzy, kilted or rolling");
}

}  // namespace polyarm::ros2
