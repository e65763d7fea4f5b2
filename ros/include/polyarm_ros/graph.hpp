#pragma once
/// Topics and services of a module on the ROS 2 graph. A port carries payloads between a node and the
/// command's door (polyarm/hardware/node_graph.hpp). Without a graph in the program there are no ports.
#include <memory>
#include <string>
#include <utility>

#include "polyarm/hardware/node_graph.hpp"
#include "polyarm_ros/cdr.hpp"
#include "polyarm_ros/log.hpp"

namespace polyarm_ros {

using Port = std::shared_ptr<polyarm::hardware::NodePort>;
using polyarm::hardware::PortKind;

/// The messages that wait at most in a queue with this quality of service.
template <typename Qos>
std::size_t depth_of(const Qos& qos) {
  const std::size_t asked = qos.polyarm_depth();
  return asked > 0 ? asked : polyarm::hardware::LetterQueue::kMost;
}

/// A port for a topic or service of the type `type`; null if there is no graph. `name` is as the node's code
/// writes it, `full` with namespace and node.
template <typename Qos>
Port open_port_of(const std::string& type, PortKind kind, const std::string& node, const std::string& name,
                  const std::string& full, const Qos& qos) {
  if (!polyarm_node_graph_1) return nullptr;
  polyarm::hardware::PortFacts facts;
  facts.kind = kind;
  facts.node = node;
  facts.name = full;
  facts.absolute = !name.empty() && name[0] == '/';
  facts.type = type;
  facts.reliable = qos.polyarm_reliable();
  facts.transient_local = qos.polyarm_transient_local();
  facts.depth = depth_of(qos);
  Port port = polyarm_node_graph_1()->open(std::move(facts));
  if (!port)
    log_format(Severity::warn, node.c_str(), "too many topics and services: '%s' is not on the ROS 2 graph",
               full.c_str());
  return port;
}
/// The same for a C++ type; null, too, if it has no definition.
template <typename Type, typename Qos>
Port open_port(PortKind kind, const std::string& node, const std::string& name, const std::string& full,
               const Qos& qos) {
  if constexpr (HasFields<Type>::value)
    return open_port_of(Type::polyarm_type(), kind, node, name, full, qos);
  else
    return nullptr;
}

/// Hands a message to the graph, if somebody there wants it. In a cycle it never waits, and allocates nothing
/// once the port has had a message of this size in each place of its queue.
template <typename Fill>
void fill_on(polyarm::hardware::NodePort& port, Fill&& fill) {
  if (port.peers.load(std::memory_order_relaxed) == 0 && !port.facts.transient_local) return;
  port.to_graph.put(0, !in_cycle(), fill);
}
template <typename Message>
void send_on(polyarm::hardware::NodePort& port, const Message& message) {
  if constexpr (HasFields<Message>::value) fill_on(port, [&](Payload& out) { encode(message, out); });
}

/// The next message from the graph; null if no message waits. Payloads that cannot be decoded are dropped.
template <typename Message>
std::shared_ptr<const void> take_from(polyarm::hardware::NodePort& port) {
  if constexpr (HasFields<Message>::value) {
    polyarm::hardware::Letter letter;
    while (port.from_graph.take(letter)) {
      auto message = std::make_shared<Message>();
      if (decode(letter.payload, *message)) return message;
    }
  }
  return nullptr;
}

inline std::shared_ptr<const void> take_bytes_from(polyarm::hardware::NodePort& port) {
  polyarm::hardware::Letter letter;
  if (!port.from_graph.take(letter)) return nullptr;
  return std::make_shared<const Payload>(std::move(letter.payload));
}

}  // namespace polyarm_ros
