#pragma once
/// Requests about controllers: list, switch, load, configure and unload them.
#include "polyarm/protocol/facts.hpp"

namespace polyarm::protocol {

/// An input of a controller, and the message types that it accepts.
struct ControllerInput {
  std::string name;
  std::vector<std::string> types;  ///< ROS types
  POLYARM_MEMBERS(ControllerInput, name, types)
};

struct ListedController {
  std::string name, type, state;
  bool chained = false, async = false, stale = false;
  double rate = 0;  ///< updates per second
  std::uint64_t updates = 0, missed = 0;
  std::vector<std::string> claimed, commands, states, references, exported_states, fallback;
  std::vector<ControllerInput> inputs;
  POLYARM_MEMBERS(ListedController, name, type, state, chained, async, stale, rate, updates, missed, claimed,
                  commands, states, references, exported_states, fallback, inputs)
};

struct ControlList {
  static constexpr Facts kFacts{
      .name = "control.list",
      .role = Role::watch,
      .text = "Lists the controllers: state, rate, claimed interfaces, inputs and outputs."};
  using Answer = std::vector<ListedController>;
  POLYARM_MEMBERS(ControlList)
};

struct ControllerTypeText {
  std::string type, text;
  POLYARM_MEMBERS(ControllerTypeText, type, text)
};

struct ControlTypes {
  static constexpr Facts kFacts{
      .name = "control.types", .role = Role::watch, .text = "Lists the controller types that can be loaded."};
  using Answer = std::vector<ControllerTypeText>;
  POLYARM_MEMBERS(ControlTypes)
};

struct ChainLink {
  std::string from, to, reference;
  bool active = false;
  POLYARM_MEMBERS(ChainLink, from, to, reference, active)
};

struct ControlChains {
  static constexpr Facts kFacts{
      .name = "control.chains",
      .role = Role::watch,
      .text = "Lists which controller commands the references of which other controller."};
  using Answer = std::vector<ChainLink>;
  POLYARM_MEMBERS(ControlChains)
};

/// The values of controller_manager_msgs/SwitchController. `best-effort` and `force_auto` are ROS's
/// spellings.
enum class Strictness { strict, best_effort, best_effort_ros, automatic, force, force_ros };
template <>
struct Words<Strictness> {
  static constexpr const char* kNoun = "strictness";
  static constexpr const char* kWords[] = {"strict", "best_effort", "best-effort",
                                           "auto",   "force",       "force_auto"};
};

/// What a controller switch does, or why it does nothing.
struct SwitchOutcome {
  bool ok = false;
  std::string reason, advice;
  std::vector<std::string> start, stop, left_out, chained, unchained;
  POLYARM_MEMBERS(SwitchOutcome, ok, reason, advice, start, stop, left_out, chained, unchained)
};

struct ControlSwitch {
  static constexpr Facts kFacts{
      .name = "control.switch",
      .role = Role::administer,
      .text =
          "Stops and starts controllers in one step between two cycles. `strictness` is strict, "
          "best_effort, auto or force. Its default is the value in the controllers file, else strict. "
          "With `dry` nothing changes: the answer says what would happen.",
      .moves = true,
      .watch_with = "dry"};
  std::optional<Names> activate, deactivate;
  std::optional<Strictness> strictness;
  bool dry = false;
  using Answer = SwitchOutcome;
  POLYARM_MEMBERS(ControlSwitch, activate, deactivate, strictness, dry)
};

struct NameAndState {
  std::string name, state;
  POLYARM_MEMBERS(NameAndState, name, state)
};

struct JustName {
  std::string name;
  POLYARM_MEMBERS(JustName, name)
};

struct ControlLoad {
  static constexpr Facts kFacts{
      .name = "control.load",
      .role = Role::administer,
      .text =
          "Creates and configures a controller. It is defined in the controllers files of the cell, in "
          "`file`, or by `type` and `parameters`."};
  std::string name;
  std::optional<std::string> type, file;
  std::optional<Map> parameters;
  struct Answer {
    static constexpr const char* kOf = "ControlLoad";
    std::string name, state;
    std::vector<std::string> warnings;
    POLYARM_MEMBERS(Answer, name, state, warnings)
  };
  POLYARM_MEMBERS(ControlLoad, name, type, file, parameters)
};

struct ControlConfigure {
  static constexpr Facts kFacts{.name = "control.configure",
                                .role = Role::administer,
                                .text = "Configures a controller: unconfigured → inactive."};
  std::string name;
  using Answer = NameAndState;
  POLYARM_MEMBERS(ControlConfigure, name)
};

struct ControlCleanup {
  static constexpr Facts kFacts{.name = "control.cleanup",
                                .role = Role::administer,
                                .text = "Cleans a controller up: inactive → unconfigured."};
  std::string name;
  using Answer = NameAndState;
  POLYARM_MEMBERS(ControlCleanup, name)
};

struct ControlUnload {
  static constexpr Facts kFacts{
      .name = "control.unload", .role = Role::administer, .text = "Removes a controller that is not active."};
  std::string name;
  using Answer = JustName;
  POLYARM_MEMBERS(ControlUnload, name)
};

struct ControlState {
  static constexpr Facts kFacts{
      .name = "control.state",
      .role = Role::administer,
      .text =
          "Brings a controller to the state unconfigured, inactive or active, through all states in "
          "between.",
      .moves = true};
  std::string name, state;
  struct Answer {
    static constexpr const char* kOf = "ControlState";
    std::string name, state;
    Merged<SwitchOutcome> outcome;  ///< present if controllers were switched
    POLYARM_MEMBERS(Answer, name, state, outcome)
  };
  POLYARM_MEMBERS(ControlState, name, state)
};

}  // namespace polyarm::protocol
