#include "polyarm/realtime/periodic.hpp"

#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <time.h>

#include <algorithm>

namespace polyarm::realtime {

namespace {
Nanoseconds now(clockid_t clock) noexcept {
  timespec t{};
  clock_gettime(clock, &t);
  return static_cast<Nanoseconds>(t.tv_sec) * 1'000'000'000 + t.tv_nsec;
}
}  // namespace

Nanoseconds monotonic_now() noexcept {
  return now(CLOCK_MONOTONIC);
}
Nanoseconds wall_now() noexcept {
  return now(CLOCK_REALTIME);
}

WakeUp Periodic::wait() noexcept {
  timespec until{static_cast<time_t>(due_ / 1'000'000'000), static_cast<long>(due_ % 1'000'000'000)};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) != 0) {
  }
  const Nanoseconds woke = monotonic_now();
  WakeUp out{due_, std::max<Nanoseconds>(0, woke - due_), 0};
  due_ += period_;
  if (due_ <= woke) {
    out.skipped = static_cast<std::uint64_t>((woke - due_) / period_) + 1;
    due_ += static_cast<Nanoseconds>(out.skipped) * period_;
  }
  return out;
}

bool Periodic::doze(Nanoseconds most) const noexcept {
  const Nanoseconds end = std::min(due_, monotonic_now() + most);
  timespec until{static_cast<time_t>(end / 1'000'000'000), static_cast<long>(end % 1'000'000'000)};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) != 0) {
  }
  return end == due_;
}

WakeUp Periodic::woken() noexcept {
  const Nanoseconds woke = monotonic_now();
  WakeUp out{due_, std::max<Nanoseconds>(0, woke - due_), 0};
  if (woke - due_ >= period_) out.skipped = static_cast<std::uint64_t>((woke - due_) / period_);
  due_ = woke + period_;
  return out;
}

unsigned apply_each(const ThreadOptions& options) noexcept {
  ::prctl(PR_SET_TIMERSLACK, 1UL);  // ns; the kernel's 50 us for ordinary threads would add to every wake-up
  unsigned refused = 0;
  const auto refuse = [&](Refusal what) { refused |= static_cast<unsigned>(what); };
  if (options.cpu >= 0) {
    cpu_set_t set;
    CPU_ZERO(&set);
    if (options.cpu < CPU_SETSIZE) CPU_SET(static_cast<unsigned>(options.cpu), &set);
    if (sched_setaffinity(0, sizeof set, &set) != 0) refuse(Refusal::cpu);
  }
  if (options.priority > 0) {
    sched_param parameters{};
    parameters.sched_priority = options.priority;
    if (sched_setscheduler(0, SCHED_FIFO, &parameters) != 0) refuse(Refusal::priority);
  }
  if (options.lock_memory && mlockall(MCL_CURRENT | MCL_FUTURE) != 0) refuse(Refusal::memory);
  return refused;
}

const char* apply(const ThreadOptions& options) noexcept {
  const unsigned refused = apply_each(options);
  const auto is = [&](Refusal what) { return (refused & static_cast<unsigned>(what)) != 0; };
  if (is(Refusal::memory)) return "memory could not be locked";
  if (is(Refusal::priority)) return "real-time priority was refused (needs CAP_SYS_NICE or an rtprio limit)";
  return is(Refusal::cpu) ? "the control thread could not be pinned to its processor" : "";
}

}  // namespace polyarm::realtime
