#pragma once
/// y(n) = b x(n-1) + a y(n-1) for each number, with a = exp(-2π df / (sf 10^(-di/10))) and b = 1 - a; sf is
/// the sampling frequency, df the damping frequency (Hz), di the damping intensity. As control_toolbox
/// documents it.
#include <cmath>

#include "control_toolbox/filter_traits.hpp"
#include "polyarm_ros/standard.hpp"

namespace control_toolbox {

template <typename T>
class LowPassFilter {
 public:
  LowPassFilter() = default;
  LowPassFilter(double sampling_frequency, double damping_frequency, double damping_intensity) {
    set_params(sampling_frequency, damping_frequency, damping_intensity);
  }
  void set_params(double sampling_frequency, double damping_frequency, double damping_intensity) {
    a_ = std::exp(-2 * M_PI * damping_frequency /
                  (sampling_frequency * std::pow(10.0, -damping_intensity / 10)));
    b_ = 1 - a_;
  }
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
      filtered_ = before_ = now;
      begun_ = true;
    }
    if (now.size() != filtered_.size())
      throw std::runtime_error("a filter gets " + std::to_string(now.size()) + " numbers after " +
                               std::to_string(filtered_.size()));
    for (std::size_t i = 0; i < filtered_.size(); ++i) filtered_[i] = b_ * before_[i] + a_ * filtered_[i];
    FilterNumbers<T>::write(filtered_, in, out);
    if (all_finite(now)) before_ = now;
    return true;
  }

 private:
  double a_ = 1, b_ = 0;
  bool configured_ = false, begun_ = false;
  typename FilterNumbers<T>::Storage filtered_{}, before_{};
};

}  // namespace control_toolbox
