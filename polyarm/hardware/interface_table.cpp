#include "polyarm/hardware/interface_table.hpp"

#include <limits>

#include "polyarm/base/error.hpp"

namespace polyarm::hardware {

namespace {
std::size_t insert(std::unordered_map<std::string, std::size_t>& index, std::vector<std::string>& names,
                   std::string name, const char* kind) {
  const std::size_t at = names.size();
  if (!index.emplace(name, at).second)
    throw Error("duplicate-interface",
                std::string("the ") + kind + " interface '" + name + "' exists already",
                "give one of the two components or joints another name");
  names.push_back(std::move(name));
  return at;
}
std::optional<std::size_t> look_up(const std::unordered_map<std::string, std::size_t>& index,
                                   std::string_view name) {
  const auto found = index.find(std::string(name));
  if (found == index.end()) return std::nullopt;
  return found->second;
}
}  // namespace

std::size_t InterfaceTable::add_state(std::string name, double initial) {
  const std::size_t at = insert(state_index_, state_names_, std::move(name), "state");
  states_.push_back(initial);
  return at;
}

std::size_t InterfaceTable::add_command(std::string name) {
  const std::size_t at = insert(command_index_, command_names_, std::move(name), "command");
  commands_.push_back(std::numeric_limits<double>::quiet_NaN());
  claims_.push_back(-1);
  return at;
}

std::optional<std::size_t> InterfaceTable::find_state(std::string_view name) const {
  return look_up(state_index_, name);
}
std::optional<std::size_t> InterfaceTable::find_command(std::string_view name) const {
  return look_up(command_index_, name);
}

}  // namespace polyarm::hardware
