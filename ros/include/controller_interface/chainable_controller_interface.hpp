#pragma once
/// A controller that others may command: it exports references, and perhaps states. A plugin overrides the
/// form that it knows: lists of handles (Rolling, Jazzy) or vectors of values (Humble).
#include "controller_interface/controller_interface_base.hpp"

namespace controller_interface {

class ChainableControllerInterface : public ControllerInterfaceBase {
  using State = hardware_interface::StateInterface;
  using Command = hardware_interface::CommandInterface;

 public:
  bool is_chainable() const final { return true; }
  bool is_in_chained_mode() const final { return chained_; }
  bool set_chained_mode(bool chained) final {
    if (!on_set_chained_mode(chained)) return false;
    chained_ = chained;
    return true;
  }
  return_type update(const rclcpp::Time& time, const rclcpp::Duration& period) final {
    if (!chained_)
      if (const auto result = update_reference_from_subscribers(time, period); result != return_type::OK)
        return result;
    return update_and_write_commands(time, period);
  }
  std::vector<State::ConstSharedPtr> export_state_interfaces() final {
    ordered_exported_state_interfaces_ = on_export_state_interfaces_list();
    exported_state_interface_names_.clear();
    exported_state_interfaces_.clear();
    for (const State::SharedPtr& each : ordered_exported_state_interfaces_) {
      check_prefix(each->get_prefix_name());
      exported_state_interface_names_.push_back(each->get_interface_name());
      exported_state_interfaces_[each->get_name()] = each;
    }
    return {ordered_exported_state_interfaces_.begin(), ordered_exported_state_interfaces_.end()};
  }
  std::vector<Command::SharedPtr> export_reference_interfaces() final {
    ordered_exported_reference_interfaces_ = on_export_reference_interfaces_list();
    exported_reference_interface_names_.clear();
    exported_reference_interfaces_.clear();
    for (const Command::SharedPtr& each : ordered_exported_reference_interfaces_) {
      check_prefix(each->get_prefix_name());
      exported_reference_interface_names_.push_back(each->get_interface_name());
      exported_reference_interfaces_[each->get_name()] = each;
    }
    return ordered_exported_reference_interfaces_;
  }

 protected:
  virtual std::vector<State> on_export_state_interfaces() {
    state_interfaces_values_.resize(exported_state_interface_names_.size(),
                                    std::numeric_limits<double>::quiet_NaN());
    std::vector<State> out;
    for (std::size_t i = 0; i < exported_state_interface_names_.size(); ++i)
      out.emplace_back(get_node()->get_name(), exported_state_interface_names_[i],
                       &state_interfaces_values_[i]);
    return out;
  }
  virtual std::vector<State::SharedPtr> on_export_state_interfaces_list() {
    std::vector<State::SharedPtr> out;
    for (State& each : on_export_state_interfaces()) out.push_back(std::make_shared<State>(std::move(each)));
    return out;
  }
  virtual std::vector<Command> on_export_reference_interfaces() {
    reference_interfaces_.resize(exported_reference_interface_names_.size(),
                                 std::numeric_limits<double>::quiet_NaN());
    std::vector<Command> out;
    for (std::size_t i = 0; i < exported_reference_interface_names_.size(); ++i)
      out.emplace_back(get_node()->get_name(), exported_reference_interface_names_[i],
                       &reference_interfaces_[i]);
    return out;
  }
  virtual std::vector<Command::SharedPtr> on_export_reference_interfaces_list() {
    std::vector<Command::SharedPtr> out;
    for (Command& each : on_export_reference_interfaces())
      out.push_back(std::make_shared<Command>(std::move(each)));
    return out;
  }
  virtual bool on_set_chained_mode(bool) { return true; }
  virtual return_type update_reference_from_subscribers(const rclcpp::Time&, const rclcpp::Duration&) {
    return update_reference_from_subscribers();
  }
  virtual return_type update_and_write_commands(const rclcpp::Time&, const rclcpp::Duration&) = 0;
  /// The form of the first releases of Humble.
  virtual return_type update_reference_from_subscribers() { return return_type::OK; }

  std::vector<std::string> exported_state_interface_names_, exported_reference_interface_names_;
  std::vector<State::SharedPtr> ordered_exported_state_interfaces_;
  std::unordered_map<std::string, State::SharedPtr> exported_state_interfaces_;
  std::vector<Command::SharedPtr> ordered_exported_reference_interfaces_;
  std::unordered_map<std::string, Command::SharedPtr> exported_reference_interfaces_;
  std::vector<double> state_interfaces_values_, reference_interfaces_;

 private:
  void check_prefix(const std::string& prefix) const {
    const std::string name = get_node()->get_name();
    if (prefix != name && prefix.rfind(name + "/", 0) != 0)
      throw std::runtime_error("the controller '" + name + "' exports an interface with the prefix '" +
                               prefix + "': it must begin with the controller's name");
  }
  bool chained_ = false;
};

}  // namespace controller_interface
