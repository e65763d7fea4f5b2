#pragma once
/// Answers of inverse kinematics as vectors, for tests that compare them.
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "polyarm/ik/inverse_kinematics.hpp"

namespace polyarm::test {

struct Answer {
  ik::IkOutcome outcome = ik::IkOutcome::malformed;
  std::vector<double> q;
  double position_error = 0, orientation_error = 0;
  std::string reason;
  explicit operator bool() const { return outcome == ik::IkOutcome::solved; }
};

inline std::vector<double> values_of(const ik::InverseKinematics& arm, const kinematics::IkSolution& one) {
  return {one.q.begin(), one.q.begin() + static_cast<std::ptrdiff_t>(arm.chain().joints())};
}

/// By descent from the seed, then from other states; with the reason where there is none.
inline Answer descend(const ik::InverseKinematics& arm, const Pose& target, std::span<const double> seed,
                      const kinematics::IkTask& task = {}) {
  const ik::IkExplanation found = arm.explain(target, seed, task);
  return {found.outcome, values_of(arm, found.nearest), found.nearest.position_error,
          found.nearest.orientation_error, found.reason};
}
inline Answer descend(const kinematics::Chain& chain, const Pose& target, std::span<const double> seed,
                      const kinematics::IkTask& task = {}) {
  return descend(ik::InverseKinematics(chain), target, seed, task);
}

/// What a move takes.
inline Answer move(const ik::InverseKinematics& arm, const Pose& target, std::span<const double> current,
                   std::span<const double> home) {
  kinematics::IkSolution found;
  if (arm.solve_move(target, current, home, found) != ik::IkOutcome::solved)
    return descend(arm, target, current);
  return {ik::IkOutcome::solved, values_of(arm, found), found.position_error, found.orientation_error, {}};
}
inline Answer move(const kinematics::Chain& chain, const Pose& target, std::span<const double> current,
                   std::span<const double> home) {
  return move(ik::InverseKinematics(chain), target, current, home);
}

/// All solutions, nearest first.
inline std::vector<std::vector<double>> all_of(const ik::InverseKinematics& arm, const Pose& target,
                                               std::span<const double> seed) {
  const auto found = std::make_unique<kinematics::IkSolutions>();
  arm.solve_all(target, seed, *found);
  std::vector<std::vector<double>> out;
  for (const kinematics::IkSolution& one : *found) out.push_back(values_of(arm, one));
  return out;
}
inline std::vector<std::vector<double>> all_of(const kinematics::Chain& chain, const Pose& target,
                                               std::span<const double> seed) {
  return all_of(ik::InverseKinematics(chain), target, seed);
}

}  // namespace polyarm::test
