#pragma once
/// Arms given as a table of numbers instead of frames: Denavit-Hartenberg parameters or screw axes.
#include <string>
#include <vector>

#include "polyarm/base/pose.hpp"
#include "polyarm/base/yaml.hpp"
#include "polyarm/description/robot_model.hpp"

namespace polyarm::description {

/// `dh`: each row leads from one joint's axis to the next, Rz(theta + q) Tz(d) Tx(a) Rx(alpha) (Denavit and
/// Hartenberg 1955; Siciliano et al. 2009, section 2.8.2). `modified_dh`: each row leads to its own joint's
/// axis, Rx(alpha) Tx(a) Rz(theta + q) Tz(d) (Craig, Introduction to Robotics, section 3.4). `poe`: axes as
/// they stand where all joint values are zero, in the base (Lynch and Park, Modern Robotics, section 4.1).
enum class TableKind { dh, modified_dh, poe };

/// One joint, as a joint of a robot file has it.
struct TableJoint {
  JointType type = JointType::revolute;
  Pose origin;  ///< in the joint before, which is the base for the first
  Vec3 axis{0, 0, 1};
};

struct KinematicTable {
  std::vector<TableJoint> joints;
  Pose flange;  ///< in the last joint's link
};

/// What a row of the table may say beside what every joint may.
const std::vector<std::string>& table_keys(TableKind kind);
/// Throws Error for a name that is none.
TableKind table_kind(const Yaml& name);
/// `rows` are the joints from the base outwards; `flange` its pose in the last frame (dh, modified_dh) or,
/// where all joint values are zero, in the base (poe). Adds what is wrong, naming the row.
KinematicTable read_table(TableKind kind, const Yaml& rows, const Yaml& flange, Problems& problems);

/// Gives every link of a chain a capsule from its joint to the next, and forbids comparing links up to two
/// joints apart. For models without any shape; says so in the notes.
void derive_shapes(RobotModel& model);

}  // namespace polyarm::description
