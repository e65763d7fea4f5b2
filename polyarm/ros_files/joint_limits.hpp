#pragma once
/// Joint limits from all places where ROS users write them: <limit> in the description, min and max in its
/// <ros2_control>, and joint_limits.yaml. The tightest limit applies.
#include <vector>

#include "polyarm/controllers/controller.hpp"
#include "polyarm/description/robot_model.hpp"
#include "polyarm/ros_files/parameter_file.hpp"

namespace polyarm::ros_files {

/// Narrows the limits of a joint by min and max of its command interfaces in <ros2_control>. If no position
/// is left, reports an error with the line of the interface.
void narrow_by_hardware(const description::RobotModel& model, const std::string& joint,
                        controllers::JointFacts& facts, Problems& problems);

/// Narrows the limits of the joints by a `joint_limits:` map. A limit whose `has_*_limits` is false is not
/// changed. Joint names may include the robot's name. Mistakes are reported with their location.
void narrow_by_file(const JointLimitsSource& source, std::vector<controllers::JointFacts*>& joints,
                    Problems& problems);

}  // namespace polyarm::ros_files
