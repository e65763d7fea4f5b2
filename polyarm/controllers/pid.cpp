#include "polyarm/controllers/pid.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

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
  if (g.integrate_first && g.antiwindup != AntiWindup::none)
    return "integrate_first requires antiwindup none";
  return std::nullopt;
}

bool possible(const PidGains& g) noexcept {
  const double times[] = {g.tracking_time_constant, g.error_deadband, g.derivative_filter};
  const auto usable = [](double x) { return std::isfinite(x) && x >= 0; };
  return std::isfinite(g.p) && std::isfinite(g.i) && std::isfinite(g.d) &&
         std::all_of(std::begin(times), std::end(times), usable) && g.i_min <= 0 && g.i_max >= 0 &&
         g.u_min < g.u_max && (!g.integrate_first || g.antiwindup == AntiWindup::none);
}

PidGains gains_of(const RosControlGains& g) {
  PidGains out{.p = g.p, .i = g.i, .d = g.d};
  out.i_min = -std::abs(g.i_clamp_min.value_or(g.i_clamp));
  out.i_max = std::abs(g.i_clamp_max.value_or(g.i_clamp));
  out.clamp_output_only = !g.antiwindup;
  out.integrate_first = true;
  return out;
}

std::optional<std::string> without_effect(const PidGains& g) {
  if (g.i == 0 || g.i_min < 0 || g.i_max > 0) return std::nullopt;
  return "the integral gain " + format_number(g.i) +
         " has no effect, since the integral is clamped to 0; state its limits (i_clamp)";
}

bool Pid::set_gains(const PidGains& gains) noexcept {
  if (!possible(gains)) return false;
  gains_ = gains;
  set_integral(integral_);
  tracking_time_ = gains_.tracking_time_constant;
  if (tracking_time_ > 0 || gains_.i == 0) return true;
  const double ratio = (gains_.d != 0 ? gains_.d : gains_.p) / gains_.i;
  tracking_time_ = gains_.d != 0 ? std::sqrt(std::max(ratio, 0.0)) : ratio;
  return true;
}

void Pid::reset(bool keep_integral) noexcept {
  terms_ = {};
  last_error_ = output_ = derivative_ = 0;
  last_measured_ = std::numeric_limits<double>::quiet_NaN();
  if (!keep_integral) integral_ = 0;
}

void Pid::set_integral(double value) noexcept {
  integral_ = gains_.clamp_output_only ? value : std::clamp(value, gains_.i_min, gains_.i_max);
}

/// `excess` is by how much the output is beyond its limits.
void Pid::integrate(double error, double excess, double dt) noexcept {
  if (gains_.i == 0 || (std::abs(error) <= gains_.error_deadband && gains_.error_deadband > 0)) return;
  if (gains_.antiwindup == AntiWindup::conditional_integration && excess * error > 0) return;
  double rate = gains_.i * error;
  if (gains_.antiwindup == AntiWindup::back_calculation && tracking_time_ > 0)
    rate -= excess / tracking_time_;
  const double sum = integral_ + rate * dt;
  if (std::isfinite(sum)) set_integral(sum);
}

double Pid::compute(double error, double error_dot, double dt) noexcept {
  if (dt == 0) return output_;
  const double nothing = std::numeric_limits<double>::quiet_NaN();
  if (!(dt > 0) || !std::isfinite(error) || !std::isfinite(error_dot)) return nothing;
  const double share = gains_.derivative_filter > 0 ? dt / (gains_.derivative_filter + dt) : 1;
  const double derivative = (1 - share) * derivative_ + share * error_dot;
  const double integral_before = integral_;
  if (gains_.integrate_first) integrate(error, 0, dt);
  const Terms terms{gains_.p * error, std::clamp(integral_, gains_.i_min, gains_.i_max),
                    gains_.d * derivative};
  const double free_output = terms.p + terms.i + terms.d;
  if (!std::isfinite(free_output)) {
    integral_ = integral_before;
    return nothing;
  }
  terms_ = terms;
  derivative_ = derivative;
  last_error_ = error;
  output_ = std::clamp(free_output, gains_.u_min, gains_.u_max);
  if (!gains_.integrate_first) integrate(error, free_output - output_, dt);
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
