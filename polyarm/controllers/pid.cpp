#include "polyarm/controllers/pid.hpp"

#include <algorithm>

#include "polyarm/base/text.hpp"

namespace polyarm::controllers {

std::optional<std::string> check(const PidGains& g) {
  for (const auto& [name, value] : {std::pair{"p", g.p},
                                    {"i", g.i},
                                    {"d", g.d},
                                    {"tracking_time_constant", g.tracking_time_constant},
                                    {"error_deadband", g.error_deadband},
                                    {"derivative_filter", g.derivative_filter}})
    if (!std::isfinite(value)) return std::string(name) + " is not a finite number";
  if (!(g.i_min <= 0 && g.i_max >= 0))
    return "the limits of the integral, " + format_number(g.i_min) + " and " + format_number(g.i_max) +
           ", must have 0 between them";
  if (!(g.u_min < g.u_max))
    return "the lower limit of the output, " + format_number(g.u_min) + ", is not below the upper, " +
           format_number(g.u_max);
  if (g.tracking_time_constant < 0) return "tracking_time_constant is below 0";
  if (g.error_deadband < 0) return "error_deadband is below 0";
  if (g.derivative_filter < 0) return "derivative_filter is below 0";
  return std::nullopt;
}

void Pid::set_gains(const PidGains& gains) noexcept {
  gains_ = gains;
  if (!gains_.clamp_output_only) integral_ = std::clamp(integral_, gains_.i_min, gains_.i_max);
  tracking_time_ = gains_.tracking_time_constant;
  if (tracking_time_ <= 0 && gains_.i > 0)
    tracking_time_ = gains_.d > 0 ? std::sqrt(gains_.d / gains_.i) : gains_.p / gains_.i;
}

void Pid::reset(bool keep_integral) noexcept {
  last_error_ = output_ = derivative_ = 0;
  last_measured_ = std::numeric_limits<double>::quiet_NaN();
  if (!keep_integral) integral_ = 0;
}

void Pid::integrate(double error, double free_output, double dt) noexcept {
  if (std::abs(error) <= gains_.error_deadband && gains_.error_deadband > 0) return;
  const double excess = free_output - output_;
  double rate = gains_.i * error;
  if (gains_.antiwindup == AntiWindup::back_calculation && tracking_time_ > 0)
    rate -= excess / tracking_time_;
  if (gains_.antiwindup == AntiWindup::conditional_integration && excess * error > 0) return;
  integral_ += rate * dt;
  if (!gains_.clamp_output_only) integral_ = std::clamp(integral_, gains_.i_min, gains_.i_max);
}

double Pid::compute(double error, double error_dot, double dt) noexcept {
  if (dt == 0) return output_;
  if (!(dt > 0) || !std::isfinite(error) || !std::isfinite(error_dot))
    return std::numeric_limits<double>::quiet_NaN();
  const double share = gains_.derivative_filter > 0 ? dt / (gains_.derivative_filter + dt) : 1;
  derivative_ += share * (error_dot - derivative_);
  const double integral = std::clamp(integral_, gains_.i_min, gains_.i_max);
  const double free_output = gains_.p * error + integral + gains_.d * derivative_;
  output_ = std::clamp(free_output, gains_.u_min, gains_.u_max);
  integrate(error, free_output, dt);
  last_error_ = error;
  return output_;
}

double Pid::compute_on_measurement(double set_point, double measured, double dt) noexcept {
  if (dt == 0) return output_;
  const double change = std::isfinite(last_measured_) && dt > 0 ? (measured - last_measured_) / dt : 0;
  const double out = compute(set_point - measured, -change, dt);
  if (std::isfinite(out)) last_measured_ = measured;
  return out;
}

}  // namespace polyarm::controllers
