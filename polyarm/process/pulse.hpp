#pragma once
/// Heartbeats of a child process, which show that its threads still run. A process that is stopped (SIGSTOP)
/// or blocked in the kernel does not end, so its parent could not notice. Heartbeats say nothing about the
/// process's work; each request of a parent has its own timeout.
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <thread>

#include "polyarm/process/channel.hpp"

namespace polyarm::process {

/// Interval of the heartbeats, and of the parent's checks.
inline constexpr std::chrono::milliseconds kPulse{100};
/// A child without a heartbeat for this long counts as hung.
inline constexpr std::chrono::milliseconds kLongestSilence{1000};

/// The child's side: a thread that sends the heartbeats. Create it after the process has confined itself, so
/// that the confinement applies to the thread.
class Pulse {
 public:
  /// `channel` must outlive this.
  explicit Pulse(Channel& channel);
  ~Pulse();
  Pulse(const Pulse&) = delete;
  Pulse& operator=(const Pulse&) = delete;

 private:
  void run();
  Channel& channel_;
  std::mutex mutex_;
  std::condition_variable over_changed_;
  bool over_ = false;
  std::thread thread_;
};

/// The parent's side; one thread. A child that has not sent a heartbeat yet is not judged. Time in which the
/// parent did not check does not count, so a machine that was suspended does not end its children.
class PulseWatch {
 public:
  using Clock = std::chrono::steady_clock;

  /// True if there was no heartbeat for `limit`. Call it at least every kPulse while the child is watched.
  bool silent(const Channel& channel, Clock::time_point now, std::chrono::nanoseconds limit);
  /// Restarts the count, after a time without checks.
  void restart(Clock::time_point now);

 private:
  std::uint64_t seen_ = 0;
  Clock::time_point looked_{};
  std::chrono::nanoseconds silence_{0};
};

}  // namespace polyarm::process
