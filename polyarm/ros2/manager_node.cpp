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

using hardware::LifecycleState;

/// How often it is looked whether a state has changed.
constexpr Nanoseconds kLookForChanges = 20'000'000;
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
    if (looked_ >= 0 && bridge_.cell().now() - looked_ < kLookForChanges) return;
    looked_ = bridge_.cell().now();
    Json now{{"controllers", Json::array()}, {"hardware_components", Json::array()}};
    for (const control::ListedController& c : bridge_.cell().loop().controllers().list())
      now["controllers"].push_back({{"name", c.name}, {"state", state_json(hardware::name(c.state))}});
    hardware::Hardware& hardware = bridge_.cell().loop().hardware();
    for (std::size_t i = 0; i < hardware.size(); ++i)
      for (const std::string& name :
           cell::names_of_component(bridge_.cell().robots(), hardware.component_name(i)))
        now["hardware_components"].push_back(
            {{"name", name}, {"state", state_json(hardware::name(hardware.diagnostics().info(i).state))}});
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
    bridge_.service(
        node_, node_ + "/reload_controller_libraries", kTypes + "ReloadControllerLibraries",
        [this](const Json& asked, const Reply& reply) { reload(asked["force_kill"].get<bool>(), reply); });
  }

  /// ROS's answers have no place for the reason: a person at the cell is told.
  void tell(const std::string& what, const Json& answer) {
    bridge_.cell().tell("ROS 2: " + what + ": " +
                        answer.value("error", Json::object()).value("what", std::string("refused")));
  }

  /// `load` of the cell configures at once; a controller that ROS 2 has loaded is not configured yet.
  void load(const std::string& name, const Reply& reply) {
    Json request;
    try {
      request = to_load(name);
    } catch (const Error& e) {
      tell("'" + name + "' cannot be loaded", {{"error", {{"what", e.what()}}}});
      return reply({{"ok", false}});
    }
    request["request"] = "control.load";
    bridge_.ask(std::move(request), [this, name, reply](const Json& answer) {
      if (!answer.value("ok", false)) {
        tell("'" + name + "' cannot be loaded", answer);
        return reply({{"ok", false}});
      }
      bridge_.ask({{"request", "control.cleanup"}, {"name", name}}, [reply](const Json& cleaned) {
        reply({{"ok", cleaned.value("ok", false)}});
      });
    });
  }

  /// Nothing that is at work is taken away unless it is forced; then all controllers go. Libraries of plugins
  /// stay loaded: what is loaded afterwards is made anew from them.
  void reload(bool force, const Reply& reply) {
    Json active = Json::array();
    const auto names = std::make_shared<std::vector<std::string>>();
    for (const control::ListedController& c : bridge_.cell().loop().controllers().list()) {
      if (c.state == LifecycleState::active) active.push_back(c.name);
      names->push_back(c.name);
    }
    if (active.empty()) return unload_all(names, reply);
    if (!force) return reply({{"ok", false}});
    bridge_.ask({{"request", "control.switch"}, {"deactivate", active}, {"strictness", "force"}},
                [this, names, reply](const Json& answer) {
                  if (answer.value("ok", false) && answer["result"].value("ok", false))
                    return unload_all(names, reply);
                  reply({{"ok", false}});
                });
  }
  void unload_all(const std::shared_ptr<std::vector<std::string>>& names, const Reply& reply) {
    if (names->empty()) return reply({{"ok", true}});
    const std::string name = names->back();
    names->pop_back();
    bridge_.ask({{"request", "control.unload"}, {"name", name}},
                [this, names, name, reply](const Json& answer) {
                  if (answer.value("ok", false)) return unload_all(names, reply);
                  tell("'" + name + "' cannot be taken away", answer);
                  reply({{"ok", false}});
                });
  }

  /// What is configured already stays so. A cell starts its controllers by itself, and launch files of users
  /// start them once more: a spawner configures and then activates, and both succeed where that is done.
  void configure(const std::string& name, const Reply& reply) {
    if (is_active(name)) return reply({{"ok", true}});
    bridge_.ask({{"request", "control.state"}, {"name", name}, {"state", "inactive"}},
                [this, name, reply](const Json& answer) {
                  const bool ok = answer.value("ok", false);
                  if (!ok) tell("'" + name + "' cannot be configured", answer);
                  reply({{"ok", ok}});
                });
  }

  bool is_active(const std::string& name) const {
    const auto all = bridge_.cell().loop().controllers().list();
    return std::any_of(all.begin(), all.end(), [&](const control::ListedController& c) {
      return c.name == name && c.state == LifecycleState::active;
    });
  }

  /// Humble has an older name for each list beside the one that is used.
  static Json either(const Json& asked, const char* name, const char* older) {
    return asked[name].empty() && asked.contains(older) ? asked[older] : asked[name];
  }

  void offer_switch() {
    bridge_.service(node_, node_ + "/switch_controller", kTypes + "SwitchController",
                    [this](const Json& asked, const Reply& reply) { change(asked, reply); });
  }

  void change(const Json& asked, const Reply& reply) {
    using Request = messages::controller_manager_msgs::srv::SwitchController::Request;
    const Json off = either(asked, "deactivate_controllers", "stop_controllers");
    Json on = either(asked, "activate_controllers", "start_controllers");
    if (off.empty())  // with a restart (both lists) an active one is meant to begin anew
      on.erase(std::remove_if(on.begin(), on.end(),
                              [this](const Json& name) { return is_active(name.get<std::string>()); }),
               on.end());
    if (on.empty() && off.empty()) return reply({{"ok", true}, {"message", "nothing is to be changed"}});
    const int strictness = asked["strictness"];
    const std::string word = strictness == 0                      ? unsaid_strictness()
                             : strictness == Request::BEST_EFFORT ? "best_effort"
                             : strictness == Request::AUTO        ? "auto"
                             : strictness == Request::FORCE_AUTO  ? "force"
                                                                  : "strict";
    bridge_.ask({{"request", "control.switch"}, {"activate", on}, {"deactivate", off}, {"strictness", word}},
                [this, on, reply](const Json& answer) { reply(switched(on, answer)); });
  }

  /// What is left out with best effort is told, too: who could be active and is not has not been switched.
  Json switched(const Json& on, const Json& answer) const {
    if (!answer.value("ok", false))
      return {{"ok", false},
              {"message", answer.value("error", Json::object()).value("what", std::string("refused"))}};
    const Json result = answer.value("result", Json::object());
    if (!result.value("ok", false))
      return {{"ok", false}, {"message", result.value("reason", std::string())}};
    std::string left_out;
    for (const Json& why : result.value("left_out", Json::array()))
      left_out += (left_out.empty() ? "" : "; ") + why.get<std::string>();
    bool all = true;
    for (const control::ListedController& c : bridge_.cell().loop().controllers().list())
      all =
          all && (c.state != LifecycleState::inactive || std::find(on.begin(), on.end(), c.name) == on.end());
    return {{"ok", all}, {"message", left_out.empty() ? "the controllers are switched" : left_out}};
  }

  /// Of a request that states none: as the controllers' file says, else as the distribution has it.
  std::string unsaid_strictness() const {
    const std::string& stated = bridge_.cell().manager().strictness;
    if (!stated.empty()) return stated;
    return bridge_.wire().distribution() == messages::Distribution::kilted ? "strict" : "best_effort";
  }

  static Json json_of(const Yaml& yaml) {
    if (yaml.is_list()) return yaml.texts();
    if (!yaml.is_map()) return yaml.text("");
    Json out = Json::object();
    for (const std::string& key : yaml.keys()) out[key] = json_of(yaml[key]);
    return out;
  }

  /// What a file says of the node of that name, later keys over earlier ones.
  void add_parameters(const std::string& file, const std::string& name, Json& into) const {
    const Yaml yaml = Yaml::load(file);
    const std::string whole = bridge_.name(name);
    for (const std::string& key :
         {std::string("/**"), "/**/" + name, "/**" + whole, std::string(name), whole}) {
      const Json found = json_of(yaml[key]["ros__parameters"]);
      if (found.is_object()) into.update(found, true);
    }
  }

  /// What a spawner has set of the controller before it loads it: its type, which may stand in its files,
  /// too, and the files, of which later ones have the last word. Where no type is known the cell looks for
  /// the controller in the last file, or in its own.
  Json to_load(const std::string& name) const {
    const auto spawned = [&](const char* key) {
      const auto at = spawned_.find(name + key);
      return at == spawned_.end() ? Json() : at->second;
    };
    Json out{{"name", name}}, parameters = Json::object();
    const Json files = spawned(".params_file");
    for (const Json& file : files) add_parameters(file.get<std::string>(), name, parameters);
    Json type = spawned(".type");
    if (type.is_null() && parameters.contains("type")) type = parameters["type"];
    parameters.erase("type");
    if (!type.is_null()) {
      out["type"] = type;
      if (!parameters.empty()) out["parameters"] = parameters;
    } else if (!files.empty()) {
      out["file"] = files.back();
    }
    return out;
  }

  /// A spawner gives lists as they are, or as one text: "['/a.yaml', '/b.yaml']" or "/a.yaml".
  static Json texts_of(const Json& value) {
    if (value.is_array()) return value;
    const std::string text = value.get<std::string>();
    if (!text.starts_with('[')) return Json::array({text});
    return Json(Yaml::parse(text, "params_file").texts());
  }

  /// "" where a spawner may set this before it loads a controller.
  std::string spawn(const std::string& key, const Json& value) {
    const std::size_t dot = key.rfind('.');
    const std::string last = dot == std::string::npos ? "" : key.substr(dot);
    if (last == ".type") {
      if (!value.is_string()) return key + " is a text";
      spawned_[key] = value;
      return "";
    }
    const bool known =
        last == ".params_file" || last == ".fallback_controllers" || last == ".node_options_args";
    if (!known) return "it is read when the cell is built";
    const bool list = value.is_array() && std::all_of(value.begin(), value.end(),
                                                      [](const Json& item) { return item.is_string(); });
    if (!value.is_string() && !list) return key + " is a list of texts";
    try {
      spawned_[key] = texts_of(value);
    } catch (const Error& e) {
      return e.what();
    }
    if (last != ".params_file")
      bridge_.cell().tell("ROS 2: " + key +
                          " has no effect on a controller that is loaded while the cell runs");
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
  /// `NAME.type`, `NAME.params_file` and the like, as a spawner sets them: a text, or a list of texts.
  std::map<std::string, Json> spawned_;
};

}  // namespace

std::unique_ptr<Part> make_manager_node(Bridge& bridge) {
  return std::make_unique<ManagerNode>(bridge);
}

}  // namespace polyarm::ros2
