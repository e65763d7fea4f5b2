#pragma once
/// Why a pose could not be had, and how near the arm comes. Used inside this room only.
#include "polyarm/ik/inverse.hpp"
#include "polyarm/descent/numeric_core.hpp"

namespace polyarm::kinematics {

/// Whether a question asks for one place and no room about it.
bool place_is_fixed(const NumericQuestion& question) noexcept;

/// Fills in `result` for a question that has no solution: the nearest joint state within limits (metres, and
/// radians at options.orientation_weight), its errors, status and reason. `question` is as the core read it.
/// Some hundred descents at most.
void explain_failure(const NumericCore& core, const NumericQuestion& question, const Pose& target,
                     std::span<const double> seed, const IkOptions& options, IkResult& result);

}  // namespace polyarm::kinematics
