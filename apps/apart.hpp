#pragma once
/// Runs jobs in processes of their own, several at a time, so a job that crashes or hangs does not affect the
/// others.
#include <cstddef>
#include <functional>
#include <optional>
#include <string>

namespace polyarm::apps {

struct ApartResult {
  std::optional<std::string> said;  ///< what the job returned; empty if it did not complete
  std::string why;                  ///< why it did not complete: killed by a signal, timeout
  double seconds = 0;               ///< wall time
  /// Somebody else ended the process (SIGINT, SIGTERM, SIGHUP, SIGKILL): this says nothing about the job.
  bool from_outside = false;
};

/// Runs job(0) … job(count - 1) in forked processes, at most `most` at a time. Kills each after `patience`
/// seconds. Calls `done` in this process as they end. The caller must have no other threads.
void run_apart(std::size_t count, unsigned most, double patience,
               const std::function<std::string(std::size_t)>& job,
               const std::function<void(std::size_t, const ApartResult&)>& done);

/// The same for jobs that are not counted beforehand: `next` returns the next one, or nothing at the end.
/// Once `given_up` returns true, running jobs are killed and `done` is not called for them. Jobs ignore
/// Ctrl-C and end with this process.
void run_apart(const std::function<std::optional<std::size_t>()>& next, unsigned most, double patience,
               const std::function<std::string(std::size_t)>& job,
               const std::function<void(std::size_t, const ApartResult&)>& done,
               const std::function<bool()>& given_up);

/// Number of processors of this machine.
unsigned processors();

}  // namespace polyarm::apps
