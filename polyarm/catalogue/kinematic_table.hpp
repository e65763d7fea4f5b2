#pragma once
/// Arms defined by a table of numbers instead of frames: Denavit-Hartenberg parameters or screw axes. Metres,
/// radians.
#include <string>
#include <vector>

#include "polyarm/base/pose.hpp"
#include "polyarm/description/robot_model.hpp"
#include "polyarm/yaml/yaml.hpp"

namespace polyarm::description {

/// `dh`: each row leads from one joint's axis to the next, Rz(theta + q) Tz(d) Tx(a) Rx(alpha) (Denavit and
/// Hartenberg 1955; Siciliano et al. 2009, section 2.8.2). `modified_dh`: each row leads to its own joint's
/// axis, Rx(alpha) Tx(a) Rz(theta + q) Tz(d) (Craig, Introduction to Robotics, section 3.4). `poe`: the axes
/// at zero joint values, in the base frame (Lynch and Park, Modern Robotics, section 4.1).
enum class TableKind { dh, modified_dh, poe };

/// One joint, with the data of a joint in a robot file.
struct TableJoint {
  JointType type = JointType::revolute;
  Pose origin;  ///< relative to the previous joint; for the first, to the base
  Vec3 axis{0, 0, 1};
};

struct KinematicTable {
  std::vector<TableJoint> joints;
  Pose flange;  ///< in the link of the last joint
};

/// The keys that a row of the table may have in addition to those of every joint.
const std::vector<std::string>& table_keys(TableKind kind);
/// Throws Error for an unknown name.
TableKind table_kind(const Yaml& name);
/// `rows` are the joints from the base outwards. `flange` is its pose in the last frame (dh, modified_dh), or
/// in the base at zero joint values (poe). Adds the faults to `problems`, with the row.
KinematicTable read_table(TableKind kind, const Yaml& rows, const Yaml& flange, Problems& problems);

/// Gives every link of a chain a capsule from its joint to the next, and excludes pairs of links up to two
/// joints apart from collision checks. For models without any shape; adds a note to the model.
void derive_shapes(RobotModel& model);

}  // namespace polyarm::description
