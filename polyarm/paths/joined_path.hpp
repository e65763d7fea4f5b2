#pragma once
/// Parts of other paths, one after the other.
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "polyarm/paths/path.hpp"

namespace polyarm::paths {

/// That the parts fit together is the business of whoever appends them: up to the second derivative where the
/// path is to be passed, in the values alone where it comes to rest. Built anywhere; then const, at()
/// allocates nothing. Shares the paths that it is made of.
class JoinedPath final : public Path {
 public:
  explicit JoinedPath(std::size_t joints) : joints_(joints) {}

  /// The part of `path` between two of its parameters, `to` > `from`. `scale` > 0: the parameter of this path
  /// per unit of that one.
  void append(std::shared_ptr<const Path> path, double from, double to, double scale = 1);
  /// The whole of it.
  void append(std::shared_ptr<const Path> path) {
    const double length = path->length();
    append(std::move(path), 0, length);
  }

  std::size_t joints() const noexcept override { return joints_; }
  double length() const noexcept override { return breaks_.back(); }
  void at(double s, const PathDerivatives& out) const noexcept override;
  /// {0, 0} of a path without parts.
  std::span<const double> breaks() const noexcept override { return breaks_; }

 private:
  struct Part {
    std::shared_ptr<const Path> path;
    double begin;  ///< of this path
    double from, to, scale;
  };
  std::size_t joints_;
  std::vector<Part> parts_;
  std::vector<double> breaks_{0, 0};
};

}  // namespace polyarm::paths
