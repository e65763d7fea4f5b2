#pragma once
#include <chrono>
#include <future>
#include <memory>
#include <string>
#include <vector>

#include "rclcpp/executors.hpp"

namespace rclcpp {

/// Parameters of other nodes. Only one is known here: the `robot_description` of robot_state_publisher, to
/// the node of a controller.
class SyncParametersClient {
 public:
  RCLCPP_SMART_PTR_DEFINITIONS(SyncParametersClient)
  template <typename NodePointer, typename... Rest>
  explicit SyncParametersClient(NodePointer&& node, const std::string& remote = "", Rest&&...)
      : core_(node->get_node_base_interface()),
        known_(remote.find("robot_state_publisher") != std::string::npos &&
               !core_->polyarm_robot_description.empty()) {
    if (!known_) polyarm_ros::report_unavailable(core_->get_name(), "node", remote);
  }
  template <typename Rep = long, typename Ratio = std::milli>
  bool wait_for_service(std::chrono::duration<Rep, Ratio> = std::chrono::duration<Rep, Ratio>(-1)) {
    return known_;
  }
  bool service_is_ready() const { return known_; }
  bool has_parameter(const std::string& name) { return !get(name).empty(); }
  template <typename T>
  T get_parameter(const std::string& name, const T& otherwise) {
    const auto found = get(name);
    return found.empty() ? otherwise : found.front().get_value<T>();
  }
  template <typename T>
  T get_parameter(const std::string& name) {
    const auto found = get(name);
    if (found.empty())
      throw exceptions::ParameterNotDeclaredException("the parameter '" + name +
                                                      "' of another node is not known here");
    return found.front().get_value<T>();
  }
  std::vector<Parameter> get_parameters(const std::vector<std::string>& names) {
    std::vector<Parameter> out;
    for (const std::string& name : names)
      for (Parameter& each : get(name)) out.push_back(std::move(each));
    return out;
  }

 private:
  std::vector<Parameter> get(const std::string& name) const {
    if (!known_ || name != "robot_description") return {};
    return {Parameter(name, core_->polyarm_robot_description)};
  }
  node_interfaces::NodeBaseInterface::SharedPtr core_;
  bool known_;
};

class AsyncParametersClient : public SyncParametersClient {
 public:
  RCLCPP_SMART_PTR_DEFINITIONS(AsyncParametersClient)
  using SyncParametersClient::SyncParametersClient;
  std::shared_future<std::vector<Parameter>> get_parameters(
      const std::vector<std::string>& names,
      const std::function<void(std::shared_future<std::vector<Parameter>>)>& call = nullptr) {
    std::promise<std::vector<Parameter>> made;
    made.set_value(SyncParametersClient::get_parameters(names));
    const auto out = made.get_future().share();
    if (call) call(out);
    return out;
  }
};

}  // namespace rclcpp
