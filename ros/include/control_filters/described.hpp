#pragma once
/// The filters of control_toolbox under the names that plugin description files give them, for chains of
/// filters.
#include <string>
#include <vector>

#include "control_filters/exponential_filter.hpp"
#include "control_filters/low_pass_filter.hpp"
#include "pluginlib/class_loader.hpp"

namespace control_filters {
template <typename Filter, typename T>
void describe(const std::string& name, const char* base) {
  polyarm_ros::described_types().try_emplace(name, name);
  polyarm_ros::exported_classes().try_emplace(
      name, polyarm_ros::ExportedClass{
                base, []() -> void* { return static_cast<filters::FilterBase<T>*>(new Filter); }});
}
inline bool describe_all() {
  using Wrench = geometry_msgs::msg::WrenchStamped;
  using Doubles = std::vector<double>;
  describe<LowPassFilter<double>, double>("control_filters/LowPassFilterDouble",
                                          "filters::FilterBase<double>");
  describe<LowPassFilter<Doubles>, Doubles>("control_filters/LowPassFilterVectorDouble",
                                            "filters::FilterBase<std::vector<double>>");
  describe<LowPassFilter<Wrench>, Wrench>("control_filters/LowPassFilterWrench",
                                          "filters::FilterBase<geometry_msgs::msg::WrenchStamped>");
  describe<ExponentialFilter<double>, double>("control_filters/ExponentialFilterDouble",
                                              "filters::FilterBase<double>");
  return true;
}
}  // namespace control_filters
