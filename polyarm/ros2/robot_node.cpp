/// /robot_state_publisher: descriptions and frames; and /clock.
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "polyarm/base/text.hpp"
#include "polyarm/description/plain_urdf.hpp"
#include "polyarm/messages/json.hpp"
#include "polyarm/messages/types.hpp"
#include "polyarm/ros2/cell_door.hpp"

namespace polyarm::ros2 {

namespace {

namespace msg = messages::geometry_msgs::msg;
constexpr Nanoseconds kFrames = 20'000'000;

msg::Transform to_message(const Pose& pose) {
  return {{pose.position.x, pose.position.y, pose.position.z},
          {pose.rotation.x, pose.rotation.y, pose.rotation.z, pose.rotation.w}};
}

/// The frames of one robot: a link's name is its frame's, with the robot's name before it where there are
/// several.
class Frames {
 public:
  Frames(cell::Cell& cell, std::size_t robot)
      : robot_{*cell.robots()[robot]}, several_{cell.robots().size() > 1} {
    const auto& table = cell.loop().table();
    for (const description::Joint& joint : robot_.model.joints) {
      const description::Joint& followed =
          joint.mimic ? robot_.model.joints[static_cast<std::size_t>(joint.mimic->joint)] : joint;
      const auto state = table.find_state(robot_.entry.name + "/" + followed.name + "/position");
      states_.push_back(state ? static_cast<int>(*state) : -1);
    }
  }

  std::vector<msg::TransformStamped> fixed() const {
    std::vector<msg::TransformStamped> out;
    const std::string root = robot_.model.links[static_cast<std::size_t>(robot_.model.root)].name;
    if (root != "world" || several_) out.push_back(transform("world", frame(root), robot_.entry.base));
    for (const description::Joint& joint : robot_.model.joints)
      if (!joint.moves()) out.push_back(of_joint(joint, joint.origin));
    return out;
  }

  void add_moving(const std::vector<double>& states, std::vector<msg::TransformStamped>& out) const {
    for (std::size_t i = 0; i < states_.size(); ++i) {
      const description::Joint& joint = robot_.model.joints[i];
      if (!joint.moves()) continue;
      const auto at = static_cast<std::size_t>(states_[i]);
      double q = states_[i] >= 0 && at < states.size() && std::isfinite(states[at]) ? states[at] : 0;
      if (joint.mimic) q = joint.mimic->multiplier * q + joint.mimic->offset;
      out.push_back(of_joint(joint, joint.origin * moved(joint, q)));
    }
  }

 private:
  static Pose moved(const description::Joint& joint, double q) {
    if (joint.type == description::JointType::prismatic) return {q * joint.axis, {}};
    const double half = 0.5 * q, s = std::sin(half);
    return {{}, {joint.axis.x * s, joint.axis.y * s, joint.axis.z * s, std::cos(half)}};
  }
  std::string frame(const std::string& link) const {
    return several_ ? robot_.entry.name + "/" + link : link;
  }
  msg::TransformStamped of_joint(const description::Joint& joint, const Pose& pose) const {
    const auto& links = robot_.model.links;
    return transform(frame(links[static_cast<std::size_t>(joint.parent_link)].name),
                     frame(links[static_cast<std::size_t>(joint.child_link)].name), pose);
  }
  static msg::TransformStamped transform(const std::string& parent, const std::string& child,
                                         const Pose& pose) {
    msg::TransformStamped out;
    out.header.frame_id = parent;
    out.child_frame_id = child;
    out.transform = to_message(pose);
    return out;
  }

  const cell::CellRobot& robot_;
  bool several_;
  std::vector<int> states_;  ///< by joint: the state whose value it has, -1: none
};

class RobotNode : public Part {
 public:
  explicit RobotNode(Bridge& bridge) : bridge_{bridge}, node_{bridge.name("robot_state_publisher")} {
    for (std::size_t i = 0; i < bridge.cell().robots().size(); ++i) frames_.emplace_back(bridge.cell(), i);
    tell_descriptions();
    const Qos often{true, false, 100}, latched{true, true, 1};
    const auto& transforms = messages::type_info<messages::tf2_msgs::msg::TFMessage>();
    moving_ = bridge.wire().publisher(node_, bridge.name("tf"), transforms, often);
    const auto fixed = bridge.wire().publisher(node_, bridge.name("tf_static"), transforms, latched);
    messages::tf2_msgs::msg::TFMessage all;
    for (const Frames& frames : frames_)
      for (msg::TransformStamped& one : frames.fixed()) all.transforms.push_back(std::move(one));
    bridge.wire().publish(fixed, messages::to_cdr(all));
    if (bridge.cell().lock_step())
      clock_ = bridge.wire().publisher(node_, "/clock",
                                       messages::type_info<messages::rosgraph_msgs::msg::Clock>());
    offer_standard_services(bridge, node_, parameters());
  }

  void serve() override {
    const Nanoseconds now = bridge_.cell().now();
    if (clock_) {
      const std::int64_t time = bridge_.ros_time(now);
      bridge_.wire().publish(*clock_, messages::to_cdr(messages::rosgraph_msgs::msg::Clock{stamp(time)}));
    }
    if (told_frames_ < 0 || now - told_frames_ >= kFrames) tell_frames(now);
  }

 private:
  static messages::builtin_interfaces::msg::Time stamp(std::int64_t time) {
    return {static_cast<std::int32_t>(time / 1'000'000'000),
            static_cast<std::uint32_t>(time % 1'000'000'000)};
  }

  /// /robot_description, or one under each robot's name.
  void tell_descriptions() {
    const auto& robots = bridge_.cell().robots();
    for (const auto& robot : robots) {
      const std::string topic = robots.size() == 1 ? bridge_.name("robot_description")
                                                   : bridge_.name(robot->entry.name + "/robot_description");
      const auto publisher = bridge_.wire().publisher(
          node_, topic, messages::type_info<messages::std_msgs::msg::String>(), {true, true, 1});
      bridge_.wire().publish(
          publisher,
          messages::to_cdr(messages::std_msgs::msg::String{description::write_plain_urdf(robot->model)}));
    }
  }

  void tell_frames(Nanoseconds now) {
    told_frames_ = now;
    if (!bridge_.wire().wanted(moving_)) return;
    messages::tf2_msgs::msg::TFMessage all;
    const control::Snapshot& snapshot = bridge_.cell().snapshot();
    for (const Frames& frames : frames_) frames.add_moving(snapshot.states, all.transforms);
    for (msg::TransformStamped& one : all.transforms)
      one.header.stamp = stamp(bridge_.ros_time(snapshot.cycle.time));
    bridge_.wire().publish(moving_, messages::to_cdr(all));
  }

  ParameterSource parameters() {
    ParameterSource out;
    out.list = [this](std::function<void(Json)> got) {
      Json all = Json::object();
      for (const auto& robot : bridge_.cell().robots()) {
        const std::string key =
            (bridge_.cell().robots().size() == 1 ? "" : robot->entry.name + ".") + "robot_description";
        all[key] = {{"value", description::write_plain_urdf(robot->model)}, {"text", "URDF"}, {"read_only", true}};
      }
      got(std::move(all));
    };
    out.set = [](const Json&, std::function<void(std::string)> done) {
      done("it is read when the cell is built");
    };
    return out;
  }

  Bridge& bridge_;
  std::string node_;
  std::vector<Frames> frames_;
  Wire::Id moving_ = 0;
  std::optional<Wire::Id> clock_;
  Nanoseconds told_frames_ = -1;
};

}  // namespace

std::unique_ptr<Part> make_robot_node(Bridge& bridge) {
  return std::make_unique<RobotNode>(bridge);
}

}  // namespace polyarm::ros2
