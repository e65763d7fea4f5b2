#pragma once
/// The Jacobian of an arm and its derivatives along a motion, which is what joints need to follow a path of
/// the TCP up to the third derivative. Metres, radians, world axes.
#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "polyarm/base/pose.hpp"
#include "polyarm/kinematics/chain.hpp"

namespace polyarm::moves {

/// One joint state and how the TCP moves there. Built once (allocates); after that each step fills in what
/// the next needs: at(), then move() with the joints' first derivatives, then move_on() with the second. No
/// allocation, one thread.
class ArmDerivatives {
 public:
  explicit ArmDerivatives(const kinematics::Chain& chain);

  /// Joints that move the TCP, as indices of the chain's joints: the columns.
  const std::vector<std::size_t>& joints() const noexcept { return joints_; }
  std::size_t columns() const noexcept { return joints_.size(); }

  /// `q`: all joints of the chain.
  void at(std::span<const double> q) noexcept;
  /// Derivatives of the columns' joints by the path parameter, after at() and move().
  void move(std::span<const double> first) noexcept;
  void move_on(std::span<const double> first, std::span<const double> second) noexcept;

  /// Where at() has put the TCP: its position, and the columns of its rotation.
  const Vec3& position() const noexcept { return position_; }
  const std::array<Vec3, 3>& rotation() const noexcept { return rotation_; }
  /// Column after column, six rows each: linear velocity x y z of the TCP, angular x y z.
  std::span<const double> J() const noexcept { return {J_[0].data(), 6 * columns()}; }
  std::span<const double> dJ() const noexcept { return {J_[1].data(), 6 * columns()}; }
  std::span<const double> ddJ() const noexcept { return {J_[2].data(), 6 * columns()}; }

 private:
  struct Axis {
    std::size_t joint, column;
    bool slides;
    double ratio;
    Vec3 direction, point;     // where all joints are zero
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
