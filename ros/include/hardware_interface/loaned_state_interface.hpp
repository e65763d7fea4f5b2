#pragma once
#include <functional>
#include <optional>
#include <string>
#include <utility>

#include "hardware_interface/handle.hpp"

namespace hardware_interface {

/// An interface that a controller holds; `release` runs when it lets go.
class LoanedStateInterface {
 public:
  using Deleter = std::function<void()>;
  explicit LoanedStateInterface(StateInterface& interface, Deleter&& release = nullptr)
      : interface_(&interface), release_(std::move(release)) {}
  explicit LoanedStateInterface(const std::shared_ptr<const StateInterface>& interface, Deleter&& release = nullptr)
      : LoanedStateInterface(const_cast<StateInterface&>(*interface), std::move(release)) {}
  LoanedStateInterface(const LoanedStateInterface&) = delete;
  LoanedStateInterface(LoanedStateInterface&& other) noexcept
      : interface_(other.interface_), release_(std::exchange(other.release_, nullptr)) {}
  ~LoanedStateInterface() {
    if (release_) release_();
  }
  const std::string& get_name() const { return interface_->get_name(); }
  const std::string& get_interface_name() const { return interface_->get_interface_name(); }
  const std::string& get_prefix_name() const { return interface_->get_prefix_name(); }
  double get_value() const { return interface_->get_value(); }
  template <typename T = double>
  std::optional<T> get_optional(unsigned int = 10) const {
    return interface_->template get_optional<T>();
  }
  template <typename T>
  bool set_value(const T& value, unsigned int = 10) {
    return interface_->set_value(value);
  }
  HandleDataType get_data_type() const { return interface_->get_data_type(); }
  bool is_castable_to_double() const { return true; }

 private:
  StateInterface* interface_;
  Deleter release_;
};

}  // namespace hardware_interface
