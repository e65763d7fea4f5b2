/// The node /controller_manager, as the tools of ros2_control expect it.
#include <algorithm>
#include <map>
#include <utility>

#include "polyarm/base/error.hpp"
#include "polyarm/messages/json.hpp"
#include "polyarm/messages/types.hpp"
#include "polyarm/protocol/controllers.hpp"
#include "polyarm/protocol/hardware.hpp"
#include "polyarm/ros2/cell_door.hpp"
#include "polyarm/ros2/life_cycle.hpp"
#include "polyarm/yaml/yaml.hpp"
#include "polyarm/yaml/yaml_repeats.hpp"

namespace polyarm::ros2 {

namespace {

using hardware::LifecycleState;

/// How often changes of state are checked, ns.
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
    for (const control::ListedController& c : bridge_.cell().controllers().list())
      now["controllers"].push_back({{"name", c.name}, {"state", state_json(hardware::name(c.state))}});
    const hardware::Hardware& hardware = bridge_.cell().hardware();
    for (std::size_t i = 0; i < hardware.size(); ++i)
      for (const std::string& name :
           cell::names_of_component(bridge_.cell().robots(), hardware.component_name(i)))
        now["hardware_components"].push_back(
            {{"name", name}, {"state", state_json(hardware::name(hardware.diagnostics().info(i).state))}});
    if (now == announced_) return;
    announced_ = now;
    now["header"]["stamp"] = bridge_.ros_stamp(bridge_.cell().now());
    const auto& type =
        messages::type_info<messages::controller_manager_msgs::msg::ControllerManagerActivity>();
    bridge_.wire().publish(activity_, messages::from_json(type, now));
  }

 private:
  /// Offers a service that maps to one request of the cell. `response` converts the answer; it gets null if
  /// the cell refused.
  template <class R>
  void offer(const char* name, const char* type, std::function<R(const Json& asked)> request,
             std::function<Json(const typename R::Answer* answer)> response) {
    bridge_.service(node_, node_ + "/" + name, kTypes + type,
                    [this, request = std::move(request), response = std::move(response)](const Json& asked,
                                                                                         const Reply& reply) {
                      bridge_.ask(request(asked), [response, reply](const protocol::Reply& replied) {
                        reply(response(replied.answer ? &replied.answer->as<R>() : nullptr));
                      });
                    });
  }
  /// The same for a request without arguments.
  template <class R>
  void offer(const char* name, const char* type, std::function<Json(const typename R::Answer* answer)> response) {
    offer<R>(name, type, [](const Json&) { return R{}; }, std::move(response));
  }

  Json names(const std::vector<std::string>& interfaces) const {
    Json out = Json::array();
    for (const std::string& name : interfaces) out.push_back(bridge_.interface_name(name));
    return out;
  }

  static std::uint16_t whole_rate(double rate) { return static_cast<std::uint16_t>(std::min(rate, 65535.0)); }

  Json controller(const protocol::ListedController& c) const {
    Json chains = Json::array();
    std::map<std::string, Json> by_controller;
    for (const std::string& name : c.commands)
      for (const std::string& other : bridge_.cell().controllers().names())
        if (name.starts_with(other + "/")) by_controller[other].push_back(name.substr(other.size() + 1));
    for (const auto& [name, references] : by_controller)
      chains.push_back({{"name", name}, {"reference_interfaces", references}});
    return {{"name", c.name},
            {"state", c.state},
            {"type", c.type},
            {"is_async", c.async},
            {"update_rate", whole_rate(c.rate)},
            {"claimed_interfaces", names(c.claimed)},
            {"required_command_interfaces", names(c.commands)},
            {"required_state_interfaces", names(c.states)},
            {"is_chainable", !c.references.empty()},
            {"is_chained", c.chained},
            {"exported_state_interfaces", c.exported_states},
            {"reference_interfaces", c.references},
            {"chain_connections", chains}};
  }

  Json interface(const std::string& name, const std::string& claimed_by, bool available) const {
    return {{"name", bridge_.interface_name(name)},
            {"data_type", "double"},
            {"is_available", available},
            {"is_claimed", !claimed_by.empty()}};
  }
  template <class Command>
  Json commands(const std::vector<Command>& all, bool available) const {
    Json out = Json::array();
    for (const Command& each : all) out.push_back(interface(each.name, each.claimed_by, available));
    return out;
  }

  Json component(const protocol::ListedHardware& h) const {
    const bool available = h.state == "active" || h.state == "inactive";
    Json states = Json::array();
    for (const std::string& name : h.states) states.push_back(interface(name, "", available));
    return {{"name", h.name},
            {"type", h.type},
            {"is_async", h.async},
            {"rw_rate", whole_rate(h.rate)},
            {"class_type", h.plugin},
            {"plugin_name", h.plugin},
            {"state", state_json(h.state)},
            {"command_interfaces", commands(h.commands, available)},
            {"state_interfaces", std::move(states)}};
  }

  template <class List, class Each>
  static Json all(const List* answer, Each each) {
    Json out = Json::array();
    if (answer)
      for (const auto& one : *answer) out.push_back(each(one));
    return out;
  }

  void offer_lists() {
    offer<protocol::ControlList>("list_controllers", "ListControllers", [this](const auto* answer) {
      return Json{{"controller", all(answer, [this](const auto& c) { return controller(c); })}};
    });
    offer<protocol::ControlTypes>("list_controller_types", "ListControllerTypes", [](const auto* answer) {
      return Json{{"types", all(answer, [](const auto& t) { return t.type; })},
                  {"base_classes",
                   all(answer, [](const auto&) { return "controller_interface::ControllerInterface"; })}};
    });
    offer<protocol::HardwareList>("list_hardware_components", "ListHardwareComponents", [this](const auto* answer) {
      return Json{{"component", all(answer, [this](const auto& h) { return component(h); })}};
    });
    offer<protocol::InterfacesList>("list_hardware_interfaces", "ListHardwareInterfaces", [this](const auto* answer) {
      if (!answer) return Json{{"command_interfaces", Json::array()}, {"state_interfaces", Json::array()}};
      return Json{{"command_interfaces", commands(answer->commands, true)},
                  {"state_interfaces",
                   all(&answer->states, [this](const auto& state) { return interface(state.name, "", true); })}};
    });
  }

  void offer_changes() {
    const auto ok = [](const auto* answer) { return Json{{"ok", answer != nullptr}}; };
    bridge_.service(node_, node_ + "/load_controller", kTypes + "LoadController",
                    [this](const Json& asked, const Reply& reply) { load(asked["name"], reply); });
    offer<protocol::ControlUnload>(
        "unload_controller", "UnloadController",
        [](const Json& asked) { return protocol::ControlUnload{asked["name"]}; }, ok);
    offer<protocol::ControlCleanup>(
        "cleanup_controller", "CleanupController",
        [](const Json& asked) { return protocol::ControlCleanup{asked["name"]}; }, ok);
    bridge_.service(node_, node_ + "/configure_controller", kTypes + "ConfigureController",
                    [this](const Json& asked, const Reply& reply) { configure(asked["name"], reply); });
    offer<protocol::HardwareState>(
        "set_hardware_component_state", "SetHardwareComponentState",
        [](const Json& asked) {
          return protocol::HardwareState{asked["name"], state_label(asked["target_state"])};
        },
        [](const auto* answer) {
          return Json{{"ok", answer != nullptr}, {"state", state_json(answer ? answer->state : "")}};
        });
    bridge_.service(
        node_, node_ + "/reload_controller_libraries", kTypes + "ReloadControllerLibraries",
        [this](const Json& asked, const Reply& reply) { reload(asked["force_kill"].get<bool>(), reply); });
  }

  /// ROS responses have no field for the reason, so it is logged in the cell.
  void tell(const std::string& what, const std::string& why) { bridge_.cell().tell("ROS 2: " + what + ": " + why); }

  /// The cell's `load` also configures; a controller loaded from ROS 2 must stay unconfigured.
  void load(const std::string& name, const Reply& reply) {
    protocol::ControlLoad request;
    try {
      request = to_load(name);
    } catch (const Error& e) {
      tell("'" + name + "' cannot be loaded", e.what());
      return reply({{"ok", false}});
    }
    bridge_.ask(std::move(request), [this, name, reply](const protocol::Reply& loaded) {
      if (loaded.refusal) {
        tell("'" + name + "' cannot be loaded", refusal_of(loaded));
        return reply({{"ok", false}});
      }
      bridge_.ask(protocol::ControlCleanup{name}, [reply](const protocol::Reply& cleaned) {
        reply({{"ok", cleaned.answer.has_value()}});
      });
    });
  }

  /// Unloads all controllers. If some are active, `force` is needed. Plugin libraries stay loaded; new
  /// controllers are made from them.
  void reload(bool force, const Reply& reply) {
    protocol::Names active;
    const auto names = std::make_shared<std::vector<std::string>>();
    for (const control::ListedController& c : bridge_.cell().controllers().list()) {
      if (c.state == LifecycleState::active) active.push_back(c.name);
      names->push_back(c.name);
    }
    if (active.empty()) return unload_all(names, reply);
    if (!force) return reply({{"ok", false}});
    protocol::ControlSwitch off;
    off.deactivate = active;
    off.strictness = protocol::Strictness::force;
    bridge_.ask(std::move(off), [this, names, reply](const protocol::Reply& switched) {
      if (switched.answer && switched.answer->as<protocol::ControlSwitch>().ok) return unload_all(names, reply);
      reply({{"ok", false}});
    });
  }
  void unload_all(const std::shared_ptr<std::vector<std::string>>& names, const Reply& reply) {
    if (names->empty()) return reply({{"ok", true}});
    const std::string name = names->back();
    names->pop_back();
    bridge_.ask(protocol::ControlUnload{name}, [this, names, name, reply](const protocol::Reply& unloaded) {
      if (unloaded.answer) return unload_all(names, reply);
      tell("'" + name + "' cannot be unloaded", refusal_of(unloaded));
      reply({{"ok", false}});
    });
  }

  /// Leaves an active controller as it is. A cell starts its controllers by itself, and launch files start
  /// them again: a spawner configures and then activates, and both must succeed if the controller is already
  /// active.
  void configure(const std::string& name, const Reply& reply) {
    if (is_active(name)) return reply({{"ok", true}});
    bridge_.ask(protocol::ControlState{name, "inactive"}, [this, name, reply](const protocol::Reply& configured) {
      if (configured.refusal) tell("'" + name + "' cannot be configured", refusal_of(configured));
      reply({{"ok", configured.answer.has_value()}});
    });
  }

  bool is_active(const std::string& name) const {
    const auto all = bridge_.cell().controllers().list();
    return std::any_of(all.begin(), all.end(), [&](const control::ListedController& c) {
      return c.name == name && c.state == LifecycleState::active;
    });
  }

  /// Humble has an older name for each list in addition to the current one.
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
    if (off.empty())  // with both lists (a restart), an active controller must start again
      on.erase(std::remove_if(on.begin(), on.end(),
                              [this](const Json& name) { return is_active(name.get<std::string>()); }),
               on.end());
    if (on.empty() && off.empty()) return reply({{"ok", true}, {"message", "nothing is to be changed"}});
    const int strictness = asked["strictness"];
    protocol::ControlSwitch request;
    request.activate = on.get<std::vector<std::string>>();
    request.deactivate = off.get<std::vector<std::string>>();
    using Word = protocol::Strictness;
    request.strictness = strictness == 0                      ? unsaid_strictness()
                         : strictness == Request::BEST_EFFORT ? Word::best_effort
                         : strictness == Request::AUTO        ? Word::automatic
                         : strictness == Request::FORCE_AUTO  ? Word::force
                                                              : Word::strict;
    bridge_.ask(std::move(request),
                [this, on, reply](const protocol::Reply& replied) { reply(switched(on, replied)); });
  }

  /// With best effort, a controller that was left out is not switched; then `ok` is false.
  Json switched(const Json& on, const protocol::Reply& reply) const {
    if (reply.refusal) return {{"ok", false}, {"message", refusal_of(reply)}};
    const protocol::SwitchOutcome& outcome = reply.answer->as<protocol::ControlSwitch>();
    if (!outcome.ok) return {{"ok", false}, {"message", outcome.reason}};
    std::string left_out;
    for (const std::string& why : outcome.left_out) left_out += (left_out.empty() ? "" : "; ") + why;
    bool all = true;
    for (const control::ListedController& c : bridge_.cell().controllers().list())
      all =
          all && (c.state != LifecycleState::inactive || std::find(on.begin(), on.end(), c.name) == on.end());
    return {{"ok", all}, {"message", left_out.empty() ? "the controllers are switched" : left_out}};
  }

  /// Strictness of a request that states none: that of the controllers file, else the distribution's default.
  std::optional<protocol::Strictness> unsaid_strictness() const {
    if (!bridge_.cell().manager().strictness.empty()) return std::nullopt;  // the cell uses the file's
    const bool strict = bridge_.wire().distribution() == messages::Distribution::kilted;
    return strict ? protocol::Strictness::strict : protocol::Strictness::best_effort;
  }

  static Json json_of(const Yaml& yaml) {
    if (yaml.is_list()) return yaml.texts();
    if (!yaml.is_map()) return yaml.text("");
    Json out = Json::object();
    for (const std::string& key : yaml.keys()) out[key] = json_of(yaml[key]);
    return out;
  }

  /// Adds what a file sets for the node of that name; later keys override earlier ones.
  void add_parameters(const std::string& file, const std::string& name, Json& into) const {
    const Yaml yaml = load_with_repeats(file);
    const std::string whole = bridge_.name(name);
    for (const std::string& key :
         {std::string("/**"), "/**/" + name, "/**" + whole, std::string(name), whole}) {
      const Json found = json_of(yaml[key]["ros__parameters"]);
      if (found.is_object()) into.update(found, true);
    }
  }

  /// Builds the load request from what a spawner has set for the controller: its type, which may also be in
  /// its files, and the parameter files (later files override earlier ones). If no type is known, the cell
  /// looks for the controller in the last file, or in its own file.
  protocol::ControlLoad to_load(const std::string& name) const {
    const auto spawned = [&](const char* key) {
      const auto at = spawned_.find(name + key);
      return at == spawned_.end() ? Json() : at->second;
    };
    protocol::ControlLoad out;
    out.name = name;
    Json parameters = Json::object();
    const Json files = spawned(".params_file");
    for (const Json& file : files) add_parameters(file.get<std::string>(), name, parameters);
    Json type = spawned(".type");
    if (type.is_null() && parameters.contains("type")) type = parameters["type"];
    parameters.erase("type");
    if (!type.is_null()) {
      out.type = type.get<std::string>();
      if (!parameters.empty()) out.parameters.emplace();
      for (const auto& [key, value] : parameters.items()) (*out.parameters)[key] = value;
    } else if (!files.empty()) {
      out.file = files.back().get<std::string>();
    }
    return out;
  }

  /// A spawner sends lists as lists, or as one text: "['/a.yaml', '/b.yaml']" or "/a.yaml".
  static Json texts_of(const Json& value) {
    if (value.is_array()) return value;
    const std::string text = value.get<std::string>();
    if (!text.starts_with('[')) return Json::array({text});
    return Json(Yaml::parse(text, "params_file").texts());
  }

  /// Stores a parameter that a spawner sets before it loads a controller. Returns "" or the reason for a
  /// refusal.
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
      const double rate = 1e9 / static_cast<double>(bridge_.cell().period());
      Json all{
          {"update_rate", entry(static_cast<std::int64_t>(rate + 0.5), "of the control loop, Hz", true)}};
      for (const control::ListedController& c : bridge_.cell().controllers().list())
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
  Json announced_;
  /// `NAME.type`, `NAME.params_file` and similar, as set by a spawner: a text, or a list of texts.
  std::map<std::string, Json> spawned_;
};

}  // namespace

std::unique_ptr<Part> make_manager_node(Bridge& bridge) {
  return std::make_unique<ManagerNode>(bridge);
}

}  // namespace polyarm::ros2
