#include "polyarm/hardware/interface_table.hpp"

#include <algorithm>
#include <limits>

#include "polyarm/base/error.hpp"

namespace polyarm::hardware {

namespace {
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
}

std::size_t InterfaceTable::add(Side& side, std::string name, double initial, const char* kind) {
  if (side.index.contains(name))
    throw Error("duplicate-interface",
                std::string("the ") + kind + " interface '" + name + "' exists already",
                "give one of the two components or joints another name");
  std::size_t at = side.names.size();
  if (!sealed_) {
    side.names.push_back(name);
    side.values.push_back(initial);
    ++side.built;
  } else if (!side.free.empty()) {
    at = side.free.back();
    side.free.pop_back();
    side.names[at] = name;
  } else {
    throw Error("table-full",
                "the running cell has no room for another interface; '" + name + "' cannot be added",
                "put the controller into the controllers file and start the cell again");
  }
  side.index.emplace(std::move(name), at);
  side.live = std::max(side.live.load(), at + 1);
  ++changes_;
  return at;
}

void InterfaceTable::remove(Side& side, std::string_view name) {
  const auto found = side.index.find(name);
  if (found == side.index.end()) return;
  side.names[found->second].clear();
  side.free.push_back(found->second);
  side.index.erase(found);
  ++changes_;
}

void InterfaceTable::seal(Side& side) {
  for (std::size_t i = kSpare; i-- > 0;) side.free.push_back(side.names.size() + i);
  side.names.resize(side.names.size() + kSpare);
  side.values.resize(side.values.size() + kSpare, kNone);
  ++changes_;
}

std::size_t InterfaceTable::add_state(std::string name, double initial) {
  return add(state_, std::move(name), initial, "state");
}
std::size_t InterfaceTable::add_command(std::string name) {
  return add(command_, std::move(name), kNone, "command");
}
void InterfaceTable::remove_state(std::string_view name) {
  remove(state_, name);
}
void InterfaceTable::remove_command(std::string_view name) {
  remove(command_, name);
}

void InterfaceTable::seal() {
  if (sealed_) return;
  sealed_ = true;
  seal(state_);
  seal(command_);
}

std::optional<std::size_t> InterfaceTable::find(const Side& side, std::string_view name) {
  const auto found = side.index.find(name);
  if (found == side.index.end()) return std::nullopt;
  return found->second;
}

std::optional<std::size_t> InterfaceTable::find_state(std::string_view name) const {
  return find(state_, name);
}
std::optional<std::size_t> InterfaceTable::find_command(std::string_view name) const {
  return find(command_, name);
}

}  // namespace polyarm::hardware
