#include "drivers/mock/mock.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "polyarm/base/text.hpp"

namespace polyarm::drivers {

using description::ComponentInfo;
using description::InterfaceInfo;
using hardware::CallbackReturn;
using hardware::ReturnType;

namespace {
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr int kMovesNothing = -1, kMovesFollower = -2;  // special values instead of the index of a part

bool flag(const std::map<std::string, std::string>& parameters, const char* name) {
  const auto found = parameters.find(name);
  return found != parameters.end() && equal_ignoring_case(trim(found->second), "true");
}

double number(const std::map<std::string, std::string>& parameters, const char* name) {
  const auto found = parameters.find(name);
  if (found == parameters.end()) return 0;
  if (const auto value = parse_number(found->second)) return *value;
  throw Error("bad-value",
              std::string("the hardware parameter ") + name + " = '" + found->second + "' is not a number",
              {});
}
}  // namespace

int MockComponent::state(const std::string& name, double initial) {
  states_.push_back({name, initial});
  return static_cast<int>(states_.size()) - 1;
}

int MockComponent::command(const std::string& name) {
  commands_.push_back({name});
  return static_cast<int>(commands_.size()) - 1;
}

void MockComponent::add_plain(const hardware::RobotInstance& robot) {
  const std::vector<std::string> joints = robot.model->joint_names();
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const std::string name = robot.name + "/" + joints[j];
    Part part;
    part.position = j < robot.initial_positions.size() ? robot.initial_positions[j] : 0;
    part.position_state = state(name + "/position", part.position);
    part.velocity_state = state(name + "/velocity", 0);
    part.position_command = command(name + "/position");
    part.quotient = true;
    parts_.push_back(part);
    part_names_.push_back(joints[j]);
  }
}

void MockComponent::add_component(const hardware::RobotInstance& robot, const ComponentInfo& info) {
  const std::string name = robot.name + "/" + info.name;
  const bool joint = info.kind == "joint";
  const std::vector<std::string> actuated = robot.model->joint_names();
  Part part;
  const auto at = std::find(actuated.begin(), actuated.end(), info.name);
  if (joint && at != actuated.end() &&
      static_cast<std::size_t>(at - actuated.begin()) < robot.initial_positions.size())
    part.position = robot.initial_positions[static_cast<std::size_t>(at - actuated.begin())];
  const auto place = [&](const std::string& interface, bool is_command) -> int* {
    if (!joint) return nullptr;
    if (interface == "position") return is_command ? &part.position_command : &part.position_state;
    if (interface == "velocity") return is_command ? &part.velocity_command : &part.velocity_state;
    if (interface == "acceleration")
      return is_command ? &part.acceleration_command : &part.acceleration_state;
    if (interface == "effort") return is_command ? &part.effort_command : &part.effort_state;
    if (!is_command && !custom_interface_.empty() && interface == custom_interface_)
      return &part.custom_state;
    return nullptr;
  };
  for (const InterfaceInfo& s : info.state_interfaces) {
    const double initial = s.name == "position" && joint ? s.initial_value.value_or(part.position)
                                                         : s.initial_value.value_or(joint ? 0.0 : kNone);
    if (joint && s.name == "position") part.position = initial;
    if (joint && s.name == "velocity") part.velocity = initial;
    if (joint && s.name == "acceleration") part.acceleration = initial;
    if (joint && s.name == "effort") part.effort = initial;
    const int index = state(name + "/" + s.name, initial);
    if (int* own = place(s.name, false))
      *own = index;
    else
      mirrors_.push_back({-1, index, initial});
  }
  const auto mirror_of = [&](const std::string& interface) -> Mirror* {
    for (Mirror& m : mirrors_)
      if (states_[static_cast<std::size_t>(m.state)].name == name + "/" + interface) return &m;
    return nullptr;
  };
  for (const InterfaceInfo& c : info.command_interfaces) {
    const int index = command(name + "/" + c.name);
    if (int* own = place(c.name, true))
      *own = index;
    else if (Mirror* m = mirror_of(c.name))
      m->command = index;
  }
  const bool mirrored = (info.kind == "sensor" && mirror_sensors_) || (info.kind == "gpio" && mirror_gpios_);
  if (mirrored)
    for (const InterfaceInfo& s : info.state_interfaces)
      if (Mirror* m = mirror_of(s.name); m && m->command < 0) m->command = command(name + "/" + s.name);
  if (!joint) return;
  parts_.push_back(part);
  part_names_.push_back(info.name);
}

void MockComponent::add_declared(const hardware::RobotInstance& robot,
                                 const description::HardwareInfo& info) {
  const std::size_t first = parts_.size();
  std::vector<std::string> names;
  std::vector<bool> follows;
  for (const ComponentInfo& component : info.components) {
    add_component(robot, component);
    if (component.kind != "joint") continue;
    names.push_back(component.name);
    follows.push_back(component.mimic.value_or(true));
  }
  for (std::size_t k = 0; k < names.size(); ++k) {
    const int joint = robot.model->find_joint(names[k]);
    if (!follows[k] || joint < 0 || !robot.model->joints[static_cast<std::size_t>(joint)].mimic) continue;
    const description::Mimic& mimic = *robot.model->joints[static_cast<std::size_t>(joint)].mimic;
    const std::string& source = robot.model->joints[static_cast<std::size_t>(mimic.joint)].name;
    const auto found = std::find(names.begin(), names.end(), source);
    if (found == names.end()) continue;
    Part& part = parts_[first + k];
    part.mimicked = static_cast<int>(first + static_cast<std::size_t>(found - names.begin()));
    part.multiplier = mimic.multiplier;
    part.offset = mimic.offset;
  }
}

const hardware::DriverFacts* MockComponent::facts() const noexcept {
  using enum hardware::ParameterKind;
  static constexpr hardware::DriverParameter kParameters[] = {
      {"calculate_dynamics", boolean, "false", "velocities and accelerations are integrated"},
      {"integrate_velocity", boolean, "false", "commanded velocities lead, positions are ignored"},
      {"disable_commands", boolean, "false", "states stay where they are"},
      {"position_state_following_offset", number, "0", "rad or m that a position state is off its command"},
      {"custom_interface_with_following_offset", text, "", "the state that takes the offset instead"},
      {"mock_sensor_commands", boolean, "false", "sensors can be commanded"},
      {"mock_gpio_commands", boolean, "false", "states of GPIOs can be commanded"},
      {"inject", text, "",
       "faults on purpose: KIND@CYCLE[:JOINT][=VALUE] …, kinds read_error, write_error, "
       "deactivate, nan, jump, freeze, slow"},
  };
  static constexpr hardware::DriverFacts kFacts = {
      "system", "nothing: states follow commands at once, no physics",
      "the behaviour of mock_components/GenericSystem, tested case by case", kParameters};
  return &kFacts;
}

std::string MockComponent::summary() const {
  if (part_names_.empty())
    return "its inputs, outputs and sensors hold what they are commanded or began with";
  std::string out = "mock hardware: states follow commands at once, no physics";
  const bool moves = dynamics_ || velocity_leads_;
  if (const std::string joints = names_of([&](const Part& part) {
        return !moves && part.velocity_command >= 0 && part.position_command < 0;
      });
      !joints.empty())
    out += "; velocities move nothing here, they are only given back as states: " + joints +
           " (<param name=\"calculate_dynamics\">true</param> in <hardware>, or physics, moves them)";
  if (const std::string joints = names_of([](const Part& part) { return part.effort_command >= 0; });
      !joints.empty())
    out += "; efforts move nothing here, they are only given back as states: " + joints +
           " (physics moves them: --hardware mujoco)";
  return out;
}

template <class Which>
std::string MockComponent::names_of(Which which) const {
  constexpr std::size_t kNamed = 6;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < parts_.size(); ++i)
    if (which(parts_[i])) names.push_back(part_names_[i]);
  const std::size_t more = names.size() > kNamed ? names.size() - kNamed : 0;
  names.resize(names.size() - more);
  return join(names, ", ") + (more > 0 ? " and " + std::to_string(more) + " more" : "");
}

CallbackReturn MockComponent::on_init(const hardware::ComponentContext& context) {
  dynamics_ = flag(context.parameters, "calculate_dynamics");
  velocity_leads_ = flag(context.parameters, "integrate_velocity");
  disabled_ = flag(context.parameters, "disable_commands");
  mirror_sensors_ = flag(context.parameters, "mock_sensor_commands");
  mirror_gpios_ = flag(context.parameters, "mock_gpio_commands");
  following_offset_ = number(context.parameters, "position_state_following_offset");
  if (const auto custom = context.parameters.find("custom_interface_with_following_offset");
      custom != context.parameters.end())
    custom_interface_ = trim(custom->second);
  for (const hardware::RobotInstance& robot : context.robots) {
    if (robot.hardware.empty()) add_plain(robot);
    for (const description::HardwareInfo& info : robot.hardware) add_declared(robot, info);
  }
  world_ = std::make_unique<MockWorld>(context, states_, commands_);
  if (const auto faults = context.parameters.find("inject"); faults != context.parameters.end()) {
    std::vector<int> positions;
    for (const Part& part : parts_) positions.push_back(part.position_state);
    injection_.parse(faults->second, part_names_, positions, states_.size());
  }
  for (std::size_t i = 0; i < commands_.size(); ++i)
    command_places_.emplace(commands_[i].name, static_cast<int>(i));
  part_followers();
  asked_.assign(commands_.size(), kNone);
  stopped_.assign(commands_.size(), 0);
  return CallbackReturn::success;
}

CallbackReturn MockComponent::on_activate() {
  injection_.begin();
  return CallbackReturn::success;
}

std::vector<hardware::InterfaceDescription> MockComponent::state_interfaces() const {
  return states_;
}
std::vector<hardware::InterfaceDescription> MockComponent::command_interfaces() const {
  return commands_;
}

/// Moves the joints that only follow a position command into followers_, and maps each command to the part
/// that it drives.
void MockComponent::part_followers() {
  part_of_command_.assign(commands_.size(), kMovesNothing);
  std::vector<Part> others;
  std::vector<std::string> other_names, follower_names;
  const bool any_mimic =
      std::any_of(parts_.begin(), parts_.end(), [](const Part& part) { return part.mimicked >= 0; });
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    const Part& p = parts_[i];
    const bool follows = p.quotient && !dynamics_ && !velocity_leads_ && !disabled_ && !any_mimic;
    if (!follows) {
      for (const int c : {p.position_command, p.velocity_command, p.acceleration_command})
        if (c >= 0) part_of_command_[static_cast<std::size_t>(c)] = static_cast<int>(others.size());
      others.push_back(p);
      other_names.push_back(part_names_[i]);
      continue;
    }
    followers_.position.push_back(p.position);
    followers_.command.push_back(static_cast<std::uint32_t>(p.position_command));
    followers_.position_state.push_back(static_cast<std::uint32_t>(p.position_state));
    followers_.velocity_state.push_back(static_cast<std::uint32_t>(p.velocity_state));
    part_of_command_[static_cast<std::size_t>(p.position_command)] = kMovesFollower;
    follower_names.push_back(part_names_[i]);
  }
  parts_ = std::move(others);
  part_names_ = std::move(other_names);
  part_names_.insert(part_names_.end(), follower_names.begin(), follower_names.end());
}

int MockComponent::command_named(const std::string& name) const noexcept {
  const auto found = command_places_.find(name);
  return found == command_places_.end() ? -1 : found->second;
}

ReturnType MockComponent::prepare_command_mode_switch(std::span<const std::string> start,
                                                      std::span<const std::string>) {
  if (!dynamics_) return ReturnType::ok;
  std::vector<int> modes(parts_.size(), 0);
  for (const std::string& name : start) {
    const int c = command_named(name);
    const int part = c < 0 ? -1 : part_of_command_[static_cast<std::size_t>(c)];
    if (part >= 0 && ++modes[static_cast<std::size_t>(part)] > 1) return ReturnType::error;
  }
  return ReturnType::ok;
}

ReturnType MockComponent::perform_command_mode_switch(std::span<const std::string> start,
                                                      std::span<const std::string> stop) noexcept {
  for (const std::string& name : stop) {
    const int c = command_named(name);
    if (c < 0) continue;
    const auto i = static_cast<std::size_t>(c);
    const int moved = part_of_command_[i];
    if (moved == kMovesNothing) continue;
    stopped_[i] = 1;
    asked_[i] = kNone;
    if (moved >= 0) {
      Part& part = parts_[static_cast<std::size_t>(moved)];
      part.velocity = part.acceleration = 0;
    }
  }
  for (const std::string& name : start)
    if (const int c = command_named(name); c >= 0) stopped_[static_cast<std::size_t>(c)] = 0;
  any_stopped_ = std::any_of(stopped_.begin(), stopped_.end(), [](char one) { return one != 0; });
  return ReturnType::ok;
}

void MockComponent::move(Part& part, double dt) noexcept {
  const auto asked = [&](int index) { return index < 0 ? kNone : asked_[static_cast<std::size_t>(index)]; };
  const double q = asked(part.position_command), v = asked(part.velocity_command),
               a = asked(part.acceleration_command);
  const double before = part.position;
  if (velocity_leads_) {
    if (std::isfinite(v)) {
      part.velocity = v;
      part.position += v * dt;
    }
  } else if (std::isfinite(q)) {
    part.position = q + (custom_interface_.empty() ? following_offset_ : 0);
    if (dynamics_ || part.quotient) {
      const double velocity = dt > 0 ? (part.position - before) / dt : 0;
      part.acceleration = dt > 0 ? (velocity - part.velocity) / dt : 0;
      part.velocity = velocity;
    } else if (std::isfinite(v)) {
      part.velocity = v;
    }
  } else if (std::isfinite(v)) {
    if (dynamics_) {
      part.acceleration = dt > 0 ? (v - part.velocity) / dt : 0;
      part.position += v * dt;
    }
    part.velocity = v;
  } else if (std::isfinite(a)) {
    part.acceleration = a;
    if (dynamics_) {
      part.velocity += a * dt;
      part.position += part.velocity * dt;
    }
  }
  if (const double e = asked(part.effort_command); std::isfinite(e)) part.effort = e;
}

inline void MockComponent::follow(double dt, std::span<double> states) noexcept {
  const double offset = custom_interface_.empty() ? following_offset_ : 0;
  const double span = dt > 0 ? dt : std::numeric_limits<double>::infinity();  // no time: zero velocity
  const std::uint32_t* const command = followers_.command.data();
  const std::uint32_t* const at = followers_.position_state.data();
  const std::uint32_t* const speed_at = followers_.velocity_state.data();
  const double* const commands = asked_.data();
  double* const position = followers_.position.data();
  double* const out = states.data();
  for (std::size_t j = 0, n = followers_.position.size(); j < n; ++j) {
    const double asked = commands[command[j]], before = position[j];
    const bool led = std::isfinite(asked);
    const double now = led ? asked + offset : before;
    position[j] = now;
    out[at[j]] = now;
    out[speed_at[j]] = led ? (now - before) / span : 0;
  }
}

void MockComponent::move_parts(double dt, std::span<double> states) noexcept {
  if (!disabled_)
    for (Part& part : parts_)
      if (part.mimicked < 0) move(part, dt);
  for (Part& part : parts_) {
    if (part.mimicked >= 0) {
      const Part& source = parts_[static_cast<std::size_t>(part.mimicked)];
      part.position = part.multiplier * source.position + part.offset;
      part.velocity = part.multiplier * source.velocity;
      part.acceleration = part.multiplier * source.acceleration;
    }
    const auto put = [&](int index, double value) {
      if (index >= 0) states[static_cast<std::size_t>(index)] = value;
    };
    put(part.position_state, part.position);
    put(part.velocity_state, part.velocity);
    put(part.acceleration_state, part.acceleration);
    put(part.effort_state, part.effort);
    put(part.custom_state, part.position + following_offset_);
  }
}

ReturnType MockComponent::read(const hardware::Cycle& cycle, std::span<double> states) noexcept {
  const double dt = seconds(cycle.period);
  follow(dt, states);
  if (!parts_.empty()) move_parts(dt, states);
  for (Mirror& mirror : mirrors_) {
    if (mirror.command >= 0 && std::isfinite(asked_[static_cast<std::size_t>(mirror.command)]) && !disabled_)
      mirror.value = asked_[static_cast<std::size_t>(mirror.command)];
    states[static_cast<std::size_t>(mirror.state)] = mirror.value;
  }
  world_->step(cycle, asked_, states);
  if (broken_) return ReturnType::error;
  return injection_.empty() ? ReturnType::ok : injection_.after_read(states);
}

ReturnType MockComponent::write(const hardware::Cycle&, std::span<const double> commands) noexcept {
  for (std::size_t i = 0; i < commands.size(); ++i) {
    const double command = commands[i];
    if (!std::isfinite(command))
      broken_ = broken_ || std::isinf(command);
    else if (!any_stopped_ || !stopped_[i])
      asked_[i] = command;
  }
  return broken_ ? ReturnType::error : injection_.after_write();
}

}  // namespace polyarm::drivers
