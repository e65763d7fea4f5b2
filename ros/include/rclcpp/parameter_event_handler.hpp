#pragma once
/// Calls back when parameters of the same node change. Those of other nodes cannot be watched.
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "polyarm_ros/door.hpp"
#include "rclcpp/node_interfaces/node_interfaces.hpp"

namespace rclcpp {

struct ParameterCallbackHandle {
  RCLCPP_SMART_PTR_DEFINITIONS(ParameterCallbackHandle)
  std::string parameter_name, node_name;
  std::function<void(const Parameter&)> callback;
  node_interfaces::PostSetParametersCallbackHandle::SharedPtr polyarm_watch;
};

class ParameterEventHandler {
 public:
  RCLCPP_SMART_PTR_DEFINITIONS(ParameterEventHandler)
  using ParameterCallbackType = std::function<void(const Parameter&)>;

  template <typename NodePointer, typename... Rest>
  explicit ParameterEventHandler(const NodePointer& node, Rest&&...)
      : core_(node->get_node_base_interface()) {}

  /// Called as long as the handle lives.
  ParameterCallbackHandle::SharedPtr add_parameter_callback(const std::string& parameter,
                                                            ParameterCallbackType callback,
                                                            const std::string& node = "") {
    auto out = std::make_shared<ParameterCallbackHandle>();
    out->parameter_name = parameter, out->node_name = node, out->callback = callback;
    if (!node.empty() && node != core_->get_name() && node != core_->get_fully_qualified_name())
      polyarm_ros::report_unavailable(core_->get_name(), "node", node);
    else
      out->polyarm_watch =
          core_->add_post_set_parameters_callback([parameter, callback](const std::vector<Parameter>& all) {
            for (const Parameter& each : all)
              if (each.get_name() == parameter) callback(each);
          });
    return out;
  }
  void remove_parameter_callback(ParameterCallbackHandle::SharedPtr handle) { handle->polyarm_watch.reset(); }

 private:
  node_interfaces::NodeBaseInterface::SharedPtr core_;
};

}  // namespace rclcpp
