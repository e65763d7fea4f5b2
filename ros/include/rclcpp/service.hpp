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
  /// True if a request waits for the executor or for take_request.
  virtual bool has_request() = 0;
  std::shared_ptr<rmw_request_id_t> create_request_header() const {
    return std::make_shared<rmw_request_id_t>();
  }
  virtual std::shared_ptr<void> create_request() = 0;
  /// Takes the oldest request into one that create_request made.
  virtual bool take_type_erased_request(void* out, rmw_request_id_t& header) = 0;
  virtual void handle_request(std::shared_ptr<rmw_request_id_t> header, std::shared_ptr<void> request) = 0;

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
    if (asked_.size() >= kMost) return false;
    asked_.push_back({--last_, std::move(request)});
    if (answers_.size() >= 2 * kMost) answers_.erase(std::prev(answers_.end()));
    answers_[last_] = std::move(answer);
    return true;
  }

  /// For a callback that answers later, and for requests that take_request gave.
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
    bool any = false;
    // No more than the queue holds: clients go on sending.
    for (std::size_t n = 0; n < kMost; ++n) {
      if (any && until > 0 && polyarm_ros::steady_time() >= until) break;
      const Asked next = next_request();
      if (!next.request) break;
      any = true;
      auto header = this->create_request_header();
      header->sequence_number = next.number;
      call_(header, next.request);
    }
    return any;
  }
  bool has_request() override {
    pull();
    const std::lock_guard lock(mutex_);
    return !asked_.empty();
  }
  /// Takes the oldest request in the place of the executor; the caller answers it with send_response.
  bool take_request(Request& out, rmw_request_id_t& header) {
    const Asked next = next_request();
    if (!next.request) return false;
    out = *next.request;
    header.sequence_number = next.number;
    return true;
  }
  std::shared_ptr<void> create_request() override { return std::make_shared<Request>(); }
  bool take_type_erased_request(void* out, rmw_request_id_t& header) override {
    return take_request(*static_cast<Request*>(out), header);
  }
  void handle_request(Header header, std::shared_ptr<void> request) override {
    call_(header, std::static_pointer_cast<Request>(request));
  }

 private:
  static constexpr std::size_t kMost = polyarm::hardware::LetterQueue::kMost;
  /// Requests of this module have negative numbers.
  struct Asked {
    long long number = 0;
    std::shared_ptr<Request> request;
  };
  /// Moves what has come from the graph to the requests that wait, as far as there is room.
  void pull() {
    if constexpr (polyarm_ros::HasFields<Request>::value) {
      if (!port_) return;
      const std::lock_guard lock(mutex_);
      polyarm::hardware::Letter letter;
      while (asked_.size() < kMost && port_->from_graph.take(letter)) {
        auto request = std::make_shared<Request>();
        if (polyarm_ros::decode(letter.payload, *request))
          asked_.push_back({static_cast<long long>(letter.number), std::move(request)});
      }
    }
  }
  Asked next_request() {
    pull();
    const std::lock_guard lock(mutex_);
    if (asked_.empty()) return {};
    Asked out = std::move(asked_.front());
    asked_.pop_front();
    return out;
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
  std::deque<Asked> asked_;
  std::map<long long, Answer> answers_;  ///< of those that wait, and of as many that are answered later
  long long last_ = 0;
};

}  // namespace rclcpp
