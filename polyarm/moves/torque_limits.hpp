#pragma once
/// What the masses of a robot, its tool and its load ask of the joints along a planned path.
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "polyarm/base/pose.hpp"
#include "polyarm/description/robot_model.hpp"
#include "polyarm/kinematics/dynamics.hpp"
#include "polyarm/timing/timed_path.hpp"

namespace polyarm::moves {

/// What an arm carries, tool and load together.
struct Payload {
  double mass = 0;  ///< kg
  Vec3 center;      ///< centre of gravity in tool0, m
  bool operator==(const Payload&) const = default;
};
/// Both together.
Payload joined(const Payload& a, const Payload& b);

/// Joint torques within effort limits, by inverse dynamics of rigid bodies: no friction, no inertia of motors
/// and gears. Const after construction: any thread; judge() allocates.
class TorqueLimits {
 public:
  /// `effort`: N m (N where a joint slides), in the order of RobotModel::actuated; infinite or 0: none is
  /// known. `payload` is fixed to the tool link, as a point. A joint whose limit does not hold the bare robot
  /// everywhere (256 random places within its ranges) has facts that do not go together, and is left out.
  /// Throws what kinematics::Tree throws, and Error("bad-model") for joints of more than one value.
  TorqueLimits(const description::RobotModel& model, const Pose& T_world_base, const Payload& payload,
               std::vector<double> effort);
  const Payload& payload() const noexcept { return payload_; }

  /// Of a joint at a place of a path.
  struct Load {
    std::size_t joint = 0;
    double torque = 0, limit = 0;  ///< N m or N
    double time = 0;               ///< s of the path
  };
  struct Judgement {
    /// Joint accelerations that are this share of the path's keep all torques within the limits, as far as
    /// speed does not ask for them; 1: they do already.
    double acceleration = 1;
    /// The path passed this much slower (a factor of its duration) certainly keeps them.
    double slower = 1;
    std::optional<Load> most;       ///< the torque furthest beyond its limit
    std::optional<Load> too_heavy;  ///< a load that cannot even be held still
  };
  /// Looks at least every 4 ms, and at 200 places.
  Judgement judge(const timing::TimedPath& path) const;

 private:
  void leave_out_what_holds_not_itself(const description::RobotModel& model);

  Payload payload_;
  std::vector<double> effort_;
  kinematics::Dynamics loaded_, bare_;
};

/// TorqueLimits where something is known to judge by, else null: no effort limits, or limits that the
/// catalogue has estimated and nothing carried beyond what that estimate was made for, the rated load.
std::shared_ptr<const TorqueLimits> torque_limits_of(const description::RobotModel& model,
                                                     const Pose& T_world_base, const Payload& payload,
                                                     std::vector<double> effort);

}  // namespace polyarm::moves
