/// /controller_manager, as the tools of ros2_control know it.
#include <algorithm>
#include <map>
#include <utility>

#include "polyarm/base/error.hpp"
#include "polyarm/base/yaml.hpp"
#include "polyarm/messages/json.hpp"
#include "polyarm/messages/types.hpp"
#include "polyarm/ros2/cell_door.hpp"
#include "polyarm/ros2/life_cycle.hpp"

namespace polyarm::ros2 {

namespace {

/// How often it is looked whether a state has changed.
constexpr Nanoseconds kLook = 20'000'000;
const std::string kTypes = "controller_manager_msgs/srv/";

class ManagerNode : public Part {
 public:
  explicit ManagerNode(Bridge& bridge) : bridge_{bridge}, node_{bridge.name("controller_manager")} {
    const Qos latched{true, true, 1};
    activity_ = bridge.wire().publisher(
        node_, node_ + "/activity",
        messages::type_info<messages::controller_manager_msgs::msg::ControllerManagerActivity>(), latched);
    offer_lists();
    offer_changes();
    offer_switch();
    offer_standard_services(bridge, node_, parameters());
  }

  void serve() override {
    if (looked_ >= 0 && bridge_.cell().now() - looked_ < kLook) return;
    looked_ = bridge_.cell().now();
    Json now{{"controllers", Json::array()}, {"hardware_components", Json::array()}};
    for (const control::ListedController& c : bridge_.cell().loop().controllers().list())
      now["controllers"].push_back({{"name", c.name}, {"state", state_json(hardware::name(c.state))}});
    hardware::Hardware& hardware = bridge_.cell().loop().hardware();
    for (std::size_t i = 0; i < hardware.size(); ++i)
      now["hardware_components"].push_back({{"name", hardware.component_name(i)},
                                            {"state", state_json(hardware::name(hardware.info(i).state))}});
    if (now == told_) return;
    told_ = now;
    now["header"]["stamp"] = bridge_.ros_stamp(bridge_.cell().now());
    const auto& type =
        messages::type_info<messages::controller_manager_msgs::msg::ControllerManagerActivity>();
    bridge_.wire().publish(activity_, messages::from_json(type, now));
  }

 private:
  /// A service that asks the cell one thing and gives its result in ROS's words.
  void offer(const char* name, const char* type, const char* request,
             std::function<Json(const Json&)> arguments, std::function<Json(const Json& answer)> response) {
    bridge_.service(node_, node_ + "/" + name, kTypes + type,
                    [this, request, arguments = std::move(arguments), response = std::move(response)](
                        const Json& asked, const Reply& reply) {
                      Json line = arguments(asked);
                      line["request"] = request;
                      bridge_.ask(std::move(line),
                                  [response, reply](const Json& answer) { reply(response(answer)); });
                    });
  }

  Json names(const Json& interfaces) const {
    Json out = Json::array();
    for (const Json& name : interfaces) out.push_back(bridge_.interface_name(name.get<std::string>()));
    return out;
  }

  Json controller(const Json& c) const {
    Json chains = Json::array();
    std::map<std::string, Json> by_controller;
    for (const Json& command : c["commands"]) {
      const std::string name = command;
      for (const std::string& other : bridge_.cell().loop().controllers().names())
        if (name.starts_with(other + "/")) by_controller[other].push_back(name.substr(other.size() + 1));
    }
    for (const auto& [name, references] : by_controller)
      chains.push_back({{"name", name}, {"reference_interfaces", references}});
    return {{"name", c["name"]},
            {"state", c["state"]},
            {"type", c["type"]},
            {"is_async", c["async"]},
            {"update_rate", static_cast<std::uint16_t>(std::min(c["rate"].get<double>(), 65535.0))},
            {"claimed_interfaces", names(c["claimed"])},
            {"required_command_interfaces", names(c["commands"])},
            {"required_state_interfaces", names(c["states"])},
            {"is_chainable", !c["references"].empty()},
            {"is_chained", c["chained"]},
            {"exported_state_interfaces", c["exported_states"]},
            {"reference_interfaces", c["references"]},
            {"chain_connections", chains}};
  }

  /// An interface is a name here and {name, claimed_by} there.
  Json interface(const Json& given, bool available) const {
    const std::string name = given.is_string() ? given.get<std::string>() : given["name"].get<std::string>();
    return {{"name", bridge_.interface_name(name)},
            {"data_type", "double"},
            {"is_available", available},
            {"is_claimed", given.is_object() && !given.value("claimed_by", std::string()).empty()}};
  }
  Json interfaces(const Json& given, bool available) const {
    Json out = Json::array();
    for (const Json& one : given) out.push_back(interface(one, available));
    return out;
  }

  Json component(const Json& h) const {
    const std::string state = h["state"];
    const bool available = state == "active" || state == "inactive";
    return {{"name", h["name"]},
            {"type", h["type"]},
            {"is_async", h["async"]},
            {"rw_rate", static_cast<std::uint16_t>(std::min(h["rate"].get<double>(), 65535.0))},
            {"class_type", h["plugin"]},
            {"plugin_name", h["plugin"]},
            {"state", state_json(state)},
            {"command_interfaces", interfaces(h["commands"], available)},
            {"state_interfaces", interfaces(h["states"], available)}};
  }

  template <class Each>
  static Json all(const Json& answer, Each each) {
    Json out = Json::array();
    for (const Json& one : answer.value("result", Json::array())) out.push_back(each(one));
    return out;
  }

  void offer_lists() {
    const auto nothing = [](const Json&) { return Json::object(); };
    offer("list_controllers", "ListControllers", "control.list", nothing, [this](const Json& answer) {
      return Json{{"controller", all(answer, [this](const Json& c) { return controller(c); })}};
    });
    offer("list_controller_types", "ListControllerTypes", "control.types", nothing, [](const Json& answer) {
      return Json{{"types", all(answer, [](const Json& t) { return t["type"]; })},
                  {"base_classes",
                   all(answer, [](const Json&) { return "controller_interface::ControllerInterface"; })}};
    });
    offer("list_hardware_components", "ListHardwareComponents", "hardware.list", nothing,
          [this](const Json& answer) {
            return Json{{"component", all(answer, [this](const Json& h) { return component(h); })}};
          });
    offer("list_hardware_interfaces", "ListHardwareInterfaces", "interfaces", nothing,
          [this](const Json& answer) {
            const Json result = answer.value("result", Json::object());
            return Json{{"command_interfaces", interfaces(result.value("commands", Json::array()), true)},
                        {"state_interfaces", interfaces(result.value("states", Json::array()), true)}};
          });
  }

  void offer_changes() {
    const auto name = [](const Json& asked) { return Json{{"name", asked["name"]}}; };
    const auto ok = [](const Json& answer) { return Json{{"ok", answer.value("ok", false)}}; };
    // `load` of the cell configures at once; ROS's does not, and its `configure` of what is configured says
    // no.
    bridge_.service(node_, node_ + "/load_controller", kTypes + "LoadController",
                    [this](const Json& asked, const Reply& reply) { load(asked["name"], reply); });
    offer("unload_controller", "UnloadController", "control.unload", name, ok);
    offer("cleanup_controller", "CleanupController", "control.cleanup", name, ok);
    bridge_.service(node_, node_ + "/configure_controller", kTypes + "ConfigureController",
                    [this](const Json& asked, const Reply& reply) { configure(asked["name"], reply); });
    offer(
        "set_hardware_component_state", "SetHardwareComponentState", "hardware.state",
        [](const Json& asked) {
          return Json{{"name", asked["name"]}, {"state", state_label(asked["target_state"])}};
        },
        [](const Json& answer) {
          const Json result = answer.value("result", Json::object());
          return Json{{"ok", answer.value("ok", false)},
                      {"state", state_json(result.value("state", std::string()))}};
        });
    bridge_.service(node_, node_ + "/reload_controller_libraries", kTypes + "ReloadControllerLibraries",
                    [](const Json&, const Reply& reply) {
                      reply({{"ok", false}});
                    });
  }

  /// ROS's answer has no place for the reason: a person at the cell is told.
  void load(const std::string& name, const Reply& reply) {
    Json request;
    try {
      request = to_load(name);
    } catch (const Error& e) {
      bridge_.cell().tell("ROS 2: '" + name + "' cannot be loaded: " + e.what());
      return reply({{"ok", false}});
    }
    request["request"] = "control.load";
    bridge_.ask(std::move(request), [this, name, reply](const Json& answer) {
      if (!answer.value("ok", false))
        bridge_.cell().tell("ROS 2: '" + name + "' cannot be loaded: " +
                            answer.value("error", Json::object()).value("what", std::string()));
      reply({{"ok", answer.value("ok", false)}});
    });
  }

  /// What is configured already stays so; what is active is not taken out of it.
  void configure(const std::string& name, const Reply& reply) {
    for (const control::ListedController& c : bridge_.cell().loop().controllers().list())
      if (c.name == name && c.state == hardware::LifecycleState::active) return reply({{"ok", false}});
    bridge_.ask({{"request", "control.state"}, {"name", name}, {"state", "inactive"}},
                [reply](const Json& answer) {
                  reply({{"ok", answer.value("ok", false)}});
                });
  }

  /// Humble has an older name for each list beside the one that is used.
  static Json either(const Json& asked, const char* name, const char* older) {
    return asked[name].empty() && asked.contains(older) ? asked[older] : asked[name];
  }

  void offer_switch() {
    using Request = messages::controller_manager_msgs::srv::SwitchController::Request;
    offer(
        "switch_controller", "SwitchController", "control.switch",
        [](const Json& asked) {
          const int strictness = asked["strictness"];
          const char* word = strictness == Request::BEST_EFFORT  ? "best_effort"
                             : strictness == Request::AUTO       ? "auto"
                             : strictness == Request::FORCE_AUTO ? "force"
                                                                 : "strict";
          return Json{{"activate", either(asked, "activate_controllers", "start_controllers")},
                      {"deactivate", either(asked, "deactivate_controllers", "stop_controllers")},
                      {"strictness", word}};
        },
        [](const Json& answer) {
          const Json result = answer.value("result", Json::object());
          const bool done = answer.value("ok", false) && result.value("ok", false);
          const std::string why =
              answer.value("ok", false)
                  ? result.value("reason", std::string())
                  : answer.value("error", Json::object()).value("what", std::string("refused"));
          return Json{{"ok", done}, {"message", done ? "" : why}};
        });
  }

  static Json json_of(const Yaml& yaml) {
    if (yaml.is_list()) return yaml.texts();
    if (!yaml.is_map()) return yaml.text("");
    Json out = Json::object();
    for (const std::string& key : yaml.keys()) out[key] = json_of(yaml[key]);
    return out;
  }

  /// What a spawner has set of the controller before it loads it. The file of one whose type it gives is read
  /// here; else the cell finds the controller in it.
  Json to_load(const std::string& name) const {
    Json out{{"name", name}};
    const auto type = spawned_.find(name + ".type"), file = spawned_.find(name + ".params_file");
    if (type != spawned_.end()) out["type"] = type->second;
    if (file == spawned_.end()) return out;
    if (type == spawned_.end())
      out["file"] = file->second;
    else
      out["parameters"] = json_of(Yaml::load(file->second)[name]["ros__parameters"]);
    return out;
  }

  /// A spawner gives files as one text, "['/a.yaml', '/b.yaml']" or "/a.yaml"; the last has the last word.
  static std::string last_file(const Json& value) {
    if (value.is_array()) return value.empty() ? "" : value.back().get<std::string>();
    std::string text = value.get<std::string>();
    if (!text.ends_with("']") && !text.ends_with("\"]")) return text;
    text.resize(text.size() - 2);
    return text.substr(text.find_last_of("'\"") + 1);
  }

  /// "" where a spawner may set this before it loads a controller.
  std::string spawn(const std::string& key, const Json& value) {
    const std::size_t dot = key.rfind('.');
    const std::string last = dot == std::string::npos ? "" : key.substr(dot);
    if (last != ".type" && last != ".params_file") return "it is read when the cell is built";
    const bool list = value.is_array() && !value.empty() && value.back().is_string();
    if (!value.is_string() && !list) return key + " is a text";
    spawned_[key] = last_file(value);
    return "";
  }

  ParameterSource parameters() {
    ParameterSource out;
    out.list = [this](std::function<void(Json)> got) {
      const auto entry = [](Json value, const char* text, bool read_only) {
        return Json{{"value", std::move(value)}, {"text", text}, {"read_only", read_only}};
      };
      const double rate = 1e9 / static_cast<double>(bridge_.cell().loop().options().period);
      Json all{
          {"update_rate", entry(static_cast<std::int64_t>(rate + 0.5), "of the control loop, Hz", true)}};
      for (const control::ListedController& c : bridge_.cell().loop().controllers().list())
        all[c.name + ".type"] = entry(c.type, "what it is", false);
      for (const auto& [key, value] : spawned_)
        all[key] = entry(value, "for a controller that is to be loaded", false);
      got(std::move(all));
    };
    out.set = [this](const Json& values, std::function<void(std::string)> done) {
      std::string refusal;
      for (const auto& [key, value] : values.items())
        if (refusal.empty()) refusal = spawn(key, value);
      done(refusal);
    };
    return out;
  }

  Bridge& bridge_;
  std::string node_;
  Wire::Id activity_ = 0;
  Nanoseconds looked_ = -1;
  Json told_;
  std::map<std::string, std::string>
      spawned_;  ///< `NAME.type` and `NAME.params_file`, as a spawner sets them
};

}  // namespace

std::unique_ptr<Part> make_manager_node(Bridge& bridge) {
  return std::make_unique<ManagerNode>(bridge);
}

}  // namespace polyarm::ros2
