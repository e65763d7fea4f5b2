#pragma once
/// Several states that belong together, read as one message.
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "controller_interface/helpers.hpp"
#include "hardware_interface/loaned_state_interface.hpp"

namespace semantic_components {

template <typename Message>
class SemanticComponentInterface {
 public:
  SemanticComponentInterface(const std::string& name, const std::vector<std::string>& names)
      : name_(name), interface_names_(names) {
    state_interfaces_.reserve(names.size());
  }
  explicit SemanticComponentInterface(const std::string& name, std::size_t size = 0) : name_(name) {
    interface_names_.reserve(size);
    state_interfaces_.reserve(size);
  }
  virtual ~SemanticComponentInterface() = default;

  bool assign_loaned_state_interfaces(std::vector<hardware_interface::LoanedStateInterface>& all) {
    return controller_interface::get_ordered_interfaces(all, interface_names_, "", state_interfaces_);
  }
  void release_interfaces() { state_interfaces_.clear(); }
  virtual std::vector<std::string> get_state_interface_names() {
    if (interface_names_.empty())
      for (std::size_t i = 0; i < interface_names_.capacity(); ++i)
        interface_names_.push_back(name_ + "/" + std::to_string(i + 1));
    return interface_names_;
  }
  bool get_values(std::vector<double>& values) const {
    if (values.capacity() != state_interfaces_.size()) return false;
    for (std::size_t i = 0; i < state_interfaces_.size(); ++i) values.push_back(value(i));
    return true;
  }
  bool get_values_as_message(Message&) { return false; }

 protected:
  double value(std::size_t i) const { return state_interfaces_[i].get().get_value(); }
  static std::vector<std::string> named(const std::string& name, std::initializer_list<const char*> parts) {
    std::vector<std::string> out;
    for (const char* part : parts) out.push_back(name + "/" + part);
    return out;
  }

  std::string name_;
  std::vector<std::string> interface_names_;
  std::vector<std::reference_wrapper<hardware_interface::LoanedStateInterface>> state_interfaces_;
};

}  // namespace semantic_components
