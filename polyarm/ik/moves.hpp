#pragma once
/// The questions that InverseKinematics answers by descent: moves, partial poses, explanations. Private to
/// this room. Metres, radians; no hidden state: any thread.
#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "polyarm/descent/numeric_core.hpp"
#include "polyarm/ik/inverse_kinematics.hpp"

namespace polyarm::ik {

/// The fault of a question.
enum class Flaw { none, not_finite, no_rotation, no_joints, seed_size, task, nothing_moves, too_far };

/// A question in the form of the numeric solver.
struct DescentQuestion {
  Pose target;  ///< with a unit quaternion
  std::array<double, Chain::kMaxJoints> values;
  std::size_t joints = 0;
  NumericQuestion inner;
  std::span<const double> seed() const noexcept { return {values.data(), joints}; }  ///< within limits
};

/// Checks a question and converts it into `out`.
Flaw read(const NumericCore& core, const Pose& target, std::span<const double> seed, const IkTask& task,
          DescentQuestion& out) noexcept;
/// `flaw` as text, with the values of the question. Allocates.
std::string describe(Flaw flaw, const Chain& chain, std::span<const double> seed, const IkTask& task);

/// True if a question requires one exact position.
bool place_is_fixed(const NumericQuestion& question) noexcept;
/// True if the position is beyond the sum of all lengths of the arm. False if the task allows a position
/// deviation.
bool out_of_bounds(const NumericCore& core, const DescentQuestion& question) noexcept;

/// Descends from the seed: first without limits, then unwound into them; if limits are still violated, with
/// the limits as walls.
bool descend_directly(const NumericCore& core, const DescentQuestion& question, IkSolution& out) noexcept;
/// The same, then from other states. If it returns false, `out` is the nearest state within limits that was
/// found.
bool search(const NumericCore& core, const DescentQuestion& question, int restarts, IkSolution& out) noexcept;
/// All solutions that descents find, nearest to the seed first, no two within 1e-3 of each other.
void collect_descents(const NumericIk& numeric, const DescentQuestion& question, int restarts,
                      IkSolutions& out) noexcept;

/// For a question without solution: the nearest joint state within limits (a radian counts like a metre), its
/// errors, the outcome and the reason. At most some hundred descents; allocates.
IkExplanation explain_failure(const NumericCore& core, const DescentQuestion& question);

}  // namespace polyarm::ik
