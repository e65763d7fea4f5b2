#pragma once
/// Joint torques that the masses of a robot, its tool and its load require along a planned path. kg, m, N m
/// (N for sliding joints).
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

/// The load of an arm: tool and workpiece together.
struct Payload {
  double mass = 0;  ///< kg
  Vec3 center;      ///< centre of gravity in tool0, m
  bool operator==(const Payload&) const = default;
};
/// The sum of two loads.
Payload joined(const Payload& a, const Payload& b);

/// The dynamics of a robot with a point mass at its tool link. Throws as kinematics::Tree does.
kinematics::Dynamics loaded_dynamics(const description::RobotModel& model, const Pose& T_world_base,
                                     const Payload& payload);

/// Checks joint torques against effort limits, by inverse dynamics of rigid bodies: no friction, no inertia
/// of motors and gears. Const after construction: any thread; judge() allocates.
class TorqueLimits {
 public:
  /// `effort`: N m (N for sliding joints), in the order of RobotModel::actuated; infinite or 0: unknown.
  /// `payload` is a point mass at the tool link. A joint whose limit does not hold the bare robot in all of
  /// 256 random states within its ranges has inconsistent data, and is ignored. Throws as kinematics::Tree
  /// does, and Error("bad-model") for joints with more than one value.
  TorqueLimits(const description::RobotModel& model, const Pose& T_world_base, const Payload& payload,
               std::vector<double> effort);
  const Payload& payload() const noexcept { return payload_; }

  /// The torque of a joint at a place of a path.
  struct Load {
    std::size_t joint = 0;
    double torque = 0, limit = 0;  ///< N m or N
    double time = 0;               ///< s of the path
  };
  struct Judgement {
    /// The factor for the joint accelerations that keeps all torques within the limits, without the torques
    /// that depend on speed only; 1: they are within the limits.
    double acceleration = 1;
    /// A factor for the duration that certainly keeps them.
    double slower = 1;
    std::optional<Load> most;       ///< the torque with the largest excess over its limit
    std::optional<Load> too_heavy;  ///< a load that a joint cannot even hold at rest
  };
  /// Checks a place at least every 4 ms, and at least 200 places.
  Judgement judge(const timing::TimedPath& path) const;

 private:
  void leave_out_what_holds_not_itself(const description::RobotModel& model);

  Payload payload_;
  std::vector<double> effort_;
  kinematics::Dynamics loaded_, bare_;
};

/// TorqueLimits if there is enough data, else null: if there are no effort limits, or if the catalogue has
/// estimated the limits and the load does not exceed the rated load that the estimate assumes.
std::shared_ptr<const TorqueLimits> torque_limits_of(const description::RobotModel& model,
                                                     const Pose& T_world_base, const Payload& payload,
                                                     std::vector<double> effort);

}  // namespace polyarm::moves
