#pragma once
/// Topics and services as ROS 2 names them, and the graph that tells its tools which node has which.
///
/// What comes in waits until `take` is called: callbacks run on that thread alone. What goes out is written
/// by a thread of this class; a reply waits up to 100 ms until its reader is matched, as the middlewares of
/// ROS 2 do.
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "polyarm/messages/type_info.hpp"
#include "polyarm/ros2/participant.hpp"

namespace polyarm::ros2 {

struct WireStatistics {
  std::uint64_t received = 0, refused = 0;  ///< refused: no payload of the type, or too short for its header
  std::uint64_t dropped = 0;                ///< came faster than they were taken
  std::uint64_t sent = 0, unsent = 0;
};

class Wire {
 public:
  using Id = std::size_t;
  using OnMessage = std::function<void(std::span<const std::byte> payload)>;
  /// A request, and how it is answered later: once, from the thread that calls take().
  struct Request {
    std::vector<std::byte> payload;
    std::function<void(std::vector<std::byte> reply)> answer;
  };
  using OnRequest = std::function<void(Request request)>;

  explicit Wire(const ParticipantOptions& options);
  ~Wire();

  /// `node`: whole name ("/controller_manager"); `topic`: whole name ("/joint_states"). Of a service `type`
  /// is its name without the part ("std_srvs/srv/Trigger"). Throw Error("no-dds") and Error("unknown-type").
  Id publisher(const std::string& node, const std::string& topic, const messages::TypeInfo& type,
               const Qos& qos = {});
  Id subscription(const std::string& node, const std::string& topic, const messages::TypeInfo& type,
                  const Qos& qos, OnMessage on_message);
  Id service(const std::string& node, const std::string& name, const std::string& type, OnRequest on_request);
  /// A node without endpoints yet.
  void node(const std::string& name);
  /// Ends the node with all it has.
  void remove_node(const std::string& name);

  /// Any thread that also calls take().
  void publish(Id publisher, std::vector<std::byte> payload);
  /// Does anybody listen to it?
  bool wanted(Id publisher) const;
  /// Runs the callbacks of at most `most` messages that have come in, and tells the graph what has changed.
  std::size_t take(std::size_t most);

  WireStatistics statistics() const;
  const Participant& participant() const;

 private:
  class Work;
  std::unique_ptr<Work> work_;
};

}  // namespace polyarm::ros2
