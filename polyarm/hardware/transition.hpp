#pragma once
/// A callback of a component's life cycle, apart from the thread that asks for it: a device may take its
/// time.
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

/// What a component is called for.
enum class Step : std::uint8_t { init, configure, activate, deactivate, cleanup, shutdown, error };
/// What becomes of it, for sentences: "initialised", "configured", …
const char* done_word(Step step);

/// Made and finished by Hardware on the thread that builds or switches; run() is called once, from any
/// thread, and takes as long as the component does. Nobody else calls the component in between, but for
/// read() and write(). It keeps what a new component needs alive; an old one belongs to Hardware.
class Transition {
 public:
  /// Calls the component; never throws.
  void run() noexcept;
  bool done() const noexcept { return done_.load(std::memory_order_acquire); }
  /// Waits at most so long, ns; true when it is done.
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
  std::shared_ptr<const std::atomic<bool>> exchanging_;  // of a component with a thread of its own
  bool was_active_ = false;                              // of a shutdown
  std::unique_ptr<Component> made_;                      // of an init
  std::unique_ptr<ComponentContext> context_;
  std::optional<Step> failed_;  // of an error: what went wrong before it
  std::string thrown_before_;
  CallbackReturn result_ = CallbackReturn::success;
  std::exception_ptr thrown_;
  mutable std::mutex mutex_;
  mutable std::condition_variable wake_;
  std::atomic<bool> done_{false};
};

/// Who runs transitions: here and now, or elsewhere. Used by the thread that builds or switches.
class Caller {
 public:
  virtual ~Caller() = default;
  virtual void start(std::shared_ptr<Transition> transition) = 0;
  /// Waits for one that was started; false when it has given up, and nobody waits for it any more.
  virtual bool await(const Transition& transition) = 0;
};

}  // namespace polyarm::hardware
