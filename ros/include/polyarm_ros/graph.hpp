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

/// A port for a topic or service of this type; null if there is no graph, or if the type has no definition.
/// `name` is as the node's code writes it, `full` with namespace and node.
template <typename Type, typename Qos>
Port open_port(PortKind kind, const std::string& node, const std::string& name, const std::string& full,
               const Qos& qos) {
  if constexpr (HasFields<Type>::value) {
    if (!polyarm_node_graph_1) return nullptr;
    polyarm::hardware::PortFacts facts;
    facts.kind = kind;
    facts.node = node;
    facts.name = full;
    facts.absolute = !name.empty() && name[0] == '/';
    facts.type = Type::polyarm_type();
    facts.reliable = qos.polyarm_reliable();
    facts.transient_local = qos.polyarm_transient_local();
    facts.depth = qos.depth();
    Port port = polyarm_node_graph_1()->open(std::move(facts));
    if (!port)
      log_format(Severity::warn, node.c_str(), "too many topics and services: '%s' is not on the ROS 2 graph",
                 full.c_str());
    return port;
  } else {
    return nullptr;
  }
}

/// Hands a message to the graph, if somebody there wants it. In a cycle it never waits, and allocates nothing
/// once the port has had a message of this size in each place of its queue.
template <typename Message>
void send_on(polyarm::hardware::NodePort& port, const Message& message) {
  if constexpr (HasFields<Message>::value) {
    if (port.peers.load(std::memory_order_relaxed) == 0 && !port.facts.transient_local) return;
    port.to_graph.put(0, !in_cycle(), [&](Payload& out) { encode(message, out); });
  }
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

}  // namespace polyarm_ros
