#pragma once
/// Signs of life of a child process, which show that its threads still run: a process that is stopped (SIGSTOP),
/// or that waits in the kernel for ever, has no end that its parent could notice. They say nothing of what the
/// process does; for that, each question that a parent asks has a time limit of its own.
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <thread>

#include "polyarm/process/channel.hpp"

namespace polyarm::process {

/// How often a child gives a sign, and how often its parent looks for one.
inline constexpr std::chrono::milliseconds kPulse{100};
/// Without a sign for so long, a child counts as hung.
inline constexpr std::chrono::milliseconds kLongestSilence{1000};

/// The child's side: a thread that gives the signs. It is made after the process has confined itself, so that the
/// thread has the same bounds.
class Pulse {
 public:
  /// `channel` outlives it.
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

/// The parent's side; one thread. A child that has given no sign yet is not judged. Time in which the parent itself
/// did not look does not count, so a machine that was suspended ends no child.
class PulseWatch {
 public:
  using Clock = std::chrono::steady_clock;

  /// True if the child has given no sign for `limit`. Called at least every kPulse while it is to be watched.
  bool silent(const Channel& channel, Clock::time_point now, std::chrono::nanoseconds limit);
  /// Begins to count anew, after a time in which nobody looked.
  void restart(Clock::time_point now);

 private:
  std::uint64_t seen_ = 0;
  Clock::time_point looked_{};
  std::chrono::nanoseconds silence_{0};
};

}  // namespace polyarm::process
