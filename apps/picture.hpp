#pragma once
/// Pictures of robots, drawn from their capsules: no GPU, no browser, a few kilobytes.
#include <span>
#include <string>

#include "polyarm/description/robot_model.hpp"

namespace polyarm::apps {

/// The robot in joint state `q` as SVG: seen from its front and right, from above, without perspective, on a
/// floor with a grid and a scale bar. Hidden surfaces by drawing what is behind first. Links without capsules
/// are drawn as the capsule nearest to their shape; robots without any shape as derived from the chain. The
/// same robot gives the same text. Throws Error as kinematics::Chain.
std::string picture_of(const description::RobotModel& model, std::span<const double> q);

}  // namespace polyarm::apps
