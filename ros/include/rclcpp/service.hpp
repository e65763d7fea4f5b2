#pragma once
#include <cstdint>
#include <cstring>
#include <deque>
#include <functional>
#include <iterator>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <type_traits>
#include <utility>

#include "polyarm_ros/door.hpp"
#include "polyarm_ros/wires.hpp"
#include "rclcpp/callback_group.hpp"
#include "rclcpp/qos.hpp"

struct rmw_request_id_t {
  signed char writer_guid[16];
  long long sequence_number;
};

enum rcl_service_introspection_state_e {
  RCL_SERVICE_INTROSPECTION_OFF,
  RCL_SERVICE_INTROSPECTION_METADATA,
  RCL_SERVICE_INTROSPECTION_CONTENTS
};
using rcl_service_introspection_state_t = rcl_service_introspection_state_e;

namespace rclcpp {

/// Polyarm publishes no events of services: if they are asked for, the log says so.
inline void report_introspection(const std::string& service, rcl_service_introspection_state_t state) {
  if (state != RCL_SERVICE_INTROSPECTION_OFF)
    polyarm_ros::report_unavailable(service, "topic of events", service + "/_service_event");
}

class ServiceBase : public polyarm_ros::Callee {
 public:
  RCLCPP_SMART_PTR_DEFINITIONS(ServiceBase)
  ServiceBase(std::string name, polyarm_ros::Port port) : port_(std::move(port)), name_(std::move(name)) {}
  const char* get_service_name() const { return name_.c_str(); }
  template <typename Clock>
  void configure_introspection(const Clock&, const QoS&, rcl_service_introspection_state_t state) const {
    report_introspection(name_, state);
  }
  std::string title() const override { return name_; }

 protected:
  polyarm_ros::Port port_;

 private:
  std::string name_;
};

/// The services of this module by their full names, for clients in the same module. Any thread.
class LocalServices {
 public:
  static void add(const std::string& full, const std::shared_ptr<ServiceBase>& service) {
    const std::lock_guard lock(mutex());
    all()[full] = service;
  }
  static std::shared_ptr<ServiceBase> find(const std::string& full) {
    const std::lock_guard lock(mutex());
    const auto found = all().find(full);
    return found == all().end() ? nullptr : found->second.lock();
  }

 private:
  static std::mutex& mutex() {
    static std::mutex value;
    return value;
  }
  static std::map<std::string, std::weak_ptr<ServiceBase>>& all() {
    static std::map<std::string, std::weak_ptr<ServiceBase>> value;
    return value;
  }
};

/// Called by clients of the same module and on the ROS 2 graph. The node's executor runs the callback.
template <typename Type>
class Service : public ServiceBase, public std::enable_shared_from_this<Service<Type>> {
 public:
  RCLCPP_SMART_PTR_DEFINITIONS(Service<Type>)
  using Request = typename Type::Request;
  using Response = typename Type::Response;
  using Header = std::shared_ptr<rmw_request_id_t>;

  template <typename Callback>
  Service(std::string name, polyarm_ros::Port port, Callback callback)
      : ServiceBase(std::move(name), std::move(port)),
        call_([this, callback](const Header& header, const std::shared_ptr<Request>& request) mutable {
          answer(callback, header, request);
        }) {}

  using Answer = std::function<void(std::shared_ptr<Response>)>;
  /// A request of a client in this module; the thread that runs the callback calls `answer`. False if as many
  /// wait as a queue of the graph holds.
  bool ask(std::shared_ptr<Request> request, Answer answer) {
    const std::lock_guard lock(mutex_);
    if (asked_.size() >= polyarm::hardware::LetterQueue::kMost) return false;
    asked_.emplace_back(std::move(request), std::move(answer));
    return true;
  }

  /// For a callback that answers later.
  void send_response(rmw_request_id_t& header, Response& response) {
    if (header.sequence_number < 0) {
      const Answer answer = take_answer(header.sequence_number);
      if (answer) answer(std::make_shared<Response>(response));
      return;
    }
    if constexpr (polyarm_ros::HasFields<Response>::value)
      if (port_)
        port_->to_graph.put(static_cast<std::uint64_t>(header.sequence_number), true,
                            [&](polyarm_ros::Payload& out) { polyarm_ros::encode(response, out); });
  }
  bool run(std::int64_t until) override {
    bool any = run_asked(until);
    if constexpr (polyarm_ros::HasFields<Request>::value) {
      polyarm::hardware::Letter letter;
      // No more than the queue holds: clients go on sending.
      for (std::size_t n = 0; n < polyarm::hardware::LetterQueue::kMost && port_; ++n) {
        if (any && until > 0 && polyarm_ros::steady_time() >= until) break;
        if (!port_->from_graph.take(letter)) break;
        any = true;
        auto request = std::make_shared<Request>();
        if (!polyarm_ros::decode(letter.payload, *request)) continue;
        auto header = std::make_shared<rmw_request_id_t>();
        header->sequence_number = static_cast<long long>(letter.number);
        call_(header, request);
      }
    }
    return any;
  }

 private:
  /// Requests of this module have negative numbers.
  bool run_asked(std::int64_t until) {
    bool any = false;
    for (std::size_t n = 0; n < polyarm::hardware::LetterQueue::kMost; ++n) {
      if (any && until > 0 && polyarm_ros::steady_time() >= until) break;
      auto header = std::make_shared<rmw_request_id_t>();
      std::shared_ptr<Request> request;
      {
        const std::lock_guard lock(mutex_);
        if (asked_.empty()) break;
        header->sequence_number = --last_;
        request = std::move(asked_.front().first);
        if (answers_.size() >= polyarm::hardware::LetterQueue::kMost)
          answers_.erase(std::prev(answers_.end()));
        answers_[last_] = std::move(asked_.front().second);
        asked_.pop_front();
      }
      any = true;
      call_(header, request);
    }
    return any;
  }
  Answer take_answer(long long number) {
    const std::lock_guard lock(mutex_);
    const auto found = answers_.find(number);
    if (found == answers_.end()) return nullptr;
    Answer out = std::move(found->second);
    answers_.erase(found);
    return out;
  }
  template <typename Callback>
  void answer(Callback& callback, const Header& header, const std::shared_ptr<Request>& request) {
    auto response = std::make_shared<Response>();
    if constexpr (std::is_invocable_v<Callback&, std::shared_ptr<Request>, std::shared_ptr<Response>>) {
      callback(request, response);
    } else if constexpr (std::is_invocable_v<Callback&, Header, std::shared_ptr<Request>,
                                             std::shared_ptr<Response>>) {
      callback(header, request, response);
    } else if constexpr (std::is_invocable_v<Callback&, std::shared_ptr<Service>, Header,
                                             std::shared_ptr<Request>>) {
      return callback(this->shared_from_this(), header, request);
    } else if constexpr (std::is_invocable_v<Callback&, Header, std::shared_ptr<Request>>) {
      return callback(header, request);
    }
    send_response(*header, *response);
  }
  std::function<void(const Header&, const std::shared_ptr<Request>&)> call_;
  std::mutex mutex_;
  std::deque<std::pair<std::shared_ptr<Request>, Answer>> asked_;
  std::map<long long, Answer> answers_;
  long long last_ = 0;
};

}  // namespace rclcpp
