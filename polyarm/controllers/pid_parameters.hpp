#pragma once
/// The parameters of a PID, as ros2_control and ros_control write them.
#include <string>
#include <vector>

#include "polyarm/controllers/parameters.hpp"
#include "polyarm/controllers/pid.hpp"

namespace polyarm::controllers {

/// Declares and reads `<prefix>.p`, `.i`, `.d`, clamps, anti-windup, time constant and deadband into `gains`,
/// which must stay where it is: the numbers can be changed while the controller runs. What cannot be becomes
/// a problem of the parameters.
void read_pid_gains(Parameters& parameters, const std::string& prefix, PidGains& gains);

/// Why these changes cannot be, when they belong to one of `gains`; empty when they can.
std::string refuse_pid_changes(const std::vector<ParameterChange>& changes,
                               const std::vector<PidGains>& gains);

}  // namespace polyarm::controllers
