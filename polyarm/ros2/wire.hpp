#pragma once
/// Topics and services as ROS 2 names them, and the graph that tells its tools which node has which.
///
/// DDS itself is spoken by a process of its own (RemoteParticipant); what it has under way is lost with it,
/// and nodes, topics and services are there again as soon as it is.
///
/// What comes in waits until `take` is called: callbacks run on that thread alone. What goes out is written
/// by a thread of this class, except a reply whose reader is there already: that is handed over at once. Any
/// other reply waits up to ten seconds until its reader is matched.
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
  std::uint64_t refused = 0;   ///< of these: too large, too short for their header, or no message of the type
  std::uint64_t dropped = 0;   ///< of these: came faster than they were taken
  std::uint64_t sent = 0, unsent = 0;
};

class Wire {
 public:
  using Id = std::size_t;
  /// False where the payload is no message of the type.
  using OnMessage = std::function<bool(std::span<const std::byte> payload)>;
  /// A request, and how it is answered later: once, from the thread that calls take().
  struct Request {
    std::vector<std::byte> payload;
    std::function<void(std::vector<std::byte> reply)> answer;
  };
  /// False as above; then nobody is answered.
  using OnRequest = std::function<bool(Request request)>;

  /// What types and the graph look like is of the distribution.
  explicit Wire(const ParticipantOptions& options,
                messages::Distribution distribution = messages::Distribution::jazzy);
  ~Wire();

  /// `node`: whole name ("/controller_manager"), or a group of its endpoints ("/arm_controller@ports"), which
  /// can be ended by itself and which the graph does not tell apart; `topic`: whole name ("/joint_states").
  /// Of a service `type` is its name without the part ("std_srvs/srv/Trigger"). Throw Error("no-dds") and
  /// Error("unknown-type").
  Id publisher(const std::string& node, const std::string& topic, const messages::TypeInfo& type,
               const Qos& qos = {});
  /// Not told of what this wire itself publishes.
  Id subscription(const std::string& node, const std::string& topic, const messages::TypeInfo& type,
                  const Qos& qos, OnMessage on_message);
  Id service(const std::string& node, const std::string& name, const std::string& type, OnRequest on_request);
  /// Asks a service of others, whatever their middleware; `on_reply` is told of the answer to the latest
  /// call.
  Id client(const std::string& node, const std::string& name, const std::string& type, OnMessage on_reply);
  /// Is there a service to ask? Of Cyclone and others, once it has had time to know of this client.
  bool ready(Id client) const;
  /// From the thread that calls take(). False where there is none to ask.
  bool call(Id client, std::vector<std::byte> request);

  /// In the form of the distribution; null where there is none.
  const messages::TypeInfo* find_type(const std::string& name) const;
  /// Ends the node, or a group of it, with all it has.
  void remove_node(const std::string& name);

  /// Any thread that also calls take().
  void publish(Id publisher, std::vector<std::byte> payload);
  /// Does anybody listen to it?
  bool wanted(Id publisher) const;
  /// Does anybody else publish this type on the topic ("/cmd_vel"), whether this wire hears it or not?
  bool offered(const std::string& topic, const messages::TypeInfo& type) const;
  /// Runs the callbacks of at most `most` messages that have come in, and tells the graph what has changed.
  std::size_t take(std::size_t most);
  /// Until something waits to be taken, at most so long.
  void wait(std::chrono::nanoseconds patience) const;

  /// Rung when something has come in; null: none is.
  void set_bell(const std::shared_ptr<realtime::Bell>& bell);

  WireStatistics statistics() const;
  /// What others that use the wire must be told of: see RemoteNews.
  std::vector<RemoteNews> take_news();
  const RemoteParticipant& participant() const;
  messages::Distribution distribution() const;

 private:
  class Work;
  std::unique_ptr<Work> work_;
};

}  // namespace polyarm::ros2
