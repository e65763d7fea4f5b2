#pragma once
/// Rotations along a path as polynomial rotation vectors. Radians; any thread; no allocation.
#include "polyarm/base/pose.hpp"
#include "polyarm/paths/hermite.hpp"

namespace polyarm::paths {

/// The angular velocity per unit of the path parameter, in body axes, and its derivatives.
struct BodyRate {
  Vec3 value, first, second;
};

Quaternion exponential(const Vec3& rotation_vector) noexcept;

/// The rate of exp(phi) for a given motion of phi, whose length is at most 2 pi. From
/// omega = phi' - (1 - cos t)/t² phi x phi' + (t - sin t)/t³ phi x (phi x phi'), t = |phi| (Park and Chung,
/// IEEE Transactions on Robotics 21, 2005: the exponential's right Jacobian), and its derivatives.
BodyRate body_rate(const Jet<Vec3>& phi) noexcept;

/// The inverse up to the second derivative: phi, in a ball of pi, of a rotation with this `rate`. Ignores
/// rate.second; phi's third derivative is 0.
Jet<Vec3> rotation_vector(const Quaternion& rotation, const BodyRate& rate) noexcept;

}  // namespace polyarm::paths
