#pragma once
/// Clients of services: of the same module, and on the ROS 2 graph. A request that nobody answers leaves its
/// future open, as in ROS. Any thread.
#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <type_traits>
#include <utility>

#include "polyarm_ros/door.hpp"
#include "polyarm_ros/wires.hpp"
#include "rclcpp/callback_group.hpp"
#include "rclcpp/future_return_code.hpp"
#include "rclcpp/qos.hpp"
#include "rclcpp/service.hpp"
#include "rclcpp/utilities.hpp"

namespace rclcpp {

class ClientBase : public polyarm_ros::Callee {
 public:
  RCLCPP_SMART_PTR_DEFINITIONS(ClientBase)
  ClientBase(std::string name, std::string full, polyarm_ros::Port port)
      : port_(std::move(port)), name_(std::move(name)), full_(std::move(full)) {}
  const char* get_service_name() const { return full_.c_str(); }
  std::string title() const override { return name_; }
  template <typename Clock>
  void configure_introspection(const Clock&, const QoS&, rcl_service_introspection_state_t state) const {
    report_introspection(full_, state);
  }
  bool service_is_ready() const { return local() || (port_ && port_->peers.load() > 0); }
  /// Waits at most for the timeout of the steady clock (negative: for ever). A thread that serves the graph
  /// itself, as in on_configure of a controller, does not wait.
  template <typename Rep = long, typename Ratio = std::milli>
  bool wait_for_service(std::chrono::duration<Rep, Ratio> timeout = std::chrono::duration<Rep, Ratio>(-1)) {
    const auto end = std::chrono::steady_clock::now() + timeout;
    while (ok() && !service_is_ready()) {
      if (polyarm_ros::serves_graph() || (timeout.count() >= 0 && std::chrono::steady_clock::now() >= end))
        break;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return service_is_ready();
  }
  /// True if a response waits for the executor or for take_response.
  virtual bool has_response() = 0;
  std::shared_ptr<rmw_request_id_t> create_request_header() const {
    return std::make_shared<rmw_request_id_t>();
  }
  virtual std::shared_ptr<void> create_response() = 0;
  /// Takes the oldest response into one that create_response made.
  virtual bool take_type_erased_response(void* out, rmw_request_id_t& header) = 0;
  /// Makes the future of a taken response ready, and calls back.
  virtual void handle_response(std::shared_ptr<rmw_request_id_t> header, std::shared_ptr<void> response) = 0;

 protected:
  virtual bool local() const = 0;
  polyarm_ros::Port port_;
  const std::string& full() const { return full_; }

 private:
  std::string name_, full_;
};

template <typename Type>
class Client : public ClientBase, public std::enable_shared_from_this<Client<Type>> {
 public:
  RCLCPP_SMART_PTR_DEFINITIONS(Client<Type>)
  using ClientBase::ClientBase;
  using Request = typename Type::Request;
  using Response = typename Type::Response;
  using SharedRequest = std::shared_ptr<Request>;
  using SharedResponse = std::shared_ptr<Response>;
  using Promise = std::promise<SharedResponse>;
  using SharedPromise = std::shared_ptr<Promise>;
  using Future = std::future<SharedResponse>;
  using SharedFuture = std::shared_future<SharedResponse>;
  using SharedFutureWithRequest = std::shared_future<std::pair<SharedRequest, SharedResponse>>;
  using CallbackType = std::function<void(SharedFuture)>;
  using CallbackWithRequestType = std::function<void(SharedFutureWithRequest)>;
  /// Requests that wait for their response; the oldest is dropped.
  static constexpr std::size_t kMost = 64;

  template <typename F>
  struct FutureWithId {
    F future;
    std::int64_t request_id = 0;
    operator F&() { return future; }
    auto get() { return future.get(); }
    bool valid() const { return future.valid(); }
    void wait() const { future.wait(); }
    template <typename Span>
    std::future_status wait_for(const Span& span) const {
      return future.wait_for(span);
    }
    template <typename Time>
    std::future_status wait_until(const Time& time) const {
      return future.wait_until(time);
    }
  };
  struct FutureAndRequestId : FutureWithId<Future> {
    SharedFuture share() { return this->future.share(); }
    operator SharedFuture() { return share(); }
  };
  struct SharedFutureAndRequestId : FutureWithId<SharedFuture> {
    operator SharedFuture() const { return this->future; }
  };

  FutureAndRequestId async_send_request(SharedRequest request) {
    Pending pending;
    FutureAndRequestId out;
    out.future = pending.promise->get_future();
    out.request_id = send(std::move(request), std::move(pending));
    return out;
  }
  /// `call` gets the future, or the pair of request and response.
  template <typename Callback>
  SharedFutureAndRequestId async_send_request(SharedRequest request, Callback&& call) {
    Pending pending;
    SharedFutureAndRequestId out;
    out.future = pending.promise->get_future().share();
    if constexpr (std::is_invocable_v<Callback&, SharedFuture>)
      pending.done = [call, future = out.future](const SharedResponse&) mutable { call(future); };
    else
      pending.done = [call, request](const SharedResponse& response) mutable {
        std::promise<std::pair<SharedRequest, SharedResponse>> both;
        both.set_value({request, response});
        call(both.get_future().share());
      };
    out.request_id = send(std::move(request), std::move(pending));
    return out;
  }
  bool remove_pending_request(std::int64_t number) {
    const std::lock_guard lock(mutex_);
    return pending_.erase(number) > 0;
  }
  template <typename F>
  bool remove_pending_request(const FutureWithId<F>& future) {
    return remove_pending_request(future.request_id);
  }
  std::size_t prune_pending_requests() {
    const std::lock_guard lock(mutex_);
    const std::size_t count = pending_.size();
    pending_.clear();
    return count;
  }
  /// Takes the responses that have come, and calls back.
  bool run(std::int64_t until) override {
    bool any = false;
    for (std::size_t n = 0; n < kMost; ++n) {
      if (any && until > 0 && polyarm_ros::steady_time() >= until) break;
      const Arrived next = next_response();
      if (!next.response) break;
      any = true;
      if (next.done)
        next.done(next.response);
      else
        finish(next.number, next.response);
    }
    return any;
  }
  bool has_response() override {
    pull();
    const std::lock_guard lock(mutex_);
    return !arrived_.empty();
  }
  /// Takes the oldest response in the place of the executor. Its future stays as it is.
  bool take_response(Response& out, rmw_request_id_t& header) {
    Arrived next = next_response();
    if (!next.response) return false;
    out = *next.response;
    header.sequence_number = next.number;
    if (next.done) {
      const std::lock_guard lock(mutex_);
      Pending& pending = pending_[next.number];
      pending.done = std::move(next.done);
      pending.answered = true;
    }
    return true;
  }
  std::shared_ptr<void> create_response() override { return std::make_shared<Response>(); }
  bool take_type_erased_response(void* out, rmw_request_id_t& header) override {
    return take_response(*static_cast<Response*>(out), header);
  }
  void handle_response(std::shared_ptr<rmw_request_id_t> header, std::shared_ptr<void> response) override {
    finish(header->sequence_number, std::static_pointer_cast<Response>(response));
  }

 private:
  using Done = std::function<void(const SharedResponse&)>;
  struct Pending {
    SharedPromise promise = std::make_shared<Promise>();
    Done done;
    bool answered = false;  ///< the future is ready; only `done` is left
  };
  struct Arrived {
    std::int64_t number = 0;
    SharedResponse response;
    Done done;  ///< of a response of this module; others are still in pending_
  };

  std::shared_ptr<Service<Type>> server() const {
    return std::dynamic_pointer_cast<Service<Type>>(LocalServices::find(this->full()));
  }
  bool local() const override { return server() != nullptr; }
  std::int64_t send(SharedRequest request, Pending pending) {
    std::int64_t number = 0;
    {
      const std::lock_guard lock(mutex_);
      number = ++last_;
      if (pending_.size() >= kMost) pending_.erase(pending_.begin());
      pending_[number] = std::move(pending);
    }
    if (const auto here = server()) {
      here->ask(std::move(request), [self = this->weak_from_this(), number](const SharedResponse& response) {
        if (const auto client = self.lock()) client->arrive(number, response);
      });
    } else if constexpr (polyarm_ros::HasFields<Request>::value) {
      if (port_)
        port_->to_graph.put(static_cast<std::uint64_t>(number), true,
                            [&](polyarm_ros::Payload& out) { polyarm_ros::encode(*request, out); });
    }
    return number;
  }
  /// Makes the future ready. Returns the callback; empty if there is none.
  Done answer(std::int64_t number, const SharedResponse& response) {
    Pending pending;
    {
      const std::lock_guard lock(mutex_);
      const auto found = pending_.find(number);
      if (found == pending_.end()) return {};
      pending = std::move(found->second);
      pending_.erase(found);
    }
    if (!pending.answered) pending.promise->set_value(response);
    return pending.done;
  }
  void finish(std::int64_t number, const SharedResponse& response) {
    if (const Done done = answer(number, response)) done(response);
  }
  /// A response of the same module, on the thread of the server: this node's executor calls back.
  void arrive(std::int64_t number, const SharedResponse& response) {
    Done done = answer(number, response);
    const std::lock_guard lock(mutex_);
    if (arrived_.size() >= kMost) arrived_.pop_front();
    arrived_.push_back({number, response, std::move(done)});
  }
  /// Moves what has come from the graph to the responses that wait, as far as there is room.
  void pull() {
    if constexpr (polyarm_ros::HasFields<Response>::value) {
      if (!this->port_) return;
      const std::lock_guard lock(mutex_);
      polyarm::hardware::Letter letter;
      while (arrived_.size() < kMost && this->port_->from_graph.take(letter)) {
        auto response = std::make_shared<Response>();
        if (polyarm_ros::decode(letter.payload, *response))
          arrived_.push_back({static_cast<std::int64_t>(letter.number), std::move(response), {}});
      }
    }
  }
  Arrived next_response() {
    pull();
    const std::lock_guard lock(mutex_);
    if (arrived_.empty()) return {};
    Arrived out = std::move(arrived_.front());
    arrived_.pop_front();
    return out;
  }

  std::mutex mutex_;
  std::map<std::int64_t, Pending> pending_;
  std::deque<Arrived> arrived_;
  std::int64_t last_ = 0;
};

}  // namespace rclcpp
