#pragma once
/// The parameters of a PID, as ros2_control and ros_control write them.
#include <limits>
#include <string>
#include <vector>

#include "polyarm/controllers/parameters.hpp"
#include "polyarm/controllers/pid.hpp"

namespace polyarm::controllers {

/// Declares and reads `<prefix>.p`, `.i`, `.d`, clamps, anti-windup, time constant and deadband into `gains`,
/// which must stay where it is: the numbers can be changed while the controller runs. What cannot be becomes
/// a problem of the parameters.
void read_pid_gains(Parameters& parameters, const std::string& prefix, PidGains& gains);

/// Gains in ros_control's form as parameters; a clamp of one side that is NaN is not stated.
struct RosControlParameters {
  double p = 0, i = 0, d = 0, i_clamp = 0;
  double i_clamp_min = std::numeric_limits<double>::quiet_NaN();
  double i_clamp_max = std::numeric_limits<double>::quiet_NaN();
  bool antiwindup = false;
  double u_min = -std::numeric_limits<double>::infinity(), u_max = std::numeric_limits<double>::infinity();
  /// The same controller here. Control thread too.
  PidGains gains() const noexcept;
};

/// Declares and reads `<prefix>.p`, which must be there, `.i`, `.d`, `.i_clamp` …, as ros_control's files
/// write them, and `.u_clamp_max`, `.u_clamp_min`. `gains` must stay where it is. An integral gain without a
/// clamp, which has no effect, becomes a warning.
void read_ros_control_gains(Parameters& parameters, const std::string& prefix, RosControlParameters& gains);

/// Why these changes cannot be, when they belong to one of `gains`; empty when they can.
std::string refuse_pid_changes(const std::vector<ParameterChange>& changes,
                               const std::vector<PidGains>& gains);
std::string refuse_pid_changes(const std::vector<ParameterChange>& changes,
                               const std::vector<RosControlParameters>& gains);

}  // namespace polyarm::controllers
