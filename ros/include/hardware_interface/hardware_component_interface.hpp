#pragma once
/// The base of SystemInterface, ActuatorInterface and SensorInterface: life cycle, description, handles.
///
/// All generations of the interface live side by side. A plugin overrides on_init of Humble (HardwareInfo) or
/// of Rolling (HardwareComponentInterfaceParams); exports handles by hand or by description; reads with or
/// without time.
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <unordered_map>
#include <utility>
#include <vector>

#include "control_msgs/msg/hardware_status.hpp"
#include "hardware_interface/component_parser.hpp"
#include "hardware_interface/handle.hpp"
#include "hardware_interface/hardware_info.hpp"
#include "hardware_interface/introspection.hpp"
#include "hardware_interface/lexical_casts.hpp"
#include "hardware_interface/types/hardware_component_interface_params.hpp"
#include "hardware_interface/types/hardware_interface_return_values.hpp"
#include "hardware_interface/types/hardware_interface_status_values.hpp"
#include "hardware_interface/types/hardware_interface_type_values.hpp"
#include "hardware_interface/types/lifecycle_state_names.hpp"
#include "lifecycle_msgs/msg/state.hpp"
#include "polyarm_ros/standard.hpp"
#include "rclcpp/duration.hpp"
#include "rclcpp/executors.hpp"
#include "rclcpp/logging.hpp"
#include "rclcpp/node.hpp"
#include "rclcpp/rclcpp.hpp"
#include "rclcpp/time.hpp"
#include "rclcpp/version.h"
#include "rclcpp_lifecycle/node_interfaces/lifecycle_node_interface.hpp"
#include "rclcpp_lifecycle/state.hpp"
#include "realtime_tools/async_function_handler.hpp"
#include "realtime_tools/realtime_helpers.hpp"
#include "realtime_tools/realtime_publisher.hpp"
#include "realtime_tools/realtime_thread_safe_box.hpp"

namespace hardware_interface {

using CallbackReturn = rclcpp_lifecycle::node_interfaces::LifecycleNodeInterface::CallbackReturn;
using Descriptions = std::unordered_map<std::string, InterfaceDescription>;

class HardwareComponentInterface : public rclcpp_lifecycle::node_interfaces::LifecycleNodeInterface {
 public:
  HardwareComponentInterface() = default;
  HardwareComponentInterface(const HardwareComponentInterface&) = delete;
  HardwareComponentInterface& operator=(const HardwareComponentInterface&) = delete;
  ~HardwareComponentInterface() override = default;

  /// Called by the wrapper: gives the component its logger and clock, then calls on_init.
  CallbackReturn init(const HardwareComponentParams& params) {
    logger_ = params.logger.get_child("hardware_component." + params.hardware_info.type + "." +
                                      params.hardware_info.name);
    clock_ = params.clock ? params.clock : std::make_shared<rclcpp::Clock>(RCL_ROS_TIME);
    info_ = params.hardware_info;
    executor_ = params.executor;
    HardwareComponentInterfaceParams own;
    own.hardware_info = params.hardware_info;
    own.executor = params.executor;
    own.node_namespace = params.node_namespace;
    if (const CallbackReturn status = start_status(); status != CallbackReturn::SUCCESS) return status;
    return on_init(own);
  }
  virtual CallbackReturn on_init(const HardwareInfo& info) {
    take(info);
    return CallbackReturn::SUCCESS;
  }
  virtual CallbackReturn on_init(const HardwareComponentInterfaceParams& params) {
    take(params.hardware_info);
    return on_init(params.hardware_info);
  }

  virtual std::vector<StateInterface> export_state_interfaces() { return {}; }
  virtual std::vector<CommandInterface> export_command_interfaces() { return {}; }
  virtual std::vector<InterfaceDescription> export_unlisted_state_interface_descriptions() { return {}; }
  virtual std::vector<InterfaceDescription> export_unlisted_command_interface_descriptions() { return {}; }
  virtual std::vector<StateInterface::ConstSharedPtr> on_export_state_interfaces() {
    std::vector<StateInterface::ConstSharedPtr> out;
    for (StateInterface& each : export_state_interfaces())
      keep_state(std::make_shared<StateInterface>(std::move(each)), out);
    if (!out.empty()) return out;
    for (const InterfaceDescription& each : export_unlisted_state_interface_descriptions()) {
      unlisted_state_interfaces_.emplace(each.get_name(), each);
      unlisted_states_.push_back(keep_state(std::make_shared<StateInterface>(each), out));
    }
    by_description(info_.joints, joint_states_, out);
    by_description(info_.sensors, sensor_states_, out);
    by_description(info_.gpios, gpio_states_, out);
    return out;
  }
  virtual std::vector<CommandInterface::SharedPtr> on_export_command_interfaces() {
    std::vector<CommandInterface::SharedPtr> out;
    for (CommandInterface& each : export_command_interfaces())
      keep_command(std::make_shared<CommandInterface>(std::move(each)), out);
    if (!out.empty()) return out;
    for (const InterfaceDescription& each : export_unlisted_command_interface_descriptions()) {
      unlisted_command_interfaces_.emplace(each.get_name(), each);
      unlisted_commands_.push_back(keep_command(std::make_shared<CommandInterface>(each), out));
    }
    by_description(info_.joints, joint_commands_, out);
    by_description(info_.gpios, gpio_commands_, out);
    return out;
  }

  virtual return_type prepare_command_mode_switch(const std::vector<std::string>&,
                                                  const std::vector<std::string>&) {
    return return_type::OK;
  }
  virtual return_type perform_command_mode_switch(const std::vector<std::string>&,
                                                  const std::vector<std::string>&) {
    return return_type::OK;
  }

  virtual return_type read(const rclcpp::Time&, const rclcpp::Duration&) { return read(); }
  virtual return_type write(const rclcpp::Time&, const rclcpp::Duration&) { return write(); }
  /// The forms of Foxy and Galactic.
  virtual return_type read() { return return_type::OK; }
  virtual return_type write() { return return_type::OK; }

  /// For Rolling. With <param name="status_publish_rate"> (Hz) a message is sent to ~/hardware_status at that
  /// rate: a copy of the one that the first function sets up, filled in by the second one on the node's
  /// thread.
  virtual CallbackReturn init_hardware_status_message(control_msgs::msg::HardwareStatus&) {
    return CallbackReturn::SUCCESS;
  }
  virtual return_type update_hardware_status_message(control_msgs::msg::HardwareStatus&) {
    return return_type::OK;
  }

  virtual std::string get_name() const { return info_.name; }
  std::string get_group_name() const { return info_.group; }
  const HardwareInfo& get_hardware_info() const { return info_; }
  const rclcpp_lifecycle::State& get_lifecycle_state() const { return lifecycle_state_; }
  const rclcpp_lifecycle::State& get_state() const { return lifecycle_state_; }
  std::uint8_t get_lifecycle_id() const { return lifecycle_state_.id(); }
  void set_lifecycle_state(const rclcpp_lifecycle::State& state) { lifecycle_state_ = state; }
  void set_state(const rclcpp_lifecycle::State& state) { lifecycle_state_ = state; }
  rclcpp::Logger get_logger() const { return logger_; }
  rclcpp::Clock::SharedPtr get_clock() const { return clock_; }
  rclcpp::Node::SharedPtr get_node() const {
    if (!node_) {
      std::string name = to_lower_case(info_.name);
      for (char& c : name)
        if (c == '/') c = '_';
      node_ = std::make_shared<rclcpp::Node>(name);
      if (const auto executor = executor_.lock()) executor->add_node(node_);
    }
    return node_;
  }
  void prepare_for_activation() {}
  void enable_introspection(bool) {}
  void pause_async_operations() {}

  bool has_state(const std::string& name) const { return states_.count(name) > 0; }
  bool has_command(const std::string& name) const { return commands_.count(name) > 0; }
  const StateInterface::SharedPtr& get_state_interface_handle(const std::string& name) const {
    return found(states_, name);
  }
  const CommandInterface::SharedPtr& get_command_interface_handle(const std::string& name) const {
    return found(commands_, name);
  }
  template <typename T = double>
  T get_state(const std::string& name) const {
    return *found(states_, name)->template get_optional<T>();
  }
  template <typename T = double>
  T get_command(const std::string& name) const {
    return *found(commands_, name)->template get_optional<T>();
  }
  template <typename T>
  void set_state(const std::string& name, const T& value) {
    found(states_, name)->set_value(value);
  }
  template <typename T>
  void set_command(const std::string& name, const T& value) {
    found(commands_, name)->set_value(value);
  }
  template <typename T>
  bool set_state(const StateInterface::SharedPtr& handle, const T& value, bool = true) {
    return handle->set_value(value);
  }
  template <typename T>
  bool set_command(const CommandInterface::SharedPtr& handle, const T& value, bool = true) {
    return handle->set_value(value);
  }
  template <typename T>
  bool get_state(const StateInterface::SharedPtr& handle, T& out, bool = true) const {
    return handle->get_value(out);
  }
  template <typename T>
  bool get_command(const CommandInterface::SharedPtr& handle, T& out, bool = true) const {
    return handle->get_value(out);
  }

 protected:
  HardwareInfo info_;
  Descriptions joint_state_interfaces_, joint_command_interfaces_;
  Descriptions sensor_state_interfaces_, sensor_command_interfaces_;
  Descriptions gpio_state_interfaces_, gpio_command_interfaces_;
  Descriptions unlisted_state_interfaces_, unlisted_command_interfaces_;
  rclcpp_lifecycle::State lifecycle_state_{lifecycle_msgs::msg::State::PRIMARY_STATE_UNCONFIGURED,
                                           lifecycle_state_names::UNCONFIGURED};
  std::vector<StateInterface::SharedPtr> joint_states_, sensor_states_, gpio_states_, unlisted_states_;
  std::vector<CommandInterface::SharedPtr> joint_commands_, gpio_commands_, unlisted_commands_;

 private:
  CallbackReturn start_status() {
    const auto given = info_.hardware_parameters.find("status_publish_rate");
    if (given == info_.hardware_parameters.end()) return CallbackReturn::SUCCESS;
    double hz = 0;
    try {
      hz = hardware_interface::stod(given->second);
    } catch (const std::invalid_argument&) {
      RCLCPP_WARN(logger_, "status_publish_rate '%s' is not a number: no status is published",
                  given->second.c_str());
    }
    if (!(hz > 0)) return CallbackReturn::SUCCESS;
    if (const auto result = init_hardware_status_message(status_); result != CallbackReturn::SUCCESS)
      return result;
    if (status_.hardware_device_states.empty()) {
      RCLCPP_WARN(logger_, "init_hardware_status_message names no device: no status is published");
      return CallbackReturn::SUCCESS;
    }
    status_publisher_ = get_node()->create_publisher<control_msgs::msg::HardwareStatus>(
        "~/hardware_status", rclcpp::SystemDefaultsQoS());
    status_timer_ = get_node()->create_wall_timer(std::chrono::duration<double>(1 / hz), [this] {
      control_msgs::msg::HardwareStatus message = status_;
      if (update_hardware_status_message(message) != return_type::OK) {
        RCLCPP_WARN_THROTTLE(logger_, *clock_, 1000, "update_hardware_status_message returns an error");
        return;
      }
      message.header.stamp = clock_->now();
      status_publisher_->publish(message);
    });
    return CallbackReturn::SUCCESS;
  }
  void take(const HardwareInfo& info) {
    if (taken_) return;
    taken_ = true;
    info_ = info;
    describe(info_.joints, joint_state_interfaces_, joint_command_interfaces_);
    describe(info_.sensors, sensor_state_interfaces_, sensor_command_interfaces_);
    describe(info_.gpios, gpio_state_interfaces_, gpio_command_interfaces_);
  }
  static void describe(const std::vector<ComponentInfo>& all, Descriptions& states, Descriptions& commands) {
    for (const ComponentInfo& component : all) {
      for (const InterfaceInfo& i : component.state_interfaces)
        states.emplace(component.name + "/" + i.name, InterfaceDescription(component.name, i));
      for (const InterfaceInfo& i : component.command_interfaces)
        commands.emplace(component.name + "/" + i.name, InterfaceDescription(component.name, i));
    }
  }
  void by_description(const std::vector<ComponentInfo>& all, std::vector<StateInterface::SharedPtr>& group,
                      std::vector<StateInterface::ConstSharedPtr>& out) {
    for (const ComponentInfo& component : all)
      for (const InterfaceInfo& i : component.state_interfaces)
        group.push_back(
            keep_state(std::make_shared<StateInterface>(InterfaceDescription(component.name, i)), out));
  }
  void by_description(const std::vector<ComponentInfo>& all, std::vector<CommandInterface::SharedPtr>& group,
                      std::vector<CommandInterface::SharedPtr>& out) {
    for (const ComponentInfo& component : all)
      for (const InterfaceInfo& i : component.command_interfaces)
        group.push_back(
            keep_command(std::make_shared<CommandInterface>(InterfaceDescription(component.name, i)), out));
  }
  StateInterface::SharedPtr keep_state(StateInterface::SharedPtr handle,
                                       std::vector<StateInterface::ConstSharedPtr>& out) {
    states_[handle->get_name()] = handle;
    out.push_back(handle);
    return handle;
  }
  CommandInterface::SharedPtr keep_command(CommandInterface::SharedPtr handle,
                                           std::vector<CommandInterface::SharedPtr>& out) {
    commands_[handle->get_name()] = handle;
    out.push_back(handle);
    return handle;
  }
  template <typename Map>
  static const typename Map::mapped_type& found(const Map& all, const std::string& name) {
    const auto at = all.find(name);
    if (at == all.end()) throw std::runtime_error("no interface '" + name + "' was exported");
    return at->second;
  }

  bool taken_ = false;
  rclcpp::Logger logger_ = rclcpp::get_logger("hardware");
  rclcpp::Clock::SharedPtr clock_ = std::make_shared<rclcpp::Clock>(RCL_ROS_TIME);
  mutable rclcpp::Node::SharedPtr node_;
  std::weak_ptr<rclcpp::Executor> executor_;
  control_msgs::msg::HardwareStatus status_;  ///< as the plugin sets it up
  rclcpp::Publisher<control_msgs::msg::HardwareStatus>::SharedPtr status_publisher_;
  rclcpp::TimerBase::SharedPtr status_timer_;
  std::unordered_map<std::string, StateInterface::SharedPtr> states_;
  std::unordered_map<std::string, CommandInterface::SharedPtr> commands_;
};

}  // namespace hardware_interface
