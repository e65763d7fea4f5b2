#include "polyarm/ros2/life_cycle.hpp"

#include <array>

namespace polyarm::ros2 {

namespace {

struct State {
  int id;
  const char* label;
};
constexpr std::array<State, 5> kStates{
    {{0, "unknown"}, {1, "unconfigured"}, {2, "inactive"}, {3, "active"}, {4, "finalized"}}};

/// The transitions that a person may ask for, and the request that does it.
struct Transition {
  int id;
  const char* label;
  const char* from;
  const char* to;
};
constexpr std::array<Transition, 4> kTransitions{{{1, "configure", "unconfigured", "inactive"},
                                                  {2, "cleanup", "inactive", "unconfigured"},
                                                  {3, "activate", "inactive", "active"},
                                                  {4, "deactivate", "active", "inactive"}}};

std::string state_of(cell::Cell& cell, const std::string& controller) {
  for (const control::ListedController& c : cell.loop().controllers().list())
    if (c.name == controller) return hardware::name(c.state);
  return "unknown";
}

const Transition* transition_of(const Json& asked) {
  const int id = asked.value("id", 0);
  const std::string label = asked.value("label", std::string());
  for (const Transition& t : kTransitions)
    if (label == t.label || (label.empty() && id == t.id)) return &t;
  return nullptr;
}

Json transitions_from(const std::string& state) {
  Json out = Json::array();
  for (const Transition& t : kTransitions)
    if (state == t.from)
      out.push_back({{"transition", {{"id", t.id}, {"label", t.label}}},
                     {"start_state", state_json(t.from)},
                     {"goal_state", state_json(t.to)}});
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

void offer_life_cycle(Bridge& bridge, const std::string& node, const std::string& controller) {
  const std::string types = "lifecycle_msgs/srv/";
  bridge.service(node, node + "/get_state", types + "GetState",
                 [&bridge, controller](const Json&, Reply reply) {
                   reply({{"current_state", state_json(state_of(bridge.cell(), controller))}});
                 });
  bridge.service(node, node + "/get_available_states", types + "GetAvailableStates",
                 [](const Json&, Reply reply) {
                   Json states = Json::array();
                   for (const State& state : kStates)
                     states.push_back({{"id", state.id}, {"label", state.label}});
                   reply({{"available_states", states}});
                 });
  bridge.service(node, node + "/get_available_transitions", types + "GetAvailableTransitions",
                 [&bridge, controller](const Json&, Reply reply) {
                   reply({{"available_transitions", transitions_from(state_of(bridge.cell(), controller))}});
                 });
  bridge.service(node, node + "/change_state", types + "ChangeState",
                 [&bridge, controller](const Json& request, Reply reply) {
                   const Transition* wanted = transition_of(request["transition"]);
                   if (!wanted || state_of(bridge.cell(), controller) != wanted->from)
                     return reply({{"success", false}});
                   bridge.ask({{"request", "control.state"}, {"name", controller}, {"state", wanted->to}},
                              [reply](const Json& answer) {
                                reply({{"success", answer.value("ok", false)}});
                              });
                 });
}

}  // namespace polyarm::ros2
