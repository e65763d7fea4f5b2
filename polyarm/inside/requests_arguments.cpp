/// Resolves names in requests: robots, life-cycle states, controllers.
#include "polyarm/base/text.hpp"
#include "polyarm/inside/requests_work.hpp"

namespace polyarm::cell {

std::size_t robot_named(const CellSetup& setup, const std::optional<std::string>& name) {
  const std::string wanted = name.value_or("");
  std::vector<std::string> names;
  for (std::size_t i = 0; i < setup.robots.size(); ++i) {
    names.push_back(setup.robots[i]->entry.name);
    if (names.back() == wanted) return i;
  }
  if (wanted.empty() && names.size() == 1) return 0;
  if (wanted.empty())
    throw Error("which-robot", "the cell has " + std::to_string(names.size()) + " robots",
                "choose one: " + join(names, ", "));
  throw Error("unknown-robot", "there is no robot '" + wanted + "'" + did_you_mean(wanted, names),
              "there are: " + join(names, ", "));
}

hardware::LifecycleState state_named(const std::string& text) {
  std::vector<std::string> names;
  for (const hardware::LifecycleState state :
       {hardware::LifecycleState::unconfigured, hardware::LifecycleState::inactive,
        hardware::LifecycleState::active, hardware::LifecycleState::finalized}) {
    if (text == hardware::name(state)) return state;
    names.emplace_back(hardware::name(state));
  }
  throw Error("bad-argument", "there is no state '" + text + "'" + did_you_mean(text, names),
              join(names, ", "));
}

}  // namespace polyarm::cell
