#pragma once
/// A life-cycle callback of a component as an object, so it can run on another thread, because a device may
/// be slow.
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "polyarm/hardware/component.hpp"

namespace polyarm::hardware {

/// The callback to call.
enum class Step : std::uint8_t { init, configure, activate, deactivate, cleanup, shutdown, error };
/// Past participle for messages: "initialised", "configured", …
const char* done_word(Step step);

/// Created and finished by Hardware on the thread that builds or switches. run() is called once, on any
/// thread, and takes as long as the component needs. Meanwhile only read() and write() of the component are
/// called. A transition owns a new component; an existing one belongs to Hardware.
class Transition {
 public:
  /// Calls the component; never throws.
  void run() noexcept;
  bool done() const noexcept { return done_.load(std::memory_order_acquire); }
  /// Waits at most `timeout` ns; true when it is done.
  bool wait(Nanoseconds timeout) const;
  Step step() const noexcept { return step_; }
  const std::string& component() const noexcept { return name_; }

 private:
  friend class Hardware;
  CallbackReturn call();

  Step step_ = Step::configure;
  std::size_t index_ = 0;
  std::string name_;
  Component* component_ = nullptr;
  std::shared_ptr<const std::atomic<bool>> exchanging_;  // for a component with its own thread
  bool was_active_ = false;                              // for a shutdown
  std::unique_ptr<Component> made_;                      // for an init
  std::unique_ptr<ComponentContext> context_;
  std::optional<Step> failed_;  // for an error: the step that failed
  std::string thrown_before_;
  CallbackReturn result_ = CallbackReturn::success;
  std::exception_ptr thrown_;
  mutable std::mutex mutex_;
  mutable std::condition_variable wake_;
  std::atomic<bool> done_{false};
};

/// Runs transitions, on the calling thread or on another. Used by the thread that builds or switches.
class Caller {
 public:
  virtual ~Caller() = default;
  virtual void start(std::shared_ptr<Transition> transition) = 0;
  /// Waits for a started transition; false if it has given up waiting.
  virtual bool await(const Transition& transition) = 0;
};

}  // namespace polyarm::hardware
