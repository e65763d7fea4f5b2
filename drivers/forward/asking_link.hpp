#pragma once
/// A link in forward mode to a controller that is asked and answers: its thread makes rounds of questions,
/// and ends what it began when the loop falls silent.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <mutex>
#include <thread>
#include <utility>

#include "drivers/wire/tcp.hpp"
#include "polyarm/realtime/latest.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::forward {

struct AskingTimes {
  bool stepped = false;                    ///< rounds only in exchange(), but for the end of a session
  Nanoseconds poll = 20'000'000;           ///< between two rounds
  Nanoseconds loop_silence = 100'000'000;  ///< without a cycle of the loop, until the robot is stopped
};

/// `Base` is a wire::LinkBase<Cause>; `Cause` has loop_silent. cycle(), exchange() and what reads the sample
/// belong to the control thread. run_thread(), halt_thread() and finish() come from one other thread at a
/// time and may wait. The derived class halts the thread before it ends.
template <class Base, class Cause, class Sample, class Outputs>
class AskingLink : public Base {
 public:
  bool fetch() noexcept { return samples_.fetch(); }
  const Sample& sample() const noexcept { return samples_.value(); }
  /// In each cycle of the loop, with the outputs that are wanted.
  void cycle(const Outputs& outputs) noexcept {
    outputs_.write(outputs);
    cycles_.fetch_add(1, std::memory_order_release);
  }
  /// One round, with everything that is to be sent before. False: no answer in time.
  bool exchange(Nanoseconds timeout) noexcept {
    const std::uint64_t before = rounds_.load();
    const Nanoseconds end = realtime::monotonic_now() + timeout;
    round_wanted_ = true;
    this->wake();
    while (rounds_.load() == before) {
      if (gone_.load()) return false;
      if (!this->await(std::max<Nanoseconds>(end - realtime::monotonic_now(), 0))) return false;
    }
    fetch();
    return true;
  }

 protected:
  enum class Phase : std::uint8_t { idle, active, ending };

  template <class... Args>
  explicit AskingLink(const AskingTimes& times, Args&&... args)
      : Base(std::forward<Args>(args)...), times_(times) {}
  ~AskingLink() = default;

  /// Questions and answers; on the thread.
  virtual void round() = 0;

  void run_thread() {
    quit_ = false;
    next_round_ = 0;
    thread_ = std::thread([this] { run(); });
  }
  void halt_thread() {
    if (!thread_.joinable()) return;
    quit_ = true;
    this->wake();
    thread_.join();
  }
  bool runs() const { return thread_.joinable(); }
  /// A session begins, with the thread halted: what was wanted before counts no more.
  void begin_session() {
    outputs_.fetch();
    wanted_ = Outputs();
    over_ = false;
    cycles_ = cycles_seen_ = 0;
    phase_ = Phase::active;
  }
  /// A session ends: rounds until one of them sets over_, and two more.
  void finish(Nanoseconds timeout) {
    own_rounds_ = true;
    phase_ = Phase::ending;
    this->wake();
    {
      std::unique_lock lock(this->mutex_);
      const auto end = std::chrono::steady_clock::now() + std::chrono::nanoseconds(timeout);
      while (!over_ && !gone_ && std::chrono::steady_clock::now() < end)
        this->changed_.wait_for(lock, std::chrono::milliseconds(5));
    }
    const std::uint64_t rounds = rounds_;
    for (const auto end = std::chrono::steady_clock::now() + std::chrono::nanoseconds(timeout);
         !gone_ && rounds_ < rounds + 2 && std::chrono::steady_clock::now() < end;) {
      this->wake();
      std::unique_lock lock(this->mutex_);
      this->changed_.wait_for(lock, std::chrono::milliseconds(5));
    }
    halt_thread();
    own_rounds_ = false;
    phase_ = Phase::idle;
    if (this->fault_ || gone_) return;
    run_thread();
  }

  realtime::Latest<Sample> samples_;
  std::atomic<Phase> phase_{Phase::idle};
  std::atomic<std::uint64_t> cycles_{0};
  std::atomic<bool> gone_{false}, over_{false};
  // the thread's; others use them while it is halted
  Outputs wanted_;
  std::uint64_t cycles_seen_ = 0;

 private:
  static constexpr Nanoseconds kLook = 20'000'000;  ///< between two looks without an event

  void wait() {
    const bool own = !times_.stepped || own_rounds_;
    const Nanoseconds left =
        own && !gone_ ? std::clamp<Nanoseconds>(next_round_ - realtime::monotonic_now(), 0, kLook) : kLook;
    if (left > 0) wire::wait_readable(this->wake_.number(), left);
  }
  void run() {
    while (!quit_) {
      wait();
      this->calm(this->wake_.number());
      const Nanoseconds now = realtime::monotonic_now();
      take_wanted(now);
      judge_loop(now);
      const bool own = !times_.stepped || own_rounds_;
      const bool wanted = round_wanted_.exchange(false);
      if (gone_ || !(wanted || (own && now >= next_round_))) continue;
      round();
      next_round_ = now + times_.poll;
      rounds_.fetch_add(1);
      this->begin_cycle();
      this->changed_.notify_all();
    }
  }
  void take_wanted(Nanoseconds now) {
    if (outputs_.fetch()) wanted_ = outputs_.value();
    const std::uint64_t cycles = cycles_.load(std::memory_order_acquire);
    if (cycles == cycles_seen_) return;
    cycles_seen_ = cycles;
    cycled_at_ = now;
  }
  void judge_loop(Nanoseconds now) {
    if (phase_ != Phase::active || this->fault_) return;
    if (cycles_seen_ > 0 && now - cycled_at_ > times_.loop_silence) this->note(Cause::loop_silent);
  }

  AskingTimes times_;
  realtime::Latest<Outputs> outputs_;
  std::atomic<std::uint64_t> rounds_{0};
  std::atomic<bool> round_wanted_{false}, own_rounds_{false}, quit_{false};
  Nanoseconds next_round_ = 0, cycled_at_ = 0;
  std::thread thread_;
};

}  // namespace polyarm::forward
