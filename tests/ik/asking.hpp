#pragma once
/// Questions whose answer is known: the pose of a joint state, of which that state has to be found again.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <string>
#include <vector>

#include "polyarm/ik/inverse_kinematics.hpp"
#include "polyarm/kinematics/singularity.hpp"
#include "polyarm/simd/rotation.hpp"
#include "tests/kinematics/sample_states.hpp"

namespace polyarm::test {

using namespace ik;

/// More by the environment's POLYARM_IK_POSES.
inline int poses_per_arm(int usual) {
  const char* given = std::getenv("POLYARM_IK_POSES");
  return given ? std::max(usual, std::atoi(given)) : usual;
}

/// Joint values at which arms are singular, where limits allow.
inline std::vector<double> grid_state(const Chain& chain, Random& random) {
  std::vector<double> q = random_state(chain, random);
  for (std::size_t j = 0; j < q.size(); ++j) {
    const double value = std::numbers::pi / 2 * std::floor(random.between(-1, 3));
    if (value >= chain.lower()[j] && value <= chain.upper()[j]) q[j] = value;
  }
  return q;
}

/// The same, off by 1e-7 to 0.1 rad, and some of the joints anywhere.
inline std::vector<double> near_singular_state(const Chain& chain, Random& random) {
  std::vector<double> q = random_state(chain, random);
  const double off = std::pow(10, random.between(-7, -1)), kept = random.unit() < 0.7 ? 0.25 : 0.0;
  for (std::size_t j = 0; j < q.size(); ++j) {
    const double value = std::numbers::pi / 2 * std::floor(random.between(-1, 3)) + random.between(-off, off);
    if (random.unit() >= kept && value >= chain.lower()[j] && value <= chain.upper()[j]) q[j] = value;
  }
  return q;
}

inline double error_of(const Chain& chain, std::span<const double> q, const Pose& target) {
  const Pose pose = chain.forward(q);
  const Rotation a = rotation_of(pose.rotation), b = rotation_of(target.rotation);
  const Vec3 turn = 0.5 * (cross(a.x, b.x) + cross(a.y, b.y) + cross(a.z, b.z));
  return std::max(norm(pose.position - target.position), norm(turn));
}

/// The largest difference of any joint, whole turns aside.
inline double difference(const Chain& chain, std::span<const double> a, std::span<const double> b) {
  double most = 0;
  for (std::size_t j = 0; j < chain.joints(); ++j) {
    const double d = a[j] - b[j];
    most = std::max(most, std::abs(chain.turns()[j] ? std::remainder(d, 2 * std::numbers::pi) : d));
  }
  return most;
}

/// Counts of one arm's questions; each miss is printed as a case to repeat.
struct Tally {
  int asked = 0, missed = 0, inexact = 0, outside = 0, unsorted = 0;
  Tally& operator+=(const Tally& other) {
    asked += other.asked;
    missed += other.missed;
    inexact += other.inexact;
    outside += other.outside;
    unsorted += other.unsorted;
    return *this;
  }
};

/// Asks for the pose of `q` and looks for `q` among the answers.
inline void ask(const Chain& chain, const InverseKinematics& arm, std::span<const double> q,
                std::span<const double> seed, const std::string& robot, Tally& tally, bool family = false) {
  const Pose target = chain.forward(q);
  IkSolutions found;
  const IkOutcome outcome = arm.solve_all(target, seed, found);
  ++tally.asked;
  // At a singularity two solutions become one, or endlessly many; q is then known to fewer digits.
  const double same = smallest_singular_value(chain, q) < 1e-4 ? 1e-2 : 1e-6;
  bool there = false;
  for (const IkSolution& one : found) {
    const std::span<const double> values(one.q.data(), chain.joints());
    there |= difference(chain, values, q) < same;
    tally.inexact += !one.exact || error_of(chain, values, target) > 2e-9;
    for (std::size_t j = 0; j < chain.joints(); ++j)
      tally.outside += values[j] < chain.lower()[j] || values[j] > chain.upper()[j];
    if (&one != found.begin()) tally.unsorted += one.distance < (&one - 1)->distance;
  }
  // Of a family that hardly anything tells apart it is the member nearest to the seed that has to be there.
  if (!there && !family && smallest_singular_value(chain, q) < 1e-6) {
    --tally.asked;
    return ask(chain, arm, q, q, robot, tally, true);
  }
  if (there) return;
  if (++tally.missed <= 3)
    fmt::print("missed by {} ({}, {} solutions): q = {} seed = {}\n", robot, name(outcome), found.count, q,
               seed);
}

inline void expect_clean(const Tally& tally) {
  EXPECT_EQ(tally.inexact, 0);
  EXPECT_EQ(tally.outside, 0);
  EXPECT_EQ(tally.unsorted, 0);
}

}  // namespace polyarm::test
