#pragma once
/// What the parts of the ROS 2 door share. Everything here is the cell thread's.
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

/// Takes replies of the cell: called once, or again and again while there are more.
using OnReply = std::function<void(const protocol::Reply& reply)>;
/// Why a request was refused, in a sentence.
std::string refusal_of(const protocol::Reply& reply);
/// A service whose fields come and go as JSON; `reply` may be called later, and once.
using Reply = std::function<void(Json response)>;
using OnCall = std::function<void(Json request, Reply reply)>;

/// The cell, the wire, and how names and times of one become those of the other.
class Bridge {
 public:
  Bridge(cell::CellView& cell, const ParticipantOptions& options, messages::Distribution distribution,
         std::string space, std::vector<std::string> twists);

  cell::CellView& cell() { return cell_; }
  Wire& wire() { return wire_; }
  const Wire& wire() const { return wire_; }
  /// "/arm" + "joint_states" → "/arm/joint_states"; what begins with / stays.
  std::string name(const std::string& relative) const;
  /// Interfaces of the only robot are called without its name, as its own files have them.
  std::string interface_name(const std::string& name) const;

  /// Asks the cell as every door does; `from` keeps requests of one asker in order.
  void ask(protocol::Request request, OnReply on_reply, const void* from = nullptr);

  /// Whether controllers may have changed since this was asked last: somebody has been answered who asked for
  /// it here.
  bool take_change() { return std::exchange(changed_, false); }

  /// What fails here ends neither the cell nor the door: a person is told once.
  void guarded(const std::function<void()>& work);

  void service(const std::string& node, const std::string& service, const std::string& type, OnCall call);
  /// A type that there is, in the form of the distribution. Throws Error("unknown-type").
  const messages::TypeInfo& type(const std::string& name) const;

  /// Of the types of one topic those that are offered before anybody publishes it: the first, or what
  /// `ros2: {cmd_vel: …}` says.
  std::vector<std::string> at_once(const std::vector<std::string>& types) const;

  void subscribe(const std::string& node, const std::string& topic, const std::string& type,
                 std::function<void(Json message)> on_message, Qos qos = {});

  /// Nanoseconds that a clock of ROS 2 shows at this cell time: the system's clock, or the cell's in
  /// lock-step.
  std::int64_t ros_time(Nanoseconds cell_time) const;
  Json ros_stamp(Nanoseconds cell_time) const;
  /// The other way round.
  Nanoseconds cell_time(std::int64_t ros_time) const { return ros_time - offset_; }
  /// A stamp of ROS in place of one of cell time, in `message["header"]["stamp"]`, and the other way round;
  /// 0 stays 0.
  void to_ros(Json& message) const;
  void to_cell(Json& message) const;
  /// Once each tick, before anything is stamped.
  void look_at_clock();
  /// Whether streams are told in this tick, all of them or none: in lock-step, where a cell may run thousands
  /// of times as fast as its readers, in 1,000 ticks of a second of the machine; on the wall clock in every
  /// one.
  bool tells() const { return tells_; }
  /// The same for one that is told between ticks, the last time at `last` by the machine's clock; then sets
  /// it.
  bool is_due(std::chrono::steady_clock::time_point& last) const;

 private:
  cell::CellView& cell_;
  Wire wire_;
  bool tells_ = true;
  std::chrono::steady_clock::time_point told_streams_;
  std::string space_;
  std::vector<std::string> twists_;
  bool changed_ = false;
  std::int64_t offset_ = 0;  ///< ros time − cell time
  /// What was seen of it: the least in this window and the one before, and in the latest few looks.
  std::int64_t least_ = 0, least_before_ = 0, recent_ = 0, window_ends_ = 0;
  int looks_ = 0;
  std::set<std::string> told_;
};

std::int64_t nanoseconds_of(const Json& stamp);
Json stamp_of(std::int64_t nanoseconds);

/// A part of the door: served once each tick.
class Part {
 public:
  virtual ~Part() = default;
  virtual void serve() = 0;
};

/// Topics that controllers put out and take, their actions, and their nodes' parameters and life cycle.
std::unique_ptr<Part> make_controller_nodes(Bridge& bridge);
/// /controller_manager.
std::unique_ptr<Part> make_manager_node(Bridge& bridge);
/// /robot_state_publisher: descriptions and frames; /clock.
std::unique_ptr<Part> make_robot_node(Bridge& bridge);
/// /polyarm: stop, hold, resume, the program; /diagnostics.
std::unique_ptr<Part> make_cell_node(Bridge& bridge);

/// `list` gives {key: {value, type, text, read_only}}.
struct ParameterSource {
  std::function<void(std::function<void(Json parameters)> got)> list;
  std::function<void(const Json& values, std::function<void(std::string refusal)> done)> set;
};
void offer_parameters(Bridge& bridge, const std::string& node, ParameterSource source);
/// Under a node's name, of Jazzy and later: what its types look like.
void offer_type_descriptions(Bridge& bridge, const std::string& node);
/// What every node has: both of the above.
void offer_standard_services(Bridge& bridge, const std::string& node, ParameterSource source);

/// An action server of a controller's port.
struct ActionPort {
  std::string node;        ///< "/arm_controller", or a group of it
  std::string name;        ///< "/arm_controller/follow_joint_trajectory"
  std::string type;        ///< "control_msgs/action/FollowJointTrajectory"
  std::string controller;  ///< where goals go
  std::string port;
};
std::unique_ptr<Part> make_action_server(Bridge& bridge, ActionPort port);

}  // namespace polyarm::ros2
