#pragma once
#include <functional>
#include <string>
#include <vector>

#include "controller_interface/helpers.hpp"
#include "hardware_interface/loaned_command_interface.hpp"

namespace semantic_components {

/// Several commands that belong together, written from one message.
template <typename Message>
class SemanticComponentCommandInterface {
 public:
  SemanticComponentCommandInterface(const std::string& name, const std::vector<std::string>& names)
      : name_(name), interface_names_(names) {
    command_interfaces_.reserve(names.size());
  }
  SemanticComponentCommandInterface(const SemanticComponentCommandInterface&) = delete;
  virtual ~SemanticComponentCommandInterface() = default;
  bool assign_loaned_command_interfaces(std::vector<hardware_interface::LoanedCommandInterface>& all) {
    return controller_interface::get_ordered_interfaces(all, interface_names_, "", command_interfaces_);
  }
  void release_interfaces() { command_interfaces_.clear(); }
  const std::vector<std::string>& get_command_interface_names() const { return interface_names_; }
  virtual bool set_values_from_message(const Message&) = 0;

 protected:
  bool set_values(const std::vector<double>& values) {
    if (values.size() != command_interfaces_.size()) return false;
    for (std::size_t i = 0; i < values.size(); ++i) command_interfaces_[i].get().set_value(values[i]);
    return true;
  }
  std::string name_;
  std::vector<std::string> interface_names_;
  std::vector<std::reference_wrapper<hardware_interface::LoanedCommandInterface>> command_interfaces_;
};

}  // namespace semantic_components
