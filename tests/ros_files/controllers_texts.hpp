#pragma once
/// Controllers files as texts, and what is read from them.
#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

#include "polyarm/base/text.hpp"
#include "polyarm/ros_files/controllers_file.hpp"

namespace polyarm::ros_files::controllers_texts {

struct Read {
  ControllersFile file;
  Problems problems;
};

inline Read read(const std::string& text) {
  Read out;
  out.file = read_controllers({{"c.yaml", "", text}}, out.problems);
  return out;
}

inline std::string all(const Problems& problems) {
  std::string out;
  for (const Problem& problem : problems.list()) out += problem.text() + "\n";
  return out;
}

/// The one finding of a text, and that there is no other.
inline Problem only(const std::string& text) {
  const Read got = read(text);
  EXPECT_EQ(got.problems.list().size(), 1u) << all(got.problems);
  return got.problems.list().empty() ? Problem{} : got.problems.list().front();
}

inline std::string thrown(const std::string& text) {
  try {
    read(text);
  } catch (const Error& error) {
    return error.what();
  }
  return "nothing";
}

inline const ControllerEntry& find(const ControllersFile& file, const std::string& full_name) {
  for (const ControllerEntry& entry : file.controllers)
    if (entry.full_name() == full_name) return entry;
  throw std::runtime_error("no controller " + full_name);
}

inline std::string text_of(const ControllerEntry& entry, const std::string& key) {
  return join(entry.parameters.list(key), ",");
}

constexpr const char* kHumble = R"(controller_manager:
  ros__parameters:
    update_rate: 250  # Hz

    joint_state_broadcaster:
      type: joint_state_broadcaster/JointStateBroadcaster

    arm_controller:
      type: joint_trajectory_controller/JointTrajectoryController

arm_controller:
  ros__parameters:
    joints:
      - shoulder
      - elbow
    command_interfaces: [position]
    state_interfaces: [position, velocity]
    constraints:
      stopped_velocity_tolerance: 0.01
      shoulder: {trajectory: 0.2, goal: 0.1}
      elbow.goal: 0.05
)";

// The values are those of the page "ros_control" that prints them line by line: the controllers of MyRobot
// with `pid: {p: 100.0, i: 10.0, d: 1.0}`, publish_rate 50 and the limits below.
constexpr const char* kMyRobot = R"(MyRobot:
  # Publish all joint states
  joint_state_controller:
    type: joint_state_controller/JointStateController
    publish_rate: 50
  JointA_EffortController:
    type: effort_controllers/JointEffortController
    joint: JointA # Name of the joint for which this controller belongs to.
    pid: {p: 100.0, i: 10.0, d: 1.0} # PIDvalues
  JointB_EffortController:
    type: effort_controllers/JointEffortController
    joint: JointB
    pid: {p: 100.0, i: 10.0, d: 1.0}
  JointC_PositionController:
    type: position_controllers/JointPositionController
    joint: JointC
)";

}  // namespace polyarm::ros_files::controllers_texts
