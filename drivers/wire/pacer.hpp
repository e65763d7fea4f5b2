#pragma once
/// Decides when a stream of commands sends to a controller that has a clock of its own. Thread: one.
#include "polyarm/base/time.hpp"

namespace polyarm::wire {

/// One command for each cycle of the controller, always the newest one, and none without a new command: a
/// controller whose commands stop must see the silence, because its own watchdog then stops the robot.
///
///     controller's packet → cycle()      control loop's command → command()
///     due() → send the newest command → sent()
class Pacer {
 public:
  /// `silence`: a stream without a new command for this long is silent. ns
  explicit Pacer(Nanoseconds silence) : silence_(silence) {}

  /// Nothing was sent yet.
  void begin(Nanoseconds now) noexcept { *this = Pacer(silence_, now); }
  /// The controller began its next cycle.
  void cycle() noexcept { open_ = true; }
  /// The control loop has a new command; it replaces one that was not sent.
  void command(Nanoseconds now) noexcept {
    replaced_ += waiting_;
    waiting_ = true;
    last_ = now;
  }
  bool due() const noexcept { return open_ && waiting_; }
  void sent() noexcept { open_ = waiting_ = false; }
  /// The loop has given no command for too long.
  bool silent(Nanoseconds now) const noexcept { return now - last_ > silence_; }
  /// Commands that a newer one replaced before they were sent.
  unsigned long replaced() const noexcept { return replaced_; }

 private:
  Pacer(Nanoseconds silence, Nanoseconds now) : silence_(silence), last_(now) {}
  Nanoseconds silence_, last_ = 0;
  bool open_ = true, waiting_ = false;
  unsigned long replaced_ = 0;
};

}  // namespace polyarm::wire
