#pragma once
/// ROS 2 topics and services over DDS, and the graph information for ROS 2 tools.
///
/// DDS runs in a separate process (RemoteParticipant). If it ends, messages in transit are lost; nodes,
/// topics and services are back as soon as it is restarted.
///
/// Received messages wait until `take` is called, and callbacks run on that thread only. A thread of this
/// class writes outgoing messages, except a reply whose reader is already matched: that is written at once.
/// Any other reply waits up to ten seconds for its reader.
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "polyarm/messages/type_info.hpp"
#include "polyarm/realtime/bell.hpp"
#include "polyarm/ros2/remote_participant.hpp"

namespace polyarm::ros2 {

struct WireStatistics {
  std::uint64_t received = 0;  ///< samples of all topics, requests and replies
  std::uint64_t refused = 0;   ///< of these: too large, too short for their header, or not of the type
  std::uint64_t dropped = 0;   ///< of these: came faster than they were taken
  std::uint64_t sent = 0, unsent = 0;
};

class Wire {
 public:
  using Id = std::size_t;
  /// Returns false if the payload is not a message of the type.
  using OnMessage = std::function<bool(std::span<const std::byte> payload)>;
  /// A request, and the function that answers it: call it once, from the thread that calls take(). It may be
  /// later.
  struct Request {
    std::vector<std::byte> payload;
    std::function<void(std::vector<std::byte> reply)> answer;
  };
  /// Returns false as above; then no reply is sent.
  using OnRequest = std::function<bool(Request request)>;

  /// The distribution decides the form of types and graph.
  explicit Wire(const ParticipantOptions& options,
                messages::Distribution distribution = messages::Distribution::jazzy);
  ~Wire();

  /// `node`: full name ("/controller_manager"), or a group of its endpoints ("/arm_controller@ports") that
  /// can be removed separately; the graph shows a group as its node. `topic`: full name ("/joint_states").
  /// For a service, `type` is its name without request or response ("std_srvs/srv/Trigger"). Throw
  /// Error("no-dds") and Error("unknown-type").
  Id publisher(const std::string& node, const std::string& topic, const messages::TypeInfo& type,
               const Qos& qos = {});
  /// Does not receive what this wire itself publishes.
  Id subscription(const std::string& node, const std::string& topic, const messages::TypeInfo& type,
                  const Qos& qos, OnMessage on_message);
  Id service(const std::string& node, const std::string& name, const std::string& type, OnRequest on_request);
  /// The same for a type that only its owner knows.
  Id service(const std::string& node, const std::string& name, const messages::TypeInfo& request,
             const messages::TypeInfo& response, OnRequest on_request);
  /// A client for services of other nodes, whatever their middleware. `on_reply` receives the reply to the
  /// latest call only.
  Id client(const std::string& node, const std::string& name, const std::string& type, OnMessage on_reply);
  /// The same for a type that only its owner knows.
  Id client(const std::string& node, const std::string& name, const messages::TypeInfo& request,
            const messages::TypeInfo& response, OnMessage on_reply);
  /// True if there is a server to call. A server of Cyclone or others counts only after it had time to
  /// discover this client.
  bool ready(Id client) const;
  /// Call it from the thread that calls take(). Returns false if there is no server.
  bool call(Id client, std::vector<std::byte> request);

  /// The type in the form of the distribution; null if unknown.
  const messages::TypeInfo* find_type(const std::string& name) const;
  /// Removes the node, or a group of it, with all its endpoints.
  void remove_node(const std::string& name);

  /// Any thread that also calls take().
  void publish(Id publisher, std::vector<std::byte> payload);
  /// True if there is a subscriber.
  bool wanted(Id publisher) const;
  /// True if another participant publishes this type on the topic ("/cmd_vel"), whether or not this wire
  /// subscribes to it.
  bool offered(const std::string& topic, const messages::TypeInfo& type) const;
  /// Runs the callbacks of at most `most` waiting messages, and publishes changes of the graph. Returns their
  /// count.
  std::size_t take(std::size_t most);
  /// Waits until a message can be taken, at most for `patience`.
  void wait(std::chrono::nanoseconds patience) const;

  /// Rung when a message has come in; null: none.
  void set_wakeup(const std::shared_ptr<realtime::Bell>& bell);

  WireStatistics statistics() const;
  /// Reports for the user: see RemoteReport.
  std::vector<RemoteReport> take_reports();
  const RemoteParticipant& participant() const;
  messages::Distribution distribution() const;

 private:
  class Work;
  std::unique_ptr<Work> work_;
};

}  // namespace polyarm::ros2
