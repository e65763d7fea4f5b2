#pragma once
/// The motion of the TCP while the joints follow a path; bounds of its speed, acceleration and jerk refer to
/// it. Metres, radians, world axes.
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "polyarm/kinematics/chain.hpp"
#include "polyarm/paths/path.hpp"
#include "polyarm/paths/pose_piece.hpp"

namespace polyarm::moves {

/// Computes the TCP's derivatives from those of the joints. Const after construction: any thread, no
/// allocation.
class TcpRates {
 public:
  explicit TcpRates(const kinematics::Chain& chain);
  std::size_t joints() const noexcept { return joints_; }
  /// All spans have joints() values: joint values, and derivatives with respect to any one parameter.
  paths::PoseDerivatives at(std::span<const double> q, std::span<const double> first,
                            std::span<const double> second, std::span<const double> third) const noexcept;

 private:
  std::size_t joints_;
  std::vector<kinematics::Chain::Axis> axes_;
  Pose zero_;  // of the TCP, at zero joint values
};

enum class TcpPart { translation, rotation };

/// The TCP's way as a path of three values over the parameter of the joints' path. translation: its position,
/// m. rotation: `first` is the angular velocity with respect to the parameter, `second` and `third` its
/// derivatives; q is 0, because no orientation value has these derivatives. Const after construction: any
/// thread, no allocation in at().
class TcpPath final : public paths::Path {
 public:
  /// `joints`: a path of chain.joints() values, at most Chain::kMaxJoints.
  TcpPath(const kinematics::Chain& chain, std::shared_ptr<const paths::Path> joints, TcpPart part);
  std::size_t joints() const noexcept override { return 3; }
  double length() const noexcept override { return path_->length(); }
  void at(double s, const paths::PathDerivatives& out) const noexcept override;
  std::span<const double> breaks() const noexcept override { return path_->breaks(); }

 private:
  TcpRates rates_;
  std::shared_ptr<const paths::Path> path_;
  TcpPart part_;
};

}  // namespace polyarm::moves
