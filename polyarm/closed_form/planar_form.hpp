#pragma once
/// Six axes of which the second and the third are parallel, with a wrist or with a fourth axis parallel to
/// them and axes 5 and 6 that meet: most arms there are. Everything that turns about those axes stays in a
/// plane, so in frames whose z they are a turn costs four products, and a length known beforehand spares a
/// root. The steps are those of families.hpp. Used inside this room only.
#include "polyarm/closed_form/closed_form.hpp"

namespace polyarm::kinematics {

/// The constants of such an arm. False where a step has nothing to hold on to: the general way is then right.
bool planar_form(const SixAxisForm& form, PlanarForm& out) noexcept;

}  // namespace polyarm::kinematics
