#pragma once
/// Describes an arm by the axes of its joints: the product of exponentials (Brockett 1984; Lynch and Park,
/// Modern Robotics, chapter 4). The closed-form inverse kinematics works on it. Metres, radians, world frame.
/// Nothing is cached: any thread. Only geometry_of() allocates; nothing throws.
#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>

#include "polyarm/kinematics/chain.hpp"
#include "polyarm/simd/rotation.hpp"

namespace polyarm::kinematics {

/// The axis of one joint at zero joint values.
struct JointAxis {
  Vec3 direction;         ///< unit vector; a positive value turns right-handed about it
  Vec3 point;             ///< any point on the axis
  bool slides = false;    ///< the joint moves along `direction` instead of turning
  std::size_t joint = 0;  ///< index in a joint state
};

/// T(q) = E_1(q_1) ... E_n(q_n) T(0), where E_i moves about axis i in its position at zero.
struct ArmGeometry {
  static constexpr std::size_t kMostAxes = 8;
  std::array<JointAxis, kMostAxes> axes;  ///< from the base outwards
  std::size_t count = 0;
  Rotation tool_rotation;  ///< of the TCP at zero joint values
  Vec3 tool_position;

  /// The pose of the TCP; `values` are in the order of `axes`.
  void forward(std::span<const double> values, Rotation& rotation, Vec3& position) const noexcept;
  /// A reference length for deviations: the sum of the distances from axis to axis, m.
  double size() const noexcept;
};

/// The axes of a chain. Returns nothing, and the reason in `why_not`, if the chain is not a plain series of
/// at most eight joints (for example if a mimic joint makes one joint drive two axes, or at another ratio).
std::optional<ArmGeometry> geometry_of(const Chain& chain, std::string& why_not);

/// The arm as seen from its tool: joint n comes first, and its pose is the inverse of the arm's pose. The
/// joint values are the same, in reverse order.
ArmGeometry reversed(const ArmGeometry& arm) noexcept;

/// The arm with axis `k` fixed at `value`; it has one axis fewer.
ArmGeometry locked(const ArmGeometry& arm, std::size_t k, double value) noexcept;

}  // namespace polyarm::kinematics
