#pragma once
/// Filters one behind the other: `filter1`, `filter2`, … with `name` and `type`. Their classes are those of
/// control_toolbox and those in the module.
#include <memory>
#include <string>
#include <vector>

#include "control_filters/described.hpp"
#include "filters/filter_base.hpp"
#include "pluginlib/class_loader.hpp"
#include "rclcpp/logging.hpp"

namespace filters {
template <typename T>
class FilterChain {
 public:
  explicit FilterChain(std::string type)
      : loader_("filters", "filters::FilterBase<" + type + ">", "filters_plugin") {
    static const bool described = control_filters::describe_all();
    static_cast<void>(described);
  }
  bool configure(const std::string& prefix,
                 const rclcpp::node_interfaces::NodeLoggingInterface::SharedPtr& logging,
                 const rclcpp::node_interfaces::NodeParametersInterface::SharedPtr& parameters) {
    all_.clear();
    for (int i = 1;; ++i) {
      const std::string begin = (prefix.empty() ? "" : prefix + ".") + "filter" + std::to_string(i) + ".";
      const std::string type = text(*parameters, begin + "type"), name = text(*parameters, begin + "name");
      if (type.empty()) return true;
      std::shared_ptr<FilterBase<T>> made;
      try {
        made = loader_.createSharedInstance(type);
      } catch (const pluginlib::PluginlibException& e) {
        RCLCPP_ERROR(logging->get_logger(), "the filter '%s': %s", type.c_str(), e.what());
        return false;
      }
      if (!made->configure(begin + "params", name, logging, parameters)) return false;
      all_.push_back(made);
    }
  }
  bool update(const T& in, T& out) {
    out = in;
    for (const auto& each : all_) {
      const T before = out;
      if (!each->update(before, out)) return false;
    }
    return true;
  }
  void clear() { all_.clear(); }
  std::size_t get_length() const { return all_.size(); }

 private:
  static std::string text(rclcpp::node_interfaces::NodeCore& node, const std::string& name) {
    if (!node.has_parameter(name)) node.declare_parameter(name, rclcpp::ParameterValue(std::string()));
    return node.get_parameter(name).get_value<std::string>();
  }
  pluginlib::ClassLoader<FilterBase<T>> loader_;
  std::vector<std::shared_ptr<FilterBase<T>>> all_;
};
}  // namespace filters
