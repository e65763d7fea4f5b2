#pragma once
/// What a switch of controllers does, worked out before anything is touched: a pure function of who is active
/// and who wants what, with its reason where it refuses.
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "polyarm/hardware/component.hpp"

namespace polyarm::control {

/// As controller_manager_msgs/SwitchController has them. `automatic` also starts the controllers that a chain
/// needs and stops those that hang on what is stopped; `force` also stops whoever holds an interface.
enum class Strictness { best_effort = 1, strict = 2, automatic = 3, force = 4 };

/// A controller as planning sees it.
struct ControllerView {
  std::string name;
  hardware::LifecycleState state = hardware::LifecycleState::inactive;
  std::vector<std::string> commands, states;      ///< what it claims, references of others among them
  std::vector<std::string> references, exported;  ///< what it offers to others
};

struct SwitchRequest {
  std::vector<std::string> activate, deactivate;
  Strictness strictness = Strictness::strict;
};

struct SwitchPlan {
  bool ok = true;
  std::string code, reason, advice;    ///< why not
  std::vector<std::string> stop;       ///< in order: who writes references before who reads them
  std::vector<std::string> start;      ///< in order: who reads references before who writes them
  std::vector<std::string> chained;    ///< their references are written by others from now on
  std::vector<std::string> unchained;  ///< and no more
  std::vector<std::string> start_interfaces, stop_interfaces;  ///< of hardware, for the mode switch
  std::vector<std::string> left_out;  ///< best effort: one sentence for each that was not done
};

/// Why a command or state interface of hardware cannot be used now ("its component 'arm' is inactive"); empty
/// where it can, or where it is no interface of hardware.
using Unavailable = std::function<std::string(const std::string& interface, bool command)>;

SwitchPlan plan_switch(std::span<const ControllerView> controllers, const SwitchRequest& request,
                       const Unavailable& unavailable);

/// The order of updates: whoever writes references or exports states before whoever reads them, else as
/// given. Throws Error("chain-circle") that names the controllers of a circle.
std::vector<std::size_t> update_order(std::span<const ControllerView> controllers);

/// All controllers that hang together with `first` through references among those for which `active` is true,
/// `first` among them; in the order in which they have to stop.
std::vector<std::size_t> chain_of(std::span<const ControllerView> controllers, std::size_t first,
                                  const std::vector<bool>& active);

}  // namespace polyarm::control
