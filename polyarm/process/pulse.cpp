#include "polyarm/process/pulse.hpp"

#include <algorithm>
#include <utility>

namespace polyarm::process {

Pulse::Pulse(Channel& channel) : channel_(channel), thread_([this] { run(); }) {}

Pulse::~Pulse() {
  {
    const std::lock_guard lock(mutex_);
    over_ = true;
  }
  over_changed_.notify_all();
  thread_.join();
}

void Pulse::run() {
  for (std::unique_lock lock(mutex_); !over_;) {
    channel_.pulse();
    over_changed_.wait_for(lock, kPulse, [this] { return over_; });
  }
}

void PulseWatch::restart(Clock::time_point now) {
  looked_ = now;
  silence_ = {};
}

bool PulseWatch::silent(const Channel& channel, Clock::time_point now, std::chrono::nanoseconds limit) {
  const auto since = std::min<std::chrono::nanoseconds>(now - std::exchange(looked_, now), kPulse);
  const std::uint64_t pulses = channel.pulses();
  if (std::exchange(seen_, pulses) != pulses || pulses == 0)
    silence_ = {};
  else
    silence_ += since;
  return silence_ >= limit;
}

}  // namespace polyarm::process
