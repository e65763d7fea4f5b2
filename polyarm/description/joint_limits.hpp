#pragma once
/// The limits that hold for a joint when several files state some: URDF, `<ros2_control>`, joint_limits.yaml.
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "polyarm/description/robot_model.hpp"

namespace polyarm::description {

/// Limits of one joint, SI (rad or m, N m or N). Empty means that nobody states it.
struct JointLimitSet {
  std::optional<double> lower, upper;
  std::optional<double> velocity, effort, acceleration, deceleration, jerk;  ///< above zero, both directions
  std::optional<SoftLimits> soft;                                            ///< within lower and upper
  /// Somebody says that this is not limited: not even what would be assumed otherwise.
  struct Disabled {
    bool position = false, velocity = false, effort = false, acceleration = false, deceleration = false,
         jerk = false, soft = false;
    bool operator==(const Disabled&) const = default;
  } disabled;
  std::optional<bool> angle_wraparound;
};

/// For each joint of the model (same indices) the tighter of URDF `<limit>` and the min and max of the
/// command interfaces in `<ros2_control>`: position directly; velocity and effort min(|min|, max);
/// acceleration's max, deceleration |acceleration's min| (where one is missing it is the other); jerk's max.
/// What stands under
/// `<limits enable="false">` is disabled; at a component that is everything of its joint. Soft limits are
/// clipped to the hard ones. Ranges that do not meet are an error, limits of zero a warning and passed over.
std::vector<JointLimitSet> merge_limits(const RobotModel& model, Problems& problems);

/// A joint_limits.yaml of ROS 1, MoveIt or ROS 2, by joint. `disabled` is what says `has_…_limits: false`.
struct JointLimitsFile {
  struct Entry {
    JointLimitSet limits;
    Location where;
  };
  std::map<std::string, Entry> joints;
  std::optional<double> velocity_scaling, acceleration_scaling;  ///< MoveIt's defaults, 0 to 1
};

/// Reads the map `joint_limits`, at the top or below name spaces, `/**` and `ros__parameters`. A `max_…`
/// counts only beside its `has_…_limits: true`; one that is off never limits, whatever its number. Angles may
/// carry the tag `!degrees`. Unknown keys and wrong types are errors, numbers without effect warnings. Throws
/// Error for what is no YAML or has no `joint_limits`.
JointLimitsFile read_joint_limits(std::string_view text, const std::string& file, Problems& problems);

/// What the file says, limits and their absence, replaces what was there; soft limits are clipped again.
/// Joints that the model does not have are warnings with the nearest name.
void override_limits(const JointLimitsFile& file, const RobotModel& model, std::vector<JointLimitSet>& limits,
                     Problems& problems);

/// Writes the limits into the joints of the model, so that planning keeps them too. Position limits of
/// continuous joints are kept out: they stay continuous.
void take_over(const std::vector<JointLimitSet>& limits, RobotModel& model);

}  // namespace polyarm::description
