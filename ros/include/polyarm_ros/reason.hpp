#pragma once
#include <atomic>
#include <cstring>
#include <string>

namespace polyarm_ros {

/// The reason of the last failure. Written without allocation by one thread at a time, read by any.
class Reason {
 public:
  void set(const char* where, const char* what) noexcept {
    const int next = 1 - shown_.load(std::memory_order_relaxed);
    char* text = texts_[next];
    std::size_t used = 0;
    for (const char* part : {where, ": ", what})
      for (; *part && used + 1 < kBytes; ++part) text[used++] = *part;
    text[used] = '\0';
    shown_.store(next, std::memory_order_release);
  }
  std::string text() const { return texts_[shown_.load(std::memory_order_acquire)]; }

 private:
  static constexpr std::size_t kBytes = 512;
  char texts_[2][kBytes] = {};
  std::atomic<int> shown_{0};
};

}  // namespace polyarm_ros
