#pragma once
/// A PID whose gains are parameters of a node, and change with them. Its state is not published.
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "control_msgs/msg/pid_state.hpp"
#include "control_toolbox/pid.hpp"
#include "rclcpp/node.hpp"
#include "rclcpp_lifecycle/lifecycle_node.hpp"
#include "realtime_tools/realtime_publisher.hpp"

namespace control_toolbox {

class PidROS {
  using Core = std::shared_ptr<rclcpp::node_interfaces::NodeCore>;

 public:
  template <class Node, typename... Rest>
  explicit PidROS(const std::shared_ptr<Node>& node, const std::string& prefix = "", Rest...)
      : PidROS(node->get_node_base_interface(), node->get_node_logging_interface(),
               node->get_node_parameters_interface(), node->get_node_topics_interface(), prefix) {}
  template <typename... Rest>
  PidROS(const Core& core, const Core&, const Core&, const Core&, std::string prefix, Rest...)
      : core_(core), prefix_(std::move(prefix)) {
    if (!prefix_.empty() && prefix_.back() != '.') prefix_ += '.';
  }

  bool initialize_from_args(double p, double i, double d, double u_max, double u_min,
                            const AntiWindupStrategy& strategy, bool save_i_term) {
    save_i_term_ = save_i_term;
    return pid_.initialize(p, i, d, u_max, u_min, strategy);
  }
  /// False if p, i or d is not there, or a value is invalid.
  bool initialize_from_ros_parameters() {
    Pid::Gains gains;
    if (!read(gains)) return false;
    save_i_term_ = parameter("save_i_term", false);
    follow();
    return pid_.initialize(gains.p_gain_, gains.i_gain_, gains.d_gain_, gains.u_max_, gains.u_min_,
                           gains.antiwindup_strat_);
  }
  void reset() { pid_.reset(save_i_term_); }
  void reset(bool save_i_term) { pid_.reset(save_i_term); }
  double compute_command(double error, const rclcpp::Duration& dt) { return pid_.compute_command(error, dt); }
  double compute_command(double error, double slope, const rclcpp::Duration& dt) {
    return pid_.compute_command(error, slope, dt);
  }
  Pid::Gains get_gains() { return pid_.get_gains(); }
  bool set_gains(const Pid::Gains& gains) { return pid_.set_gains(gains); }
  bool set_gains(double p, double i, double d, double u_max, double u_min, const AntiWindupStrategy& s) {
    return pid_.set_gains(p, i, d, u_max, u_min, s);
  }
  void set_current_cmd(double value) { pid_.set_current_cmd(value); }
  double get_current_cmd() { return pid_.get_current_cmd(); }
  void get_current_pid_errors(double& p, double& i, double& d) { pid_.get_current_pid_errors(p, i, d); }
  void print_values() {}

  // Humble
  bool initPid() {
    legacy_ = true;
    double p, i, d;
    if (!number("p", p) || !number("i", i) || !number("d", d)) return false;
    pid_.initPid(p, i, d, parameter("i_clamp_max", 0.0), parameter("i_clamp_min", 0.0),
                 parameter("antiwindup", false));
    follow();
    return true;
  }
  void initPid(double p, double i, double d, double i_max, double i_min, bool antiwindup) {
    pid_.initPid(p, i, d, i_max, i_min, antiwindup);
  }
  double computeCommand(double error, rclcpp::Duration dt) {
    return pid_.computeCommand(error, static_cast<std::uint64_t>(dt.nanoseconds()));
  }
  double computeCommand(double error, double slope, rclcpp::Duration dt) {
    return pid_.computeCommand(error, slope, static_cast<std::uint64_t>(dt.nanoseconds()));
  }
  Pid::Gains getGains() { return pid_.get_gains(); }
  void setGains(double p, double i, double d, double i_max, double i_min, bool antiwindup = false) {
    pid_.setGains(p, i, d, i_max, i_min, antiwindup);
  }

 private:
  bool number(const char* name, double& out) {
    const std::string whole = prefix_ + name;
    if (!core_->has_parameter(whole)) {
      if (!core_->is_overridden(whole)) return false;
      core_->declare_parameter(whole, rclcpp::ParameterValue(0.0));
    }
    out = core_->get_parameter(whole).get_value<double>();
    return true;
  }
  template <typename T>
  T parameter(const char* name, const T& otherwise) {
    const std::string whole = prefix_ + name;
    if (!core_->has_parameter(whole)) core_->declare_parameter(whole, rclcpp::ParameterValue(otherwise));
    return core_->get_parameter(whole).get_value<T>();
  }
  bool read(Pid::Gains& gains) {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    if (!number("p", gains.p_gain_) || !number("i", gains.i_gain_) || !number("d", gains.d_gain_))
      return false;
    gains.u_max_ = parameter("u_clamp_max", kInfinity);
    gains.u_min_ = parameter("u_clamp_min", -kInfinity);
    if (!parameter("saturation", std::isfinite(gains.u_max_) || std::isfinite(gains.u_min_)))
      gains.u_max_ = kInfinity, gains.u_min_ = -kInfinity;
    AntiWindupStrategy& s = gains.antiwindup_strat_;
    try {
      s.set_type(parameter("antiwindup_strategy", std::string("none")));
    } catch (const std::invalid_argument&) {
      return false;
    }
    s.i_max = parameter("i_clamp_max", kInfinity), s.i_min = parameter("i_clamp_min", -kInfinity);
    s.tracking_time_constant = parameter("tracking_time_constant", 0.0);
    s.error_deadband = parameter("error_deadband", s.error_deadband);
    std::string why;
    return gains.validate(why);
  }
  /// Gains follow changes of the parameters.
  void follow() {
    changed_ = core_->add_post_set_parameters_callback([this](const std::vector<rclcpp::Parameter>&) {
      Pid::Gains gains;
      if (legacy_)
        pid_.setGains(parameter("p", 0.0), parameter("i", 0.0), parameter("d", 0.0),
                      parameter("i_clamp_max", 0.0), parameter("i_clamp_min", 0.0),
                      parameter("antiwindup", false));
      else if (read(gains))
        pid_.set_gains(gains);
    });
  }
  Core core_;
  std::string prefix_;
  bool save_i_term_ = false, legacy_ = false;
  Pid pid_;
  rclcpp::node_interfaces::PostSetParametersCallbackHandle::SharedPtr changed_;
};

}  // namespace control_toolbox
