#pragma once
/// What a link to a controller has whatever it speaks: its thread is woken, the loop waits for its cycles,
/// and the first cause that ended it is kept with its words.
#include <sys/eventfd.h>

#include <condition_variable>
#include <mutex>
#include <string>

#include "drivers/wire/cause_word.hpp"
#include "drivers/wire/tcp.hpp"
#include "polyarm/base/descriptor.hpp"

namespace polyarm::wire {

/// `Cause` has a function `sentence(Cause, int detail, const std::string& where, const std::string& text)` in
/// its namespace.
template <class Cause>
class LinkBase {
 public:
  // --- control thread; nothing waits, locks or allocates but await() ---
  /// Waits for the controller's next cycle, or for a failure.
  bool await(Nanoseconds timeout) noexcept {
    if (!wait_readable(cycle_.number(), timeout)) return false;
    calm(cycle_.number());
    return true;
  }
  Cause cause() const noexcept { return fault_.cause(); }
  /// Why open() or start() was refused last; the link may be well.
  Cause refused() const noexcept { return refused_.cause(); }
  /// The driver itself found a cause: the robot is stopped.
  void fail(Cause cause, int detail) noexcept {
    fault_.set_first({cause, detail});
    wake();
    ::eventfd_write(cycle_.number(), 1);  // await() returns
  }

  /// Any thread: the sentence of the cause, or "".
  std::string reason() const {
    const auto why = fault_ ? fault_.value() : refused_.value();
    const std::lock_guard lock(mutex_);
    return sentence(why.cause, why.detail, where_, text_);
  }

 protected:
  explicit LinkBase(std::string where)
      : wake_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)),
        cycle_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)),
        where_(std::move(where)) {}
  ~LinkBase() = default;

  /// The thread of the link looks again.
  void wake() noexcept { ::eventfd_write(wake_.number(), 1); }
  /// The loop's await() returns: a new cycle began.
  void begin_cycle() noexcept { ::eventfd_write(cycle_.number(), 1); }
  /// Takes what an eventfd has counted.
  static void calm(int descriptor) noexcept {
    eventfd_t count = 0;
    ::eventfd_read(descriptor, &count);
  }
  /// The link ends with this cause, unless it has one.
  void note(Cause cause, int detail = 0, const std::string& text = {}) {
    const std::lock_guard lock(mutex_);
    if (!fault_) text_ = text;
    fail(cause, detail);
    changed_.notify_all();
  }
  /// open() or start() is refused with this cause. Returns false.
  bool refuse(Cause cause, int detail = 0, const std::string& text = {}) {
    const std::lock_guard lock(mutex_);
    text_ = text;
    refused_.set({cause, detail});
    return false;
  }
  std::string text() const {
    const std::lock_guard lock(mutex_);
    return text_;
  }

  Descriptor wake_, cycle_;
  CauseWord<Cause> fault_, refused_;
  mutable std::mutex mutex_;  ///< the words, and what a link adds; never the control thread's
  std::condition_variable changed_;

 private:
  std::string where_, text_;
};

}  // namespace polyarm::wire
