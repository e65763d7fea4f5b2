#pragma once
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "polyarm/hardware/hardware.hpp"
#include "polyarm/setup/observer.hpp"

namespace polyarm::cell {

/// Callbacks of hardware components on threads of their own: a device that takes its time keeps nobody but
/// those who asked for it. In lock-step they are called at once. Cell thread.
class HardwareCalls : public hardware::Caller {
 public:
  /// Waiting is told about after this long, and again after every doubling.
  static constexpr Nanoseconds kWorthTelling = 2'000'000'000;

  HardwareCalls(bool run_inline, Observer& observer) : inline_(run_inline), observer_(observer) {}

  void start(std::shared_ptr<hardware::Transition> transition) override;
  /// For start-up and shutdown, when nothing else runs: tells what it waits for.
  bool await(const hardware::Transition& transition) override;
  /// From now on await() gives up after `patience` ns.
  void give_up_after(Nanoseconds patience) { patience_ = patience; }
  /// And as soon as this says so, which is asked ten times in a second: a person has had enough.
  void give_up_when(std::function<bool()> asked) { asked_ = std::move(asked); }

  /// While the cell runs: goes on with a transition that was started; true when it is over. `now`: cell time.
  /// Throws as Hardware::finish().
  bool advance(hardware::Hardware& hardware, std::shared_ptr<hardware::Transition>& transition,
               Nanoseconds now);
  /// What the loop's own events ask for and nobody waits for: begun when the component is free. Once each
  /// tick.
  void post(std::size_t component, hardware::Step step) { wanted_.push_back({component, step, nullptr}); }
  void tick(hardware::Hardware& hardware, Nanoseconds now);

 private:
  struct Wanted {
    std::size_t component;
    hardware::Step step;
    std::shared_ptr<hardware::Transition> running;
  };
  bool give_up(const hardware::Transition& transition, Nanoseconds waited);
  void tell_waiting(const hardware::Transition& transition, Nanoseconds since, const char* end);

  bool inline_;
  Observer& observer_;
  Nanoseconds patience_ = -1;  // < 0: as long as it takes
  std::function<bool()> asked_;
  std::list<Wanted> wanted_;
  struct Since {
    Nanoseconds begun, told_next;
  };
  std::map<const hardware::Transition*, Since> since_;
};

}  // namespace polyarm::cell
