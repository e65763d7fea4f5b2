#include "polyarm/base/printer.hpp"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <utility>

namespace polyarm {

namespace {

constexpr auto kTimeout = std::chrono::seconds(2);
constexpr std::size_t kPiece = 4096;  ///< what a pipe takes whole, so that its reader's progress is seen

}  // namespace

struct Printer::Work {
  Work(int to, Full when_full, Gap gap_text, std::size_t bytes)
      : descriptor(to), full(when_full), gap(std::move(gap_text)), most(bytes) {}

  void run() {
    std::unique_lock lock(mutex);
    for (;;) {
      wake.wait(lock, [this] { return over || !waiting.empty(); });
      if (waiting.empty()) return;
      std::string now = std::exchange(waiting, {});
      if (left_out > 0) now += gap(std::exchange(left_out, 0));
      writing = true;
      room.notify_all();
      lock.unlock();
      const bool written = write(now);
      lock.lock();
      writing = false;
      const bool news = !written && !std::exchange(gone, gone || !written);
      if (news && tell) {
        const auto told = tell;
        lock.unlock();
        told();
        lock.lock();
      }
      room.notify_all();
    }
  }

  /// Without the lock.
  bool write(std::string_view text) {
    while (!text.empty()) {
      const ssize_t count = ::write(descriptor, text.data(), std::min(text.size(), kPiece));
      if (count < 0 && errno != EINTR && !(is_full(errno) && wait_for_room())) return false;
      if (count <= 0) continue;
      text.remove_prefix(static_cast<std::size_t>(count));
      const std::lock_guard lock(mutex);
      ++taken;
      room.notify_all();
    }
    return true;
  }

  /// Whoever shares the descriptor may have made it one that never waits.
  static bool is_full(int error) { return error == EAGAIN || error == EWOULDBLOCK; }
  bool wait_for_room() const {
    pollfd asked{descriptor, POLLOUT, 0};
    const int count = ::poll(&asked, 1, -1);
    return (count > 0 && (asked.revents & POLLOUT) != 0) || (count < 0 && errno == EINTR);
  }

  bool idle() const { return gone || (waiting.empty() && !writing); }

  const int descriptor;
  const Full full;
  const Gap gap;
  const std::size_t most;
  std::function<void()> tell;
  std::mutex mutex;
  std::condition_variable wake, room;
  std::string waiting;
  std::size_t left_out = 0, taken = 0;
  bool writing = false, over = false, gone = false;
};

Printer::Printer(int descriptor, Full full, Gap gap, std::size_t most)
    : work_(std::make_shared<Work>(descriptor, full, std::move(gap), most)) {
  std::thread([work = work_] { work->run(); }).detach();
}

Printer::~Printer() {
  settle();
  const std::lock_guard lock(work_->mutex);
  work_->over = true;
  work_->wake.notify_all();
}

bool Printer::gone() const {
  const std::lock_guard lock(work_->mutex);
  return work_->gone;
}

void Printer::when_gone(std::function<void()> tell) {
  std::unique_lock lock(work_->mutex);
  work_->tell = std::move(tell);
}

void Printer::put(std::string_view text) {
  std::unique_lock lock(work_->mutex);
  const auto fits = [&] {
    return work_->gone || work_->waiting.empty() || work_->waiting.size() + text.size() <= work_->most;
  };
  if (work_->full == Full::waits) work_->room.wait(lock, fits);
  if (work_->gone) return;
  // Once something is left out, the gap is told before anything follows it.
  if (work_->left_out > 0 || !fits()) {
    ++work_->left_out;
    return;
  }
  work_->waiting += text;
  work_->wake.notify_all();
}

bool Printer::settle() {
  std::unique_lock lock(work_->mutex);
  const auto idle = [this] { return work_->idle(); };
  if (work_->full == Full::waits) {
    work_->room.wait(lock, idle);
    return true;
  }
  for (std::size_t before = work_->taken;; before = work_->taken) {
    if (work_->room.wait_for(lock, kTimeout, [&] { return idle() || work_->taken != before; })) {
      if (idle()) return true;
    } else {
      return false;
    }
  }
}

}  // namespace polyarm
