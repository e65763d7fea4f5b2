#pragma once
/// The Jacobian of an arm and its derivatives along a motion, so that joints can follow a path of the TCP up
/// to the third derivative. Metres, radians, world axes.
#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "polyarm/base/pose.hpp"
#include "polyarm/kinematics/chain.hpp"

namespace polyarm::moves {

/// One joint state and the motion of the TCP there. Built once (allocates). Afterwards call at(), then move()
/// with the joints' first derivatives, then move_on() with the second ones: each call prepares the next. No
/// allocation; one thread at a time.
class ArmDerivatives {
 public:
  explicit ArmDerivatives(const kinematics::Chain& chain);

  /// The columns: the joints that move the TCP, as indices of the chain's joints.
  const std::vector<std::size_t>& joints() const noexcept { return joints_; }
  std::size_t columns() const noexcept { return joints_.size(); }

  /// `q`: all joints of the chain.
  void at(std::span<const double> q) noexcept;
  /// Derivatives of the columns' joints with respect to the path parameter; call at() and move() first.
  void move(std::span<const double> first) noexcept;
  void move_on(std::span<const double> first, std::span<const double> second) noexcept;

  /// The TCP after at(): its position, and the columns of its rotation.
  const Vec3& position() const noexcept { return position_; }
  const std::array<Vec3, 3>& rotation() const noexcept { return rotation_; }
  /// Column-major, six rows each: linear velocity x y z of the TCP, angular velocity x y z.
  std::span<const double> J() const noexcept { return {J_[0].data(), 6 * columns()}; }
  std::span<const double> dJ() const noexcept { return {J_[1].data(), 6 * columns()}; }
  std::span<const double> ddJ() const noexcept { return {J_[2].data(), 6 * columns()}; }

 private:
  struct Axis {
    std::size_t joint, column;
    bool slides;
    double ratio;
    Vec3 direction, point;     // at zero joint values
    std::array<Vec3, 3> z, o;  // in the world, and derivatives
  };
  void fill(std::size_t order) noexcept;

  std::vector<std::size_t> joints_;
  std::vector<Axis> axes_;
  Vec3 position_zero_, position_;
  std::array<Vec3, 3> rotation_zero_, rotation_;
  std::array<Vec3, 3> tcp_;  // position and derivatives
  std::array<std::vector<double>, 3> J_;
};

}  // namespace polyarm::moves
