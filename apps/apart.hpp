#pragma once
/// Jobs in processes of their own, several at a time: one that crashes or hangs takes nothing with it.
#include <cstddef>
#include <functional>
#include <optional>
#include <string>

namespace polyarm::apps {

struct ApartResult {
  std::optional<std::string> said;  ///< what the job returned; nothing where it did not come to its end
  std::string why;                  ///< then: killed by a signal, took too long
  double seconds = 0;               ///< wall time
};

/// Runs job(0) … job(count - 1) in forked processes, at most `most` at a time; each is killed after
/// `patience` seconds. `done` is called in this process, as they end. The caller has no other threads.
void run_apart(std::size_t count, unsigned most, double patience,
               const std::function<std::string(std::size_t)>& job,
               const std::function<void(std::size_t, const ApartResult&)>& done);

/// As many as this machine has processors.
unsigned processors();

}  // namespace polyarm::apps
