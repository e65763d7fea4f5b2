#pragma once
/// A tree over many boxes that are aligned with the axes, for what has thousands of pieces. Built once; const
/// functions: any thread, no allocation. Metres.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "polyarm/base/pose.hpp"
#include "polyarm/collision/convex_body.hpp"

namespace polyarm::collision {

struct Bounds {
  Vec3 lower, upper;
};

Bounds bounds_of(const ConvexBody& body);

class BoxTree {
 public:
  static constexpr std::uint32_t kInner = UINT32_MAX;
  /// In depth-first order: what is below a node follows it.
  struct Node {
    Bounds bounds;
    std::uint32_t next = 0;       ///< the node after everything below this one
    std::uint32_t leaf = kInner;  ///< index of the box
  };

  BoxTree() = default;
  explicit BoxTree(std::span<const Bounds> boxes);

  bool empty() const noexcept { return nodes_.empty(); }
  const std::vector<Node>& nodes() const noexcept { return nodes_; }

  /// Calls take(index) for each box that is nearer to `point` than range(), which may shrink meanwhile.
  template <typename Range, typename Take>
  void each_near(const Vec3& point, const Range& range, const Take& take) const {
    for (std::uint32_t i = 0; i < nodes_.size();) {
      const Node& node = nodes_[i];
      if (distance(point, node.bounds) > range()) {
        i = node.next;
        continue;
      }
      if (node.leaf != kInner) take(node.leaf);
      ++i;
    }
  }
  static double distance(const Vec3& point, const Bounds& b) noexcept {
    const auto out = [](double v, double low, double high) { return std::max({low - v, v - high, 0.0}); };
    return std::hypot(out(point.x, b.lower.x, b.upper.x), out(point.y, b.lower.y, b.upper.y),
                      out(point.z, b.lower.z, b.upper.z));
  }

 private:
  Bounds build(std::span<const Bounds> boxes, std::span<std::uint32_t> order);
  std::vector<Node> nodes_;
};

}  // namespace polyarm::collision
