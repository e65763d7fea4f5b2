#pragma once
/// Runs callbacks of hardware components without blocking the cell thread.
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "polyarm/hardware/hardware.hpp"
#include "polyarm/setup/observer.hpp"

namespace polyarm::cell {

/// Runs each callback on a thread of its own, so a slow device only delays the client that asked for it. In
/// lock-step the cell waits for each callback, so that runs are repeatable. Cell thread.
class HardwareCalls : public hardware::Caller {
 public:
  /// Waiting is reported after this time, ns, and again each time it has doubled.
  static constexpr Nanoseconds kWorthReporting = 2'000'000'000;

  HardwareCalls(bool waits, Observer& observer) : waits_(waits), observer_(observer) {}

  void start(std::shared_ptr<hardware::Transition> transition) override;
  /// For start-up and shutdown, when nothing else runs: waits, and reports what it waits for.
  bool await(const hardware::Transition& transition) override;
  /// After this call await() gives up after `patience` ns.
  void give_up_after(Nanoseconds patience) { wait_limit_ = patience; }
  /// await() also gives up when `asked` returns true (the user no longer wants to wait); it is called ten
  /// times per second.
  void give_up_when(std::function<bool()> asked) { asked_ = std::move(asked); }

  /// While the cell runs: starts a transition, which advance() then follows. In lock-step it waits as
  /// await().
  void begin(const std::shared_ptr<hardware::Transition>& transition);
  /// While the cell runs: advances a transition that was started; true when it is done. `now`: cell time.
  /// Throws like Hardware::finish().
  bool advance(hardware::Hardware& hardware, std::shared_ptr<hardware::Transition>& transition,
               Nanoseconds now);
  /// For transitions that the loop's events require and no client waits for: post() queues a transition, and
  /// tick(), called once each tick, starts it when the component is free.
  void post(std::size_t component, hardware::Step step) { wanted_.push_back({component, step, nullptr}); }
  void tick(hardware::Hardware& hardware, Nanoseconds now);

 private:
  struct Wanted {
    std::size_t component;
    hardware::Step step;
    std::shared_ptr<hardware::Transition> running;
  };
  bool give_up(const hardware::Transition& transition, Nanoseconds waited);
  void report_waiting(const hardware::Transition& transition, Nanoseconds since, const char* end);

  bool waits_;
  Observer& observer_;
  Nanoseconds wait_limit_ = -1;  // < 0: no limit
  std::function<bool()> asked_;
  std::list<Wanted> wanted_;
  struct Since {
    Nanoseconds begun, next_report;
  };
  std::map<const hardware::Transition*, Since> since_;
};

}  // namespace polyarm::cell
