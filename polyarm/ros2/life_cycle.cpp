#include "polyarm/ros2/life_cycle.hpp"

#include <array>

#include "polyarm/messages/json.hpp"
#include "polyarm/messages/types.hpp"
#include "polyarm/protocol/controllers.hpp"

namespace polyarm::ros2 {

namespace {

using StateId = messages::lifecycle_msgs::msg::State;
using Id = messages::lifecycle_msgs::msg::Transition;

struct State {
  int id;
  const char* label;
};
constexpr std::array<State, 11> kStates{{{StateId::PRIMARY_STATE_UNKNOWN, "unknown"},
                                         {StateId::PRIMARY_STATE_UNCONFIGURED, "unconfigured"},
                                         {StateId::PRIMARY_STATE_INACTIVE, "inactive"},
                                         {StateId::PRIMARY_STATE_ACTIVE, "active"},
                                         {StateId::PRIMARY_STATE_FINALIZED, "finalized"},
                                         {StateId::TRANSITION_STATE_CONFIGURING, "configuring"},
                                         {StateId::TRANSITION_STATE_CLEANINGUP, "cleaningup"},
                                         {StateId::TRANSITION_STATE_SHUTTINGDOWN, "shuttingdown"},
                                         {StateId::TRANSITION_STATE_ACTIVATING, "activating"},
                                         {StateId::TRANSITION_STATE_DEACTIVATING, "deactivating"},
                                         {StateId::TRANSITION_STATE_ERRORPROCESSING, "errorprocessing"}}};

/// A client requests a transition from a primary state; the transitions after it follow automatically.
struct Transition {
  int id;
  const char* label;
  const char* from;
  const char* to;
};
constexpr const char *kSuccess = "transition_success", *kFailure = "transition_failure",
                     *kError = "transition_error";
/// Shutdown of a controller is not offered; use `cleanup` and `unload_controller`.
constexpr std::array<Transition, 16> kTransitions{
    {{Id::TRANSITION_CONFIGURE, "configure", "unconfigured", "configuring"},
     {Id::TRANSITION_ON_CONFIGURE_SUCCESS, kSuccess, "configuring", "inactive"},
     {Id::TRANSITION_ON_CONFIGURE_FAILURE, kFailure, "configuring", "unconfigured"},
     {Id::TRANSITION_ON_CONFIGURE_ERROR, kError, "configuring", "errorprocessing"},
     {Id::TRANSITION_CLEANUP, "cleanup", "inactive", "cleaningup"},
     {Id::TRANSITION_ON_CLEANUP_SUCCESS, kSuccess, "cleaningup", "unconfigured"},
     {Id::TRANSITION_ON_CLEANUP_FAILURE, kFailure, "cleaningup", "inactive"},
     {Id::TRANSITION_ON_CLEANUP_ERROR, kError, "cleaningup", "errorprocessing"},
     {Id::TRANSITION_ACTIVATE, "activate", "inactive", "activating"},
     {Id::TRANSITION_ON_ACTIVATE_SUCCESS, kSuccess, "activating", "active"},
     {Id::TRANSITION_ON_ACTIVATE_FAILURE, kFailure, "activating", "inactive"},
     {Id::TRANSITION_ON_ACTIVATE_ERROR, kError, "activating", "errorprocessing"},
     {Id::TRANSITION_DEACTIVATE, "deactivate", "active", "deactivating"},
     {Id::TRANSITION_ON_DEACTIVATE_SUCCESS, kSuccess, "deactivating", "inactive"},
     {Id::TRANSITION_ON_DEACTIVATE_FAILURE, kFailure, "deactivating", "active"},
     {Id::TRANSITION_ON_DEACTIVATE_ERROR, kError, "deactivating", "errorprocessing"}}};

/// The success transition after a requested one; null if there is none.
const Transition* success_after(const Transition& asked) {
  for (const Transition& t : kTransitions)
    if (t.label == kSuccess && std::string_view(t.from) == asked.to) return &t;
  return nullptr;
}

std::string state_of(cell::CellView& cell, const std::string& controller) {
  for (const control::ListedController& c : cell.controllers().list())
    if (c.name == controller) return hardware::name(c.state);
  return "unknown";
}

/// A transition that can be requested, found by label or, if the label is empty, by id.
const Transition* transition_of(const Json& asked) {
  const int id = asked.value("id", 0);
  const std::string label = asked.value("label", std::string());
  for (const Transition& t : kTransitions)
    if (success_after(t) && (label == t.label || (label.empty() && id == t.id))) return &t;
  return nullptr;
}

Json transition_json(const Transition& t) {
  return {{"transition", {{"id", t.id}, {"label", t.label}}},
          {"start_state", state_json(t.from)},
          {"goal_state", state_json(t.to)}};
}

/// The transitions from a state, or all.
Json transitions(const std::string& from = {}) {
  Json out = Json::array();
  for (const Transition& t : kTransitions)
    if (from.empty() || from == t.from) out.push_back(transition_json(t));
  return out;
}

}  // namespace

Json state_json(const std::string& label) {
  for (const State& state : kStates)
    if (label == state.label) return {{"id", state.id}, {"label", state.label}};
  return {{"id", 0}, {"label", "unknown"}};
}

std::string state_label(const Json& state) {
  const int id = state.value("id", 0);
  const std::string label = state.value("label", std::string());
  for (const State& known : kStates)
    if (known.id != 0 && (id == known.id || (id == 0 && label == known.label))) return known.label;
  return "";
}

LifeCycle::LifeCycle(Bridge& bridge, std::string node, std::string controller)
    : bridge_{bridge}, node_{std::move(node)}, controller_{std::move(controller)} {
  const auto& event = messages::type_info<messages::lifecycle_msgs::msg::TransitionEvent>();
  events_ = bridge.wire().publisher(node_, node_ + "/transition_event", event);
  const std::string types = "lifecycle_msgs/srv/";
  const auto serve = [&](const char* name, const char* type, std::function<Json(Bridge&)> answer) {
    bridge.service(
        node_, node_ + "/" + name, types + type,
        [&bridge, answer = std::move(answer)](const Json&, const Reply& reply) { reply(answer(bridge)); });
  };
  serve("get_state", "GetState", [name = controller_](Bridge& b) {
    return Json{{"current_state", state_json(state_of(b.cell(), name))}};
  });
  serve("get_available_states", "GetAvailableStates", [](Bridge&) {
    Json states = Json::array();
    for (const State& state : kStates) states.push_back({{"id", state.id}, {"label", state.label}});
    return Json{{"available_states", states}};
  });
  serve("get_available_transitions", "GetAvailableTransitions", [name = controller_](Bridge& b) {
    return Json{{"available_transitions", transitions(state_of(b.cell(), name))}};
  });
  serve("get_transition_graph", "GetAvailableTransitions", [](Bridge&) {
    return Json{{"available_transitions", transitions()}};
  });
  bridge.service(node_, node_ + "/change_state", types + "ChangeState",
                 [&bridge, name = controller_](const Json& request, Reply reply) {
                   const Transition* wanted = transition_of(request["transition"]);
                   if (!wanted || state_of(bridge.cell(), name) != wanted->from)
                     return reply({{"success", false}});
                   bridge.ask(protocol::ControlState{name, success_after(*wanted)->to},
                              [reply](const protocol::Reply& replied) {
                                reply({{"success", replied.answer.has_value()}});
                              });
                 });
}

void LifeCycle::look(const std::string& state) {
  const std::string before = std::exchange(state_, state);
  if (before.empty() || before == state || !bridge_.wire().wanted(events_)) return;
  for (const Transition& t : kTransitions)
    if (const Transition* then = success_after(t); then && before == t.from && state == then->to)
      for (const Transition* each : {&t, then}) tell(transition_json(*each));
}

void LifeCycle::tell(Json event) {
  event["timestamp"] = bridge_.ros_time(bridge_.cell().now());
  const auto& type = messages::type_info<messages::lifecycle_msgs::msg::TransitionEvent>();
  bridge_.wire().publish(events_, messages::from_json(type, event));
}

}  // namespace polyarm::ros2
