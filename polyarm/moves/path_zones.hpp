#pragma once
/// Bounds that apply only to parts of a path, as paths whose norms are bounded by 1 everywhere, for
/// timing::NormLimit. Const after construction: any thread; at() allocates nothing.
#include <cstddef>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "polyarm/moves/tcp_rates.hpp"
#include "polyarm/paths/cartesian_path.hpp"
#include "polyarm/paths/path.hpp"
#include "polyarm/timing/timing.hpp"

namespace polyarm::moves {

/// Between `from` and `to` (path parameter, both included) a bound has the weight `weight`: one over the
/// limit, 0 for unlimited.
struct Zone {
  double from = 0, to = 0, weight = 0;
};

/// The derivatives of `path` times the weight of the place; where zones meet, the highest of their weights.
/// Places without a zone have the weight 0. Zones are in ascending order.
class WeightedPath final : public paths::Path {
 public:
  WeightedPath(std::shared_ptr<const paths::Path> path, std::vector<Zone> zones);
  std::size_t joints() const noexcept override { return path_->joints(); }
  double length() const noexcept override { return path_->length(); }
  void at(double s, const paths::PathDerivatives& out) const noexcept override;
  std::span<const double> breaks() const noexcept override { return path_->breaks(); }

 private:
  double weight(double s) const noexcept;

  std::shared_ptr<const paths::Path> path_;
  std::vector<Zone> zones_;
};

/// The path parameter itself as a path of one value: bounds the parameter's speed.
class ParameterPath final : public paths::Path {
 public:
  explicit ParameterPath(std::shared_ptr<const paths::Path> path) : path_(std::move(path)) {}
  std::size_t joints() const noexcept override { return 1; }
  double length() const noexcept override { return path_->length(); }
  void at(double s, const paths::PathDerivatives& out) const noexcept override;
  std::span<const double> breaks() const noexcept override { return path_->breaks(); }

 private:
  std::shared_ptr<const paths::Path> path_;
};

/// A path of the TCP as a path of three values: its position, m; or its angular velocity with respect to the
/// parameter and the derivatives of the angular velocity (`q` is then 0).
class PosePath final : public paths::Path {
 public:
  PosePath(std::shared_ptr<const paths::CartesianPath> path, TcpPart part)
      : path_(std::move(path)), part_(part) {}
  std::size_t joints() const noexcept override { return 3; }
  double length() const noexcept override { return path_->length(); }
  void at(double s, const paths::PathDerivatives& out) const noexcept override;
  std::span<const double> breaks() const noexcept override { return path_->breaks(); }

 private:
  std::shared_ptr<const paths::CartesianPath> path_;
  TcpPart part_;
};

/// The bounds of one quantity along the whole path, zone by zone.
struct ZoneLimits {
  std::vector<Zone> speed, acceleration;
  double jerk = std::numeric_limits<double>::infinity();  ///< per unit of acceleration
  /// Infinite: no bound. Add zones in ascending order.
  void add(double from, double to, double most_speed, double most_acceleration, double most_jerk);
};

/// Zone limits in the form that the timing takes; owns the paths that the norms refer to.
class ZoneNorms {
 public:
  void add(const std::shared_ptr<const paths::Path>& path, const ZoneLimits& limits, const std::string& name);
  std::span<const timing::NormLimit> list() const { return norms_; }

 private:
  void put(std::shared_ptr<const paths::Path> path, double speed, double acceleration, double jerk,
           const std::string& name);

  std::vector<std::shared_ptr<const paths::Path>> paths_;
  std::vector<timing::NormLimit> norms_;
};

}  // namespace polyarm::moves
