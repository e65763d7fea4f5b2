#pragma once
/// Proportional, integral, derivative: the feedback of ros2_control's control_toolbox, with its order of
/// steps and its ways to keep the integral from growing. Standard types only.
#include <cmath>
#include <limits>
#include <optional>
#include <string>

namespace polyarm::controllers {

/// What happens to the integral while the output is limited. `none`: nothing. `back_calculation`: the excess
/// is taken back over the tracking time. `conditional_integration`: errors that would lead further beyond the
/// limit are not integrated.
enum class AntiWindup { none, back_calculation, conditional_integration };

/// Gains in output per error, per error second, and per error a second.
struct PidGains {
  double p = 0, i = 0, d = 0;
  double u_min = -std::numeric_limits<double>::infinity(), u_max = std::numeric_limits<double>::infinity();
  double i_min = -std::numeric_limits<double>::infinity(), i_max = std::numeric_limits<double>::infinity();
  AntiWindup antiwindup = AntiWindup::none;
  double tracking_time_constant = 0;  ///< s; 0: sqrt(d / i), or p / i without d
  double error_deadband = 0;          ///< errors not above this are not integrated
  double derivative_filter = 0;  ///< s, time constant of a first-order low pass on the derivative; 0: raw
  /// The integral's share of the output is clamped, and not the integral itself: ros_control without
  /// antiwindup.
  bool clamp_output_only = false;
  /// The present error enters the integral before the output is computed (backward Euler): ros_control. Only
  /// with `antiwindup` none.
  bool integrate_first = false;
  bool derivative_on_measurement = false;  ///< what Pid::follow takes the derivative of
};

/// Why these gains cannot be; nothing where they can.
std::optional<std::string> check(const PidGains& gains);
/// The same as yes or no, for the control thread.
bool possible(const PidGains& gains) noexcept;

/// Gains as ros_control's files state them under `pid:`. Signs of the clamps have no meaning there, and
/// without a clamp the integral has no share in the output.
struct RosControlGains {
  double p = 0, i = 0, d = 0, i_clamp = 0;
  std::optional<double> i_clamp_min = {}, i_clamp_max = {};  ///< instead of i_clamp
  bool antiwindup = false;
};
/// The same controller here: its order of steps, and the integral itself clamped with `antiwindup`, only its
/// share of the output without.
PidGains gains_of(const RosControlGains& gains);
/// "pid.i has no effect …" where gains state an integral that their clamps never let through.
std::optional<std::string> without_effect(const PidGains& gains);

/// One controller. update: the control thread; nothing allocates, locks or throws.
class Pid {
 public:
  /// Shares of the last output, before its limits.
  struct Terms {
    double p = 0, i = 0, d = 0;
  };

  /// Impossible gains become gains of 0.
  explicit Pid(const PidGains& gains = {}) { set_gains(gains); }

  /// The output for `error` after `dt` seconds; the derivative is the difference from the last error. The
  /// present error enters the integral after the output is computed (forward Euler). dt of 0 gives the last
  /// output again; an error or dt that is no number, a dt below 0, or a sum beyond all numbers gives NaN and
  /// changes nothing.
  double compute(double error, double dt) noexcept {
    const double change = dt > 0 ? (error - last_error_) / dt : 0;
    return compute(error, change, dt);
  }
  /// The same with a derivative that is known better.
  double compute(double error, double error_dot, double dt) noexcept;
  /// Derivative on the measurement: a step of the set point makes no kick. `measured` is what is controlled.
  double compute_on_measurement(double set_point, double measured, double dt) noexcept;
  /// As the gains say: on the measurement, or on the error set_point - measured.
  double follow(double set_point, double measured, double dt) noexcept {
    return gains_.derivative_on_measurement ? compute_on_measurement(set_point, measured, dt)
                                            : compute(set_point - measured, dt);
  }

  /// Forgets errors and output, and the integral too unless it is to be kept.
  void reset(bool keep_integral = false) noexcept;
  /// Between two cycles; the integral stays where the new limits allow it. Impossible gains are refused:
  /// false, and the old ones go on.
  bool set_gains(const PidGains& gains) noexcept;
  const PidGains& gains() const noexcept { return gains_; }

  double integral() const noexcept { return integral_; }  ///< the integral's share of the output
  Terms terms() const noexcept { return terms_; }
  double last_output() const noexcept { return output_; }
  double last_error() const noexcept { return last_error_; }
  double last_derivative() const noexcept { return derivative_; }

 private:
  void set_integral(double value) noexcept;
  void integrate(double error, double excess, double dt) noexcept;

  PidGains gains_ = {};
  Terms terms_;
  double integral_ = 0, last_error_ = 0, output_ = 0, derivative_ = 0;
  double last_measured_ = std::numeric_limits<double>::quiet_NaN();
  double tracking_time_ = 0;
};

}  // namespace polyarm::controllers
