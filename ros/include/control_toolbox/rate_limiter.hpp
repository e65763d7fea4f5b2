#pragma once
/// Limits a value, and its first and second change in time. NaN switches a limit off; a minimum that is NaN is
/// the negative maximum.
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace control_toolbox {

template <typename T>
class RateLimiter {
  static constexpr T kNone = std::numeric_limits<T>::quiet_NaN();

 public:
  RateLimiter(T min_value = kNone, T max_value = kNone, T min_first_neg = kNone, T max_first_pos = kNone,
              T min_first_pos = kNone, T max_first_neg = kNone, T min_second = kNone, T max_second = kNone) {
    set_params(min_value, max_value, min_first_neg, max_first_pos, min_first_pos, max_first_neg, min_second,
               max_second);
  }
  void set_params(T min_value = kNone, T max_value = kNone, T min_first_neg = kNone, T max_first_pos = kNone,
                  T min_first_pos = kNone, T max_first_neg = kNone, T min_second = kNone,
                  T max_second = kNone) {
    const Range value = range(min_value, max_value, "value");
    const Range away = range(min_first_neg, max_first_pos, "first derivative");
    const Range back{std::isnan(min_first_pos) ? away.low : min_first_pos,
                     std::isnan(max_first_neg) ? away.high : max_first_neg};
    if (away.on() && back.low > back.high) throw std::invalid_argument("Invalid first derivative limits");
    second_ = range(min_second, max_second, "second derivative");
    value_ = value, away_ = away, back_ = back;
  }

  /// Limits `v`, which follows `v0` and before it `v1`, `dt` s apart. Returns the share that is left of it.
  T limit(T& v, T v0, T v1, T dt) {
    const T asked = v;
    limit_second_derivative(v, v0, v1, dt);
    limit_first_derivative(v, v0, dt);
    limit_value(v);
    return share(v, asked);
  }
  T limit_value(T& v) {
    const T asked = v;
    if (value_.on()) v = std::clamp(v, value_.low, value_.high);
    return share(v, asked);
  }
  T limit_first_derivative(T& v, T v0, T dt) {
    const T asked = v;
    if (away_.on()) {
      const T low = v0 > T(0) ? back_.low : away_.low, high = v0 < T(0) ? back_.high : away_.high;
      v = v0 + std::clamp(v - v0, low * dt, high * dt);
    }
    return share(v, asked);
  }
  /// Only while the value moves away from what it was.
  T limit_second_derivative(T& v, T v0, T v1, T dt) {
    const T asked = v, step = v - v0, before = v0 - v1;
    if (second_.on() && (step - before) * step > 0)
      v = v0 + before + std::clamp(step - before, second_.low * dt * dt, second_.high * dt * dt);
    return share(v, asked);
  }

 private:
  struct Range {
    T low = kNone, high = kNone;
    bool on() const { return !std::isnan(high); }
  };
  static Range range(T low, T high, const char* what) {
    const Range out{std::isnan(low) ? -high : low, high};
    if (out.on() && out.low > out.high) throw std::invalid_argument(std::string("Invalid ") + what + " limits");
    return out;
  }
  static T share(T left, T asked) { return asked != T(0) ? left / asked : T(1); }
  Range value_, away_, back_, second_;
};

}  // namespace control_toolbox
