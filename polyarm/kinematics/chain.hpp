#pragma once
/// Where a robot's links and its tool centre point are for given joint values, and how they move. Built once
/// from a model, then const. Everything here is SI: metres, radians, poses in the world.
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "polyarm/base/pose.hpp"
#include "polyarm/description/robot_model.hpp"
#include "polyarm/kinematics/screw_chain.hpp"

namespace polyarm::kinematics {

/// The kinematics of one robot from its base to a tool centre point (TCP). A joint state `q` has one value
/// for each actuated joint of the model, in the order of RobotModel::actuated; actuated joints that do not
/// lie between root and tip have no influence on the TCP. A mimic joint follows as multiplier * q + offset.
/// Thread: const and without hidden state, so any thread; forward(), link_poses(), jacobian() allocate
/// nothing. Precondition of all three: the spans have the sizes stated.
class Chain {
 public:
  /// Most actuated joints that the model may have: hands, legs and other arms among them.
  static constexpr std::size_t kMaxJoints = 128;
  /// Most of them that may move the TCP.
  static constexpr std::size_t kMostMoving = 32;

  /// `tip_link` indexes RobotModel::links. T_world_base places the root link, T_tip_tcp the TCP in the tip
  /// link. Planar and floating joints stay at their origins. Throws Error("bad-model") for a tip or parent
  /// that does not exist, mimic joints that follow each other in a circle, or numbers that are not finite;
  /// Error("too-many-joints") for more than kMaxJoints actuated joints or kMostMoving on the path.
  Chain(const description::RobotModel& model, int tip_link, Pose T_world_base = {}, Pose T_tip_tcp = {});

  /// How many values a joint state has.
  std::size_t joints() const noexcept { return lower_.size(); }
  const std::vector<std::string>& names() const noexcept { return names_; }
  /// Limits, rad or m; infinite where the model states none.
  const std::vector<double>& lower() const noexcept { return lower_; }
  const std::vector<double>& upper() const noexcept { return upper_; }
  /// Whether joint `i` moves the TCP.
  bool moves_tcp(std::size_t i) const noexcept { return on_path_[i]; }
  /// Whether joint `i` is prismatic: its values are metres, not radians.
  bool slides(std::size_t i) const noexcept { return slides_[i]; }
  /// A change of joint `i` by this much, rad, leaves the TCP where it is (2 pi for an ordinary revolute
  /// joint); 0 where there is no such change.
  double period(std::size_t i) const noexcept { return period_[i]; }
  /// Whether joint `i` has such a period.
  const std::vector<bool>& turns() const noexcept { return turns_; }
  /// One moving joint of the way from base to TCP, as it stands where all joint values are zero, in the
  /// world. Its angle (or its way along `direction`) is ratio * q[joint] + offset, the offset being part of
  /// where it stands.
  struct Axis {
    std::size_t joint = 0;
    bool slides = false;
    double ratio = 1;  ///< of a mimic joint; else 1
    Vec3 direction, point;
  };
  /// From the base outwards. A joint that others mimic comes more than once. Allocates.
  std::vector<Axis> axes() const;
  /// How many links the model has, which is the size of link_poses().
  std::size_t links() const noexcept { return link_count_; }
  const Pose& base() const noexcept { return T_world_base_; }
  /// What reach() is measured from: the base's origin, in the world.
  const Vec3& reach_center() const noexcept { return T_world_base_.position; }

  /// The largest distance of the TCP from the base's origin that some joint state within limits was found to
  /// have, m. Found by exact maximisation over one joint after another from several starts: a true distance,
  /// and in practice the largest. Infinite with a prismatic joint that has no limits.
  double reach() const noexcept { return reach_; }
  /// No joint state within limits puts the TCP further from the base's origin than this, m: the sum of all
  /// lengths.
  double reach_bound() const noexcept { return reach_bound_; }

  /// The TCP's pose.
  Pose forward(std::span<const double> q) const noexcept;
  /// The pose of every link of the model, in the order of RobotModel::links. Links behind planar or floating
  /// joints are placed as if those stood at zero.
  void link_poses(std::span<const double> q, std::span<Pose> out) const noexcept;
  /// Velocity of the TCP per joint velocity: 6 rows (linear x y z, angular x y z, world axes at the TCP) by
  /// joints() columns, row after row. Returns the TCP's pose, which the sweep finds on its way.
  Pose jacobian(std::span<const double> q, std::span<double> J) const noexcept;
  /// The same chain compiled for speed, which forward() and jacobian() use: batches, other frames.
  const ScrewChain& screws() const noexcept { return screws_; }

 private:
  /// How a joint of the model gets its value: multiplier * q[variable] + offset; a constant where variable is
  /// -1.
  struct Drive {
    int variable = -1;
    double multiplier = 1, offset = 0;
    double value(std::span<const double> q) const noexcept {
      return variable < 0 ? offset : multiplier * q[static_cast<std::size_t>(variable)] + offset;
    }
  };
  /// A rotation matrix (row after row) and a translation.
  struct Frame {
    double r[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    double p[3] = {0, 0, 0};
  };
  /// One moving joint of the path. `fixed` leads from the frame after the joint before (the world at first)
  /// to this joint's frame, turned so that the joint's axis is z.
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
