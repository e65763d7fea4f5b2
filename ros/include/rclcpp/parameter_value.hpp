#pragma once
/// A parameter's value: one of ROS's nine types.
#include <cstdint>
#include <sstream>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include "rcl_interfaces/msg/parameter.hpp"
#include "rcl_interfaces/msg/parameter_descriptor.hpp"
#include "rcl_interfaces/msg/parameter_type.hpp"
#include "rcl_interfaces/msg/set_parameters_result.hpp"
#include "rclcpp/exceptions.hpp"

namespace rclcpp {

enum class ParameterType : std::uint8_t {
  PARAMETER_NOT_SET,
  PARAMETER_BOOL,
  PARAMETER_INTEGER,
  PARAMETER_DOUBLE,
  PARAMETER_STRING,
  PARAMETER_BYTE_ARRAY,
  PARAMETER_BOOL_ARRAY,
  PARAMETER_INTEGER_ARRAY,
  PARAMETER_DOUBLE_ARRAY,
  PARAMETER_STRING_ARRAY
};
class ParameterTypeException : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
  ParameterTypeException(ParameterType, ParameterType) : std::runtime_error("parameter has another type") {}
};

class ParameterValue {
 public:
  using Variant = std::variant<std::monostate, bool, std::int64_t, double, std::string,
                               std::vector<std::uint8_t>, std::vector<bool>, std::vector<std::int64_t>,
                               std::vector<double>, std::vector<std::string>>;
  ParameterValue() = default;
  template <typename T>
  explicit ParameterValue(const T& value) : value_(stored(value)) {}
  explicit ParameterValue(const rcl_interfaces::msg::ParameterValue& from);
  rcl_interfaces::msg::ParameterValue to_value_msg() const;

  ParameterType get_type() const { return static_cast<ParameterType>(value_.index()); }
  template <typename T>
  T get() const {
    if constexpr (std::is_same_v<T, ParameterValue>) {
      return *this;
    } else if constexpr (std::is_same_v<T, bool>) {
      return as<bool>();
    } else if constexpr (std::is_enum_v<T>) {
      return static_cast<T>(as<std::int64_t>());
    } else if constexpr (std::is_integral_v<T>) {
      return static_cast<T>(as<std::int64_t>());
    } else if constexpr (std::is_floating_point_v<T>) {
      if (const auto* whole = std::get_if<std::int64_t>(&value_)) return static_cast<T>(*whole);
      return static_cast<T>(as<double>());
    } else if constexpr (std::is_constructible_v<std::string, T> && !std::is_same_v<T, std::nullptr_t>) {
      return as<std::string>();
    } else {
      using Element = typename T::value_type;
      if constexpr (std::is_same_v<Element, int> || std::is_same_v<Element, long long>) {
        const auto& all = as<std::vector<std::int64_t>>();
        return T(all.begin(), all.end());
      } else if constexpr (std::is_same_v<Element, float>) {
        const auto& all = as<std::vector<double>>();
        return T(all.begin(), all.end());
      } else {
        return as<T>();
      }
    }
  }
  template <ParameterType type>
  decltype(auto) get() const {
    return as<std::variant_alternative_t<static_cast<std::size_t>(type), Variant>>();
  }
  /// The same value as another type, where files write it alike: 1 for 1.0, [] for any array, one value for an
  /// array of it, a number for a text. Throws InvalidParameterTypeException with the name.
  ParameterValue as_type(ParameterType wanted, const std::string& name) const;
  /// As ROS prints it: `true`, `2`, `0.500000`, `text`, `["a", "b"]`.
  std::string as_text() const {
    return std::visit([](const auto& value) { return text_of(value); }, value_);
  }
  bool operator==(const ParameterValue& o) const { return value_ == o.value_; }
  bool operator!=(const ParameterValue& o) const { return value_ != o.value_; }

 private:
  template <typename T>
  static Variant stored(const T& v) {
    if constexpr (std::is_same_v<T, bool>)
      return v;
    else if constexpr (std::is_enum_v<T>)
      return static_cast<std::int64_t>(v);
    else if constexpr (std::is_integral_v<T>)
      return static_cast<std::int64_t>(v);
    else if constexpr (std::is_floating_point_v<T>)
      return static_cast<double>(v);
    else if constexpr (std::is_convertible_v<T, std::string>)
      return std::string(v);
    else if constexpr (std::is_same_v<T, std::vector<int>>)
      return std::vector<std::int64_t>(v.begin(), v.end());
    else if constexpr (std::is_same_v<T, std::vector<float>>)
      return std::vector<double>(v.begin(), v.end());
    else
      return v;
  }
  static std::string text_of(std::monostate) { return "not set"; }
  static std::string text_of(bool value) { return value ? "true" : "false"; }
  static std::string text_of(const std::string& value) { return value; }
  template <typename T>
  static std::string text_of(const T& value) {
    if constexpr (std::is_arithmetic_v<T>) {
      return std::to_string(value);
    } else {
      using Element = typename T::value_type;
      std::string out;
      for (const Element each : value) {
        const std::string text = text_of(each);
        out += (out.empty() ? "" : ", ") + (std::is_same_v<Element, std::string> ? '"' + text + '"' : text);
      }
      return "[" + out + "]";
    }
  }
  template <typename T>
  const T& as() const {
    if (const T* found = std::get_if<T>(&value_)) return *found;
    throw ParameterTypeException("parameter has another type");
  }
  Variant value_;
};

inline ParameterValue::ParameterValue(const rcl_interfaces::msg::ParameterValue& from) {
  switch (static_cast<ParameterType>(from.type)) {
    case ParameterType::PARAMETER_NOT_SET:
      return;
    case ParameterType::PARAMETER_BOOL:
      value_ = from.bool_value;
      return;
    case ParameterType::PARAMETER_INTEGER:
      value_ = from.integer_value;
      return;
    case ParameterType::PARAMETER_DOUBLE:
      value_ = from.double_value;
      return;
    case ParameterType::PARAMETER_STRING:
      value_ = from.string_value;
      return;
    case ParameterType::PARAMETER_BYTE_ARRAY:
      value_ = from.byte_array_value;
      return;
    case ParameterType::PARAMETER_BOOL_ARRAY:
      value_ = from.bool_array_value;
      return;
    case ParameterType::PARAMETER_INTEGER_ARRAY:
      value_ = from.integer_array_value;
      return;
    case ParameterType::PARAMETER_DOUBLE_ARRAY:
      value_ = from.double_array_value;
      return;
    case ParameterType::PARAMETER_STRING_ARRAY:
      value_ = from.string_array_value;
      return;
  }
  throw std::runtime_error("the message names no type of a parameter");
}
inline rcl_interfaces::msg::ParameterValue ParameterValue::to_value_msg() const {
  rcl_interfaces::msg::ParameterValue out;
  out.type = static_cast<std::uint8_t>(get_type());
  const auto put = [this](auto& to) {
    if (const auto* held = std::get_if<std::decay_t<decltype(to)>>(&value_)) to = *held;
  };
  put(out.bool_value), put(out.integer_value), put(out.double_value), put(out.string_value);
  put(out.byte_array_value), put(out.bool_array_value), put(out.integer_array_value);
  put(out.double_array_value), put(out.string_array_value);
  return out;
}

inline const char* to_text(ParameterType type) {
  static const char* const names[] = {"not set", "bool", "integer", "double", "string", "byte_array",
                                      "bool_array", "integer_array", "double_array", "string_array"};
  return names[static_cast<int>(type)];
}

inline ParameterValue ParameterValue::as_type(ParameterType wanted, const std::string& name) const {
  using T = ParameterType;
  const T have = get_type();
  if (have == wanted || wanted == T::PARAMETER_NOT_SET || have == T::PARAMETER_NOT_SET) return *this;
  const auto text = [this] {
    if (const auto* whole = std::get_if<std::int64_t>(&value_)) return std::to_string(*whole);
    if (const auto* yes = std::get_if<bool>(&value_)) return std::string(*yes ? "true" : "false");
    std::ostringstream out;
    out.precision(15);
    out << as<double>();
    return out.str();
  };
  const bool scalar = have < T::PARAMETER_STRING;
  if (wanted == T::PARAMETER_DOUBLE && have == T::PARAMETER_INTEGER)
    return ParameterValue(static_cast<double>(as<std::int64_t>()));
  if (wanted == T::PARAMETER_STRING && scalar) return ParameterValue(text());
  if (wanted == T::PARAMETER_DOUBLE_ARRAY) {
    if (have == T::PARAMETER_INTEGER_ARRAY) {
      const auto& all = as<std::vector<std::int64_t>>();
      return ParameterValue(std::vector<double>(all.begin(), all.end()));
    }
    if (have == T::PARAMETER_INTEGER || have == T::PARAMETER_DOUBLE)
      return ParameterValue(std::vector<double>{get<double>()});
  }
  if (wanted == T::PARAMETER_STRING_ARRAY && (scalar || have == T::PARAMETER_STRING))
    return ParameterValue(
        std::vector<std::string>{have == T::PARAMETER_STRING ? as<std::string>() : text()});
  const auto* none = std::get_if<std::vector<std::string>>(&value_);
  if (none && none->empty()) {
    if (wanted == T::PARAMETER_BOOL_ARRAY) return ParameterValue(std::vector<bool>());
    if (wanted == T::PARAMETER_INTEGER_ARRAY) return ParameterValue(std::vector<std::int64_t>());
    if (wanted == T::PARAMETER_DOUBLE_ARRAY) return ParameterValue(std::vector<double>());
  }
  throw exceptions::InvalidParameterTypeException("parameter '" + name + "' has the type " + to_text(have) +
                                                  " in the file; it must be a " + to_text(wanted));
}

class Parameter {
 public:
  Parameter() = default;
  explicit Parameter(std::string name) : name_(std::move(name)) {}
  Parameter(std::string name, ParameterValue value) : name_(std::move(name)), value_(std::move(value)) {}
  template <typename T>
  Parameter(std::string name, T value) : name_(std::move(name)), value_(value) {}
  const std::string& get_name() const { return name_; }
  ParameterType get_type() const { return value_.get_type(); }
  std::string get_type_name() const { return to_text(get_type()); }
  const ParameterValue& get_parameter_value() const { return value_; }
  template <typename T>
  T get_value() const {
    return value_.get<T>();
  }
  template <ParameterType type>
  decltype(auto) get_value() const {
    return value_.get<type>();
  }
  bool as_bool() const { return value_.get<bool>(); }
  std::int64_t as_int() const { return value_.get<std::int64_t>(); }
  double as_double() const { return value_.get<double>(); }
  std::string as_string() const { return value_.get<std::string>(); }
  std::vector<bool> as_bool_array() const { return value_.get<std::vector<bool>>(); }
  std::vector<std::int64_t> as_integer_array() const { return value_.get<std::vector<std::int64_t>>(); }
  std::vector<double> as_double_array() const { return value_.get<std::vector<double>>(); }
  std::vector<std::string> as_string_array() const { return value_.get<std::vector<std::string>>(); }
  std::vector<std::uint8_t> as_byte_array() const { return value_.get<std::vector<std::uint8_t>>(); }
  std::string value_to_string() const { return value_.as_text(); }
  static Parameter from_parameter_msg(const rcl_interfaces::msg::Parameter& from) {
    return {from.name, ParameterValue(from.value)};
  }
  rcl_interfaces::msg::Parameter to_parameter_msg() const {
    rcl_interfaces::msg::Parameter out;
    out.name = name_;
    out.value = value_.to_value_msg();
    return out;
  }
  rcl_interfaces::msg::ParameterValue get_value_message() const { return value_.to_value_msg(); }
  bool operator==(const Parameter& other) const { return name_ == other.name_ && value_ == other.value_; }
  bool operator!=(const Parameter& other) const { return !(*this == other); }

 private:
  std::string name_;
  ParameterValue value_;
};
inline std::string to_string(const ParameterValue& value) {
  return value.as_text();
}
inline std::string to_string(const Parameter& parameter) {
  return parameter.value_to_string();
}

}  // namespace rclcpp
