#pragma once
/// A path that consists of parts of other paths, one after the other. Joint values in rad or m.
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "polyarm/paths/path.hpp"

namespace polyarm::paths {

/// The caller ensures that the parts fit together: continuous up to the second derivative where the path does
/// not stop, equal values where it stops. Built on any thread; then const, and at() allocates nothing. Shares
/// ownership of its paths.
class JoinedPath final : public Path {
 public:
  explicit JoinedPath(std::size_t joints) : joints_(joints) {}

  /// Appends the part of `path` between two of its parameters, `to` > `from`. `scale` > 0: this path's
  /// parameter per unit of the other's.
  void append(std::shared_ptr<const Path> path, double from, double to, double scale = 1);
  /// Appends the whole path.
  void append(std::shared_ptr<const Path> path) {
    const double length = path->length();
    append(std::move(path), 0, length);
  }

  std::size_t joints() const noexcept override { return joints_; }
  double length() const noexcept override { return breaks_.back(); }
  void at(double s, const PathDerivatives& out) const noexcept override;
  /// {0, 0} for a path without parts.
  std::span<const double> breaks() const noexcept override { return breaks_; }

 private:
  struct Part {
    std::shared_ptr<const Path> path;
    double begin;  ///< in this path's parameter
    double from, to, scale;
  };
  std::size_t joints_;
  std::vector<Part> parts_;
  std::vector<double> breaks_{0, 0};
};

}  // namespace polyarm::paths
