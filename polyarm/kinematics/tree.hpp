#pragma once
/// A robot's whole tree, with a fixed, planar or floating root: joint states, poses of links, Jacobians.
/// Chain (base to tool, one value for each joint) is the quicker way where a single arm is all there is.
/// Everything is SI: metres, radians, poses in the world.
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "polyarm/base/pose.hpp"
#include "polyarm/description/robot_model.hpp"
#include "polyarm/kinematics/screw_chain.hpp"
#include "polyarm/kinematics/tree_model.hpp"

namespace polyarm::kinematics {

class TreeBuilder;

/// How the root link is tied to the world, beside what joints the model has.
enum class RootJoint { fixed, planar, floating };

struct TreeOptions {
  RootJoint root = RootJoint::fixed;
  Pose T_world_base;          ///< of the root link; with a free root, where its joint is at zero
  Vec3 gravity{0, 0, -9.81};  ///< m/s^2, in the world
};

/// What a joint has in a state: `positions` values from q[position] and `velocities` from v[velocity].
/// revolute, continuous, prismatic: one of each. planar: x and y in the plane and the angle about its normal
/// (axes: the joint's, turned so that z is the normal), and their rates. floating: x y z and the quaternion
/// x y z w in q; the linear velocity in the joint's axes and the angular velocity in the child's in v.
struct TreeJoint {
  std::string name;
  description::JointType type = description::JointType::fixed;
  std::size_t position = 0, velocity = 0, positions = 1, velocities = 1;
};

/// Thread: const and without hidden state, so any thread. Nothing but the constructor, neutral() and
/// massless_joints() allocates or throws. Precondition: spans have the sizes stated.
class Tree {
 public:
  /// Throws Error("bad-model") for joints that form a circle or follow each other in one, mimic joints that
  /// are or follow planar or floating ones, and numbers that are not finite.
  explicit Tree(const description::RobotModel& model, const TreeOptions& options = {});

  /// How many values q and v have. They differ by one for each floating joint.
  std::size_t positions() const noexcept { return model_.positions; }
  std::size_t velocities() const noexcept { return model_.velocities; }
  std::size_t links() const noexcept { return links_.size(); }
  /// The root's joint first (named "root") where it is free, then RobotModel::actuated in order.
  const std::vector<TreeJoint>& joints() const noexcept { return joints_; }

  /// All zero, quaternions without rotation.
  std::vector<double> neutral() const;
  /// Goes on from q by v * dt (of floating joints by the exponential), in place.
  void integrate(std::span<double> q, std::span<const double> v, double dt) const noexcept;

  /// The pose of every link, in the order of RobotModel::links.
  void link_poses(std::span<const double> q, std::span<Pose> out) const noexcept;
  Pose link_pose(std::span<const double> q, std::size_t link) const noexcept;
  /// 6 rows by velocities() columns of the velocity of a point that is fixed to `link` (given in its frame),
  /// row after row. body: in the link's axes. Returns the pose of the link.
  Pose jacobian(std::span<const double> q, std::size_t link, const Vec3& point, std::span<double> J,
                JacobianFrame frame = JacobianFrame::local_world_aligned) const noexcept;
  /// kg, of all that moves.
  double mass() const noexcept;
  /// Names of joints behind which there is no mass: no torque gives them a definite acceleration. Allocates.
  std::vector<std::string> massless_joints() const;
  /// J, zero at the world's origin.
  double potential_energy(std::span<const double> q) const noexcept;

  /// For the kernels; valid as long as a copy of this tree lives.
  const TreeModel& model() const noexcept { return model_; }
  const Vec3& gravity() const noexcept { return gravity_; }

 private:
  struct Link {
    int step = -1;   ///< that carries it; -1: the world
    Pose from_step;  ///< where it stands from the step's origin in the reference axes
  };
  friend class TreeBuilder;
  Pose step_pose(std::span<const double> q, int step) const noexcept;

  std::vector<TreeJoint> joints_;
  std::vector<Link> links_;
  std::shared_ptr<const std::vector<TreeStep>> steps_;  ///< what model_ points to; shared by copies
  TreeModel model_;
  Pose T_world_reference_;
  Vec3 gravity_;
};

}  // namespace polyarm::kinematics
