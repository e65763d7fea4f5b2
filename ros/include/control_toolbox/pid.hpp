#pragma once
/// A PID of one degree of freedom, with control_toolbox's names: those of Jazzy and Rolling, and those of Humble
/// (computeCommand, setGains), which integrates before it commands.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>

#include "rclcpp/duration.hpp"
#include "realtime_tools/realtime_buffer.hpp"
#include "realtime_tools/realtime_thread_safe_box.hpp"

namespace control_toolbox {

template <typename T>
bool is_zero(T value, T tolerance = std::numeric_limits<T>::epsilon()) {
  return std::abs(value) <= tolerance;
}

struct AntiWindupStrategy {
  enum Value : std::int8_t {
    UNDEFINED = -1,
    NONE,
    BACK_CALCULATION,
    CONDITIONAL_INTEGRATION,
    LEGACY  ///< of the first releases of Jazzy: the integral is clamped
  };
  AntiWindupStrategy() = default;
  AntiWindupStrategy(Value value) : type(value) {}  // NOLINT: implicit in ROS
  void set_type(const std::string& name) {
    type = name == "none"                      ? NONE
           : name == "back_calculation"        ? BACK_CALCULATION
           : name == "conditional_integration" ? CONDITIONAL_INTEGRATION
           : name == "legacy"                  ? LEGACY
                                               : UNDEFINED;
    if (type == UNDEFINED)
      throw std::invalid_argument("'" + name +
                                  "' is no antiwindup strategy: none, back_calculation or "
                                  "conditional_integration");
  }
  void validate() const {
    if (type == UNDEFINED) throw std::invalid_argument("the antiwindup strategy is not set");
    if (type == BACK_CALCULATION && !(tracking_time_constant >= 0 && std::isfinite(tracking_time_constant)))
      throw std::invalid_argument("back_calculation needs a tracking_time_constant of 0 or more");
    if (i_min > 0 || i_max < 0) throw std::invalid_argument("the integral's bounds must include 0");
  }
  std::string to_string() const {
    static const char* const names[] = {"UNDEFINED", "none", "back_calculation", "conditional_integration",
                                        "legacy"};
    return names[type + 1];
  }
  operator std::string() const { return to_string(); }
  bool operator==(Value other) const { return type == other; }
  bool operator!=(Value other) const { return type != other; }

  Value type = NONE;
  double i_max = std::numeric_limits<double>::infinity();
  double i_min = -std::numeric_limits<double>::infinity();
  double tracking_time_constant = 0;  ///< s; 0: from the gains
  double error_deadband = std::numeric_limits<double>::epsilon();
};

class Pid {
 public:
  struct Gains {
    Gains() = default;
    Gains(double p, double i, double d, double u_max, double u_min, const AntiWindupStrategy& strategy)
        : p_gain_(p), i_gain_(i), d_gain_(d), u_max_(u_max), u_min_(u_min), antiwindup_strat_(strategy) {}
    Gains(double p, double i, double d, double i_max, double i_min, bool antiwindup = false)
        : p_gain_(p), i_gain_(i), d_gain_(d), i_max_(i_max), i_min_(i_min), antiwindup_(antiwindup) {
      antiwindup_strat_.i_max = i_max, antiwindup_strat_.i_min = i_min;
    }
    bool validate(std::string& why) const {
      if (!(u_min_ < u_max_)) return why = "u_min must be below u_max", false;
      try {
        antiwindup_strat_.validate();
      } catch (const std::exception& e) {
        return why = e.what(), false;
      }
      return true;
    }
    double p_gain_ = 0, i_gain_ = 0, d_gain_ = 0;
    double u_max_ = std::numeric_limits<double>::infinity();
    double u_min_ = -std::numeric_limits<double>::infinity();
    double i_max_ = std::numeric_limits<double>::infinity();
    double i_min_ = -std::numeric_limits<double>::infinity();
    bool antiwindup_ = false;
    AntiWindupStrategy antiwindup_strat_;
  };

  Pid() { initialize(0, 0, 0, kInfinity, -kInfinity, {}); }
  Pid(double p, double i, double d, double u_max, double u_min, const AntiWindupStrategy& strategy) {
    if (!initialize(p, i, d, u_max, u_min, strategy))
      throw std::invalid_argument("the gains of a PID are invalid");
  }
  explicit Pid(double p, double i = 0, double d = 0, double i_max = 0, double i_min = -0.0,
               bool antiwindup = false) {
    initPid(p, i, d, i_max, i_min, antiwindup);
  }
  Pid(const Pid& other) { *this = other; }
  Pid& operator=(const Pid& other) {
    if (this != &other) box_.set(other.box_.get()), reset();
    return *this;
  }

  bool initialize(double p, double i, double d, double u_max, double u_min,
                  const AntiWindupStrategy& strategy) {
    if (!set_gains(p, i, d, u_max, u_min, strategy)) return false;
    reset();
    return true;
  }
  void reset() { reset(false); }
  void reset(bool save_i_term) {
    p_error_last_ = p_error_ = d_error_ = cmd_ = 0;
    if (!save_i_term) clear_saved_iterm();
    gains_ = box_.get();
  }
  void clear_saved_iterm() { i_term_ = i_error_ = 0; }
  Gains get_gains() { return box_.get(); }
  Gains get_gains_rt() { return gains_; }
  void get_gains(double& p, double& i, double& d, double& u_max, double& u_min,
                 AntiWindupStrategy& strategy) {
    const Gains all = get_gains();
    p = all.p_gain_, i = all.i_gain_, d = all.d_gain_, u_max = all.u_max_, u_min = all.u_min_;
    strategy = all.antiwindup_strat_;
  }
  bool set_gains(double p, double i, double d, double u_max, double u_min,
                 const AntiWindupStrategy& strategy) {
    return set_gains(Gains(p, i, d, u_max, u_min, strategy));
  }
  /// Refuses what is invalid, and keeps the old gains.
  bool set_gains(Gains gains) {
    std::string why;
    if (!gains.validate(why)) return false;
    AntiWindupStrategy& s = gains.antiwindup_strat_;
    if (s.type == AntiWindupStrategy::BACK_CALCULATION && is_zero(s.tracking_time_constant)) {
      if (!is_zero(gains.d_gain_))
        s.tracking_time_constant = std::sqrt(gains.d_gain_ / gains.i_gain_);
      else
        s.tracking_time_constant = gains.p_gain_ / gains.i_gain_;
    }
    box_.set(gains);
    return true;
  }

  /// `error` is desired minus measured; `dt` in s. 0 repeats the last command; below 0 throws.
  double compute_command(double error, const double& dt) {
    if (is_zero(dt)) return cmd_;
    if (dt < 0) throw std::invalid_argument("a PID is called with a negative period");
    if (!std::isfinite(error)) return cmd_ = std::numeric_limits<double>::quiet_NaN();
    const double slope = (error - p_error_last_) / dt;
    p_error_last_ = error;
    return compute_command(error, slope, dt);
  }
  double compute_command(double error, double slope, const double& dt) {
    if (is_zero(dt)) return cmd_;
    if (dt < 0) throw std::invalid_argument("a PID is called with a negative period");
    if (const auto fresh = box_.try_get()) gains_ = *fresh;
    p_error_ = error, d_error_ = slope;
    if (!std::isfinite(error) || !std::isfinite(slope))
      return cmd_ = std::numeric_limits<double>::quiet_NaN();
    const double free = gains_.p_gain_ * error + i_term_ + gains_.d_gain_ * slope;
    cmd_ = std::clamp(free, gains_.u_min_, gains_.u_max_);
    integrate(error, free, dt);
    return cmd_;
  }
  double compute_command(double error, const rclcpp::Duration& dt) {
    return compute_command(error, dt.seconds());
  }
  double compute_command(double error, double slope, const rclcpp::Duration& dt) {
    return compute_command(error, slope, dt.seconds());
  }
  double compute_command(double error, const std::int64_t& dt_ns) {
    return compute_command(error, static_cast<double>(dt_ns) * 1e-9);
  }
  double compute_command(double error, double slope, const std::int64_t& dt_ns) {
    return compute_command(error, slope, static_cast<double>(dt_ns) * 1e-9);
  }
  double compute_command(double error, const std::chrono::nanoseconds& dt) {
    return compute_command(error, dt.count());
  }
  double compute_command(double error, double slope, const std::chrono::nanoseconds& dt) {
    return compute_command(error, slope, dt.count());
  }
  void set_current_cmd(double value) { cmd_ = value; }
  double get_current_cmd() { return cmd_; }
  void get_current_pid_errors(double& p, double& i, double& d) {
    p = p_error_, i = i_term_, d = d_error_;
  }

  // Humble
  void initPid(double p, double i, double d, double i_max, double i_min, bool antiwindup = false) {
    setGains(p, i, d, i_max, i_min, antiwindup);
    reset();
  }
  void setGains(double p, double i, double d, double i_max, double i_min, bool antiwindup = false) {
    box_.set(Gains(p, i, d, i_max, i_min, antiwindup));
  }
  void setGains(const Gains& gains) { box_.set(gains); }
  Gains getGains() { return get_gains(); }
  double computeCommand(double error, std::uint64_t dt_ns) {
    if (dt_ns == 0 || !std::isfinite(error)) return 0;
    const double slope = (error - p_error_last_) / (static_cast<double>(dt_ns) * 1e-9);
    p_error_last_ = error;
    return computeCommand(error, slope, dt_ns);
  }
  double computeCommand(double error, double slope, std::uint64_t dt_ns) {
    if (const auto fresh = box_.try_get()) gains_ = *fresh;
    if (dt_ns == 0 || !std::isfinite(error) || !std::isfinite(slope)) return 0;
    p_error_ = error, d_error_ = slope;
    i_error_ += static_cast<double>(dt_ns) * 1e-9 * error;
    if (gains_.antiwindup_ && gains_.i_gain_ != 0) {
      const double a = gains_.i_min_ / gains_.i_gain_, b = gains_.i_max_ / gains_.i_gain_;
      i_error_ = std::clamp(i_error_, std::min(a, b), std::max(a, b));
    }
    i_term_ = gains_.i_gain_ * i_error_;
    if (!gains_.antiwindup_)
      i_term_ = std::clamp(i_term_, std::min(gains_.i_min_, gains_.i_max_),
                           std::max(gains_.i_min_, gains_.i_max_));
    return cmd_ = gains_.p_gain_ * error + i_term_ + gains_.d_gain_ * slope;
  }
  void setCurrentCmd(double value) { cmd_ = value; }
  double getCurrentCmd() { return cmd_; }

 private:
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();

  /// The current error counts from the next command on.
  void integrate(double error, double free, double dt) {
    const AntiWindupStrategy& s = gains_.antiwindup_strat_;
    const double step = dt * gains_.i_gain_ * error;
    if (!is_zero(error, s.error_deadband)) {
      if (s == AntiWindupStrategy::BACK_CALCULATION) {
        if (!is_zero(gains_.i_gain_)) i_term_ += step + dt / s.tracking_time_constant * (cmd_ - free);
      } else if (s == AntiWindupStrategy::CONDITIONAL_INTEGRATION) {
        if (is_zero(free - cmd_) || error * free <= 0) i_term_ += step;
      } else {
        i_term_ += step;
      }
    }
    i_term_ = std::clamp(i_term_, s.i_min, s.i_max);
  }
  Gains gains_;
  realtime_tools::RealtimeThreadSafeBox<Gains> box_;
  double p_error_last_ = 0, p_error_ = 0, d_error_ = 0, i_term_ = 0, i_error_ = 0, cmd_ = 0;
};

}  // namespace control_toolbox
