#pragma once
#include <cmath>
#include <string>

#include "rclcpp/parameter.hpp"
#include "rsl/parameter_validators.hpp"

namespace control_filters {
/// Like rsl's; NaN switches the limit off and is good.
template <typename T>
tl::expected<void, std::string> gt_eq_or_nan(const rclcpp::Parameter& p, T bound) {
  return std::isnan(p.get_value<T>()) ? tl::expected<void, std::string>() : rsl::gt_eq<T>(p, bound);
}
template <typename T>
tl::expected<void, std::string> lt_eq_or_nan(const rclcpp::Parameter& p, T bound) {
  return std::isnan(p.get_value<T>()) ? tl::expected<void, std::string>() : rsl::lt_eq<T>(p, bound);
}
}  // namespace control_filters
namespace control_toolbox {
using control_filters::gt_eq_or_nan;
using control_filters::lt_eq_or_nan;
}  // namespace control_toolbox
namespace filters {
using control_filters::gt_eq_or_nan;
using control_filters::lt_eq_or_nan;
}  // namespace filters
