#pragma once
#include <memory>
#include <string>

#include "polyarm_ros/door.hpp"
#include "rclcpp/callback_group.hpp"
#include "rclcpp/qos.hpp"

struct rmw_request_id_t {
  signed char writer_guid[16];
  long long sequence_number;
};

namespace rclcpp {

class ServiceBase {
 public:
  RCLCPP_SMART_PTR_DEFINITIONS(ServiceBase)
  ServiceBase(const std::string& node, std::string name) : name_(std::move(name)) {
    polyarm_ros::report_unavailable(node, "service", name_);
  }
  virtual ~ServiceBase() = default;
  const char* get_service_name() const { return name_.c_str(); }

 private:
  std::string name_;
};
/// Never called.
template <typename Type>
class Service : public ServiceBase {
 public:
  RCLCPP_SMART_PTR_DEFINITIONS(Service<Type>)
  using ServiceBase::ServiceBase;
  void send_response(rmw_request_id_t&, typename Type::Response&) {}
};

}  // namespace rclcpp
