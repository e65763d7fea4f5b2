#pragma once
/// The validators that parameter files name: no value if the parameter is good, else what is wrong.
#include <algorithm>
#include <cstddef>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "rclcpp/parameter.hpp"
#include "tl/expected.hpp"

namespace rsl {

namespace detail {
using Validity = tl::expected<void, std::string>;
template <typename T>
std::string shown(const T& value) {
  std::ostringstream out;
  out << value;
  return out.str();
}
template <typename T>
std::string shown(const std::vector<T>& all) {
  std::string out;
  for (const auto& each : all) out += (out.empty() ? "" : ", ") + shown(static_cast<T>(each));
  return "{" + out + "}";
}
inline Validity wrong(const rclcpp::Parameter& p, const std::string& what) {
  return tl::make_unexpected("parameter '" + p.get_name() + "' " + what);
}
inline std::size_t length(const rclcpp::Parameter& p) {
  using Type = rclcpp::ParameterType;
  switch (p.get_type()) {
    case Type::PARAMETER_STRING:
      return p.as_string().size();
    case Type::PARAMETER_BOOL_ARRAY:
      return p.as_bool_array().size();
    case Type::PARAMETER_INTEGER_ARRAY:
      return p.as_integer_array().size();
    case Type::PARAMETER_DOUBLE_ARRAY:
      return p.as_double_array().size();
    case Type::PARAMETER_STRING_ARRAY:
      return p.as_string_array().size();
    default:
      return 0;
  }
}
/// All elements, or the one value.
template <typename T>
std::vector<T> elements(const rclcpp::Parameter& p) {
  return p.get_type() >= rclcpp::ParameterType::PARAMETER_BYTE_ARRAY
             ? p.get_value<std::vector<T>>()
             : std::vector<T>{p.get_value<T>()};
}
template <typename T, typename Test>
Validity each(const rclcpp::Parameter& p, Test good, const std::string& rule) {
  for (const T value : elements<T>(p))
    if (!good(value)) return wrong(p, "is " + shown(value) + "; it must be " + rule);
  return {};
}
}  // namespace detail

#define POLYARM_ROS_COMPARE_(NAME, OP, RULE)                                                           \
  template <typename T>                                                                                \
  detail::Validity NAME(const rclcpp::Parameter& p, T bound) {                                         \
    return detail::each<T>(p, [&](const T& v) { return v OP bound; }, RULE + detail::shown(bound));    \
  }
POLYARM_ROS_COMPARE_(gt, >, "above ")
POLYARM_ROS_COMPARE_(gt_eq, >=, "at least ")
POLYARM_ROS_COMPARE_(lt, <, "below ")
POLYARM_ROS_COMPARE_(lt_eq, <=, "at most ")
POLYARM_ROS_COMPARE_(lower_bounds, >=, "at least ")
POLYARM_ROS_COMPARE_(upper_bounds, <=, "at most ")
POLYARM_ROS_COMPARE_(lower_element_bounds, >=, "at least ")
POLYARM_ROS_COMPARE_(upper_element_bounds, <=, "at most ")
#undef POLYARM_ROS_COMPARE_

template <typename T>
detail::Validity bounds(const rclcpp::Parameter& p, T low, T high) {
  return detail::each<T>(
      p, [&](const T& v) { return v >= low && v <= high; },
      "from " + detail::shown(low) + " to " + detail::shown(high));
}
template <typename T>
detail::Validity element_bounds(const rclcpp::Parameter& p, T low, T high) {
  return bounds<T>(p, low, high);
}
template <typename T>
detail::Validity one_of(const rclcpp::Parameter& p, const std::vector<T>& all) {
  return detail::each<T>(
      p, [&](const T& v) { return std::find(all.begin(), all.end(), v) != all.end(); },
      "one of " + detail::shown(all));
}
template <typename T>
detail::Validity subset_of(const rclcpp::Parameter& p, const std::vector<T>& all) {
  return one_of<T>(p, all);
}
template <typename T>
detail::Validity unique(const rclcpp::Parameter& p) {
  const std::vector<T> all = detail::elements<T>(p);
  if (std::set<T>(all.begin(), all.end()).size() != all.size())
    return detail::wrong(p, "has a value twice");
  return {};
}
template <typename T = void>
detail::Validity fixed_size(const rclcpp::Parameter& p, std::size_t size) {
  if (detail::length(p) == size) return {};
  return detail::wrong(p, "has " + detail::shown(detail::length(p)) + " values; it must have " +
                              detail::shown(size));
}
template <typename T = void>
detail::Validity size_gt(const rclcpp::Parameter& p, std::size_t size) {
  if (detail::length(p) > size) return {};
  return detail::wrong(p, "must have more than " + detail::shown(size) + " values");
}
template <typename T = void>
detail::Validity size_lt(const rclcpp::Parameter& p, std::size_t size) {
  if (detail::length(p) < size) return {};
  return detail::wrong(p, "must have fewer than " + detail::shown(size) + " values");
}
template <typename T = void>
detail::Validity not_empty(const rclcpp::Parameter& p) {
  if (detail::length(p) > 0) return {};
  return detail::wrong(p, "is empty");
}
inline rcl_interfaces::msg::SetParametersResult to_parameter_result_msg(const detail::Validity& result) {
  rcl_interfaces::msg::SetParametersResult out;
  out.successful = result.has_value();
  if (!result) out.reason = result.error();
  return out;
}

}  // namespace rsl
