#pragma once
/// Kinematics of a robot's whole tree with a fixed, planar or floating root: joint states, poses of links,
/// Jacobians. For a single arm use Chain (base to tool, one value for each joint); it is faster. SI units:
/// metres, radians; poses in the world frame.
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

/// The joint between world and root link, in addition to the joints of the model.
enum class RootJoint { fixed, planar, floating };

struct TreeOptions {
  RootJoint root = RootJoint::fixed;
  Pose T_world_base;          ///< of the root link; for a free root, its pose at zero
  Vec3 gravity{0, 0, -9.81};  ///< m/s^2, in the world
};

/// The part of a joint in a state: `positions` values from q[position] and `velocities` values from
/// v[velocity]. revolute, continuous, prismatic: one of each. planar: x and y in the plane and the angle
/// about its normal (in the joint's axes, turned so that z is the normal), and their rates. floating: q has x
/// y z and the quaternion x y z w; v has the linear velocity in the joint's axes and the angular velocity in
/// the child's axes.
struct TreeJoint {
  std::string name;
  description::JointType type = description::JointType::fixed;
  std::size_t position = 0, velocity = 0, positions = 1, velocities = 1;
};

/// Thread: const and without hidden state, so any thread. Only the constructor, neutral() and
/// massless_joints() allocate or throw. Precondition: spans have the sizes stated.
class Tree {
 public:
  /// Throws Error("bad-model") if joints or mimic joints form a cycle, if a mimic joint is or follows a
  /// planar or floating joint, or if a number is not finite.
  explicit Tree(const description::RobotModel& model, const TreeOptions& options = {});

  /// Sizes of q and v. They differ by one for each floating joint.
  std::size_t positions() const noexcept { return model_.positions; }
  std::size_t velocities() const noexcept { return model_.velocities; }
  std::size_t links() const noexcept { return links_.size(); }
  /// The root's joint (named "root") comes first if it is free, then RobotModel::actuated in order.
  const std::vector<TreeJoint>& joints() const noexcept { return joints_; }

  /// All values zero, quaternions at identity.
  std::vector<double> neutral() const;
  /// Advances q by v * dt, in place (floating joints by the exponential map).
  void integrate(std::span<double> q, std::span<const double> v, double dt) const noexcept;

  /// The pose of every link, in the order of RobotModel::links.
  void link_poses(std::span<const double> q, std::span<Pose> out) const noexcept;
  Pose link_pose(std::span<const double> q, std::size_t link) const noexcept;
  /// The velocity of a point that is fixed to `link` (given in the link's frame): 6 rows by velocities()
  /// columns, row-major. body: in the link's axes. Returns the pose of the link.
  Pose jacobian(std::span<const double> q, std::size_t link, const Vec3& point, std::span<double> J,
                JacobianFrame frame = JacobianFrame::local_world_aligned) const noexcept;
  /// Total mass of all moving bodies, kg.
  double mass() const noexcept;
  /// Names of joints that move no mass: a torque gives them no definite acceleration. Allocates.
  std::vector<std::string> massless_joints() const;
  /// J, zero at the world's origin.
  double potential_energy(std::span<const double> q) const noexcept;

  /// For the kernels; valid while a copy of this tree exists.
  const TreeModel& model() const noexcept { return model_; }
  const Vec3& gravity() const noexcept { return gravity_; }

 private:
  struct Link {
    int step = -1;   ///< the step that carries the link; -1: the world
    Pose from_step;  ///< pose of the link from the step's origin, in the reference axes
  };
  friend class TreeBuilder;
  Pose step_pose(std::span<const double> q, int step) const noexcept;

  std::vector<TreeJoint> joints_;
  std::vector<Link> links_;
  std::shared_ptr<const std::vector<TreeStep>> steps_;  ///< data that model_ points to; shared by copies
  TreeModel model_;
  Pose T_world_reference_;
  Vec3 gravity_;
};

}  // namespace polyarm::kinematics
