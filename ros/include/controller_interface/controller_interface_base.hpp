#pragma once
/// What all controllers of ros2_control have in common, from Humble to Rolling. The wrapper of Polyarm
/// (polyarm_ros/controller.hpp) calls it in the place of a controller manager.
#include <cstdint>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "controller_interface/controller_interface_params.hpp"
#include "controller_interface/visibility_control.h"
#include "hardware_interface/handle.hpp"
#include "hardware_interface/introspection.hpp"
#include "hardware_interface/loaned_command_interface.hpp"
#include "hardware_interface/loaned_state_interface.hpp"
#include "rclcpp/rclcpp.hpp"
#include "rclcpp/version.h"
#include "rclcpp_lifecycle/lifecycle_node.hpp"
#include "realtime_tools/realtime_helpers.hpp"

namespace controller_interface {

enum class return_type : std::uint8_t { OK = 0, ERROR = 1, SUCCESS = OK };  // SUCCESS in Foxy
enum class interface_configuration_type : std::uint8_t {
  ALL = 0,
  INDIVIDUAL = 1,
  NONE = 2,
  INDIVIDUAL_BEST_EFFORT = 3,
  REGEX = 4
};
struct InterfaceConfiguration {
  interface_configuration_type type;
  std::vector<std::string> names = {};
};
using CallbackReturn = rclcpp_lifecycle::node_interfaces::LifecycleNodeInterface::CallbackReturn;

class ControllerInterfaceBase : public rclcpp_lifecycle::node_interfaces::LifecycleNodeInterface {
 public:
  using Node = rclcpp_lifecycle::LifecycleNode;

  virtual InterfaceConfiguration command_interface_configuration() const = 0;
  virtual InterfaceConfiguration state_interface_configuration() const = 0;
  virtual void assign_interfaces(std::vector<hardware_interface::LoanedCommandInterface>&& commands,
                                 std::vector<hardware_interface::LoanedStateInterface>&& states) {
    command_interfaces_ = std::move(commands);
    state_interfaces_ = std::move(states);
  }
  virtual void release_interfaces() {
    command_interfaces_.clear();
    state_interfaces_.clear();
  }

  /// For the wrapper. The forms below are those of Rolling, Jazzy, Humble and Galactic, newest first: each
  /// calls the newer one, so a controller may override any of them and calls its base class there.
  return_type init(const ControllerInterfaceParams& params) {
    make_node(params);
    return init(params.controller_name);
  }
  virtual return_type init(const std::string& name, const std::string& description, unsigned int rate,
                           const std::string& name_space, const rclcpp::NodeOptions& options) {
    if (!node_) {
      ControllerInterfaceParams params;
      params.controller_name = name;
      params.robot_description = description;
      params.update_rate = params.controller_manager_update_rate = rate;
      params.node_namespace = name_space;
      params.node_options = options;
      make_node(params);
    }
    return on_init() == CallbackReturn::SUCCESS ? return_type::OK : return_type::ERROR;
  }
  virtual return_type init(const std::string& name, const std::string& name_space,
                           const rclcpp::NodeOptions& options) {
    return init(name, params_.robot_description, params_.update_rate, name_space, options);
  }
  virtual return_type init(const std::string& name) {
    return init(name, params_.node_namespace, params_.node_options);
  }

  virtual CallbackReturn on_init() { return CallbackReturn::SUCCESS; }
  virtual return_type update(const rclcpp::Time&, const rclcpp::Duration&) { return update(); }
  /// The form of Foxy.
  virtual return_type update() { return return_type::OK; }
  virtual rclcpp::NodeOptions define_custom_node_options() const { return rclcpp::NodeOptions(); }

  std::shared_ptr<Node> get_node() const {
    if (!node_) throw std::runtime_error("the controller has no node before init()");
    return node_;
  }
  const rclcpp_lifecycle::State& configure() { return get_node()->configure(); }
  const rclcpp_lifecycle::State& get_lifecycle_state() const { return node_->get_current_state(); }
  const rclcpp_lifecycle::State& get_state() const { return node_->get_current_state(); }
  std::uint8_t get_lifecycle_id() const { return node_->get_current_state().id(); }
  unsigned int get_update_rate() const { return params_.update_rate; }
  bool is_async() const { return false; }
  const std::string& get_robot_description() const { return params_.robot_description; }
  const std::unordered_map<std::string, joint_limits::JointLimits>& get_hard_joint_limits() const {
    return params_.hard_joint_limits;
  }
  const std::unordered_map<std::string, joint_limits::SoftJointLimits>& get_soft_joint_limits() const {
    return params_.soft_joint_limits;
  }
  std::string get_name() const { return get_node()->get_name(); }
  void enable_introspection(bool) {}
  void wait_for_trigger_update_to_finish() {}
  void prepare_for_deactivation() {}

  template <typename T>
  auto auto_declare(const std::string& name, const T& value) {
    if (get_node()->get_node_base_interface()->has_parameter(name))
      return get_node()->get_parameter(name).template get_value<T>();
    return static_cast<T>(get_node()->template declare_parameter<T>(name, value));
  }

  virtual bool is_chainable() const = 0;
  virtual std::vector<hardware_interface::CommandInterface::SharedPtr> export_reference_interfaces() = 0;
  virtual std::vector<hardware_interface::StateInterface::ConstSharedPtr> export_state_interfaces() = 0;
  virtual bool set_chained_mode(bool chained) = 0;
  virtual bool is_in_chained_mode() const = 0;

 protected:
  std::vector<hardware_interface::LoanedCommandInterface> command_interfaces_;
  std::vector<hardware_interface::LoanedStateInterface> state_interfaces_;

  std::shared_ptr<Node> node_;

 private:
  void make_node(const ControllerInterfaceParams& params) {
    params_ = params;
    if (params_.update_rate == 0) params_.update_rate = params_.controller_manager_update_rate;
    rclcpp::NodeOptions options = params.node_options;
    const rclcpp::NodeOptions custom = define_custom_node_options();
    options.allow_undeclared_parameters(custom.allow_undeclared_parameters());
    options.automatically_declare_parameters_from_overrides(
        custom.automatically_declare_parameters_from_overrides());
    node_ = std::make_shared<Node>(params.controller_name, params.node_namespace, options, false);
    node_->get_node_base_interface()->polyarm_robot_description = params.robot_description;
    node_->get_node_base_interface()->polyarm_reads_undeclared = true;
    node_->register_on_configure([this](const auto& state) { return on_configure(state); });
    node_->register_on_cleanup([this](const auto& state) { return on_cleanup(state); });
    node_->register_on_activate([this](const auto& state) { return on_activate(state); });
    node_->register_on_deactivate([this](const auto& state) { return on_deactivate(state); });
    node_->register_on_shutdown([this](const auto& state) { return on_shutdown(state); });
    node_->register_on_error([this](const auto& state) { return on_error(state); });
  }

  ControllerInterfaceParams params_;
};
using ControllerInterfaceBaseSharedPtr = std::shared_ptr<ControllerInterfaceBase>;

}  // namespace controller_interface
