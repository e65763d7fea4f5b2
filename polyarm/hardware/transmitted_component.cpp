#include "polyarm/hardware/transmitted_component.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::hardware {

using description::ComponentInfo;
using description::InterfaceInfo;

namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

InterfaceInfo* find(std::vector<InterfaceInfo>& interfaces, const std::string& name) {
  for (InterfaceInfo& i : interfaces)
    if (i.name == name) return &i;
  return nullptr;
}

/// Adds the transmitted interfaces of `other` that `mine` lacks.
void unite(std::vector<InterfaceInfo>& mine, const std::vector<InterfaceInfo>& other) {
  for (const InterfaceInfo& i : other)
    if (quantity_of(i.name) && !find(mine, i.name)) mine.push_back(i);
}

double start_position(const RobotInstance& robot, const std::string& joint) {
  const std::vector<std::string> names = robot.model->joint_names();
  const auto found = std::find(names.begin(), names.end(), joint);
  const auto j = static_cast<std::size_t>(found - names.begin());
  return found != names.end() && j < robot.initial_positions.size() ? robot.initial_positions[j] : 0;
}

/// Converts the joints' initial values to actuators. Limits stay with the joints.
void start_values(const Transmission& transmission, const RobotInstance& robot,
                  const std::vector<ComponentInfo>& joints, std::vector<ComponentInfo>& actuators) {
  for (ComponentInfo& actuator : actuators)
    for (auto* interfaces : {&actuator.state_interfaces, &actuator.command_interfaces})
      for (InterfaceInfo& i : *interfaces) {
        const auto quantity = quantity_of(i.name);
        if (!quantity) continue;
        std::array<double, 2> from{}, to{};
        for (std::size_t k = 0; k < joints.size(); ++k) {
          from[k] = *quantity == Quantity::position ? start_position(robot, joints[k].name) : 0;
          for (const InterfaceInfo& stated : joints[k].state_interfaces)
            if (stated.name == i.name && stated.initial_value) from[k] = *stated.initial_value;
        }
        transmission.to_actuators(*quantity, from, to);
        i.initial_value = to[static_cast<std::size_t>(&actuator - actuators.data())];
        i.min = i.max = std::nullopt;
      }
}

}  // namespace

void TransmittedComponent::drive(RobotInstance& robot, description::HardwareInfo& block) {
  for (const description::TransmissionInfo& info : block.transmissions) {
    Transmission transmission(info);
    std::vector<ComponentInfo> joints, actuators;
    for (std::size_t k = 0; k < transmission.size(); ++k) {
      const auto at = std::find_if(block.components.begin(), block.components.end(), [&](const auto& c) {
        return c.kind == "joint" && c.name == transmission.joints()[k];
      });
      if (at == block.components.end())
        throw Error(Problem{"unknown-joint", info.where,
                            "the transmission '" + info.name + "' drives '" + transmission.joints()[k] +
                                "', which is not a joint of '" + block.name + "'",
                            "name one of its joints, or take the transmission out"});
      joints.push_back(*at);
      actuators.push_back(*at);
      actuators.back().name = transmission.actuators()[k];
      block.components.erase(at);
    }
    if (joints.size() == 2) {
      for (std::size_t k = 0; k < 2; ++k)
        for (InterfaceInfo& c : joints[k].command_interfaces)
          if (quantity_of(c.name) && !find(joints[1 - k].command_interfaces, c.name))
            throw Error(Problem{"bad-transmission", c.where.line ? c.where : info.where,
                                "'" + joints[k].name + "' has the command interface '" + c.name + "' and '" +
                                    joints[1 - k].name + "', which is driven with it, has not",
                                "give both joints of '" + info.name + "' the same command interfaces"});
      for (std::size_t k = 0; k < 2; ++k)
        unite(actuators[k].state_interfaces, joints[1 - k].state_interfaces);
    }
    start_values(transmission, robot, joints, actuators);
    driven_.push_back({robot.name, std::move(transmission), joints_.size()});
    joints_.insert(joints_.end(), joints.begin(), joints.end());
    block.components.insert(block.components.end(), actuators.begin(), actuators.end());
  }
  block.transmissions.clear();
}

void TransmittedComponent::connect(Side& side) {
  const bool commands = &side == &commands_;
  struct End {
    std::size_t driven, k;
  };
  std::map<std::string, End> ends;  // "arm/motor_1"
  for (std::size_t d = 0; d < driven_.size(); ++d)
    for (std::size_t k = 0; k < driven_[d].transmission.size(); ++k)
      ends[driven_[d].robot + "/" + driven_[d].transmission.actuators()[k]] = {d, k};
  std::map<std::pair<std::size_t, std::string>, Link> links;
  for (std::size_t i = 0; i < side.inside.size(); ++i) {
    const std::string& name = side.inside[i].name;
    const std::size_t slash = name.rfind('/');
    const auto end = ends.find(name.substr(0, slash));
    if (end == ends.end()) {
      side.passes.push_back({i, side.outside.size()});
      side.outside.push_back(side.inside[i]);
      continue;
    }
    const auto [d, k] = end->second;
    const std::string interface = name.substr(slash + 1);
    const auto quantity = quantity_of(interface);
    if (!quantity) {
      side.passes.push_back({i, side.outside.size()});
      side.outside.push_back(side.inside[i]);
      side.outside.back().name =
          driven_[d].robot + "/" + driven_[d].transmission.joints()[k] + "/" + interface;
      continue;
    }
    Link& link = links.try_emplace({d, interface}, Link{d, *quantity, {}, {-1, -1}, {-1, -1}}).first->second;
    link.inside[k] = i;
  }
  for (auto& [key, link] : links) {
    const Driven& driven = driven_[key.first];
    std::array<double, 2> from{}, to{};
    for (std::size_t k = 0; k < driven.transmission.size(); ++k)
      from[k] = side.inside[link.inside[k]].initial;
    driven.transmission.to_joints(link.quantity, from, to);
    for (std::size_t k = 0; k < driven.transmission.size(); ++k) {
      ComponentInfo& joint = joints_[driven.first_joint + k];
      if (!find(commands ? joint.command_interfaces : joint.state_interfaces, key.second)) continue;
      const std::string name = driven.robot + "/" + joint.name + "/" + key.second;
      link.outside[k] = static_cast<int>(side.outside.size());
      side.outside.push_back({name, commands ? kUnknown : to[k]});
      for (std::size_t s = 0; commands && s < states_.outside.size(); ++s)
        if (states_.outside[s].name == name) link.measured[k] = static_cast<int>(s);
    }
    side.links.push_back(link);
  }
  side.values.assign(side.inside.size(), kUnknown);
  for (std::size_t i = 0; i < side.inside.size(); ++i) side.values[i] = side.inside[i].initial;
  side.reaches.resize(side.outside.size());
  for (const Pass& pass : side.passes) side.reaches[pass.outside] = {static_cast<int>(pass.inside)};
  for (const Link& link : side.links)
    for (std::size_t k = 0; k < driven_[link.transmission].transmission.size(); ++k)
      if (link.outside[k] >= 0)
        for (std::size_t m = 0; m < driven_[link.transmission].transmission.size(); ++m)
          side.reaches[static_cast<std::size_t>(link.outside[k])].push_back(static_cast<int>(link.inside[m]));
}

CallbackReturn TransmittedComponent::on_init(const ComponentContext& context) {
  ComponentContext told = context;
  for (RobotInstance& robot : told.robots)
    for (description::HardwareInfo& block : robot.hardware) drive(robot, block);
  const CallbackReturn result = inside_->on_init(told);
  if (result != CallbackReturn::success) return result;
  states_.inside = inside_->state_interfaces();
  commands_.inside = inside_->command_interfaces();
  connect(states_);
  connect(commands_);
  measured_.assign(states_.outside.size(), kUnknown);
  std::size_t longest = 0;
  for (const InterfaceDescription& d : commands_.inside) longest = std::max(longest, d.name.size());
  for (auto* names : {&start_names_, &stop_names_}) {
    names->resize(commands_.inside.size());
    for (std::string& name : *names) name.reserve(longest + 1);
  }
  return result;
}

/// Translates command names to names inside, each once, into strings with reserved capacity.
std::size_t TransmittedComponent::translate(const Side& side, std::span<const std::string> names,
                                            std::vector<std::string>& scratch) const noexcept {
  std::size_t count = 0;
  for (const std::string& name : names)
    for (std::size_t o = 0; o < side.outside.size(); ++o) {
      if (side.outside[o].name != name) continue;
      for (const int inside : side.reaches[o]) {
        const std::string& reached = side.inside[static_cast<std::size_t>(inside)].name;
        const auto end = scratch.begin() + static_cast<std::ptrdiff_t>(count);
        if (count < scratch.size() && std::find(scratch.begin(), end, reached) == end)
          scratch[count++] = reached;
      }
    }
  return count;
}

ReturnType TransmittedComponent::prepare_command_mode_switch(std::span<const std::string> start,
                                                             std::span<const std::string> stop) {
  std::vector<std::string> starting(commands_.inside.size()), stopping(commands_.inside.size());
  starting.resize(translate(commands_, start, starting));
  stopping.resize(translate(commands_, stop, stopping));
  return inside_->prepare_command_mode_switch(starting, stopping);
}

ReturnType TransmittedComponent::perform_command_mode_switch(std::span<const std::string> start,
                                                             std::span<const std::string> stop) noexcept {
  const std::size_t starting = translate(commands_, start, start_names_);
  const std::size_t stopping = translate(commands_, stop, stop_names_);
  return inside_->perform_command_mode_switch(std::span(start_names_).first(starting),
                                              std::span(stop_names_).first(stopping));
}

ReturnType TransmittedComponent::read(const Cycle& cycle, std::span<double> states) noexcept {
  const ReturnType result = inside_->read(cycle, states_.values);
  for (const Pass& pass : states_.passes) states[pass.outside] = states_.values[pass.inside];
  for (const Link& link : states_.links) {
    const Transmission& transmission = driven_[link.transmission].transmission;
    std::array<double, 2> from{}, to{};
    for (std::size_t k = 0; k < transmission.size(); ++k) from[k] = states_.values[link.inside[k]];
    transmission.to_joints(link.quantity, from, to);
    for (std::size_t k = 0; k < transmission.size(); ++k)
      if (link.outside[k] >= 0) states[static_cast<std::size_t>(link.outside[k])] = to[k];
  }
  std::copy(states.begin(), states.end(), measured_.begin());
  return result;
}

ReturnType TransmittedComponent::write(const Cycle& cycle, std::span<const double> commands) noexcept {
  for (const Pass& pass : commands_.passes) commands_.values[pass.inside] = commands[pass.outside];
  for (const Link& link : commands_.links) {
    const Transmission& transmission = driven_[link.transmission].transmission;
    std::array<double, 2> from{kUnknown, kUnknown}, to{};
    bool any = false;
    for (std::size_t k = 0; k < transmission.size(); ++k) {
      if (link.outside[k] >= 0) from[k] = commands[static_cast<std::size_t>(link.outside[k])];
      any = any || std::isfinite(from[k]);
    }
    for (std::size_t k = 0; any && k < transmission.size(); ++k)
      if (std::isnan(from[k])) {
        from[k] = link.quantity == Quantity::position ? kUnknown : 0;
        if (link.quantity == Quantity::position && link.measured[k] >= 0)
          from[k] = measured_[static_cast<std::size_t>(link.measured[k])];
      }
    transmission.to_actuators(link.quantity, from, to);
    for (std::size_t k = 0; k < transmission.size(); ++k) commands_.values[link.inside[k]] = to[k];
  }
  return inside_->write(cycle, commands_.values);
}

std::string TransmittedComponent::summary() const {
  std::vector<std::string> names;
  for (const Driven& driven : driven_) names.push_back(driven.transmission.name());
  const std::string own = "joints through the transmissions " + join(names, ", ");
  const std::string inner = inside_->summary();
  return inner.empty() ? own : inner + "; " + own;
}

std::unique_ptr<Component> through_transmissions(std::unique_ptr<Component> component,
                                                 const ComponentContext& context) {
  for (const RobotInstance& robot : context.robots)
    for (const description::HardwareInfo& block : robot.hardware)
      if (!block.transmissions.empty()) return std::make_unique<TransmittedComponent>(std::move(component));
  return component;
}

}  // namespace polyarm::hardware
