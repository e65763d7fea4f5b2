#pragma once
/// Whether the commands that a controller is sent again and again still come. Standard types only: plugins
/// include this.
#include <atomic>
#include <utility>

#include "polyarm/base/time.hpp"

namespace polyarm::controllers {

/// Of one controller: when its last command was made, and whether it has grown old. Control thread, but for
/// stale(), and for `timeout`, which is written between two updates.
class CommandWatch {
 public:
  double timeout = 0;  ///< s that a command counts; 0: as long as nothing else is sent

  /// Nothing has been sent: at activation, at a stop, and where another controller commands this one.
  void forget() noexcept {
    counts_ = false;
    stale_.store(false, std::memory_order_relaxed);
  }
  /// A command that was made at `stamp` has come at `now`. False when it has been too long on its way.
  bool take(Nanoseconds stamp, Nanoseconds now) noexcept {
    if (timeout > 0 && seconds(now - stamp) >= timeout) return false;
    made_at_ = stamp;
    counts_ = true;
    stale_.store(false, std::memory_order_relaxed);
    return true;
  }
  /// Once each update: true in the one in which the last command becomes too old. `asks`: it asks for
  /// something that now ends, so that somebody is to be told.
  bool expires(Nanoseconds now, bool asks = true) noexcept {
    if (!counts_ || !(timeout > 0) || !(seconds(now - made_at_) > timeout)) return false;
    counts_ = false;
    stale_.store(true, std::memory_order_relaxed);
    news_.store(asks, std::memory_order_release);
    return true;
  }
  bool counts() const noexcept { return counts_; }
  /// The last command has grown old, and none has come since. Any thread.
  bool stale() const noexcept { return stale_.load(std::memory_order_relaxed); }
  /// What expired and asked for something is told once.
  bool take_reports() noexcept {
    return news_.load(std::memory_order_relaxed) && news_.exchange(false, std::memory_order_acquire);
  }

 private:
  Nanoseconds made_at_ = 0;
  bool counts_ = false;
  std::atomic<bool> stale_{false}, news_{false};
};

}  // namespace polyarm::controllers
