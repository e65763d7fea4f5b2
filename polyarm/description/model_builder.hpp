#pragma once
#include <string>

#include "polyarm/description/robot_model.hpp"

namespace polyarm::description {

/// A joint as a file names it, before names are indices.
struct NamedJoint {
  Joint joint;
  std::string parent, child, mimics;
  Location where;
};

/// Ties joints to links: checks names, finds the root, sorts parents before children (otherwise the file's
/// order), fills parent_joint, mimic and actuated. Adds what is wrong: unknown or duplicated names (nearest
/// name), a link with two parents, several roots, circles. A <mimic> that cannot be followed (a joint that is
/// missing or has no one value, a circle) is a warning, and its joint moves by itself. Returns false if the
/// model cannot be used.
bool tie_together(RobotModel& model, std::vector<NamedJoint> joints, const Location& file, Problems& problems,
                  Problems& warnings);

/// Gives links without mass an estimate from their collision shapes (or a small body where they have none and
/// move), repairs tensors that no body has, and notes both in the provenance.
void complete_inertials(RobotModel& model, Problems& warnings);

/// Mass properties of the shapes at a density, kg/m³.
Inertial inertial_of(const std::vector<Shape>& shapes, double density);
/// Principal moments positive and fulfilling the triangle inequality (within rounding)?
bool plausible(const Inertial& inertial);

}  // namespace polyarm::description
