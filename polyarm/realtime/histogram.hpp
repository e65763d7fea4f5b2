#pragma once
/// Counters and duration histograms (ns) with one writer thread and any number of readers, without locks.
#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cstdint>
#include <tuple>

#include "polyarm/base/time.hpp"

namespace polyarm::realtime {

/// A counter that one thread increments and any thread may read; as cheap as a plain number.
class Counter {
 public:
  Counter& operator+=(std::uint64_t n) noexcept {
    value_.store(value_.load(std::memory_order_relaxed) + n, std::memory_order_relaxed);
    return *this;
  }
  Counter& operator++() noexcept { return *this += 1; }
  operator std::uint64_t() const noexcept { return value_.load(std::memory_order_relaxed); }

 private:
  std::atomic<std::uint64_t> value_{0};
};

/// Counts durations in buckets of 1/16 of an octave (6 % wide), to compute percentiles without keeping
/// samples. add() takes a few instructions and allocates nothing. Percentiles are upper bucket edges. One
/// thread adds; any thread may read at the same time.
class Histogram {
 public:
  void add(Nanoseconds value) noexcept {
    ++counts_[bucket(value)];
    ++count_;
    if (value > max()) max_.store(value, std::memory_order_relaxed);
  }
  std::uint64_t count() const noexcept { return count_; }
  Nanoseconds max() const noexcept { return max_.load(std::memory_order_relaxed); }
  /// The duration that the share `p` in [0, 1] of all samples does not exceed, ns; 0 when empty.
  Nanoseconds percentile(double p) const noexcept {
    std::uint64_t seen = 0;
    const auto wanted = static_cast<std::uint64_t>(p * static_cast<double>(count_) + 0.5);
    for (std::size_t i = 0; i < counts_.size(); ++i) {
      seen += counts_[i];
      if (seen >= wanted && seen > 0) return std::min(upper_edge(i), max());
    }
    return max();
  }
  /// Tells `each(to, count)` for each quarter of an octave: how many samples were no longer than `to`, and
  /// longer than the `to` before. From the quarter before the shortest to that of the longest; nothing while
  /// there are no samples.
  template <typename Each>
  void quarters(Each each) const {
    constexpr std::size_t kOne = 4;
    std::array<std::uint64_t, std::tuple_size_v<decltype(counts_)> / kOne> sums{};
    for (std::size_t i = 0; i < counts_.size(); ++i) sums[i / kOne] += counts_[i];
    const auto any = [](std::uint64_t sum) { return sum > 0; };
    const auto first = std::find_if(sums.begin(), sums.end(), any);
    const auto last = std::find_if(sums.rbegin(), sums.rend(), any).base();
    for (auto at = first == sums.begin() || first == sums.end() ? first : first - 1; at < last; ++at)
      each(upper_edge(static_cast<std::size_t>(at - sums.begin()) * kOne + kOne - 1), *at);
  }

 private:
  static constexpr int kFine = 4;  // 16 buckets an octave
  static std::size_t bucket(Nanoseconds value) noexcept {
    const auto v = static_cast<std::uint64_t>(value < 0 ? 0 : value);
    if (v < (1u << kFine)) return static_cast<std::size_t>(v);
    const int octave = std::bit_width(v) - 1;
    const auto fine = (v >> (octave - kFine)) & ((1u << kFine) - 1);
    return (static_cast<std::size_t>(octave - kFine + 1) << kFine) + static_cast<std::size_t>(fine);
  }
  static Nanoseconds upper_edge(std::size_t i) noexcept {
    if (i < (1u << kFine)) return static_cast<Nanoseconds>(i);
    const int octave = static_cast<int>(i >> kFine) + kFine - 1;
    const auto fine = i & ((1u << kFine) - 1);
    return static_cast<Nanoseconds>((((1ull << kFine) + fine + 1) << (octave - kFine)) - 1);
  }
  std::array<Counter, 976> counts_;
  Counter count_;
  std::atomic<Nanoseconds> max_{0};
};

}  // namespace polyarm::realtime
