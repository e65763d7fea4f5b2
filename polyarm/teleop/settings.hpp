#pragma once
/// How one robot leads another: the settings of one pair of a cell.
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/base/pose.hpp"

namespace polyarm::teleop {

enum class Mapping : std::uint8_t {
  joints,  ///< each joint of the follower follows a joint of the leader
  tcp      ///< the follower's TCP repeats the motion of the leader's TCP
};

/// What a person holds while the follower may move.
enum class Clutch : std::uint8_t {
  key,     ///< a client that repeats a request
  tag,     ///< a tag or variable of the cell, for example of a pedal
  gripper  ///< a joint of the leader: its hand is closed
};

/// follower = scale · leader + offset; rad or m.
struct JointPair {
  std::string leader, follower;
  double scale = 1, offset = 0;
};

/// A joint of the leader between two ends. `closed` may be above or below `open`.
struct HandRange {
  std::string joint;
  double closed = 0, open = 1;  ///< rad or m
  /// 0: closed, 1: open; beyond the ends less than 0 or more than 1.
  double opening(double q) const noexcept { return (q - closed) / (open - closed); }
};

/// The gripper of the follower: a tag. A flag is true while the hand is closed; a number is 0 to 1 (open).
struct GripperLink {
  HandRange hand;
  std::string tag;
};

struct PairSettings {
  std::string name, leader, follower;  ///< robots by their names in the cell
  Mapping mapping = Mapping::joints;
  // joints
  std::vector<JointPair> joints;  ///< empty: by name, and if no name fits in order
  bool relative = false;          ///< true: from the pose at the clutch; false: approaches the leader's pose
  double approach = 0.1;          ///< share of the speed of that approach, (0, 1]
  // tcp
  double scale = 1;         ///< of translations
  bool orientation = true;  ///< false: the follower keeps its orientation
  Quaternion turn;          ///< maps directions in the leader's base into the follower's base

  double speed = 1;  ///< share of the follower's limits, (0, 1]
  Clutch clutch = Clutch::key;
  std::string tag;                  ///< of Clutch::tag
  HandRange hand;                   ///< of Clutch::gripper
  std::optional<GripperLink> grip;  ///< what closes and opens the follower's gripper
  Location where;
};

}  // namespace polyarm::teleop
