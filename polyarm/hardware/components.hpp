#pragma once
/// The components of a loop and the interfaces that they offer, as the controller manager sees them.
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "polyarm/hardware/component.hpp"
#include "polyarm/hardware/forward_moves.hpp"
#include "polyarm/hardware/interface_table.hpp"
#include "polyarm/realtime/jobs.hpp"

namespace polyarm::hardware {

struct Hosting;

/// Components are identified by index, in order of addition. Cell thread unless stated otherwise.
class Components {
 public:
  std::size_t size() const noexcept;
  const std::string& component_name(std::size_t i) const;
  /// Index of the component; -1 if there is no such name.
  int find(std::string_view name) const;
  const std::string& group(std::size_t i) const;
  bool contained(std::size_t i) const;  ///< its faults may be limited to its group
  bool real(std::size_t i) const;
  bool takes_commands(std::size_t i) const;      ///< true if it offers command interfaces
  LifecycleState state_of(std::size_t i) const;  ///< any thread
  ForwardMoves* forward_moves(std::size_t i) const;  ///< null: it takes no moves
  /// Index of the component that offers the interface; -1 if none does.
  int component_of_state(std::size_t index) const;
  int component_of_command(std::size_t index) const;

  /// Checks whether these command interfaces can be started and stopped together. Throws Error("busy") while
  /// a component that offers one of them is in a callback, Error("mode-refused") if a component throws.
  bool prepare_mode_switch(std::span<const std::string> start, std::span<const std::string> stop);
  /// Control thread.
  bool perform_mode_switch(std::span<const std::string> start, std::span<const std::string> stop) noexcept;

 protected:
  Components(InterfaceTable& table, realtime::Jobs& jobs);
  ~Components();
  Components(const Components&) = delete;
  Components& operator=(const Components&) = delete;

  std::unique_ptr<Hosting> hosting_;
};

}  // namespace polyarm::hardware
