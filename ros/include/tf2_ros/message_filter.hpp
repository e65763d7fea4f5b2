#pragma once
/// Holds messages back until a buffer can transform them. They pass in the thread that brings the message or
/// the missing transform, in the order of their arrival. At most `queue_size` wait (0: any number); then the
/// oldest is dropped. One that waits longer than the timeout of the steady clock is dropped when the next
/// message or transform comes.
#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "message_filters/message_traits.hpp"
#include "message_filters/simple_filter.hpp"
#include "tf2_ros/buffer.hpp"

namespace tf2_ros {
namespace filter_failure_reasons {
enum FilterFailureReason { Unknown, OutTheBack, EmptyFrameID, NoTransformFound, QueueFull };
}  // namespace filter_failure_reasons
using FilterFailureReason = filter_failure_reasons::FilterFailureReason;

class MessageFilterBase {
 public:
  using V_string = std::vector<std::string>;
  virtual ~MessageFilterBase() = default;
  virtual void clear() = 0;
  virtual void setTargetFrame(const std::string& frame) = 0;
  virtual void setTargetFrames(const V_string& frames) = 0;
  virtual void setTolerance(const rclcpp::Duration& tolerance) = 0;
};

template <class M, class BufferT = Buffer>
class MessageFilter : public MessageFilterBase, public message_filters::SimpleFilter<M> {
 public:
  using typename message_filters::SimpleFilter<M>::EventType;
  using typename message_filters::SimpleFilter<M>::MConstPtr;
  using FailureCallback = std::function<void(const MConstPtr&, FilterFailureReason)>;
  using Span = std::chrono::nanoseconds;

  template <typename NodePointer>
  MessageFilter(BufferT& buffer, const std::string& target_frame, std::uint32_t queue_size,
                const NodePointer&, Span timeout = Span::max())
      : buffer_(buffer), most_(queue_size), timeout_(timeout) {
    begin(target_frame);
  }
  template <typename Logging, typename Clock>
  MessageFilter(BufferT& buffer, const std::string& target_frame, std::uint32_t queue_size,
                const std::shared_ptr<Logging>&, const std::shared_ptr<Clock>&, Span timeout = Span::max())
      : buffer_(buffer), most_(queue_size), timeout_(timeout) {
    begin(target_frame);
  }
  template <typename Filter, typename... Rest>
  MessageFilter(Filter& from, BufferT& buffer, const std::string& target_frame, std::uint32_t queue_size,
                Rest&&... rest)
      : MessageFilter(buffer, target_frame, queue_size, std::forward<Rest>(rest)...) {
    connectInput(from);
  }
  ~MessageFilter() override {
    input_.disconnect();
    const std::lock_guard lock(link_->mutex);
    link_->filter = nullptr;
  }

  template <typename Filter>
  void connectInput(Filter& from) {
    input_.disconnect();
    input_ = from.registerCallback([this](const EventType& event) { add(event); });
  }
  void setTargetFrame(const std::string& frame) override { setTargetFrames({frame}); }
  void setTargetFrames(const V_string& frames) override {
    const std::lock_guard lock(mutex_);
    targets_ = frames;
  }
  std::string getTargetFramesString() {
    const std::lock_guard lock(mutex_);
    std::string out;
    for (const std::string& each : targets_) out += (out.empty() ? "" : " ") + each;
    return out;
  }
  /// The transform must also be known this much after a message's stamp.
  void setTolerance(const rclcpp::Duration& tolerance) override {
    const std::lock_guard lock(mutex_);
    tolerance_ = tolerance;
  }
  void setQueueSize(std::uint32_t size) {
    const std::lock_guard lock(mutex_);
    most_ = size;
  }
  std::uint32_t getQueueSize() const {
    const std::lock_guard lock(mutex_);
    return most_;
  }
  void clear() override {
    const std::lock_guard lock(mutex_);
    waiting_.clear();
  }
  /// Called with each message that is dropped.
  message_filters::Connection registerFailureCallback(const FailureCallback& call) {
    set_failure(*failure_, call);
    return message_filters::Connection([kept = failure_] { set_failure(*kept, nullptr); });
  }
  void add(const MConstPtr& message) { add(EventType(message)); }
  void add(const EventType& event) {
    std::vector<Dropped> dropped;
    {
      const std::lock_guard lock(mutex_);
      if (event.getConstMessage()->header.frame_id.empty()) {
        dropped.push_back({event, filter_failure_reasons::EmptyFrameID});
      } else {
        if (most_ > 0 && waiting_.size() >= most_) {
          dropped.push_back({waiting_.front().event, filter_failure_reasons::QueueFull});
          waiting_.pop_front();
        }
        waiting_.push_back({event, std::chrono::steady_clock::now()});
      }
    }
    report(dropped);
    pass_on();
  }

 private:
  struct Waiting {
    EventType event;
    std::chrono::steady_clock::time_point since;
  };
  struct Dropped {
    EventType event;
    FilterFailureReason reason;
  };
  struct Failure {
    std::mutex mutex;
    FailureCallback call;
  };
  /// The buffer may outlive the filter and the other way round.
  struct Link {
    std::recursive_mutex mutex;
    MessageFilter* filter = nullptr;
  };

  void begin(const std::string& target) {
    setTargetFrame(target);
    link_->filter = this;
    watch_ = buffer_.on_change([link = link_] {
      const std::lock_guard lock(link->mutex);
      if (link->filter) link->filter->pass_on();
    });
  }
  bool known(const M& message) const {
    const rclcpp::Time stamp = message_filters::message_traits::TimeStamp<M>::value(message);
    for (const std::string& target : targets_) {
      if (!buffer_.canTransform(target, message.header.frame_id, stamp)) return false;
      if (tolerance_.nanoseconds() > 0 && stamp.nanoseconds() > 0 &&
          !buffer_.canTransform(target, message.header.frame_id, stamp + tolerance_))
        return false;
    }
    return true;
  }
  void pass_on() {
    std::vector<EventType> ready;
    std::vector<Dropped> dropped;
    {
      const std::lock_guard lock(mutex_);
      const auto now = std::chrono::steady_clock::now();
      for (auto at = waiting_.begin(); at != waiting_.end();) {
        const bool passes = known(*at->event.getConstMessage()), late = now - at->since > timeout_;
        if (passes)
          ready.push_back(at->event);
        else if (late)
          dropped.push_back({at->event, filter_failure_reasons::NoTransformFound});
        at = passes || late ? waiting_.erase(at) : at + 1;
      }
    }
    report(dropped);
    for (const EventType& each : ready) this->signalMessage(each);
  }
  void report(const std::vector<Dropped>& dropped) {
    FailureCallback call;
    {
      const std::lock_guard lock(failure_->mutex);
      call = failure_->call;
    }
    if (!call) return;
    for (const Dropped& each : dropped) call(each.event.getConstMessage(), each.reason);
  }
  static void set_failure(Failure& of, FailureCallback call) {
    const std::lock_guard lock(of.mutex);
    of.call = std::move(call);
  }

  BufferT& buffer_;
  std::uint32_t most_;
  Span timeout_;
  V_string targets_;
  rclcpp::Duration tolerance_{0, 0};
  mutable std::mutex mutex_;
  std::deque<Waiting> waiting_;
  std::shared_ptr<Failure> failure_ = std::make_shared<Failure>();
  std::shared_ptr<Link> link_ = std::make_shared<Link>();
  std::shared_ptr<void> watch_;
  message_filters::Connection input_;
};

}  // namespace tf2_ros
