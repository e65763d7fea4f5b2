#pragma once
/// All components of one control loop: their life cycle, their places in the interface table, and one call
/// each to read and to write them all.
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "polyarm/hardware/component.hpp"
#include "polyarm/hardware/interface_table.hpp"

namespace polyarm::hardware {

enum class FaultKind : std::uint8_t {
  none,
  component_read,
  component_write,
  component_deactivated,
  bad_state
};

/// What went wrong in a cycle, as numbers; texts are made outside the loop.
struct Fault {
  FaultKind kind = FaultKind::none;
  std::int32_t component = -1;  ///< index of the component
  explicit operator bool() const noexcept { return kind != FaultKind::none; }
};

/// A value that a test of a fault forces onto an interface, over whatever hardware or controllers say.
struct ForcedValue {
  bool state = false;  ///< else command
  std::size_t index = 0;
  double value = 0;
};

/// Building and life cycle: one thread, before the loop runs or with the loop stopped. read() and write():
/// the control thread.
class Hardware {
 public:
  explicit Hardware(InterfaceTable& table) : table_(table) {}
  ~Hardware();

  /// Initialises the component and enters its interfaces into the table. Throws Error when it refuses.
  void add(std::unique_ptr<Component> component, const ComponentContext& context);
  /// unconfigured → inactive → active, in order of addition. Throws Error that names component and step.
  void configure_and_activate();
  /// active → inactive → finalized, in reverse order. Never throws.
  void shut_down() noexcept;

  /// Forces every state and command interface with this name. Throws Error("unknown-interface") if there is
  /// none.
  void force(const std::string& interface_name, double value);

  Fault read(const Cycle& cycle) noexcept;
  Fault write(const Cycle& cycle) noexcept;
  bool perform_mode_switch(std::span<const std::string> start, std::span<const std::string> stop);

  /// The first simulated world among the components, or null.
  const WorldState* world() const noexcept { return world_; }
  const std::vector<std::string>& world_names() const { return world_names_; }
  std::size_t size() const { return hosted_.size(); }
  const std::string& component_name(std::size_t i) const { return hosted_[i].name; }
  LifecycleState state_of(std::size_t i) const { return hosted_[i].state; }
  std::vector<std::string> summaries() const;

 private:
  struct Hosted {
    std::string name;
    std::unique_ptr<Component> component;
    LifecycleState state = LifecycleState::unconfigured;
    std::size_t first_state = 0, states = 0, first_command = 0, commands = 0;
  };
  void advance(Hosted& hosted, CallbackReturn (Component::*step)(), LifecycleState to, const char* step_name);

  InterfaceTable& table_;
  std::vector<Hosted> hosted_;
  std::vector<ForcedValue> forced_;
  const WorldState* world_ = nullptr;
  std::vector<std::string> world_names_;
};

}  // namespace polyarm::hardware
