#pragma once
/// What drivers on a simulated controller of their own share: faults that become due, and a clock that moves
/// while the driver ends.
#include <atomic>
#include <chrono>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "drivers/wire/orders.hpp"
#include "polyarm/base/time.hpp"

namespace polyarm::wire {

/// Orders that are given at a time (s of active cycles, from the first activation on), or when the driver
/// starts again. One thread.
class DueOrders {
 public:
  DueOrders() = default;
  explicit DueOrders(std::vector<TimedOrder> orders) : orders_(std::move(orders)) {}
  /// Orders what is due, then moves on by a cycle.
  template <typename FarSide>
  void step(FarSide& far, double period) {
    for (TimedOrder& one : orders_)
      if (!one.again && !one.order.empty() && since_ >= one.at) far.order(std::exchange(one.order, ""));
    since_ += period;
  }
  /// The driver starts: gives each `KIND@again` whose timed orders before it were given.
  template <typename FarSide>
  void start(FarSide& far) {
    for (TimedOrder& one : orders_) {
      if (!one.again && !one.order.empty()) return;  // what follows belongs to a later fault
      if (!one.order.empty()) far.order(std::exchange(one.order, ""));
    }
  }

 private:
  std::vector<TimedOrder> orders_;
  double since_ = 0;
};

/// Moves the controller's clock while the driver ends, from answer to answer as while it runs: the clock of
/// this machine says nothing about how fast a driver answers.
template <typename FarSide>
class Stepper {
 public:
  Stepper(FarSide& far, Nanoseconds patience)
      : far_(far), thread_([this, patience] {
          while (!quit_) {
            far_.step(patience);
            std::this_thread::sleep_for(kTurn);
          }
        }) {}
  ~Stepper() {
    quit_ = true;
    thread_.join();
    far_.hold_clock(false);
  }

 private:
  /// Between two steps: without it, the lock of the far side is hardly ever free for the thread that answers
  /// the driver's requests, and the driver waits until they time out.
  static constexpr std::chrono::microseconds kTurn{100};
  FarSide& far_;
  std::atomic<bool> quit_{false};
  std::thread thread_;
};

}  // namespace polyarm::wire
