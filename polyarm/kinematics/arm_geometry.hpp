#pragma once
/// An arm as the axes of its joints: the product of exponentials (Brockett 1984; Lynch and Park, Modern
/// Robotics, chapter 4). What the closed-form inverse kinematics looks at. Metres, radians, world frame.
#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>

#include "polyarm/kinematics/chain.hpp"
#include "polyarm/simd/rotation.hpp"

namespace polyarm::kinematics {

/// One joint's axis as it stands where all joint values are zero.
struct JointAxis {
  Vec3 direction;         ///< unit vector; the joint turns about it by its value, right-handed
  Vec3 point;             ///< any point of the axis
  bool slides = false;    ///< moves along `direction` instead of turning
  std::size_t joint = 0;  ///< index in a joint state
};

/// T(q) = E_1(q_1) ... E_n(q_n) T(0), where E_i turns about axis i as it stands at zero.
struct ArmGeometry {
  static constexpr std::size_t kMostAxes = 8;
  std::array<JointAxis, kMostAxes> axes;  ///< from the base outwards
  std::size_t count = 0;
  Rotation tool_rotation;  ///< of the TCP where all joint values are zero
  Vec3 tool_position;

  /// The TCP's pose; `values` in the order of `axes`.
  void forward(std::span<const double> values, Rotation& rotation, Vec3& position) const noexcept;
  /// A length to measure deviations by: the sum of the ways from axis to axis, m.
  double size() const noexcept;
};

/// The axes of a chain; nothing where it is no plain row of up to eight joints (a mimic joint drives two of
/// them, or at another rate), with the reason in `why_not`.
std::optional<ArmGeometry> geometry_of(const Chain& chain, std::string& why_not);

/// The arm seen from its tool: joint n first, and the pose that it reaches is the inverse of the arm's. The
/// joint values are the same, in reverse order.
ArmGeometry reversed(const ArmGeometry& arm) noexcept;

/// The arm with axis `k` held at `value`: one axis less.
ArmGeometry locked(const ArmGeometry& arm, std::size_t k, double value) noexcept;

}  // namespace polyarm::kinematics
