#pragma once
/// `polyarm calibrate read`: the geometry of an arm as its own controller states it.
#include <string>

#include "polyarm/description/arm_calibration.hpp"
#include "polyarm/description/robot_model.hpp"

namespace polyarm::apps {

struct ReadOptions {
  std::string host;
  int port = 30001;
  double timeout = 5;  ///< s
};

/// Asks the controller of a robot of Universal Robots. Nothing moves. Prints how far the arm is from its
/// description.
description::ArmCalibration read_arm(const description::RobotModel& robot, const ReadOptions& options);

}  // namespace polyarm::apps
