#pragma once
#include <cmath>
#include <limits>

namespace polyarm::controllers {

/// A filter of first order: y(n) = a y(n-1) + b x(n-1) + c x(n), which begins with its first input. What is
/// not finite is passed over: the output stays. Real-time.
class FirstOrderFilter {
 public:
  FirstOrderFilter() = default;  ///< lets everything through

  /// control_toolbox's low pass: a = exp(-2 pi damping_frequency / sampling_frequency * 10^(intensity / 10)),
  /// b = 1 - a; it answers to the input one sample later. Frequencies in Hz, intensity in dB.
  static FirstOrderFilter low_pass(double sampling_frequency, double damping_frequency, double intensity);
  /// y(n) = alpha x(n) + (1 - alpha) y(n-1)
  static FirstOrderFilter exponential(double alpha) { return {1 - alpha, 0, alpha}; }

  double update(double x) noexcept {
    if (!std::isfinite(x)) return output_;
    if (std::isnan(output_)) output_ = input_ = x;
    output_ = a_ * output_ + b_ * input_ + c_ * x;
    input_ = x;
    return output_;
  }
  void reset() noexcept { output_ = input_ = kNone; }

 private:
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  FirstOrderFilter(double a, double b, double c) : a_(a), b_(b), c_(c) {}
  double a_ = 0, b_ = 0, c_ = 1;
  double input_ = kNone, output_ = kNone;
};

}  // namespace polyarm::controllers
