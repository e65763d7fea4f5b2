/// The door to ROS 2: what `ros2:` in a cell and --ros2 open.
#include <algorithm>
#include <array>
#include <cstdlib>

#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/cell/door.hpp"
#include "polyarm/ros2/cell_door.hpp"

namespace polyarm::ros2 {

namespace {

/// Messages that are taken in one tick.
constexpr std::size_t kMost = 32;

std::string environment(const char* name) {
  const char* value = std::getenv(name);
  return value ? value : "";
}

std::string option(const cell::DoorOptions& options, const char* key, const std::string& fallback) {
  const auto at = options.find(key);
  return at == options.end() ? fallback : at->second;
}

ParticipantOptions participant(const cell::DoorOptions& options) {
  ParticipantOptions out;
  const std::string domain = option(options, "domain", environment("ROS_DOMAIN_ID"));
  if (const auto number = parse_number(domain.empty() ? "0" : domain);
      number && *number >= 0 && *number <= 232 && *number == static_cast<int>(*number))
    out.domain = static_cast<std::uint32_t>(*number);
  else
    throw Error("bad-value", "the domain '" + domain + "' is no number from 0 to 232",
                "look at `ros2: {domain: …}` and ROS_DOMAIN_ID");
  const std::string range = lower(option(options, "range", environment("ROS_AUTOMATIC_DISCOVERY_RANGE")));
  if (!range.empty() && range != "localhost" && range != "subnet")
    throw Error("bad-value", "the range '" + range + "' is neither LOCALHOST nor SUBNET",
                "SUBNET lets the robot be reached from other machines");
  out.loopback = range != "subnet";
  for (const std::string& peer :
       split_words(option(options, "peers", environment("ROS_STATIC_PEERS")), ";, "))
    out.peers.push_back(peer);
  if (out.loopback)
    std::erase_if(out.peers, [](const std::string& peer) { return !peer.starts_with("127."); });
  return out;
}

class Ros2Door : public cell::Door {
 public:
  Ros2Door(cell::Cell& cell, const cell::DoorOptions& options)
      : options_{participant(options)}, bridge_{cell, options_, option(options, "namespace", "")} {
    bridge_.look_at_clock();
    parts_ = {make_robot_node(bridge_), make_manager_node(bridge_), make_controller_nodes(bridge_)};
  }

  void serve() override {
    bridge_.look_at_clock();
    for (std::size_t i = 0; i < kMost && one(); ++i) {
    }
    for (const auto& part : parts_) bridge_.guarded([&] { part->serve(); });
  }

  /// False where nothing has come in.
  bool one() {
    bool more = true;
    bridge_.guarded([&] { more = bridge_.wire().take(1) > 0; });
    return more;
  }

  std::string address() const override {
    return "ROS 2: domain " + std::to_string(options_.domain) +
           (options_.loopback ? ", this machine alone" : ", reachable from other machines");
  }

 private:
  ParticipantOptions options_;
  Bridge bridge_;
  std::array<std::unique_ptr<Part>, 3> parts_;
};

std::unique_ptr<cell::Door> make(cell::Cell& cell, const cell::DoorOptions& options) {
  return std::make_unique<Ros2Door>(cell, options);
}

}  // namespace

}  // namespace polyarm::ros2

POLYARM_DOOR(polyarm::ros2::make)
