#pragma once
/// The limits of joints from all the places where users of ROS write them: the description's <limit>, the min
/// and max of its <ros2_control>, and joint_limits.yaml. The tighter one holds.
#include <vector>

#include "polyarm/controllers/controller.hpp"
#include "polyarm/description/robot_model.hpp"
#include "polyarm/ros_files/parameter_file.hpp"

namespace polyarm::ros_files {

/// Narrows the limits of a joint by the min and max of its command interfaces in <ros2_control>. Ranges that
/// leave no position are an error with the line of the interface.
void narrow_by_hardware(const description::RobotModel& model, const std::string& joint,
                        controllers::JointFacts& facts, Problems& problems);

/// Narrows (and where `has_*_limits` says false, leaves alone) the limits of the joints by a `joint_limits:`
/// map. Joints are named with or without their robot. What is wrong becomes a problem with its place.
void narrow_by_file(const JointLimitsSource& source, std::vector<controllers::JointFacts*>& joints,
                    Problems& problems);

}  // namespace polyarm::ros_files
