#pragma once
#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "rclcpp/executors.hpp"

namespace rclcpp {
/// Parameters of other nodes cannot be reached from a plugin.
class SyncParametersClient {
 public:
  RCLCPP_SMART_PTR_DEFINITIONS(SyncParametersClient)
  template <typename NodePointer>
  explicit SyncParametersClient(NodePointer&& node, const std::string& remote = "") {
    polyarm_ros::report_unavailable(node->get_name(), "node", remote);
  }
  template <typename Timeout = std::chrono::nanoseconds>
  bool wait_for_service(Timeout = {}) {
    return false;
  }
  bool service_is_ready() const { return false; }
  bool has_parameter(const std::string&) { return false; }
  template <typename T>
  T get_parameter(const std::string&, const T& otherwise) {
    return otherwise;
  }
  template <typename T>
  T get_parameter(const std::string&) {
    return {};
  }
  std::vector<Parameter> get_parameters(const std::vector<std::string>&) { return {}; }
};
class AsyncParametersClient : public SyncParametersClient {
 public:
  RCLCPP_SMART_PTR_DEFINITIONS(AsyncParametersClient)
  using SyncParametersClient::SyncParametersClient;
  std::shared_future<std::vector<Parameter>> get_parameters(const std::vector<std::string>&) {
    std::promise<std::vector<Parameter>> made;
    made.set_value({});
    return made.get_future().share();
  }
};
}  // namespace rclcpp
