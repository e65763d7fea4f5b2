#pragma once
/// One arm of a description that has several, as a robot of its own; what two such robots have in common.
/// Metres, radians. Any thread; allocates.
#include <string>
#include <vector>

#include "polyarm/description/robot_model.hpp"

namespace polyarm::description {

/// Keeps the branch through `link`: the links from the root to it, all behind it, what is fixed to these, and
/// bars that follow its joints. Everything else is left out, with its joints, named states, groups, pairs,
/// transmissions and <ros2_control> joints. An empty name has no effect. Errors: unknown-link; bad-branch if
/// the link does not move, or if a joint of the branch follows one that is left out.
void keep_branch(RobotModel& model, const std::string& link, const Location& where = {});

/// The arms of a description: where it parts into two or more chains of four or more joints.
struct Arms {
  std::vector<std::string>
      tools;  ///< for each arm the link that would carry its tool; empty: one arm or none
  std::vector<std::string> shared;  ///< joints that move all of them
};
Arms arms_of(const RobotModel& model);
/// One sentence: that a description has several arms, and how each becomes a robot. Empty if it has not.
std::string hint_of_arms(const RobotModel& model);

/// By link of `one`: true if it is fixed to the root, and `other` has the same link with the same shapes at
/// the same place (within a centimetre): both have the same body. Empty if they share no link.
std::vector<char> shared_links(const RobotModel& one, const Pose& T_world_one, const RobotModel& other,
                               const Pose& T_world_other);

}  // namespace polyarm::description
