#pragma once
/// Arms drawn at random from each family of closed forms, and ways to spoil them.
#include <cmath>
#include <numbers>
#include <vector>

#include "polyarm/closed_form/arm_class.hpp"
#include "polyarm/kinematics/random.hpp"
#include "tests/kinematics/sample_robots.hpp"
#include "tests/kinematics/sample_states.hpp"

namespace polyarm::test {

/// Those that are solved in quadratics or quartics.
inline constexpr kinematics::ArmFamily kClosedFamilies[] = {
    kinematics::ArmFamily::wrist_2_parallel_3,
    kinematics::ArmFamily::wrist_1_parallel_2,
    kinematics::ArmFamily::wrist_1_meets_2,
    kinematics::ArmFamily::wrist_2_meets_3,
    kinematics::ArmFamily::parallel_234_5_meets_6,
    kinematics::ArmFamily::parallel_123_5_meets_6,
    kinematics::ArmFamily::wrist,
    kinematics::ArmFamily::parallel_234,
};

/// Six axes of a family, lengths about half a metre, no two neighbours nearly parallel unless they are; of no
/// other family, were axes off by `clearly` (as classify()'s tolerance).
inline std::vector<AxisRow> random_axes(kinematics::ArmFamily family, kinematics::Random& random,
                                        double clearly = 0.03) {
  using kinematics::ArmFamily;
  std::vector<AxisRow> a(6);
  for (std::size_t i = 0; i < 6; ++i) {
    do a[i].direction = random_direction(random);
    while (i > 0 && norm(cross(a[i].direction, a[i - 1].direction)) < 0.3);
    a[i].point = (i > 0 ? a[i - 1].point : Vec3{}) + random_vector(random, 0.5);
  }
  const auto parallel = [&](std::size_t i, std::size_t j) {
    a[j].direction = random.unit() < 0.5 ? a[i].direction : -a[i].direction;
  };
  const auto steep = [&](std::size_t i, std::size_t j) {
    return norm(cross(a[i].direction, a[j].direction)) > 0.3;
  };
  const bool wrist = family == ArmFamily::wrist || family == ArmFamily::wrist_2_parallel_3 ||
                     family == ArmFamily::wrist_1_parallel_2 || family == ArmFamily::wrist_1_meets_2 ||
                     family == ArmFamily::wrist_2_meets_3;
  if (wrist) a[4].point = a[5].point = a[3].point;
  switch (family) {
    case ArmFamily::wrist_2_parallel_3:
      parallel(1, 2);
      break;
    case ArmFamily::wrist_1_parallel_2:
      parallel(0, 1);
      break;
    case ArmFamily::wrist_1_meets_2:
      a[1].point = a[0].point;
      break;
    case ArmFamily::wrist_2_meets_3:
      a[2].point = a[1].point;
      break;
    case ArmFamily::parallel_234_5_meets_6:
      a[5].point = a[4].point;
      [[fallthrough]];
    case ArmFamily::parallel_234:
      parallel(1, 2);
      parallel(1, 3);
      break;
    case ArmFamily::parallel_123_5_meets_6:
      a[5].point = a[4].point;
      parallel(0, 1);
      parallel(0, 2);
      break;
    case ArmFamily::search_5_meets_6:
      a[5].point = a[4].point;
      break;
    case ArmFamily::search_4_meets_5:
      a[4].point = a[3].point;
      a[1].point = a[0].point;  // by itself it is solved as any six axes are
      break;
    default:
      break;
  }
  // Aligning may have brought together what should be apart.
  for (std::size_t i = 0; i + 1 < 6; ++i)
    if (!steep(i, i + 1) && norm(cross(a[i].direction, a[i + 1].direction)) > 1e-9)
      return random_axes(family, random, clearly);
  kinematics::ArmGeometry arm;
  arm.count = 6;
  for (std::size_t i = 0; i < 6; ++i) arm.axes[i] = {a[i].direction, a[i].point};
  arm.tool_position = a[5].point;
  const auto seen = kinematics::classify(arm, clearly);
  if (seen.family != family || seen.from_tool) return random_axes(family, random, clearly);
  // Nor may there be another way to search, by chance, that is taken instead.
  const auto alike = [&](const kinematics::SixAxisClass& other, bool from_tool) {
    return other.family == family && other.from_tool == from_tool;
  };
  if (kinematics::searched(family) &&
      !(alike(kinematics::classify(arm), false) && alike(kinematics::classify(reversed(arm)), true)))
    return random_axes(family, random, clearly);
  return a;
}

/// The same axes in the opposite order, as if the tool were bolted to the ground.
inline std::vector<AxisRow> turned_round(std::vector<AxisRow> axes) {
  std::reverse(axes.begin(), axes.end());
  for (AxisRow& row : axes) row.direction = -row.direction;
  return axes;
}

/// Axes off by up to `size`, m and rad, as a calibration finds them.
inline std::vector<AxisRow> spoiled(std::vector<AxisRow> axes, double size, kinematics::Random& random) {
  for (AxisRow& row : axes) {
    row.direction = normalized(row.direction + random_vector(random, size));
    row.point = row.point + random_vector(random, size);
  }
  return axes;
}

inline description::RobotModel random_arm(const std::vector<AxisRow>& axes, kinematics::Random& random) {
  const Pose tool{axes.back().point + random_vector(random, 0.2),
                  from_axis_angle(random_direction(random), 2)};
  return robot_of_axes("random", axes, tool);
}

}  // namespace polyarm::test
