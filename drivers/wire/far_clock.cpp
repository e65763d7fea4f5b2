#include "drivers/wire/far_clock.hpp"

#include <poll.h>
#include <sys/eventfd.h>

#include <algorithm>
#include <utility>

#include "polyarm/realtime/periodic.hpp"

namespace polyarm::wire {

FarClock::FarClock(Nanoseconds patience)
    : patience_(patience), wake_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {}

FarClock::~FarClock() {
  quit_ = true;
  ::eventfd_write(wake_.number(), 1);
  if (thread_.joinable()) thread_.join();
}

void FarClock::start(Nanoseconds period, Controller controller) {
  period_ = period;
  controller_ = std::move(controller);
  thread_ = std::thread([this] { run(); });
}

void FarClock::hold(bool on) {
  const std::lock_guard lock(mutex_);
  held_ = on;
}

bool FarClock::step(Nanoseconds patience, const std::function<bool()>& ready) {
  std::unique_lock lock(mutex_);
  bool came = true;
  if (patience > 0) came = served_.wait_for(lock, std::chrono::nanoseconds(patience), ready);
  controller_.cycle();
  return came;
}

void FarClock::settle() {
  std::unique_lock lock(mutex_);
  served_.wait(lock, [this, before = served_times_] { return served_times_ != before; });
}

/// Until something has come, or the cycle is due.
void FarClock::await_work(Nanoseconds due) {
  std::vector<int> open{wake_.number()};
  {
    const std::lock_guard lock(mutex_);
    controller_.descriptors(open);
  }
  std::vector<pollfd> polled;
  for (const int descriptor : open) polled.push_back({descriptor, POLLIN, 0});
  const Nanoseconds left =
      std::clamp<Nanoseconds>(due - realtime::monotonic_now(), patience_ > 0 ? 1'000'000 : 0, period_);
  const timespec time{0, static_cast<long>(left)};
  ::ppoll(polled.data(), polled.size(), &time, nullptr);
}

void FarClock::run() {
  Nanoseconds due = realtime::monotonic_now() + period_;
  while (!quit_) {
    await_work(due);
    const std::lock_guard lock(mutex_);
    controller_.serve();
    ++served_times_;
    served_.notify_all();
    const Nanoseconds now = realtime::monotonic_now();
    if (now < due) continue;
    if (!held_ && controller_.waits() && now < due + patience_) continue;
    due = std::max(due + period_, patience_ > 0 ? now : now - 10 * period_);
    if (!held_) controller_.cycle();
  }
}

}  // namespace polyarm::wire
