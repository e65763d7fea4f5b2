#pragma once
/// Shared by the parts of the ROS 2 door. Everything here belongs to the cell thread.
#include <chrono>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/base/time.hpp"
#include "polyarm/inside/view.hpp"
#include "polyarm/protocol/request.hpp"
#include "polyarm/ros2/wire.hpp"

namespace polyarm::ros2 {

using Json = nlohmann::json;

/// Receives replies of the cell: one, or several for requests that report progress.
using OnReply = std::function<void(const protocol::Reply& reply)>;
/// The reason for a refusal, in one sentence.
std::string refusal_of(const protocol::Reply& reply);
/// A service whose request and response are JSON. `reply` may be called later, and must be called once.
using Reply = std::function<void(Json response)>;
using OnCall = std::function<void(Json request, Reply reply)>;

/// Connects the cell and the DDS wire, and converts names and times between them.
class Bridge {
 public:
  Bridge(cell::CellView& cell, const ParticipantOptions& options, messages::Distribution distribution,
         std::string space, std::vector<std::string> twists);

  cell::CellView& cell() { return cell_; }
  Wire& wire() { return wire_; }
  const Wire& wire() const { return wire_; }
  /// "/arm" + "joint_states" → "/arm/joint_states"; a name that begins with / stays as it is.
  std::string name(const std::string& relative) const;
  /// With a single robot, interface names lose the robot's name, as in the robot's own files.
  std::string interface_name(const std::string& name) const;

  /// Sends a request to the cell. `from` keeps the requests of one client in order.
  void ask(protocol::Request request, OnReply on_reply, const void* from = nullptr);

  /// True if controllers may have changed since the last call, because the cell answered a `control.`
  /// request.
  bool take_change() { return std::exchange(changed_, false); }

  /// Runs `work` and catches its exceptions; each is reported once. The cell and the door keep running.
  void guarded(const std::function<void()>& work);

  void service(const std::string& node, const std::string& service, const std::string& type, OnCall call);
  /// A message type in the form of the distribution. Throws Error("unknown-type").
  const messages::TypeInfo& type(const std::string& name) const;

  /// The types of a topic that are offered before it has a publisher: those of `ros2: {cmd_vel: …}`, else the
  /// first.
  std::vector<std::string> at_once(const std::vector<std::string>& types) const;

  void subscribe(const std::string& node, const std::string& topic, const std::string& type,
                 std::function<void(Json message)> on_message, Qos qos = {});

  /// ROS time of a cell time, ns. ROS time is the system clock; in lock-step it is the cell time.
  std::int64_t ros_time(Nanoseconds cell_time) const;
  Json ros_stamp(Nanoseconds cell_time) const;
  /// The inverse.
  Nanoseconds cell_time(std::int64_t ros_time) const { return ros_time - offset_; }
  /// to_ros() converts the stamp in `message["header"]["stamp"]` from cell time to ROS time, to_cell() does
  /// the inverse; 0 stays 0.
  void to_ros(Json& message) const;
  void to_cell(Json& message) const;
  /// Updates the clock offset. Call once each tick, before any message is stamped.
  void check_clock();
  /// True if streams are sent in this tick. In lock-step a cell may run thousands of times faster than its
  /// readers, so at most 1000 ticks per second of wall time send streams. Otherwise every tick does.
  bool tells() const { return reports_; }
  /// The same for a stream that is sent between ticks. `last`: when it was sent last (steady clock); updated
  /// if due.
  bool is_due(std::chrono::steady_clock::time_point& last) const;

 private:
  cell::CellView& cell_;
  Wire wire_;
  bool reports_ = true;
  std::chrono::steady_clock::time_point told_streams_;
  std::string space_;
  std::vector<std::string> twists_;
  bool changed_ = false;
  std::int64_t offset_ = 0;  ///< ROS time − cell time, ns
  /// Observed offsets: the smallest of this window and of the previous one, and of the last few calls.
  std::int64_t least_ = 0, least_before_ = 0, recent_ = 0, window_ends_ = 0;
  int looks_ = 0;
  std::set<std::string> announced_;
};

std::int64_t nanoseconds_of(const Json& stamp);
Json stamp_of(std::int64_t nanoseconds);

/// A part of the door, served once each tick.
class Part {
 public:
  virtual ~Part() = default;
  virtual void serve() = 0;
};

/// Nodes of the controllers: their topics, actions, parameters and life cycles.
std::unique_ptr<Part> make_controller_nodes(Bridge& bridge);
/// The node /controller_manager.
std::unique_ptr<Part> make_manager_node(Bridge& bridge);
/// /robot_state_publisher (descriptions and frames), and /clock.
std::unique_ptr<Part> make_robot_node(Bridge& bridge);
/// /polyarm (stop, hold, resume, program control), and /diagnostics.
std::unique_ptr<Part> make_cell_node(Bridge& bridge);

/// Nodes of plugins: their topics and services (hardware/node_graph.hpp).
std::unique_ptr<Part> make_plugin_nodes(Bridge& bridge);

/// /move_group of each robot, as MoveIt's clients know it.
std::unique_ptr<Part> make_move_groups(Bridge& bridge);

/// Parameters of a node. `list` returns {key: {value, type, text, read_only}}.
struct ParameterSource {
  std::function<void(std::function<void(Json parameters)> got)> list;
  std::function<void(const Json& values, std::function<void(std::string refusal)> done)> set;
};
void offer_parameters(Bridge& bridge, const std::string& node, ParameterSource source);
/// Offers the service that describes message types under the node's name (Jazzy and later).
void offer_type_descriptions(Bridge& bridge, const std::string& node);
/// Offers both of the above, which every node has.
void offer_standard_services(Bridge& bridge, const std::string& node, ParameterSource source);

/// An action server for the action port of a controller.
struct ActionPort {
  std::string node;        ///< "/arm_controller", or a group of its endpoints
  std::string name;        ///< "/arm_controller/follow_joint_trajectory"
  std::string type;        ///< "control_msgs/action/FollowJointTrajectory"
  std::string controller;  ///< the controller that receives the goals
  std::string port;
};
std::unique_ptr<Part> make_action_server(Bridge& bridge, ActionPort port);

}  // namespace polyarm::ros2
