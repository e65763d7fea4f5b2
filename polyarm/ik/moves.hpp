#pragma once
/// Questions that InverseKinematics answers by descent: moves, parts of poses, reasons. Used inside this room
/// only.
#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "polyarm/descent/numeric_core.hpp"
#include "polyarm/ik/inverse_kinematics.hpp"

namespace polyarm::ik {

/// What is wrong with a question.
enum class Flaw { none, not_finite, no_rotation, no_joints, seed_size, task, nothing_moves, too_far };

/// A question as the numeric solver takes it.
struct DescentQuestion {
  Pose target;  ///< with a unit quaternion
  std::array<double, Chain::kMaxJoints> values;
  std::size_t joints = 0;
  NumericQuestion inner;
  std::span<const double> seed() const noexcept { return {values.data(), joints}; }  ///< within limits
};

/// Reads a question into `out`.
Flaw read(const NumericCore& core, const Pose& target, std::span<const double> seed, const IkTask& task,
          DescentQuestion& out) noexcept;
/// `flaw` in words, with the values of the question. Allocates.
std::string describe(Flaw flaw, const Chain& chain, std::span<const double> seed, const IkTask& task);

/// Whether a question asks for one place and no room about it.
bool place_is_fixed(const NumericQuestion& question) noexcept;
/// True if the place is beyond all lengths of the arm; never if the task gives the place some room.
bool out_of_bounds(const NumericCore& core, const DescentQuestion& question) noexcept;

/// From the seed: first free and wound back into the limits; if they are still broken, with the limits as
/// walls.
bool descend_directly(const NumericCore& core, const DescentQuestion& question, IkSolution& out) noexcept;
/// The same, then from other states. False: `out` is the nearest that was found within limits.
bool search(const NumericCore& core, const DescentQuestion& question, int restarts, IkSolution& out) noexcept;
/// All that descents find, nearest to the seed first, no two within 1e-3 of each other.
void collect_descents(const NumericIk& numeric, const DescentQuestion& question, int restarts,
                      IkSolutions& out) noexcept;

/// For a question that has no solution: the nearest joint state within limits (a radian counts like a metre),
/// its errors, outcome and reason. Some hundred descents at most; allocates.
IkExplanation explain_failure(const NumericCore& core, const DescentQuestion& question);

}  // namespace polyarm::ik
