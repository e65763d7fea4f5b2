#include "polyarm/hardware/hardware.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/hardware/hosted.hpp"
#include "polyarm/hardware/life_cycle.hpp"

namespace polyarm::hardware {

Hardware::Hardware(InterfaceTable& table, realtime::Jobs& jobs) : Components(table, jobs) {}

Hardware::~Hardware() {
  shut_down();
}

namespace {
double following_error_of(const Component& component, const ComponentContext& context, double otherwise) {
  const auto stated = context.parameters.find("following_error");
  if (stated == context.parameters.end()) return component.real() ? kRealFollowingError : otherwise;
  const auto value = parse_number(stated->second);
  if (!value || !(*value > 0))
    throw Error("bad-value",
                "following_error of '" + context.name + "' is '" + stated->second + "', not above zero",
                "write how far a joint may be from its command, rad or m");
  return *value;
}
}  // namespace

void Hardware::add(std::unique_ptr<Component> component, const ComponentContext& context,
                   HostOptions options) {
  initialise(*component, context, "the hardware component");
  const std::vector<InterfaceDescription> states =
      offered(context.name, [&] { return component->state_interfaces(); });
  const std::vector<InterfaceDescription> commands =
      offered(context.name, [&] { return component->command_interfaces(); });
  if (component->blocks()) options.async = true;
  InterfaceTable& table = hosting_->table;
  auto hosted = std::make_unique<HostedComponent>();
  hosted->name = context.name;
  hosted->following_error = following_error_of(*component, context, options.following_error);
  hosted->component = std::move(component);
  hosted->divisor = std::max(1u, options.divisor);
  hosted->budget = options.budget;
  hosted->options = std::move(options);
  hosted->first_state = table.states().size();
  for (const InterfaceDescription& d : states) table.add_state(d.name, d.initial);
  hosted->states = table.states().size() - hosted->first_state;
  hosted->first_command = table.commands().size();
  for (const InterfaceDescription& d : commands) table.add_command(d.name);
  hosted->commands = table.commands().size() - hosted->first_command;
  if (hosted->options.async) make_runner(*hosted, context.period);
  auto& all = hosting_->all;
  if (hosted->component->paces()) {
    if (hosting_->pacer >= 0)
      throw Error("two-clocks",
                  "'" + hosted->name + "' and '" + component_name(static_cast<std::size_t>(hosting_->pacer)) +
                      "' both pace the control loop",
                  "run them in two cells: a loop has one clock");
    hosting_->pacer = static_cast<int>(all.size());
  }
  all.push_back(std::move(hosted));
  hosting_->restarted.reserve(all.capacity());
  hosting_->off.reserve(all.capacity());
}

void Hardware::make_runner(HostedComponent& hosted, Nanoseconds loop_period) {
  const auto states = hosting_->table.states().subspan(hosted.first_state, hosted.states);
  if (hosted.options.period > 0) {
    hosted.divisor = 1;
    hosted.own_clock =
        std::make_unique<OwnClock>(hosted.component, states, hosted.commands, hosted.options.period,
                                   hosted.options.lock_step, hosted.options.thread);
    return;
  }
  hosted.own_states.assign(states.begin(), states.end());
  hosted.own_commands.assign(hosted.commands, std::numeric_limits<double>::quiet_NaN());
  HostedComponent* own = &hosted;
  hosted.runner = std::make_unique<realtime::AsyncRunner>(
      [own] {
        const auto clock = [own] {
          return own->options.lock_step ? own->own_cycle.time : realtime::monotonic_now();
        };
        own->own_exchanged.began = clock();
        ReturnType result = own->component->write(own->own_cycle, own->own_commands);
        if (result == ReturnType::ok) result = own->component->read(own->own_cycle, own->own_states);
        own->own_exchanged.ended = clock();
        own->own_result.store(result, std::memory_order_release);
        own->ran.store(true, std::memory_order_release);
      },
      hosted.options.lock_step, hosted.options.thread, loop_period * hosted.divisor);
}

void Hardware::force(const std::string& interface_name, double value) {
  const InterfaceTable& table = hosting_->table;
  const auto state = table.find_state(interface_name);
  const auto command = table.find_command(interface_name);
  if (!state && !command) {
    std::vector<std::string> names = table.state_names();
    names.insert(names.end(), table.command_names().begin(), table.command_names().end());
    throw Error("unknown-interface",
                "there is no interface '" + interface_name + "'" + did_you_mean(interface_name, names),
                "interfaces are named robot/joint/interface, for example arm/tool/vacuum");
  }
  std::erase_if(hosting_->forced, [&](const ForcedValue& forced) {
    return forced.state ? state && *state == forced.index : command && *command == forced.index;
  });
  if (std::isnan(value)) return;
  if (state) hosting_->forced.push_back({true, *state, value});
  if (command) hosting_->forced.push_back({false, *command, value});
}

}  // namespace polyarm::hardware
