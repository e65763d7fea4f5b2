/// One ROS 2 node per controller: topics, actions, parameters, life cycle.
#include <algorithm>
#include <map>
#include <utility>

#include "polyarm/base/error.hpp"
#include "polyarm/messages/json.hpp"
#include "polyarm/messages/types.hpp"
#include "polyarm/protocol/messages.hpp"
#include "polyarm/ros2/cell_door.hpp"
#include "polyarm/ros2/life_cycle.hpp"
#include "polyarm/ros2/typed_topic.hpp"
#include "polyarm/ros_files/message_forms.hpp"
#include "polyarm/yaml/yaml.hpp"

namespace polyarm::ros2 {

namespace {

using controllers::Output;
using hardware::LifecycleState;

/// How often the list of controllers and their subscribers are checked, ns.
constexpr Nanoseconds kLookForControllers = 50'000'000;
/// The same reason is not reported again within this time, ns.
constexpr Nanoseconds kReportAgain = 5'000'000'000;

std::string declared(cell::CellView& cell, const std::string& controller, const char* key) {
  const controllers::ControllerContext* context = cell.controllers().context(controller);
  const controllers::Declared* found = context ? context->parameters.find_declared(key) : nullptr;
  return found ? found->value : "";
}

/// Converts a sample to the shape of its ROS message where the cell's own shape differs.
Json in_ros_shape(const std::string& type, Json message) {
  if (type == "control_msgs/JointTrajectoryControllerState") {
    if (message["output"].is_array()) message["output"] = Json{{"positions", message["output"]}};
    message["desired"] = message["reference"];  // Humble has both names
    message["actual"] = message["feedback"];
  }
  if (type == "sensor_msgs/BatteryState") message["present"] = message["present"] != 0;
  if (type == "control_msgs/BatteryStateArray")
    for (Json& battery : message["battery_states"]) battery["present"] = battery["present"] != 0;
  if (type == "control_msgs/SteeringControllerStatus")  // Humble's and Jazzy's name
    message["linear_velocity_command"] = message["traction_command"];
  if (type == "geometry_msgs/TransformStamped") return {{"transforms", Json::array({std::move(message)})}};
  return message;
}

/// One output topic of a controller. For joint states, `robot` limits it to the joints of that robot, named
/// without the robot's name.
class OutputTopic {
 public:
  OutputTopic(Bridge& bridge, const std::string& node, const std::string& topic, const Output& output,
              const std::string& robot = {})
      : bridge_{bridge}, port_{output.name()}, type_{output.type()}, robot_{robot} {
    const bool transform = type_ == "geometry_msgs/TransformStamped";
    info_ = bridge.wire().find_type(transform ? "tf2_msgs/TFMessage" : type_);
    if (info_)
      publisher_ = bridge.wire().publisher(node, topic, *info_, {true, false, transform ? 100u : 10u});
  }

  /// Checks for subscribers. A new subscriber gets only samples from now on: older ones may be outdated or
  /// never filled.
  void look() {
    const bool before = std::exchange(wanted_, info_ && bridge_.wire().wanted(publisher_));
    if (wanted_ && !before) seen_ = std::max(seen_, bridge_.cell().now());
  }
  void serve(const controllers::Controller& controller) {
    Output* output = wanted_ ? controller.find_output(port_) : nullptr;
    if (!output || !bridge_.tells()) return;
    output->fetch();
    if (output->value().time <= seen_) return;
    seen_ = output->value().time;
    bridge_.wire().publish(publisher_,
                           type_ == "sensor_msgs/JointState" ? joint_states(*output) : any(*output));
  }

 private:
  std::vector<std::byte> any(const Output& output) const {
    Json message = Json::parse(ros_files::message_json(output));
    bridge_.to_ros(message);
    // With a single robot, interface names are those of its own files.
    if (type_ == "control_msgs/DynamicJointState")
      for (Json& name : message["joint_names"]) name = bridge_.interface_name(name.get<std::string>());
    return messages::from_json(*info_, in_ros_shape(type_, std::move(message)));
  }

  /// Three values per joint, converted without JSON, because this topic runs at the rate of the loop.
  std::vector<std::byte> joint_states(const Output& output) {
    const auto& values = output.value().values;
    if (states_.name.empty()) find_joints(output);
    for (std::size_t i = 0; i < places_.size(); ++i) {
      states_.position[i] = values[places_[i]];
      states_.velocity[i] = values[places_[i] + 1];
      states_.effort[i] = values[places_[i] + 2];
    }
    const std::int64_t now = bridge_.ros_time(output.value().time);
    states_.header.stamp = {static_cast<std::int32_t>(now / 1'000'000'000),
                            static_cast<std::uint32_t>(now % 1'000'000'000)};
    return messages::to_cdr(states_);
  }

  void find_joints(const Output& output) {
    const std::string prefix = robot_.empty() ? "" : robot_ + "/";
    for (std::size_t i = 0; i + 2 < output.fields().size(); i += 3) {
      const std::string name = output.fields()[i].substr(0, output.fields()[i].rfind('/'));
      if (!name.starts_with(prefix)) continue;
      states_.name.push_back(name.substr(prefix.size()));
      places_.push_back(i);
    }
    for (auto* list : {&states_.position, &states_.velocity, &states_.effort}) list->resize(places_.size());
    if (const auto frame = output.texts.find("frame_id"); frame != output.texts.end())
      states_.header.frame_id = frame->second;
  }

  Bridge& bridge_;
  std::string port_, type_, robot_;
  const messages::TypeInfo* info_ = nullptr;
  Wire::Id publisher_ = 0;
  bool wanted_ = false;
  Nanoseconds seen_ = -1;
  messages::sensor_msgs::msg::JointState states_;
  std::vector<std::size_t> places_;  ///< indices of its joints' positions among the values
};

/// The ROS node of one controller. Its topics and services exist while the controller is configured.
class ControllerNode {
 public:
  ControllerNode(Bridge& bridge, const std::string& controller)
      : bridge_{bridge},
        controller_{controller},
        node_{bridge.name(controller)},
        ports_{node_ + "@ports"},
        life_{bridge, node_, controller} {
    offer_standard_services(bridge, node_, parameters());
  }
  ~ControllerNode() {
    close_ports();
    bridge_.wire().remove_node(node_);
  }
  ControllerNode(const ControllerNode&) = delete;
  ControllerNode& operator=(const ControllerNode&) = delete;

  void open_ports(const controllers::Controller& controller, bool only_base) {
    offer_outputs(controller, only_base);
    for (const controllers::InputPort& port : controller.inputs()) offer_input(port, only_base);
  }
  void close_ports() {
    actions_.clear();
    inputs_.clear();
    outputs_.clear();
    bridge_.wire().remove_node(ports_);
  }

  void look(const std::string& state) {
    life_.look(state);
    for (OutputTopic& topic : outputs_) topic.look();
    for (const auto& topic : inputs_) topic->look();
  }
  void serve() {
    const controllers::Controller* controller = bridge_.cell().controllers().find(controller_);
    if (!controller) return;
    for (OutputTopic& topic : outputs_) topic.serve(*controller);
    for (const auto& action : actions_) action->serve();
  }

 private:
  void offer_outputs(const controllers::Controller& controller, bool only_base) {
    const bool local = declared(bridge_.cell(), controller_, "use_local_topics") == "true";
    for (const auto& output : controller.outputs()) {
      const std::string& name = output->name();
      const bool global = name == "tf" || (!local && name.ends_with("joint_states"));
      outputs_.emplace_back(bridge_, ports_, global ? bridge_.name(name) : node_ + "/" + name, *output);
      // MoveIt and RViz know a robot by the joint names of its own description.
      if (output->type() == "sensor_msgs/JointState" && bridge_.cell().robots().size() > 1)
        for (const auto& robot : bridge_.cell().robots())
          outputs_.emplace_back(bridge_, ports_, bridge_.name(robot->entry.name + "/joint_states"), *output,
                                robot->entry.name);
      if ((name == "odom" || name == "odometry") && only_base)
        outputs_.emplace_back(bridge_, ports_, bridge_.name("odom"), *output);
      // Where ROS users remap the transform of a base to /tf.
      if (name == "tf_odometry") outputs_.emplace_back(bridge_, ports_, bridge_.name("tf"), *output);
    }
  }

  void offer_input(const controllers::InputPort& port, bool only_base) {
    if (port.action) {
      const std::string& type = port.types.front();
      const std::string whole = type.substr(0, type.find('/')) + "/action" + type.substr(type.find('/'));
      if (bridge_.wire().find_type(whole + "_Goal"))
        actions_.push_back(
            make_action_server(bridge_, {ports_, node_ + "/" + port.name, whole, controller_, port.name}));
      if (type == "control_msgs/FollowJointTrajectory") offer_query();
    }
    if (port.name == "set_odometry") offer_service(port.name, "control_msgs/srv/SetOdometry");
    if (port.name == "reset_odometry") offer_service(port.name, "std_srvs/srv/Empty");
    std::vector<std::string> types = port.types;
    std::erase_if(types, [&](const std::string& type) {
      return !bridge_.wire().find_type(type) || (port.action && bridge_.wire().find_type(type + "_Goal"));
    });
    if (types.empty()) return;
    offer_topic(node_ + "/" + port.name, port.name, types);
    if (port.name == "cmd_vel" && only_base) offer_topic(bridge_.name("cmd_vel"), port.name, types);
  }

  void offer_topic(const std::string& topic, const std::string& port, const std::vector<std::string>& types) {
    inputs_.push_back(
        std::make_unique<TypedTopic>(bridge_, ports_, topic, types, bridge_.at_once(types),
                                     [this, topic, port](const std::string& group, const std::string& type) {
                                       listen(group, topic, port, type);
                                     }));
  }

  /// A service whose request goes to the input of the same name.
  void offer_service(const std::string& port, const char* type) {
    bridge_.service(ports_, node_ + "/" + port, type, [this, port](const Json& request, const Reply& reply) {
      protocol::SendMessage sent;
      sent.to = controller_ + "/" + port;
      sent.message = protocol::Message(request);
      bridge_.ask(std::move(sent), [reply](const protocol::Reply& replied) {
        reply({{"success", !replied.refusal}, {"message", replied.refusal ? refusal_of(replied) : ""}});
      });
    });
  }

  /// Where its trajectory will be at a time; time 0 is now.
  void offer_query() {
    bridge_.service(
        ports_, node_ + "/query_state", "control_msgs/srv/QueryTrajectoryState",
        [this](const Json& request, const Reply& reply) {
          protocol::QueryTrajectory query;
          query.name = controller_;
          if (const std::int64_t at = nanoseconds_of(request["time"]); at != 0)
            query.at = seconds(bridge_.cell_time(at));
          bridge_.ask(std::move(query), [reply](const protocol::Reply& replied) {
            if (replied.refusal) return reply({{"success", false}, {"message", refusal_of(replied)}});
            const auto& at = replied.answer->as<protocol::QueryTrajectory>();
            reply({{"success", true},
                   {"name", at.joints},
                   {"position", at.position},
                   {"velocity", at.velocity},
                   {"acceleration", at.acceleration}});
          });
        });
  }

  /// The last ignored message, and when it was reported.
  struct Ignored {
    std::string why;
    Nanoseconds at = 0;
  };
  /// A topic has no reply, so a refusal is logged in the cell. The same reason is not logged again soon.
  static void tell_ignored(Bridge& bridge, Ignored& told, const std::string& topic, const protocol::Reply& reply) {
    if (!reply.refusal || reply.refusal->problems().front().code == "not-active") return;
    const std::string why = refusal_of(reply);
    const Nanoseconds now = bridge.cell().now();
    if (why == told.why && now - told.at < kReportAgain) return;
    told = {why, now};
    bridge.cell().tell("ROS 2: a message on " + topic + " is ignored: " + why);
  }

  /// Sends a message to the cell as every door does. Messages to an inactive controller are dropped, as in
  /// ROS.
  void listen(const std::string& group, const std::string& topic, const std::string& port,
              const std::string& type) {
    const bool command = type.find("Twist") != std::string::npos;
    bridge_.subscribe(group, topic, type,
                      [this, topic, to = controller_ + "/" + port](Json message) {
                        bridge_.to_cell(message);
                        protocol::SendMessage sent;
                        sent.to = to;
                        sent.message = protocol::Message(std::move(message));
                        bridge_.ask(
                            std::move(sent),
                            [told = announced_, topic, &bridge = bridge_](const protocol::Reply& reply) {
                              tell_ignored(bridge, *told, topic, reply);
                            },
                            this);
                      },
                      {!command, false, command ? 1u : 10u});
  }

  ParameterSource parameters() {
    ParameterSource out;
    out.list = [this](std::function<void(Json)> got) {
      bridge_.ask(protocol::ParamList{controller_}, [got = std::move(got)](const protocol::Reply& reply) {
        Json all = Json::object();
        if (reply.answer)
          for (const protocol::Parameter& p : reply.answer->as<protocol::ParamList>()) all[p.key] = entry_of(p);
        got(std::move(all));
      });
    };
    out.set = [this](const Json& values, std::function<void(std::string)> done) {
      protocol::ParamSet request{controller_, {}};
      for (const auto& [key, value] : values.items()) request.values[key] = value;
      bridge_.ask(std::move(request), [done = std::move(done)](const protocol::Reply& reply) {
        done(reply.answer ? "" : refusal_of(reply));
      });
    };
    return out;
  }

  static Json entry_of(const protocol::Parameter& parameter) {
    using Type = messages::rcl_interfaces::msg::ParameterType;
    Json out{{"value", value_of(parameter)}, {"text", parameter.text}, {"read_only", !parameter.changeable}};
    if (parameter.type == "a list of numbers") out["type"] = Type::PARAMETER_DOUBLE_ARRAY;
    if (parameter.type == "a list of texts") out["type"] = Type::PARAMETER_STRING_ARRAY;
    if (parameter.choices) out["constraints"] = "one of " + Json(*parameter.choices).dump();
    return out;
  }

  /// The JSON value of a parameter, converted from its text by its type.
  static Json value_of(const protocol::Parameter& parameter) {
    const std::string &type = parameter.type, &text = parameter.value;
    try {
      const Yaml yaml = Yaml::parse(text, "parameter");
      if (type == "true or false") return text == "true";
      if (type == "a whole number") return static_cast<std::int64_t>(yaml.number());
      if (type == "a number") return yaml.number();
      if (type == "a list of numbers") return yaml.numbers();
      if (type == "a list of texts") return yaml.texts();
    } catch (const Error&) {
    }
    return text;
  }

  Bridge& bridge_;
  const std::string controller_, node_;
  const std::shared_ptr<Ignored> announced_ = std::make_shared<Ignored>();  ///< replies may outlive the node
  const std::string ports_;  ///< group of the endpoints that exist only while the controller is configured
  LifeCycle life_;
  std::vector<OutputTopic> outputs_;
  std::vector<std::unique_ptr<TypedTopic>> inputs_;
  std::vector<std::unique_ptr<Part>> actions_;
};

class ControllerNodes : public Part {
 public:
  explicit ControllerNodes(Bridge& bridge) : bridge_{bridge} {}

  void serve() override {
    const bool changed = bridge_.take_change();
    if (changed || looked_ < 0 || bridge_.cell().now() - looked_ >= kLookForControllers) look();
    for (auto& [name, known] : nodes_) known.node->serve();
  }

 private:
  struct Known {
    const controllers::Controller* controller = nullptr;
    bool configured = false, only_base = false;
    std::unique_ptr<ControllerNode> node;
  };

  /// The controller that takes twists also listens on /cmd_vel if it is the only one.
  static std::string only_base(cell::CellView& cell, const std::vector<control::ListedController>& all) {
    std::vector<std::string> bases;
    for (const control::ListedController& c : all)
      for (const controllers::InputPort& port : cell.controllers().find(c.name)->inputs())
        if (port.name == "cmd_vel") bases.push_back(c.name);
    return bases.size() == 1 ? bases.front() : "";
  }

  void look() {
    looked_ = bridge_.cell().now();
    const auto all = bridge_.cell().controllers().list();
    const std::string base = only_base(bridge_.cell(), all);
    std::erase_if(nodes_, [&](const auto& known) {
      return std::none_of(all.begin(), all.end(), [&](const auto& c) { return c.name == known.first; });
    });
    for (const control::ListedController& c : all) {
      bring_up_to_date(nodes_[c.name], c, c.name == base);
      nodes_[c.name].node->look(hardware::name(c.state));
    }
  }

  void bring_up_to_date(Known& known, const control::ListedController& c, bool only_base) {
    const controllers::Controller* controller = bridge_.cell().controllers().find(c.name);
    const bool configured = c.state != LifecycleState::unconfigured;
    if (known.controller != controller) {
      known.node.reset();  // its endpoints must go before their names are used again
      known = {controller, false, false, std::make_unique<ControllerNode>(bridge_, c.name)};
    }
    if (known.configured == configured && known.only_base == only_base) return;
    known.node->close_ports();
    if (configured) known.node->open_ports(*controller, only_base);
    known.configured = configured;
    known.only_base = only_base;
  }

  Bridge& bridge_;
  Nanoseconds looked_ = -1;
  std::map<std::string, Known> nodes_;
};

}  // namespace

std::unique_ptr<Part> make_controller_nodes(Bridge& bridge) {
  return std::make_unique<ControllerNodes>(bridge);
}

}  // namespace polyarm::ros2
