#pragma once
#include <cstddef>
#include <vector>

namespace rcppmath {
/// The mean of the last values, at most `size` of them.
template <typename T>
class RollingMeanAccumulator {
 public:
  RollingMeanAccumulator() = delete;
  explicit RollingMeanAccumulator(std::size_t size) : values_(size, T{}) {}
  void accumulate(T value) {
    sum_ += value - values_[next_];
    values_[next_] = value;
    if (++next_ == values_.size()) next_ = 0, full_ = true;
  }
  T getRollingMean() const {
    const std::size_t count = full_ ? values_.size() : next_;
    return count ? sum_ / static_cast<T>(count) : T{};
  }

 private:
  std::vector<T> values_;
  std::size_t next_ = 0;
  T sum_{};
  bool full_ = false;
};
}  // namespace rcppmath
