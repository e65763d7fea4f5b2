#pragma once
/// The mock hardware of ros2_control, for plugins that derive from it: states follow commands. Polyarm's own
/// `mock` takes its place where a description names it.
///
/// Parameters of the hardware: disable_commands, calculate_dynamics, position_state_following_offset,
/// custom_interface_with_following_offset, mock_sensor_commands, mock_gpio_commands.
#include <cmath>
#include <string>
#include <vector>

#include "hardware_interface/lexical_casts.hpp"
#include "hardware_interface/system_interface.hpp"
#include "hardware_interface/types/hardware_interface_type_values.hpp"

namespace mock_components {
using hardware_interface::CallbackReturn;
using hardware_interface::return_type;

class GenericSystem : public hardware_interface::SystemInterface {
  using State = hardware_interface::StateInterface::SharedPtr;
  using Command = hardware_interface::CommandInterface::SharedPtr;

 public:
  using SystemInterface::on_init;
  CallbackReturn on_init(const hardware_interface::HardwareInfo& info) override {
    if (SystemInterface::on_init(info) != CallbackReturn::SUCCESS) return CallbackReturn::ERROR;
    disabled_ = is_true("disable_commands");
    dynamics_ = is_true("calculate_dynamics");
    offset_ = number("position_state_following_offset");
    if (const auto custom = info_.hardware_parameters.find("custom_interface_with_following_offset");
        custom != info_.hardware_parameters.end())
      custom_ = custom->second;
    return CallbackReturn::SUCCESS;
  }

  std::vector<hardware_interface::StateInterface> export_state_interfaces() override {
    std::vector<hardware_interface::StateInterface> out;
    for (const auto* components : {&info_.joints, &info_.sensors, &info_.gpios})
      for (const auto& component : *components)
        for (const auto& each : component.state_interfaces)
          out.emplace_back(hardware_interface::InterfaceDescription(component.name, each));
    for (const auto& each : export_unlisted_state_interface_descriptions()) out.emplace_back(each);
    return out;
  }
  std::vector<hardware_interface::CommandInterface> export_command_interfaces() override {
    std::vector<hardware_interface::CommandInterface> out;
    for (const auto* components : {&info_.joints, &info_.gpios})
      for (const auto& component : *components)
        for (const auto& each : component.command_interfaces)
          out.emplace_back(hardware_interface::InterfaceDescription(component.name, each));
    for (const auto& each : export_unlisted_command_interface_descriptions()) out.emplace_back(each);
    return out;
  }
  /// Commands that set the states of sensors and of gpios.
  std::vector<hardware_interface::InterfaceDescription> export_unlisted_command_interface_descriptions()
      override {
    std::vector<hardware_interface::InterfaceDescription> out;
    const auto mirror = [&out](const std::vector<hardware_interface::ComponentInfo>& components) {
      for (const auto& component : components)
        for (const auto& each : component.state_interfaces)
          if (!has(component.command_interfaces, each.name)) out.emplace_back(component.name, each);
    };
    if (is_true("mock_sensor_commands") || is_true("fake_sensor_commands")) mirror(info_.sensors);
    if (is_true("mock_gpio_commands") || is_true("fake_gpio_commands")) mirror(info_.gpios);
    return out;
  }
  std::vector<Command> on_export_command_interfaces() override {
    auto out = SystemInterface::on_export_command_interfaces();
    link(out);
    return out;
  }

  return_type perform_command_mode_switch(const std::vector<std::string>& start,
                                          const std::vector<std::string>&) override {
    for (Axis& axis : axes_)
      for (const std::string& each : start) {
        if (each == axis.joint + "/position") axis.mode = Mode::position;
        if (each == axis.joint + "/velocity") axis.mode = Mode::velocity;
        if (each == axis.joint + "/acceleration") axis.mode = Mode::acceleration;
      }
    return return_type::OK;
  }
  CallbackReturn on_configure(const rclcpp_lifecycle::State&) override { return CallbackReturn::SUCCESS; }
  return_type read(const rclcpp::Time&, const rclcpp::Duration& period) override {
    if (disabled_) return return_type::OK;
    for (Axis& axis : axes_) step(axis, period.seconds());
    for (const Link& each : links_)
      if (const double value = get(each.command); !std::isnan(value)) set(each.state, value + each.offset);
    for (const Follower& each : followers_) set(each.state, each.offset + each.factor * get(each.leader));
    return return_type::OK;
  }
  return_type write(const rclcpp::Time&, const rclcpp::Duration&) override { return return_type::OK; }

 private:
  /// A state that follows a command.
  struct Link {
    State state;
    Command command;
    double offset;
  };
  struct Follower {
    State state, leader;
    double offset, factor;
  };
  enum class Mode { position, velocity, acceleration };
  /// A joint whose velocity and acceleration are calculated. Null where it has no such interface.
  struct Axis {
    std::string joint;
    State position, velocity, acceleration;
    Command to_position, to_velocity, to_acceleration;
    Mode mode;
  };

  template <typename Handle>
  static double get(const Handle& handle) {
    return handle->template get_optional<double>().value_or(std::nan(""));
  }
  static void set(const State& state, double value) {
    if (state) state->set_value(value);
  }
  static bool has(const std::vector<hardware_interface::InterfaceInfo>& all, const std::string& name) {
    for (const auto& each : all)
      if (each.name == name) return true;
    return false;
  }
  bool is_true(const char* name) const {
    const auto found = info_.hardware_parameters.find(name);
    return found != info_.hardware_parameters.end() && hardware_interface::parse_bool(found->second);
  }
  double number(const char* name) const {
    const auto found = info_.hardware_parameters.find(name);
    return found == info_.hardware_parameters.end() || found->second.empty()
               ? 0.0
               : hardware_interface::stod(found->second);
  }
  State state(const std::string& name) const {
    return has_state(name) ? get_state_interface_handle(name) : nullptr;
  }
  Command command(const std::string& name) const {
    return has_command(name) ? get_command_interface_handle(name) : nullptr;
  }

  void link(const std::vector<Command>& commands) {
    links_.clear(), axes_.clear(), followers_.clear();
    for (const auto& joint : info_.joints) {
      const std::string front = joint.name + "/";
      for (const char* kind : {"position", "velocity", "acceleration", "effort"})
        if (const State own = state(front + kind); own && std::isnan(get(own))) set(own, 0);
      if (dynamics_) add_axis(joint.name);
      if (!custom_.empty())
        if (const State custom = state(front + custom_))
          if (const Command position = command(front + "position"))
            links_.push_back({custom, position, offset_});
    }
    for (const Command& each : commands) {
      const std::string kind = each->get_interface_name();
      const bool motion = kind == "position" || kind == "velocity" || kind == "acceleration";
      const State same = state(each->get_name());
      if (same && !(dynamics_ && motion && is_joint(each->get_prefix_name())))
        links_.push_back({same, each, kind == "position" && custom_.empty() ? offset_ : 0.0});
    }
    for (const auto& mimic : info_.mimic_joints)
      for (const auto& each : info_.joints.at(mimic.joint_index).state_interfaces) {
        const State own = state(info_.joints.at(mimic.joint_index).name + "/" + each.name);
        const State leader = state(info_.joints.at(mimic.mimicked_joint_index).name + "/" + each.name);
        if (own && leader)
          followers_.push_back({own, leader, each.name == "position" ? mimic.offset : 0.0, mimic.multiplier});
      }
  }
  void add_axis(const std::string& joint) {
    const std::string front = joint + "/";
    Axis axis{joint,
              state(front + "position"),
              state(front + "velocity"),
              state(front + "acceleration"),
              command(front + "position"),
              command(front + "velocity"),
              command(front + "acceleration"),
              Mode::position};
    if (!axis.to_position) axis.mode = axis.to_velocity ? Mode::velocity : Mode::acceleration;
    axes_.push_back(axis);
  }
  bool is_joint(const std::string& name) const {
    for (const auto& joint : info_.joints)
      if (joint.name == name) return true;
    return false;
  }
  void step(Axis& axis, double dt) {
    const Command& by = axis.mode == Mode::position   ? axis.to_position
                        : axis.mode == Mode::velocity ? axis.to_velocity
                                                      : axis.to_acceleration;
    if (!(dt > 0) || !by || std::isnan(get(by))) return;
    const double command = get(by), start = axis.position ? get(axis.position) : 0,
                 speed = axis.velocity ? get(axis.velocity) : 0;
    double position = start + speed * dt, velocity = command;
    if (axis.mode == Mode::position) {
      position = command + (custom_.empty() ? offset_ : 0.0);
      velocity = (position - start) / dt;
    } else if (axis.mode == Mode::acceleration) {
      velocity = speed + command * dt;
    }
    set(axis.position, position), set(axis.velocity, velocity);
    set(axis.acceleration, (velocity - speed) / dt);
  }

  bool disabled_ = false, dynamics_ = false;
  double offset_ = 0;
  std::string custom_;
  std::vector<Link> links_;
  std::vector<Axis> axes_;
  std::vector<Follower> followers_;
};
using GenericRobot = GenericSystem;

}  // namespace mock_components
