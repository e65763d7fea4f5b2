/// The node /robot_state_publisher (descriptions and frames), and /clock.
#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/base/text.hpp"
#include "polyarm/description/plain_urdf.hpp"
#include "polyarm/messages/json.hpp"
#include "polyarm/messages/types.hpp"
#include "polyarm/recording/state_messages.hpp"
#include "polyarm/ros2/cell_door.hpp"

namespace polyarm::ros2 {

namespace {

constexpr Nanoseconds kFrames = 20'000'000;

/// By robot: true if its root link has its pose in an odometry frame, which its controller publishes. The
/// pose of that frame itself is left to a localization node.
std::vector<bool> drives(const cell::CellView& cell) {
  std::vector<bool> out;
  for (std::size_t i = 0; i < cell.robots().size(); ++i) {
    const description::RobotModel& model = cell.robots()[i]->model;
    const std::string prefix = cell.robots().size() > 1 ? cell.robots()[i]->entry.name + "/" : "";
    const std::string& base = cell.base(i).base_name();
    out.push_back(std::any_of(model.links.begin(), model.links.end(),
                              [&](const description::Link& link) { return prefix + link.name == base; }));
  }
  return out;
}

class RobotNode : public Part {
 public:
  explicit RobotNode(Bridge& bridge)
      : bridge_{bridge},
        node_{bridge.name("robot_state_publisher")},
        state_{bridge.cell().robots(), bridge.cell().table(), drives(bridge.cell())} {
    report_descriptions();
    const Qos often{true, false, 100}, latched{true, true, 1};
    const auto& transforms = messages::type_info<messages::tf2_msgs::msg::TFMessage>();
    moving_ = bridge.wire().publisher(node_, bridge.name("tf"), transforms, often);
    const auto fixed = bridge.wire().publisher(node_, bridge.name("tf_static"), transforms, latched);
    bridge.wire().publish(fixed, messages::to_cdr(state_.fixed_frames()));
    if (bridge.cell().lock_step())
      clock_ = bridge.wire().publisher(node_, "/clock",
                                       messages::type_info<messages::rosgraph_msgs::msg::Clock>());
    offer_standard_services(bridge, node_, parameters());
  }

  void serve() override {
    const Nanoseconds now = bridge_.cell().now();
    if (!bridge_.tells()) return;
    if (clock_ && now != clock_told_) {
      clock_told_ = now;
      const std::int64_t time = bridge_.ros_time(now);
      bridge_.wire().publish(
          *clock_, messages::to_cdr(messages::rosgraph_msgs::msg::Clock{recording::stamp_of(time)}));
    }
    if (reported_frames_ < 0 || now - reported_frames_ >= kFrames) tell_frames(now);
  }

 private:
  /// Publishes /robot_description, or one under each robot's name.
  void report_descriptions() {
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
    reported_frames_ = now;
    if (!bridge_.wire().wanted(moving_)) return;
    const control::Snapshot& snapshot = bridge_.cell().snapshot();
    bridge_.wire().publish(moving_, messages::to_cdr(state_.moving_frames(
                                        snapshot.states, bridge_.ros_time(snapshot.cycle.time))));
  }

  ParameterSource parameters() {
    ParameterSource out;
    out.list = [this](std::function<void(Json)> got) {
      Json all = Json::object();
      for (const auto& robot : bridge_.cell().robots()) {
        const std::string key =
            (bridge_.cell().robots().size() == 1 ? "" : robot->entry.name + ".") + "robot_description";
        all[key] = {
            {"value", description::write_plain_urdf(robot->model)}, {"text", "URDF"}, {"read_only", true}};
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
  recording::StateMessages state_;
  Wire::Id moving_ = 0;
  std::optional<Wire::Id> clock_;
  Nanoseconds clock_told_ = -1;  ///< the cell time of the last message on /clock
  Nanoseconds reported_frames_ = -1;
};

}  // namespace

std::unique_ptr<Part> make_robot_node(Bridge& bridge) {
  return std::make_unique<RobotNode>(bridge);
}

}  // namespace polyarm::ros2
