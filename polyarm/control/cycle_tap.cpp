#include "polyarm/control/cycle_tap.hpp"

#include <algorithm>

namespace polyarm::control {

CycleTap::CycleTap(std::size_t states, std::size_t commands, std::size_t rows, unsigned every)
    : states_(states),
      commands_(commands),
      every_(std::max(every, 1u)),
      heads_(std::max<std::size_t>(rows, 1)),
      data_(heads_.size() * (states + commands)) {}

void CycleTap::record(const TappedCycle& cycle, std::span<const double> states,
                      std::span<const double> commands) noexcept {
  if (cycle.index % every_ != 0) return;
  const std::uint64_t written = written_.load(std::memory_order_relaxed);
  if (written - read_.load(std::memory_order_acquire) >= heads_.size()) {
    lost_.fetch_add(1, std::memory_order_relaxed);
    return;
  }
  const std::size_t at = written % heads_.size();
  heads_[at] = cycle;
  double* to = data_.data() + at * (states_ + commands_);
  std::copy_n(states.begin(), std::min(states.size(), states_), to);
  std::copy_n(commands.begin(), std::min(commands.size(), commands_), to + states_);
  written_.store(written + 1, std::memory_order_release);
}

const TappedCycle* CycleTap::front() const noexcept {
  const std::uint64_t read = read_.load(std::memory_order_relaxed);
  return read == written_.load(std::memory_order_acquire) ? nullptr : &heads_[read % heads_.size()];
}

std::span<const double> CycleTap::states() const noexcept {
  const std::size_t at = read_.load(std::memory_order_relaxed) % heads_.size();
  return {data_.data() + at * (states_ + commands_), states_};
}

std::span<const double> CycleTap::commands() const noexcept {
  const std::size_t at = read_.load(std::memory_order_relaxed) % heads_.size();
  return {data_.data() + at * (states_ + commands_) + states_, commands_};
}

void CycleTap::drop() noexcept {
  read_.store(read_.load(std::memory_order_relaxed) + 1, std::memory_order_release);
}

}  // namespace polyarm::control
