#pragma once
/// Forward kinematics and Jacobians of one robot: poses of its links and of its tool centre point (TCP) for
/// given joint values. A Chain is built once from a model and is const afterwards. SI units: metres, radians;
/// poses in the world frame.
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "polyarm/base/pose.hpp"
#include "polyarm/description/robot_model.hpp"
#include "polyarm/kinematics/screw_chain.hpp"

namespace polyarm::kinematics {

/// The kinematics of one robot from its base to a tool centre point (TCP). A joint state `q` has one value
/// for each actuated joint of the model, in the order of RobotModel::actuated. Joints that do not lie between
/// root and tip do not move the TCP. A mimic joint follows as multiplier * q + offset.
/// Thread: const and without hidden state, so any thread. forward(), link_poses() and jacobian() allocate
/// nothing; their spans must have the sizes stated.
class Chain {
 public:
  /// The largest number of actuated joints of a model, including hands, legs and other arms.
  static constexpr std::size_t kMaxJoints = 128;
  /// The largest number of joints that move the TCP.
  static constexpr std::size_t kMostMoving = 32;

  /// `tip_link` indexes RobotModel::links. T_world_base is the pose of the root link, T_tip_tcp the pose of
  /// the TCP in the tip link. Planar and floating joints stay at their origins. Throws Error("bad-model") if
  /// the tip or a parent does not exist, if mimic joints form a cycle, or if a number is not finite; throws
  /// Error("too-many-joints") above kMaxJoints actuated joints or above kMostMoving on the path.
  Chain(const description::RobotModel& model, int tip_link, Pose T_world_base = {}, Pose T_tip_tcp = {});

  /// The size of a joint state.
  std::size_t joints() const noexcept { return lower_.size(); }
  const std::vector<std::string>& names() const noexcept { return names_; }
  /// Limits, rad or m; infinite if the model states none.
  const std::vector<double>& lower() const noexcept { return lower_; }
  const std::vector<double>& upper() const noexcept { return upper_; }
  /// True if joint `i` moves the TCP.
  bool moves_tcp(std::size_t i) const noexcept { return on_path_[i]; }
  /// True if joint `i` is prismatic: its values are metres, not radians.
  bool slides(std::size_t i) const noexcept { return slides_[i]; }
  /// The change of joint `i`, rad, that leaves the TCP where it is: 2 pi for an ordinary revolute joint, 0 if
  /// there is no such change.
  double period(std::size_t i) const noexcept { return period_[i]; }
  /// True for each joint that has a period.
  const std::vector<bool>& turns() const noexcept { return turns_; }
  /// One moving joint on the path from base to TCP: its axis at zero joint values, in the world. Its angle
  /// (or its travel along `direction`) is ratio * q[joint] + offset; the position at zero includes the
  /// offset.
  struct Axis {
    std::size_t joint = 0;
    bool slides = false;
    double ratio = 1;  ///< 1 unless it is a mimic joint
    Vec3 direction, point;
  };
  /// From the base outwards. A joint that others mimic appears more than once. Allocates.
  std::vector<Axis> axes() const;
  /// The number of links of the model, and the size of link_poses().
  std::size_t links() const noexcept { return link_count_; }
  const Pose& base() const noexcept { return T_world_base_; }
  /// The point that reach() is measured from: the base's origin, in the world.
  const Vec3& reach_center() const noexcept { return T_world_base_.position; }

  /// The largest distance from the base's origin to the TCP that was found within the joint limits, m. The
  /// search maximises exactly over one joint after another, from several starts. The distance is attainable;
  /// in practice it is the largest. Infinite if a prismatic joint has no limits.
  double reach() const noexcept { return reach_; }
  /// An upper bound on that distance, m: the sum of all lengths.
  double reach_bound() const noexcept { return reach_bound_; }

  /// The pose of the TCP.
  Pose forward(std::span<const double> q) const noexcept;
  /// The pose of every link of the model, in the order of RobotModel::links. Planar and floating joints count
  /// as zero.
  void link_poses(std::span<const double> q, std::span<Pose> out) const noexcept;
  /// Velocity of the TCP per joint velocity: 6 rows (linear x y z, angular x y z, world axes at the TCP) by
  /// joints() columns, row-major. Also returns the pose of the TCP.
  Pose jacobian(std::span<const double> q, std::span<double> J) const noexcept;
  /// The compiled form of this chain that forward() and jacobian() use. It also offers batches and other
  /// frames.
  const ScrewChain& screws() const noexcept { return screws_; }

 private:
  /// The value of a joint of the model: multiplier * q[variable] + offset; the constant `offset` if variable
  /// is -1.
  struct Drive {
    int variable = -1;
    double multiplier = 1, offset = 0;
    double value(std::span<const double> q) const noexcept {
      return variable < 0 ? offset : multiplier * q[static_cast<std::size_t>(variable)] + offset;
    }
  };
  /// A rotation matrix (row-major) and a translation.
  struct Frame {
    double r[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    double p[3] = {0, 0, 0};
  };
  /// One moving joint of the path. `fixed` maps from the frame behind the previous joint (at first: the
  /// world) to the frame of this joint, whose z is the joint's axis.
  struct Step {
    Frame fixed;
    bool prismatic = false;
    Drive drive;
  };
  /// One joint of the model, for link_poses().
  struct TreeJoint {
    int parent = 0, child = 0;
    Pose origin;
    Vec3 axis;
    description::JointType type = description::JointType::fixed;
    Drive drive;
  };

  static Frame frame_of(const Pose& pose) noexcept;
  static Pose pose_of(const Frame& frame) noexcept;
  static void move(Frame& frame, const Step& step, double value) noexcept;
  static void append(Frame& frame, const Frame& next) noexcept;
  static Drive drive_of(const description::RobotModel& model, int joint);

  void read_joints(const description::RobotModel& model);
  void read_path(const description::RobotModel& model, int tip_link);
  void add_step(const description::Joint& joint, const Drive& drive, Pose& pending);
  Frame sweep(std::span<const double> q) const noexcept;
  void find_periods();
  double largest_value(const Step& step) const noexcept;
  double distance_squared(std::span<const double> q) const noexcept;
  double furthest_turn(std::span<double> q, std::size_t joint) const noexcept;
  void stretch_joint(std::span<double> q, std::size_t joint) const noexcept;
  void find_reach();

  std::vector<std::string> names_;
  std::vector<double> lower_, upper_, period_;
  std::vector<bool> on_path_, turns_, slides_;
  std::vector<TreeJoint> tree_;
  std::vector<Step> steps_;
  Frame last_;  ///< from the frame after the last joint to the TCP
  Pose T_world_base_, T_tip_tcp_;
  ScrewChain screws_;
  std::size_t link_count_ = 0;
  int root_ = 0;
  double reach_ = 0, reach_bound_ = 0;
};

}  // namespace polyarm::kinematics
