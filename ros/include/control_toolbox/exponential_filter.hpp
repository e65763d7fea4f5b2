#pragma once
/// y(n) = alpha x(n) + (1 - alpha) y(n-1) for each number; the first value passes. y(n) = y(n-1) where
/// x(n) is NaN or infinite.
#include <cmath>

#include "control_toolbox/filter_traits.hpp"
#include "polyarm_ros/standard.hpp"

namespace control_toolbox {

template <typename T>
class ExponentialFilter {
 public:
  ExponentialFilter() = default;
  explicit ExponentialFilter(double alpha) : alpha_(alpha) {}
  void set_params(double alpha) { alpha_ = alpha; }
  bool configure() {
    begun_ = false;
    return configured_ = true;
  }
  bool is_configured() const { return configured_; }
  /// False while no finite value has come. Throws std::runtime_error if it is not configured, or if a list
  /// has another length than before.
  bool update(const T& in, T& out) {
    if (!configured_) throw std::runtime_error("Filter is not configured");
    const auto& now = FilterNumbers<T>::read(in);
    if (!begun_) {
      if (!all_finite(now) || now.size() == 0) return false;
      filtered_ = now;
      begun_ = true;
    }
    if (now.size() != filtered_.size())
      throw std::runtime_error("a filter gets " + std::to_string(now.size()) + " numbers after " +
                               std::to_string(filtered_.size()));
    for (std::size_t i = 0; i < filtered_.size(); ++i)
      if (std::isfinite(now[i])) filtered_[i] = alpha_ * now[i] + (1 - alpha_) * filtered_[i];
    FilterNumbers<T>::write(filtered_, in, out);
    return true;
  }

 private:
  double alpha_ = 0.5;
  bool configured_ = false, begun_ = false;
  typename FilterNumbers<T>::Storage filtered_{};
};

}  // namespace control_toolbox
