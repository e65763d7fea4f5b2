#pragma once
/// Makes the steps of a Tree from a model. Private to tree.cpp.
#include <vector>

#include "polyarm/kinematics/tree.hpp"

namespace polyarm::kinematics {

class TreeBuilder {
 public:
  TreeBuilder(const description::RobotModel& model, const TreeOptions& options, Tree& out);
  void build();

 private:
  /// For each joint of the model: the joint that it follows, and the ratio and offset.
  struct Drive {
    int joint = -1;  ///< of the model; -1: it does not move
    double ratio = 1, offset = 0;
  };
  Drive drive_of(int joint) const;
  void number_joints();
  void add_joint(const TreeJoint& joint);
  void add_root();
  void add_link_of(int joint);
  /// Adds the steps of one joint to the link `from`; `at` is the pose of the joint's axes in the reference
  /// frame at zero. Returns the last step.
  int add_steps(const TreeJoint& joint, const Vec3& axis, const Pose& at, int from_step, double ratio);
  int add_step(Motion motion, const Vec3& h, const Vec3& origin, int parent, std::size_t position,
               std::size_t velocity, double ratio);
  void add_body(int link);

  const description::RobotModel& model_;
  const TreeOptions& options_;
  Tree& out_;
  std::vector<TreeStep> steps_;
  std::vector<Vec3> origins_;  ///< of the steps, in the reference frame at zero
  std::vector<Pose> at_zero_;  ///< of the links, in the reference frame
  std::vector<int> joint_of_;  ///< index into Tree::joints for each joint of the model; -1: none
};

}  // namespace polyarm::kinematics
