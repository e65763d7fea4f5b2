#include "polyarm/hardware/components.hpp"

#include <algorithm>

#include "polyarm/base/error.hpp"
#include "polyarm/hardware/hosted.hpp"
#include "polyarm/hardware/life_cycle.hpp"

namespace polyarm::hardware {

Components::Components(InterfaceTable& table, realtime::Jobs& jobs)
    : hosting_(std::make_unique<Hosting>(table, jobs)) {}
Components::~Components() = default;

std::size_t Components::size() const noexcept {
  return hosting_->all.size();
}
const std::string& Components::component_name(std::size_t i) const {
  return hosting_->all[i]->name;
}
const std::string& Components::group(std::size_t i) const {
  return hosting_->all[i]->options.group;
}
bool Components::contained(std::size_t i) const {
  return hosting_->all[i]->options.contained;
}
bool Components::real(std::size_t i) const {
  return hosting_->all[i]->component->real();
}
bool Components::takes_commands(std::size_t i) const {
  return hosting_->all[i]->commands > 0;
}
LifecycleState Components::state_of(std::size_t i) const {
  return hosting_->all[i]->state.load(std::memory_order_acquire);
}

ForwardMoves* Components::forward_moves(std::size_t i) const {
  auto* const takes = dynamic_cast<TakesMoves*>(hosting_->all[i]->component.get());
  return takes ? takes->forward_moves(kForwardLayout) : nullptr;
}

int Components::find(std::string_view name) const {
  const auto& all = hosting_->all;
  const auto found = std::find_if(all.begin(), all.end(), [&](const auto& one) { return one->name == name; });
  return found == all.end() ? -1 : static_cast<int>(found - all.begin());
}

namespace {
/// Finds the component of an entry; components occupy consecutive ranges of the table.
int owner_of(const std::vector<std::unique_ptr<HostedComponent>>& all, std::size_t index, std::size_t HostedComponent::*first,
             std::size_t HostedComponent::*count) {
  const auto after = std::upper_bound(all.begin(), all.end(), index,
                                      [&](std::size_t at, const auto& one) { return at < (*one).*first; });
  for (auto each = after; each != all.begin();) {  // an empty range starts where the next one does
    const HostedComponent& hosted = **--each;
    if (index < hosted.*first + hosted.*count) return static_cast<int>(each - all.begin());
    if (hosted.*count > 0) break;
  }
  return -1;
}
}  // namespace

int Components::component_of_state(std::size_t index) const {
  return owner_of(hosting_->all, index, &HostedComponent::first_state, &HostedComponent::states);
}
int Components::component_of_command(std::size_t index) const {
  return owner_of(hosting_->all, index, &HostedComponent::first_command, &HostedComponent::commands);
}

namespace {
bool offers(const HostedComponent& hosted, const InterfaceTable& table, std::span<const std::string> commands) {
  return std::any_of(commands.begin(), commands.end(), [&](const std::string& command) {
    const auto index = table.find_command(command);
    return index && *index >= hosted.first_command && *index < hosted.first_command + hosted.commands;
  });
}
}  // namespace

bool Components::prepare_mode_switch(std::span<const std::string> start, std::span<const std::string> stop) {
  for (const auto& hosted : hosting_->all) {
    if (hosted->pending) {
      if (offers(*hosted, hosting_->table, start) || offers(*hosted, hosting_->table, stop))
        require_idle(*hosted);
      continue;
    }
    try {
      if (hosted->component->prepare_command_mode_switch(start, stop) != ReturnType::ok) return false;
    } catch (...) {
      rethrow_as_error("mode-refused", "the hardware component '" + hosted->name +
                                           "', when asked to accept the controller switch,");
    }
  }
  return true;
}

bool Components::perform_mode_switch(std::span<const std::string> start,
                                     std::span<const std::string> stop) noexcept {
  bool all = true;
  for (const auto& hosted : hosting_->all)
    if (!hosted->busy.load(std::memory_order_acquire) &&
        hosted->component->perform_command_mode_switch(start, stop) != ReturnType::ok)
      all = false;
  return all;
}

}  // namespace polyarm::hardware
