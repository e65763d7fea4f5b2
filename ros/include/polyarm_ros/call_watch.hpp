#pragma once
/// Names callbacks for which the cell waits. Callbacks of a controller's node run on the cell thread, between
/// two of its ticks. One that takes long delays jogging, programs and the page, and the control loop stops
/// the robots on their path after 0.5 s; nothing can end it. So it is named: while it runs, and afterwards.
#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <string>

#include "polyarm_ros/cell_clock.hpp"
#include "polyarm_ros/log.hpp"

namespace polyarm_ros {

/// The calls under way. Written by the threads that call, read by the thread of the log.
class CallWatch {
 public:
  static constexpr std::size_t kCalls = 32, kBytes = 200;
  /// A call that ends later than this gets a warning, one that runs longer an error; ns.
  static constexpr std::int64_t kSlow = 100'000'000, kStuck = 300'000'000;

  struct Call {
    std::atomic<bool> taken{false}, told{false};
    std::atomic<std::int64_t> since{0};  ///< 0: not under way
    std::array<char, kBytes> logger{}, kind{}, name{};
  };
  /// Null if all are taken.
  Call* begin(const char* logger, const char* kind, const std::string& name) {
    for (Call& each : calls_) {
      if (each.taken.exchange(true)) continue;
      copy(logger, each.logger);
      copy(kind, each.kind);
      copy(name.c_str(), each.name);
      each.told = false;
      each.since = steady_time();
      return &each;
    }
    return nullptr;
  }
  void end(Call& call) {
    const std::int64_t passed = steady_time() - call.since.exchange(0);
    if (passed > kSlow)
      log_format(Severity::warn, call.logger.data(), "its %s '%s' took %lld ms, and the cell waited for it",
                 call.kind.data(), call.name.data(), static_cast<long long>(passed / 1'000'000));
    call.taken = false;
  }
  /// Names the calls that run too long, each once.
  void look() {
    const std::int64_t now = steady_time();
    for (Call& each : calls_) {
      const std::int64_t since = each.since;
      if (since == 0 || now - since < kStuck || each.told.exchange(true)) continue;
      log_format(
          Severity::error, each.logger.data(),
          "its %s '%s' has not returned for %lld ms. The cell waits for it: after 500 ms all robots stop",
          each.kind.data(), each.name.data(), static_cast<long long>((now - since) / 1'000'000));
    }
  }

 private:
  static void copy(const char* text, std::array<char, kBytes>& to) {
    std::size_t n = 0;
    for (; text[n] && n + 1 < kBytes; ++n) to[n] = text[n];
    to[n] = 0;
  }
  std::array<Call, kCalls> calls_;
};
inline CallWatch& call_watch() {
  static CallWatch watch;
  return watch;
}

/// One call, from its constructor to its destructor. Not in a cycle.
class WatchedCall {
 public:
  WatchedCall(const char* logger, const char* kind, const std::string& name)
      : call_(call_watch().begin(logger, kind, name)) {
    log_ring().look = [] { call_watch().look(); };
    log_ring().start();
  }
  ~WatchedCall() {
    if (call_) call_watch().end(*call_);
  }
  WatchedCall(const WatchedCall&) = delete;
  WatchedCall& operator=(const WatchedCall&) = delete;

 private:
  CallWatch::Call* call_;
};

}  // namespace polyarm_ros
