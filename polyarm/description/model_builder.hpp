#pragma once
/// Builds a model from the names in a file, and completes its masses. SI units.
#include <string>

#include "polyarm/description/robot_model.hpp"

namespace polyarm::description {

/// A joint with the names from the file, before they become indices.
struct NamedJoint {
  Joint joint;
  std::string parent, child, mimics;
  Location where;
};

/// Files write pi/2 as 1.5708. Then axes that are parallel or meet by design do not: an arm with five axes
/// misses a tool that points straight down, and closed forms do not apply. An angle with 4 to 9 decimals that
/// is a multiple of pi/4 rounded or cut to them, within 1e-5 rad, becomes this multiple. Values with more
/// digits, such as those of a calibration, stay. Returns true if an angle changed.
bool settle_angles(Vec3& rpy);

/// Connects joints and links: checks names, finds the root, sorts parents before children (otherwise in the
/// file's order), and fills parent_joint, mimic and actuated. Adds the faults: unknown or duplicate names
/// (with the nearest name), a link with two parents, several roots, cycles. Warnings: several joints between
/// the same two links, of which the last one by name moves the link; a <mimic> that cannot be followed (the
/// joint is missing or does not have exactly one value, or a cycle), whose joint becomes independent. Returns
/// false if the model is unusable.
bool tie_together(RobotModel& model, std::vector<NamedJoint> joints, const Location& file, Problems& problems,
                  Problems& warnings);

/// Gives links without mass an estimate from their collision shapes. A moving link without a shape gets a
/// small body. Repairs impossible tensors. Notes each change in the provenance.
void complete_inertials(RobotModel& model, Problems& warnings);

/// Mass properties of the shapes at a density, kg/m³. A mesh counts as the boxes around its convex pieces,
/// and as nothing without them.
Inertial inertial_of(const std::vector<Shape>& shapes, double density);
/// True if the principal moments are positive and satisfy the triangle inequality (within rounding).
bool plausible(const Inertial& inertial);

}  // namespace polyarm::description
