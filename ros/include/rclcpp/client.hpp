#pragma once
#include <chrono>
#include <future>
#include <memory>
#include <string>
#include <utility>

#include "polyarm_ros/door.hpp"
#include "rclcpp/callback_group.hpp"
#include "rclcpp/future_return_code.hpp"
#include "rclcpp/qos.hpp"

namespace rclcpp {

class ClientBase {
 public:
  RCLCPP_SMART_PTR_DEFINITIONS(ClientBase)
  ClientBase(const std::string& node, std::string name) : name_(std::move(name)) {
    polyarm_ros::report_unavailable(node, "service", name_);
  }
  virtual ~ClientBase() = default;
  const char* get_service_name() const { return name_.c_str(); }
  bool service_is_ready() const { return false; }
  template <typename Rep = long, typename Ratio = std::milli>
  bool wait_for_service(std::chrono::duration<Rep, Ratio> = std::chrono::duration<Rep, Ratio>(-1)) {
    return false;
  }

 private:
  std::string name_;
};

/// Of a service that nobody offers: its futures never become ready.
template <typename Type>
class Client : public ClientBase {
 public:
  RCLCPP_SMART_PTR_DEFINITIONS(Client<Type>)
  using ClientBase::ClientBase;
  using SharedRequest = typename Type::Request::SharedPtr;
  using SharedResponse = typename Type::Response::SharedPtr;
  using Promise = std::promise<SharedResponse>;
  using Future = std::future<SharedResponse>;
  using SharedFuture = std::shared_future<SharedResponse>;
  struct FutureAndRequestId : Future {
    using Future::Future;
    explicit FutureAndRequestId(Future&& f) : Future(std::move(f)) {}
    Future future;
    long long request_id = 0;
    SharedFuture share() { return Future::share(); }
  };
  using SharedFutureAndRequestId = SharedFuture;

  FutureAndRequestId async_send_request(SharedRequest) {
    promise_ = std::make_shared<Promise>();
    return FutureAndRequestId(promise_->get_future());
  }
  template <typename Callback>
  SharedFuture async_send_request(SharedRequest, Callback&&) {
    promise_ = std::make_shared<Promise>();
    return promise_->get_future().share();
  }
  bool remove_pending_request(long long) { return true; }
  template <typename F>
  bool remove_pending_request(const F&) {
    return true;
  }
  std::size_t prune_pending_requests() { return 0; }

 private:
  std::shared_ptr<Promise> promise_;
};

}  // namespace rclcpp
