#pragma once
/// Every number that hardware and controllers exchange, with its name. Built once, then of fixed size.
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace polyarm::hardware {

/// One contiguous array of doubles for states, one for commands, one full name for each entry. Names become
/// indices when a controller is configured; in a cycle there are only indices. Building: any one thread;
/// values: the control thread alone. Addresses of values are stable once the table is built.
class InterfaceTable {
 public:
  /// Adds an entry; throws Error("duplicate-interface") when the name is taken. Returns its index.
  std::size_t add_state(std::string name, double initial);
  std::size_t add_command(std::string name);

  std::optional<std::size_t> find_state(std::string_view name) const;
  std::optional<std::size_t> find_command(std::string_view name) const;
  const std::vector<std::string>& state_names() const { return state_names_; }
  const std::vector<std::string>& command_names() const { return command_names_; }

  std::span<double> states() noexcept { return states_; }
  std::span<const double> states() const noexcept { return states_; }
  std::span<double> commands() noexcept { return commands_; }
  std::span<const double> commands() const noexcept { return commands_; }

  /// Exclusive claims: the id of the controller that holds each command, -1 for none.
  std::vector<int>& claims() noexcept { return claims_; }

 private:
  std::vector<double> states_, commands_;
  std::vector<std::string> state_names_, command_names_;
  std::vector<int> claims_;
  std::unordered_map<std::string, std::size_t> state_index_, command_index_;
};

}  // namespace polyarm::hardware
