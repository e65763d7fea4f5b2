#pragma once
/// Where the log lines of a plugin go: standard error. A line that is written during read, write or update
/// never blocks: it is copied into a ring of fixed size, which a thread of the module prints. When the ring
/// is full, lines are dropped and counted.
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <thread>

namespace polyarm_ros {

enum class Severity : int { debug = 10, info = 20, warn = 30, error = 40, fatal = 50 };

inline const char* name_of(Severity severity) {
  return severity == Severity::debug   ? "DEBUG"
         : severity == Severity::info  ? "INFO"
         : severity == Severity::warn  ? "WARN"
         : severity == Severity::error ? "ERROR"
                                       : "FATAL";
}

/// True on a thread that is in read, write or update. The wrapper sets it.
inline bool& in_cycle() {
  static thread_local bool value = false;
  return value;
}

/// Lines between threads: bounded, many writers, one reader, no locks.
class LogRing {
 public:
  static constexpr std::size_t kLines = 256, kBytes = 1024;

  LogRing() {
    for (std::size_t i = 0; i < kLines; ++i) slots_[i].turn.store(i, std::memory_order_relaxed);
  }
  ~LogRing() {
    stop_.store(true);
    if (reader_.joinable()) reader_.join();
    drain();
  }
  /// Called by the reader every 20 ms; null: nothing.
  std::atomic<void (*)()> look{nullptr};
  /// Starts the reader. Not during a cycle.
  void start() {
    if (!started_.exchange(true)) reader_ = std::thread([this] { run(); });
  }
  void push(const char* text, std::size_t size) noexcept {
    std::size_t at = head_.load(std::memory_order_relaxed);
    for (;;) {
      Slot& slot = slots_[at % kLines];
      const std::size_t turn = slot.turn.load(std::memory_order_acquire);
      if (turn == at) {
        if (!head_.compare_exchange_weak(at, at + 1, std::memory_order_relaxed)) continue;
        slot.size = size < kBytes ? size : kBytes;
        std::memcpy(slot.text, text, slot.size);
        slot.turn.store(at + 1, std::memory_order_release);
        return;
      }
      if (turn < at) {
        dropped_.fetch_add(1, std::memory_order_relaxed);
        return;
      }
      at = head_.load(std::memory_order_relaxed);
    }
  }

 private:
  struct Slot {
    std::atomic<std::size_t> turn{0};
    std::size_t size = 0;
    char text[kBytes];
  };
  void run() {
    while (!stop_.load()) {
      drain();
      if (void (*const call)() = look) call();
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  }
  void drain() {
    for (;;) {
      Slot& slot = slots_[tail_ % kLines];
      if (slot.turn.load(std::memory_order_acquire) != tail_ + 1) break;
      if (::write(2, slot.text, slot.size) < 0) return;
      slot.turn.store(tail_ + kLines, std::memory_order_release);
      ++tail_;
    }
    if (const unsigned lost = dropped_.exchange(0))
      std::fprintf(stderr, "(%u log lines of plugins were dropped)\n", lost);
  }

  Slot slots_[kLines];
  std::atomic<std::size_t> head_{0};
  std::size_t tail_ = 0;
  std::atomic<unsigned> dropped_{0};
  std::atomic<bool> stop_{false}, started_{false};
  std::thread reader_;
};
inline LogRing& log_ring() {
  static LogRing ring;
  return ring;
}

inline std::atomic<int>& least_severity() {
  static std::atomic<int> value{static_cast<int>(Severity::info)};
  return value;
}

/// One line, "[severity] [logger]: text".
inline void log_text(Severity severity, const char* logger, const char* text) {
  char line[LogRing::kBytes];
  int size = std::snprintf(line, sizeof line - 1, "[%s] [%s]: %s", name_of(severity), logger, text);
  if (size < 0) return;
  if (size > static_cast<int>(sizeof line) - 2) size = sizeof line - 2;
  line[size++] = '\n';
  if (in_cycle())
    log_ring().push(line, static_cast<std::size_t>(size));
  else if (::write(2, line, static_cast<std::size_t>(size)) < 0)
    return;
}

__attribute__((format(printf, 3, 4))) inline void log_format(Severity severity, const char* logger,
                                                             const char* format, ...) {
  char text[LogRing::kBytes];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  log_text(severity, logger, text);
}

}  // namespace polyarm_ros
