#pragma once
/// A cell in lock-step whose controllers share a joint, as the tests of its requests need it.
#include <gtest/gtest.h>

#include <string>

#include "polyarm/inside/requests.hpp"
#include "tests/support/lock_step_cell.hpp"

namespace polyarm::test {

inline constexpr const char* kSharedJoint = R"(
controller_manager:
  ros__parameters:
    update_rate: 1000
    follow: {type: joint_trajectory_controller/JointTrajectoryController}
    tail: {type: forward_command_controller/ForwardCommandController}
    tail_too: {type: forward_command_controller/ForwardCommandController}
    joint_state_broadcaster: {type: joint_state_broadcaster/JointStateBroadcaster}
follow:
  ros__parameters:
    joints: [joint_1, joint_2]
    command_interfaces: [position]
    state_interfaces: [position, velocity]
tail:
  ros__parameters:
    joints: [joint_5, joint_6]
    interface_name: position
tail_too:
  ros__parameters:
    joints: [joint_6]
    interface_name: position
)";

inline std::string error_of(const Json& answer) {
  return answer.contains("error") ? answer["error"].value("code", "") : "none";
}
inline std::string what_of(const Json& answer) {
  return answer.contains("error") ? answer["error"].value("what", "") : answer.dump();
}

class RequestsTest : public ::testing::Test {
 protected:
  LockStepCell cell{kSharedJoint};
};

}  // namespace polyarm::test
