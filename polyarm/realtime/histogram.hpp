#pragma once
#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cstdint>

#include "polyarm/base/time.hpp"

namespace polyarm::realtime {

/// A count that one thread raises and any may read: as cheap as a plain number.
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

/// Counts of durations in buckets of 1/16 of an octave (6 % wide), for percentiles without keeping samples.
/// add() is a few instructions, allocates nothing; percentiles are upper bucket edges. One thread adds, any
/// may read meanwhile.
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
