#include "polyarm/planning/pose_goals.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

namespace polyarm::planning {

namespace {

double distance(std::span<const double> a, std::span<const double> b) {
  double sum = 0;
  for (std::size_t j = 0; j < a.size(); ++j) sum += (b[j] - a[j]) * (b[j] - a[j]);
  return sum;
}

/// Adds the same pose with one joint a whole turn further, either way.
void add_turns(const kinematics::Chain& chain, const JointState& q, std::vector<JointState>& to) {
  for (std::size_t j = 0; j < q.size(); ++j) {
    if (!(chain.period(j) > 0)) continue;
    for (const double side : {-1.0, 1.0}) {
      JointState turned = q;
      turned[j] += side * chain.period(j);
      if (turned[j] >= chain.lower()[j] && turned[j] <= chain.upper()[j]) to.push_back(std::move(turned));
    }
  }
}

}  // namespace

std::vector<JointState> with_turns(const kinematics::Chain& chain, std::vector<JointState> states,
                                   std::span<const double> seed) {
  std::vector<JointState> turned;
  for (const JointState& q : states) add_turns(chain, q, turned);
  std::stable_sort(turned.begin(), turned.end(), [&](const JointState& a, const JointState& b) {
    return distance(seed, a) < distance(seed, b);
  });
  states.insert(states.end(), turned.begin(), turned.end());
  return states;
}

std::vector<JointState> goals_for(const ik::InverseKinematics& solver, const Pose& tcp_in_world,
                                  std::span<const double> seed, std::size_t most) {
  const auto found = std::make_unique<kinematics::IkSolutions>();
  if (solver.solve_all(tcp_in_world, seed, *found) != kinematics::IkOutcome::solved) return {};
  const kinematics::Chain& chain = solver.chain();
  std::vector<JointState> out;
  for (const kinematics::IkSolution& solution : *found)
    out.emplace_back(solution.q.begin(), solution.q.begin() + static_cast<std::ptrdiff_t>(chain.joints()));
  out = with_turns(chain, std::move(out), seed);
  if (out.size() > most) out.resize(most);
  return out;
}

}  // namespace polyarm::planning
