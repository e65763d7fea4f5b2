#include "polyarm/requests/controller_switch.hpp"

#include <memory>

namespace polyarm::cell {

Poll<control::SwitchPlan> switch_controllers(Machine& machine, control::SwitchRequest request) {
  using Switched = Progress<control::SwitchPlan>;
  auto under_way = std::make_shared<ControllerSwitch>(machine, std::move(request));
  return [under_way] { return under_way->advance() ? Switched::done(under_way->plan()) : Switched{}; };
}

}  // namespace polyarm::cell
