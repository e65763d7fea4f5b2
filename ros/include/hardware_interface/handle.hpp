#pragma once
/// Named numbers that hardware and controllers share. A handle either points at a variable of its plugin
/// (exported by hand) or owns its number (exported by description). One thread at a time: the loop's, while
/// the plugin is active.
#include <cstdint>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>

#include "hardware_interface/hardware_info.hpp"
#include "hardware_interface/introspection.hpp"
#include "hardware_interface/lexical_casts.hpp"
#include "hardware_interface/macros.hpp"
#include "hardware_interface/visibility_control.h"
#include "polyarm_ros/standard.hpp"
#include "rclcpp/logging.hpp"
#include "rcpputils/pointer_traits.hpp"

namespace hardware_interface {

using HANDLE_DATATYPE = std::variant<std::monostate, double, bool>;

class Handle {
 public:
  Handle(const std::string& prefix, const std::string& interface, double* value = nullptr)
      : prefix_(prefix),
        interface_(interface),
        name_(prefix + "/" + interface),
        type_(HandleDataType::DOUBLE),
        value_(value),
        bound_(value != nullptr) {}
  Handle(const std::string& prefix, const std::string& interface, const std::string& data_type,
         const std::string& initial = "")
      : prefix_(prefix),
        interface_(interface),
        name_(prefix + "/" + interface),
        type_(HandleDataType(data_type)),
        own_(first_value(initial)) {}
  explicit Handle(const InterfaceDescription& description)
      : Handle(description.get_prefix_name(), description.get_interface_name(),
               description.get_data_type_string(), description.interface_info.initial_value) {}
  explicit Handle(const std::string& interface) : interface_(interface), name_("/" + interface) {}
  explicit Handle(const char* interface) : Handle(std::string(interface)) {}
  Handle(const Handle&) = default;
  Handle(Handle&&) = default;
  Handle& operator=(const Handle&) = default;
  Handle& operator=(Handle&&) = default;
  virtual ~Handle() = default;

  explicit operator bool() const { return bound_; }
  const std::string& get_name() const { return name_; }
  const std::string get_full_name() const { return name_; }
  const std::string& get_interface_name() const { return interface_; }
  const std::string& get_prefix_name() const { return prefix_; }
  HandleDataType get_data_type() const { return type_; }
  bool is_castable_to_double() const { return true; }
  bool is_valid() const { return true; }

  double get_value() const { return *place(); }
  template <typename T>
  bool get_value(T& out) const {
    return out = as<T>(*place()), true;
  }
  template <typename T>
  bool get_value(T& out, bool) const {
    return get_value(out);
  }
  template <typename T = double>
  std::optional<T> get_optional(unsigned int = 10) const {
    return as<T>(*place());
  }

  template <typename T>
  bool set_value(const T& value) {
    return *place() = static_cast<double>(value), true;
  }
  template <typename T>
  bool set_value(const T& value, bool) {
    return set_value(value);
  }
  template <typename T>
  bool set_value(const T& value, unsigned int) {
    return set_value(value);
  }

  /// Where the number is. Not part of ROS's interface.
  double* polyarm_place() { return place(); }

 protected:
  template <typename T>
  static T as(double value) {
    if constexpr (std::is_same_v<T, bool>)
      return value != 0.0;
    else
      return static_cast<T>(value);
  }
  /// The initial value of the description, else the one that means "not set yet" for the type.
  double first_value(const std::string& text) const {
    if (!text.empty()) {
      if (type_ == HandleDataType::BOOL) return parse_bool(text) ? 1.0 : 0.0;
      return hardware_interface::stod(text);
    }
    switch (type_) {
      case HandleDataType::BOOL:
        return 0;
      case HandleDataType::UINT8:
        return std::numeric_limits<std::uint8_t>::max();
      case HandleDataType::INT8:
        return std::numeric_limits<std::int8_t>::max();
      case HandleDataType::UINT16:
        return std::numeric_limits<std::uint16_t>::max();
      case HandleDataType::INT16:
        return std::numeric_limits<std::int16_t>::max();
      case HandleDataType::UINT32:
        return std::numeric_limits<std::uint32_t>::max();
      case HandleDataType::INT32:
        return std::numeric_limits<std::int32_t>::max();
      default:
        return std::numeric_limits<double>::quiet_NaN();
    }
  }
  double* place() const { return bound_ ? value_ : const_cast<double*>(&own_); }

  std::string prefix_, interface_, name_;
  HandleDataType type_ = HandleDataType::DOUBLE;
  double* value_ = nullptr;
  bool bound_ = false;
  double own_ = std::numeric_limits<double>::quiet_NaN();
};

class StateInterface : public Handle {
 public:
  using Handle::Handle;
  using SharedPtr = std::shared_ptr<StateInterface>;
  using ConstSharedPtr = std::shared_ptr<const StateInterface>;
  void registerIntrospection() const {}
  void unregisterIntrospection() const {}
};

class CommandInterface : public Handle {
 public:
  using Handle::Handle;
  using SharedPtr = std::shared_ptr<CommandInterface>;
  /// Commands belong to one owner: no copies.
  CommandInterface(const CommandInterface&) = delete;
  CommandInterface(CommandInterface&&) = default;
  CommandInterface& operator=(CommandInterface&&) = default;
  void registerIntrospection() const {}
  void unregisterIntrospection() const {}
};

/// The names of Foxy.
class ReadOnlyHandle : public Handle {
 public:
  using Handle::Handle;
};
class ReadWriteHandle : public Handle {
 public:
  using Handle::Handle;
};

}  // namespace hardware_interface
