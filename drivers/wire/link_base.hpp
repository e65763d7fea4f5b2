#pragma once
/// What a link to a controller has whatever it speaks: its thread is woken, the loop waits for its cycles,
/// and the first cause that ended it is kept with its words. Then what those have that stream positions.
#include <sys/eventfd.h>

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <string>

#include "drivers/wire/tcp.hpp"
#include "polyarm/base/descriptor.hpp"
#include "polyarm/base/time.hpp"
#include "polyarm/hardware/driver_facts.hpp"
#include "polyarm/realtime/latest.hpp"

namespace polyarm::wire {

/// A cause and its detail in one atomic word. Cause{} (0) means none. Any thread.
template <class Cause>
class CauseWord {
 public:
  struct Value {
    Cause cause;
    int detail;
  };
  explicit operator bool() const noexcept { return word_.load(std::memory_order_acquire) != 0; }
  Value value() const noexcept {
    const std::uint64_t word = word_.load(std::memory_order_acquire);
    return {static_cast<Cause>(word & 0xFF), static_cast<std::int32_t>(word >> 8)};
  }
  Cause cause() const noexcept { return value().cause; }
  void set(Value value) noexcept { word_.store(packed(value), std::memory_order_release); }
  /// Keeps the first cause.
  void set_first(Value value) noexcept {
    std::uint64_t none = 0;
    word_.compare_exchange_strong(none, packed(value), std::memory_order_acq_rel);
  }
  void clear() noexcept { word_.store(0, std::memory_order_release); }

 private:
  static std::uint64_t packed(Value value) noexcept {
    return static_cast<std::uint64_t>(value.cause) |
           static_cast<std::uint64_t>(static_cast<std::uint32_t>(value.detail)) << 8;
  }
  std::atomic<std::uint64_t> word_{0};
};

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

/// What links share that stream joint positions.
struct StreamSettings {
  bool follows = true;   ///< the loop gives one command for each packet
  bool stepped = false;  ///< the controller's clock waits for answers; the loop asks for the services
  Nanoseconds timeout = 2'000'000'000, start_timeout = 10'000'000'000;
  Nanoseconds silence = 100'000'000;       ///< without a packet, until the link counts as lost
  Nanoseconds loop_silence = 100'000'000;  ///< without a command of the loop, until the robot is braked
  double most_behind = 0.05;               ///< rad, that the shaper may be behind

  /// From the parameters that every such driver declares.
  void read(hardware::DriverParameters& p) {
    most_behind = p.number("max_behind");
    silence = nanoseconds(p.number("silence_ms") / 1000);
    loop_silence = nanoseconds(p.number("loop_silence_ms") / 1000);
    timeout = nanoseconds(p.number("connect_timeout"));
    start_timeout = nanoseconds(p.number("start_timeout"));
  }
};

/// `Base` is a LinkBase. A Sample is what the controller sends in each cycle, a Panel what its services show.
/// open(), close(), start() and stop() of a link come from one thread at a time and may wait.
template <class Base, class Sample, class Panel>
class StreamLink : public Base {
 public:
  // --- control thread; nothing waits, locks or allocates ---
  bool fetch() noexcept {
    panels_.fetch();
    return samples_.fetch();
  }
  const Sample& sample() const noexcept { return samples_.value(); }
  const Panel& panel() const noexcept { return panels_.value(); }

 protected:
  using Base::Base;
  ~StreamLink() = default;
  enum class Phase : std::uint8_t { idle, starting, streaming, ending };

  void set_phase(Phase phase) {
    const std::lock_guard lock(this->mutex_);
    phase_ = phase;
    this->changed_.notify_all();
  }
  /// Waits until the thread of the link has begun a session. `lock` holds mutex_.
  void renew(std::unique_lock<std::mutex>& lock) {
    renew_ = true;
    this->wake();
    this->changed_.wait(lock, [this] { return !renew_; });
  }
  /// The thread of the link has begun it. The caller holds mutex_.
  void renewed() {
    renew_ = false;
    this->changed_.notify_all();
  }
  /// Ends the link if the commands are more than `most` rad behind what the loop wants: for the cause
  /// `lost`; if that is empty, for the limit of an axis.
  template <class Shaper, class Cause>
  void judge_behind(const Shaper& shaper, double behind, double most, Cause lost) {
    if (behind <= most) return;
    if (lost != Cause::none) return this->note(lost);
    const std::size_t axis = shaper.axis_behind();
    this->note(Cause::too_fast, static_cast<int>(3 * axis) + static_cast<int>(shaper.exceeded(axis)));
  }

  realtime::Latest<Sample> samples_;
  realtime::Latest<Panel> panels_;
  std::atomic<Phase> phase_{Phase::idle};  ///< changed with mutex_
  std::atomic<bool> renew_{false};         ///< the thread of the link begins a session
  std::atomic<bool> stands_{true};         ///< what is ending stands, or is out of reach
  std::atomic<bool> quit_{false};          ///< the threads of the link end
};

}  // namespace polyarm::wire
