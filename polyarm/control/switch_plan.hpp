#pragma once
/// Plans a switch of controllers before anything changes: a pure function of the active controllers and the
/// request, with the reason of a refusal.
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "polyarm/hardware/component.hpp"

namespace polyarm::control {

/// As in controller_manager_msgs/SwitchController. `automatic` also starts the controllers that a chain needs
/// and stops those that depend on stopped ones; `force` also stops controllers that hold a requested
/// interface.
enum class Strictness { best_effort = 1, strict = 2, automatic = 3, force = 4 };

/// The facts of a controller for planning.
struct ControllerView {
  std::string name;
  hardware::LifecycleState state = hardware::LifecycleState::inactive;
  std::vector<std::string> commands, states;      ///< interfaces that it uses, also references of others
  std::vector<std::string> references, exported;  ///< interfaces that it offers to others
};

struct SwitchRequest {
  std::vector<std::string> activate, deactivate;
  Strictness strictness = Strictness::strict;
};

struct SwitchPlan {
  bool ok = true;
  std::string code, reason, advice;    ///< why the switch is refused
  std::vector<std::string> stop;       ///< in order: writers of references before their readers
  std::vector<std::string> start;      ///< in order: readers of references before their writers
  std::vector<std::string> chained;    ///< their references are now written by other controllers
  std::vector<std::string> unchained;  ///< their references are no longer written by others
  std::vector<std::string> start_interfaces, stop_interfaces;  ///< hardware interfaces, for the mode switch
  std::vector<std::string> left_out;  ///< best effort: one sentence per request that was left out
};

/// Why a hardware interface cannot be used now ("its component 'arm' is inactive"); empty if it can be used
/// or belongs to no hardware.
using Unavailable = std::function<std::string(const std::string& interface, bool command)>;

SwitchPlan plan_switch(std::span<const ControllerView> controllers, const SwitchRequest& request,
                       const Unavailable& unavailable);

/// The order of updates: controllers that write references or export states come before their readers;
/// otherwise as given. Throws Error("chain-circle") that names the controllers of a circle.
std::vector<std::size_t> update_order(std::span<const ControllerView> controllers);

/// All controllers connected with `first` through references, among those for which `active` is true,
/// including `first`; in the order in which they must stop.
std::vector<std::size_t> chain_of(std::span<const ControllerView> controllers, std::size_t first,
                                  const std::vector<bool>& active);

}  // namespace polyarm::control
