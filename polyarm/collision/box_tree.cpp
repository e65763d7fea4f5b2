#include "polyarm/collision/box_tree.hpp"

#include <numeric>

namespace polyarm::collision {

namespace {

constexpr std::size_t kTogether = 4;  // boxes below one node

Bounds joined(const Bounds& a, const Bounds& b) {
  return {{std::min(a.lower.x, b.lower.x), std::min(a.lower.y, b.lower.y), std::min(a.lower.z, b.lower.z)},
          {std::max(a.upper.x, b.upper.x), std::max(a.upper.y, b.upper.y), std::max(a.upper.z, b.upper.z)}};
}
double along(const Vec3& v, int axis) {
  return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

}  // namespace

Bounds bounds_of(const ConvexBody& body) {
  const double grown = body.radius + body.disc;
  Bounds out{{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
  for (const Vec3& p : body.points) {
    out.lower = {std::min(out.lower.x, p.x - grown), std::min(out.lower.y, p.y - grown),
                 std::min(out.lower.z, p.z - grown)};
    out.upper = {std::max(out.upper.x, p.x + grown), std::max(out.upper.y, p.y + grown),
                 std::max(out.upper.z, p.z + grown)};
  }
  return out;
}

BoxTree::BoxTree(std::span<const Bounds> boxes) {
  if (boxes.empty()) return;
  std::vector<std::uint32_t> order(boxes.size());
  std::iota(order.begin(), order.end(), 0u);
  nodes_.reserve(2 * boxes.size());
  build(boxes, order);
}

Bounds BoxTree::build(std::span<const Bounds> boxes, std::span<std::uint32_t> order) {
  const std::size_t at = nodes_.size();
  nodes_.emplace_back();
  Bounds all = boxes[order[0]];
  for (const std::uint32_t i : order) all = joined(all, boxes[i]);
  if (order.size() <= kTogether) {
    for (const std::uint32_t i : order)
      nodes_.push_back({boxes[i], static_cast<std::uint32_t>(nodes_.size() + 1), i});
  } else {
    const Vec3 size = all.upper - all.lower;
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const std::size_t half = order.size() / 2;
    std::nth_element(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(half), order.end(),
                     [&](std::uint32_t a, std::uint32_t b) {
                       const double x = along(boxes[a].lower + boxes[a].upper, axis),
                                    y = along(boxes[b].lower + boxes[b].upper, axis);
                       return x != y ? x < y : a < b;
                     });
    build(boxes, order.first(half));
    build(boxes, order.subspan(half));
  }
  nodes_[at].bounds = all;
  nodes_[at].next = static_cast<std::uint32_t>(nodes_.size());
  return all;
}

}  // namespace polyarm::collision
