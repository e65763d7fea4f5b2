#pragma once
#include <map>
#include <memory>
#include <string>

#include "rclcpp/node_interfaces/node_interfaces.hpp"

namespace filters {
/// One filter of a chain; its parameters are those of a node below a prefix.
template <typename T>
class FilterBase {
  using Parameters = rclcpp::node_interfaces::NodeParametersInterface::SharedPtr;
  using Logging = rclcpp::node_interfaces::NodeLoggingInterface::SharedPtr;

 public:
  virtual ~FilterBase() = default;
  bool configure(const std::string& prefix, const std::string& name, const Logging& logging,
                 const Parameters& parameters) {
    param_prefix_ = prefix, filter_name_ = name;
    logging_interface_ = logging, params_interface_ = parameters;
    return configured_ = configure();
  }
  virtual bool update(const T& in, T& out) = 0;
  const std::string& getName() const { return filter_name_; }

 protected:
  virtual bool configure() = 0;
  std::string param_prefix_, filter_name_;
  bool configured_ = false;
  Parameters params_interface_;
  Logging logging_interface_;
};
}  // namespace filters
