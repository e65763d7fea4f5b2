#pragma once
/// Constraints of MoveIt: whether a joint state keeps them, and joint states that do. Metres, radians. Any
/// thread; allocates.
#include <string>
#include <vector>

#include "polyarm/move_group/scene.hpp"
#include "polyarm/planning/planner.hpp"

namespace polyarm::move_group {

/// Bounds of one request's constraint lists.
inline constexpr std::size_t kMostConstraints = 200, kMostAlternatives = 50;

/// One Constraints message, with names and frames resolved.
class Goal {
 public:
  /// Throws Refusal: unknown joints, links and frames, numbers that are not finite, and visibility
  /// constraints.
  Goal(const Around& around, const msg::Constraints& message);

  bool empty() const { return joints_.empty() && positions_.empty() && orientations_.empty(); }
  bool has_poses() const { return !positions_.empty() || !orientations_.empty(); }
  /// What a joint state violates, as a sentence; empty if it keeps everything.
  std::string violated(std::span<const double> q) const;
  /// One result for each joint, position and orientation constraint.
  std::vector<msg::ConstraintEvalResult> evaluate(std::span<const double> q) const;
  /// Narrows limits to the joint constraints.
  void narrow(std::vector<double>& lower, std::vector<double>& upper) const;

  /// Joint states of the group within limits that keep the constraints, best first; other joints stay as in
  /// `start`. `wide`: also away from the middle of tolerances and regions, which takes longer. Throws
  /// Refusal(NO_IK_SOLUTION | INVALID_GOAL_CONSTRAINTS) with the reason if there are none and `wide` is set.
  std::vector<planning::JointState> states(const Group& group, std::span<const double> start,
                                           bool wide) const;

 private:
  struct JointBound {
    std::size_t variable;
    double value, low, high;
  };
  struct Solid {
    std::uint8_t type;
    double a, b, c;  ///< half of a box; radius; radius and half of a height
    Pose pose;       ///< in the world
    bool contains(const Vec3& point) const;
    double least() const;  ///< the radius of a ball inside
  };
  struct PositionBound {
    int link;
    Vec3 offset;  ///< in the link
    std::vector<Solid> region;
  };
  struct OrientationBound {
    int link;
    Quaternion target;  ///< of the link in the world
    Vec3 tolerance;
    bool rotation_vector;
    Vec3 error(const Quaternion& rotation) const;
  };
  void add(const msg::JointConstraint& message);
  void add(const msg::PositionConstraint& message);
  void add(const msg::OrientationConstraint& message);
  int pose_link() const;
  std::string violated(const JointBound& bound, std::span<const double> q) const;
  std::string violated(const PositionBound& bound, std::span<const double> q) const;
  std::string violated(const OrientationBound& bound, std::span<const double> q) const;
  planning::JointState joint_goal(const Group& group, std::span<const double> start) const;
  std::vector<planning::JointState> pose_goals(const Group& group, std::span<const double> start,
                                               bool wide) const;

  const Around around_;
  std::vector<JointBound> joints_;
  std::vector<PositionBound> positions_;
  std::vector<OrientationBound> orientations_;
};

}  // namespace polyarm::move_group
