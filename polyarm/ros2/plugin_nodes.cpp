/// Nodes of plugins on the graph. Payloads pass as they are: the plugin knows its types. What one port has to
/// send is taken a few payloads at a time, so that a fast publisher delays nothing else.
#include <algorithm>
#include <cctype>
#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/hardware/node_graph.hpp"
#include "polyarm/ros2/cell_door.hpp"

namespace polyarm::ros2 {

namespace {

using hardware::Letter;
using hardware::NodePort;
using hardware::PortFacts;
using hardware::PortKind;

/// How often the ports and their peers are looked at.
constexpr auto kLook = std::chrono::milliseconds(50);
/// Payloads of one port in a tick; open requests of one service; length of a name.
constexpr int kMostInATick = 32;
constexpr std::size_t kMostRequests = 64, kLongestName = 200;
/// How long a client waits for the reply to one call before its next one goes out; and how long calls wait
/// for a server.
constexpr auto kLongestCall = std::chrono::seconds(10);

/// "std_msgs/msg/String" as "std_msgs::msg::dds_::String_".
std::string dds_name_of(const std::string& type) {
  const std::size_t last = type.rfind('/');
  std::string out;
  for (const char c : type.substr(0, last + 1)) out += c == '/' ? std::string("::") : std::string(1, c);
  return out + "dds_::" + type.substr(last + 1) + "_";
}

bool is_ros_name(const std::string& name) {
  return name.size() > 1 && name.size() <= kLongestName && name[0] == '/' && name.back() != '/' &&
         name.find("//") == std::string::npos && std::all_of(name.begin(), name.end(), [](unsigned char c) {
           return std::isalnum(c) || c == '_' || c == '/';
         });
}

std::vector<std::byte> bytes_of(const std::vector<std::uint8_t>& payload) {
  std::vector<std::byte> out(payload.size());
  std::transform(payload.begin(), payload.end(), out.begin(), [](std::uint8_t b) { return std::byte{b}; });
  return out;
}
auto copy_of(std::span<const std::byte> payload) {
  return [payload](std::vector<std::uint8_t>& out) {
    for (const std::byte b : payload) out.push_back(std::to_integer<std::uint8_t>(b));
  };
}

/// Types that only plugins know have no hash and no fields here. The texts of a TypeInfo must stay where they
/// are.
class Types {
 public:
  explicit Types(Bridge& bridge) : bridge_{bridge} {}
  const messages::TypeInfo& type(const std::string& name) {
    if (const messages::TypeInfo* known = bridge_.wire().find_type(name)) return *known;
    auto& own = own_[name];
    if (!own) {
      own = std::make_unique<Own>();
      own->name = name, own->dds_name = dds_name_of(name);
      own->info = {own->name.c_str(), own->dds_name.c_str(), "", "", {}};
    }
    return own->info;
  }

 private:
  struct Own {
    std::string name, dds_name;
    messages::TypeInfo info{};
  };
  Bridge& bridge_;
  std::map<std::string, std::unique_ptr<Own>> own_;
};

/// One port on the wire. Its endpoints are a group of their own, which ends with it.
class OpenPort {
 public:
  OpenPort(Bridge& bridge, Types& types, const std::shared_ptr<NodePort>& port, std::size_t number)
      : bridge_{bridge}, port_{port}, kind_{port->facts.kind} {
    const PortFacts& facts = port->facts;
    const std::string node = bridge.name(facts.node.substr(1));
    const std::string name = facts.absolute ? facts.name : bridge.name(facts.name.substr(1));
    if (!is_ros_name(node) || !is_ros_name(name))
      throw Error("bad-name", "a plugin names '" + facts.name + "' of its node '" + facts.node +
                                  "', which is no name of ROS 2: it is not on the graph");
    group_ = node + "@plugin" + std::to_string(number);
    const Qos qos{facts.reliable, facts.transient_local, facts.depth};
    if (facts.kind == PortKind::publisher)
      id_ = bridge.wire().publisher(group_, name, types.type(facts.type), qos);
    else if (facts.kind == PortKind::subscription)
      bridge.wire().subscription(group_, name, types.type(facts.type), qos,
                                 [port = port_](std::span<const std::byte> payload) {
                                   const auto open = port.lock();
                                   return !open || open->from_graph.put(0, true, copy_of(payload));
                                 });
    else if (facts.kind == PortKind::client)
      id_ = bridge.wire().client(group_, name, types.type(facts.type + "_Request"),
                                 types.type(facts.type + "_Response"),
                                 [this](std::span<const std::byte> reply) { return take_reply(reply); });
    else
      bridge.wire().service(group_, name, types.type(facts.type + "_Request"),
                            types.type(facts.type + "_Response"),
                            [this](Wire::Request request) { return take(std::move(request)); });
  }
  ~OpenPort() {
    if (const auto port = port_.lock()) port->peers = 0;
    bridge_.wire().remove_node(group_);
  }
  OpenPort(const OpenPort&) = delete;
  OpenPort& operator=(const OpenPort&) = delete;

  bool is(const std::shared_ptr<NodePort>& port) const { return port_.lock() == port; }
  bool ended() const { return port_.expired(); }
  void look() {
    const auto port = port_.lock();
    if (port && kind_ == PortKind::publisher) port->peers = bridge_.wire().wanted(id_) ? 1 : 0;
    if (port && kind_ == PortKind::client) port->peers = bridge_.wire().ready(id_) ? 1 : 0;
  }
  void serve() {
    const auto port = port_.lock();
    if (kind_ == PortKind::client) {
      if (port) call_next(*port);
      return;
    }
    for (int i = 0; port && i < kMostInATick && port->to_graph.take(letter_); ++i) {
      if (kind_ == PortKind::publisher) {
        bridge_.wire().publish(id_, bytes_of(letter_.payload));
      } else if (const auto asked = asked_.find(letter_.number); asked != asked_.end()) {
        asked->second(bytes_of(letter_.payload));
        asked_.erase(asked);
      }
    }
  }

 private:
  /// One call after the other: the wire knows the reply to the latest one only. A server that comes late gets
  /// no old calls.
  void call_next(NodePort& port) {
    const auto now = std::chrono::steady_clock::now();
    if (bridge_.wire().ready(id_))
      served_ = now;
    else if (now - served_ < kLongestCall)
      return;
    else
      return drop_calls(port);
    if (calling_ != 0 && now - called_ < kLongestCall) return;
    if (!port.to_graph.take(letter_)) return;
    calling_ = 0;
    if (bridge_.wire().call(id_, bytes_of(letter_.payload))) calling_ = letter_.number, called_ = now;
  }
  void drop_calls(NodePort& port) {
    // No more than the queue holds: the plugin goes on sending.
    for (std::size_t n = 0; n < hardware::LetterQueue::kMost && port.to_graph.take(letter_); ++n) {
    }
  }
  bool take_reply(std::span<const std::byte> reply) {
    const auto port = port_.lock();
    const std::uint64_t number = std::exchange(calling_, 0);
    return !port || number == 0 || port->from_graph.put(number, true, copy_of(reply));
  }
  bool take(Wire::Request request) {
    const auto port = port_.lock();
    if (!port) return true;
    if (asked_.size() >= kMostRequests)
      asked_.erase(asked_.begin());  // the plugin has not answered the oldest
    asked_[++requests_] = std::move(request.answer);
    return port->from_graph.put(requests_, true, copy_of(request.payload));
  }

  Bridge& bridge_;
  const std::weak_ptr<NodePort> port_;
  const PortKind kind_;
  std::string group_;
  Wire::Id id_ = 0;
  Letter letter_;
  std::uint64_t requests_ = 0;
  std::uint64_t calling_ = 0;  ///< of a client: number of the call that waits for its reply; 0 if none does
  std::chrono::steady_clock::time_point called_;
  std::chrono::steady_clock::time_point served_ = std::chrono::steady_clock::now();  ///< there was a server
  std::map<std::uint64_t, std::function<void(std::vector<std::byte>)>> asked_;
};

class PluginNodes : public Part {
 public:
  explicit PluginNodes(Bridge& bridge) : bridge_{bridge}, types_{bridge} {}

  void serve() override {
    const auto now = std::chrono::steady_clock::now();
    if (now - looked_ >= kLook) {
      looked_ = now;
      look();
    }
    for (const auto& each : open_) bridge_.guarded([&] { each->serve(); });
  }

 private:
  void look() {
    std::erase_if(open_, [](const auto& each) { return each->ended(); });
    std::erase_if(refused_, [](const auto& each) { return each.expired(); });
    for (const std::shared_ptr<NodePort>& port : hardware::node_graph().ports())
      if (!is_known(port)) open(port);
    for (const auto& each : open_) each->look();
  }
  bool is_known(const std::shared_ptr<NodePort>& port) const {
    return std::any_of(open_.begin(), open_.end(), [&](const auto& each) { return each->is(port); }) ||
           std::any_of(refused_.begin(), refused_.end(),
                       [&](const auto& each) { return each.lock() == port; });
  }
  void open(const std::shared_ptr<NodePort>& port) {
    try {
      open_.push_back(std::make_unique<OpenPort>(bridge_, types_, port, ++opened_));
    } catch (const Error& e) {
      refused_.push_back(port);
      bridge_.cell().tell(std::string("ROS 2: ") + e.what());
    }
  }

  Bridge& bridge_;
  Types types_;
  std::vector<std::unique_ptr<OpenPort>> open_;
  std::vector<std::weak_ptr<NodePort>> refused_;
  std::chrono::steady_clock::time_point looked_;
  std::size_t opened_ = 0;
};

}  // namespace

std::unique_ptr<Part> make_plugin_nodes(Bridge& bridge) {
  return std::make_unique<PluginNodes>(bridge);
}

}  // namespace polyarm::ros2
