#pragma once
/// Six axes with parallel axes 2 and 3, and either a wrist or a parallel axis 4 with axes 5 and 6 that meet:
/// most existing arms. Everything that turns about the parallel axes stays in a plane, so in frames with that
/// z a turn costs four products, and constant lengths save a square root. The steps are those of
/// families.hpp. Private to this room. Metres, radians; any thread.
#include "polyarm/closed_form/closed_form.hpp"

namespace polyarm::kinematics {

/// The constants of such an arm. False if a step would be degenerate: use the general solver then.
bool planar_form(const SixAxisForm& form, PlanarForm& out) noexcept;

}  // namespace polyarm::kinematics
