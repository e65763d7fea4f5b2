#pragma once
/// A filter whose parameters are numbers of its node.
#include <stdexcept>
#include <string>

#include "filters/filter_base.hpp"
#include "rclcpp/parameter.hpp"

namespace control_filters {
template <typename T>
class NodeFilter : public filters::FilterBase<T> {
 protected:
  /// The parameter below the filter's prefix. Throws std::runtime_error if it has no value.
  double number(const std::string& name) {
    const std::string full = this->param_prefix_.empty() ? name : this->param_prefix_ + "." + name;
    auto& node = *this->params_interface_;
    if (!node.has_parameter(full)) {
      if (!node.is_overridden(full))
        throw std::runtime_error("the filter's parameter '" + full + "' has no value");
      node.declare_parameter(full, rclcpp::ParameterValue(0.0));
    }
    return node.get_parameter(full).template get_value<double>();
  }
};
}  // namespace control_filters
