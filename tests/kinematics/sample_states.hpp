#pragma once
/// Chains of sample robots, states drawn within their limits, and the instructions there may be.
#include <algorithm>
#include <span>
#include <vector>

#include "polyarm/kinematics/chain.hpp"
#include "polyarm/simd/instruction_set.hpp"
#include "polyarm/kinematics/random.hpp"
#include "tests/kinematics/sample_robots.hpp"

namespace polyarm::test {

inline constexpr kinematics::InstructionSet kInstructionSets[] = {kinematics::InstructionSet::portable,
                                                                  kinematics::InstructionSet::avx2,
                                                                  kinematics::InstructionSet::avx512};

inline kinematics::Chain chain_of(const description::RobotModel& model) {
  return kinematics::Chain(model, tip_of(model));
}

inline std::vector<double> random_state(const kinematics::Chain& chain, kinematics::Random& random) {
  std::vector<double> q;
  for (std::size_t j = 0; j < chain.joints(); ++j) q.push_back(random_value(chain, j, random));
  return q;
}

/// Each joint at most `far` (rad or m) from `q`, within limits.
inline std::vector<double> nearby_state(const kinematics::Chain& chain, std::span<const double> q, double far,
                                        kinematics::Random& random) {
  std::vector<double> out;
  for (std::size_t j = 0; j < chain.joints(); ++j)
    out.push_back(std::clamp(q[j] + far * (2 * random.unit() - 1), chain.lower()[j], chain.upper()[j]));
  return out;
}

inline Vec3 random_vector(kinematics::Random& random, double size) {
  return {random.between(-size, size), random.between(-size, size), random.between(-size, size)};
}
inline Vec3 random_direction(kinematics::Random& random) {
  for (;;) {
    const Vec3 v = random_vector(random, 1);
    if (norm(v) > 0.1 && norm(v) < 1) return normalized(v);
  }
}

}  // namespace polyarm::test
