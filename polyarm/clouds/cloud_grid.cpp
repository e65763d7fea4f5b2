#include "polyarm/clouds/cloud_grid.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "polyarm/base/bounds.hpp"

namespace polyarm::clouds {

namespace {

constexpr double kSmallestCell = 1e-3;
constexpr std::size_t kFirstSlots = 1 << 12, kMostCells = bounds::kCloudCells;

std::array<std::int64_t, 3> indices_of(std::uint64_t key) {
  constexpr std::uint64_t kMask = (std::uint64_t{1} << CloudGrid::kBits) - 1;
  const auto index = [&](int axis) {
    return static_cast<std::int64_t>((key >> (axis * CloudGrid::kBits)) & kMask) - CloudGrid::kMiddle;
  };
  return {index(0), index(1), index(2)};
}
std::size_t mix(std::uint64_t key) {
  key *= 0x9E3779B97F4A7C15u;
  return static_cast<std::size_t>(key ^ (key >> 32));
}

/// Cells in a row, then rows side by side, then layers.
struct Block {
  std::array<std::int64_t, 3> first, last;
  float lower[3], upper[3];

  void join(const Block& other, int axis) {
    last[static_cast<std::size_t>(axis)] = other.last[static_cast<std::size_t>(axis)];
    for (int k = 0; k < 3; ++k) {
      lower[k] = std::min(lower[k], other.lower[k]);
      upper[k] = std::max(upper[k], other.upper[k]);
    }
  }
};

/// Joins blocks that are neighbours along `axis` and equal across it.
void join_along(int axis, std::vector<Block>& blocks) {
  const auto a = static_cast<std::size_t>(axis), b = (a + 1) % 3, c = (a + 2) % 3;
  const auto across = [&](const Block& x) {
    return std::array{x.first[b], x.last[b], x.first[c], x.last[c]};
  };
  std::sort(blocks.begin(), blocks.end(), [&](const Block& x, const Block& y) {
    return std::pair(across(x), x.first[a]) < std::pair(across(y), y.first[a]);
  });
  std::size_t kept = 0;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (kept > 0 && across(blocks[kept - 1]) == across(blocks[i]) &&
        blocks[kept - 1].last[a] + 1 == blocks[i].first[a])
      blocks[kept - 1].join(blocks[i], axis);
    else
      blocks[kept++] = blocks[i];
  }
  blocks.resize(kept);
}

}  // namespace

CloudGrid::CloudGrid(double cell)
    : cell_(std::isfinite(cell) ? std::max(cell, kSmallestCell) : kSmallestCell), per_cell_(1 / cell_) {
  keys_.assign(kFirstSlots, 0);
  extents_.resize(kFirstSlots);
}

std::size_t CloudGrid::find(std::uint64_t key) {
  const std::size_t mask = keys_.size() - 1;
  std::size_t slot = mix(key) & mask;
  while (keys_[slot] != 0 && keys_[slot] != key) slot = (slot + 1) & mask;
  return slot;
}

void CloudGrid::put(std::uint64_t key, const Extent& extent) {
  const std::size_t slot = find(key);
  Extent& own = extents_[slot];
  if (keys_[slot] == 0) {
    keys_[slot] = key;
    own = extent;
    ++cells_;
    return;
  }
  for (int k = 0; k < 3; ++k) {
    own.lower[k] = std::min(own.lower[k], extent.lower[k]);
    own.upper[k] = std::max(own.upper[k], extent.upper[k]);
  }
}

void CloudGrid::add_to(std::uint64_t key, const float (&p)[3]) {
  const std::size_t slot = find(key);
  if (keys_[slot] != 0) {
    last_key_ = key;
    last_ = &extents_[slot];
    return last_->include(p);
  }
  put(key, {{p[0], p[1], p[2]}, {p[0], p[1], p[2]}});
  last_key_ = 0;
  if (cells_ > kMostCells)
    coarsen();
  else if (2 * cells_ > keys_.size())
    grow();
}

void CloudGrid::grow() {
  std::vector<std::uint64_t> keys(2 * keys_.size(), 0);
  std::vector<Extent> extents(keys.size());
  keys_.swap(keys);
  extents_.swap(extents);
  cells_ = 0;
  last_key_ = 0;
  for (std::size_t i = 0; i < keys.size(); ++i)
    if (keys[i] != 0) put(keys[i], extents[i]);
}

void CloudGrid::coarsen() {
  std::vector<std::uint64_t> keys(keys_.size(), 0);
  std::vector<Extent> extents(extents_.size());
  keys_.swap(keys);
  extents_.swap(extents);
  cells_ = 0;
  last_key_ = 0;
  cell_ *= 2;
  per_cell_ = 1 / cell_;
  for (std::size_t i = 0; i < keys.size(); ++i)
    if (keys[i] != 0) {
      const std::array<std::int64_t, 3> index = indices_of(keys[i]);
      put(key_of(index[0] >> 1, index[1] >> 1, index[2] >> 1), extents[i]);
    }
}

Cloud CloudGrid::boxes(double radius, std::size_t most) {
  std::vector<Block> blocks;
  std::vector<std::pair<std::uint64_t, std::uint32_t>> cells;  // by key: along x first
  for (;; coarsen()) {
    blocks.clear();
    cells.clear();
    for (std::size_t i = 0; i < keys_.size(); ++i)
      if (keys_[i] != 0) cells.emplace_back(keys_[i], static_cast<std::uint32_t>(i));
    std::sort(cells.begin(), cells.end());
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const Extent& own = extents_[cells[i].second];
      Block block;
      block.first = block.last = indices_of(cells[i].first);
      for (int k = 0; k < 3; ++k) block.lower[k] = own.lower[k], block.upper[k] = own.upper[k];
      if (i > 0 && cells[i - 1].first + 1 == cells[i].first)
        blocks.back().join(block, 0);
      else
        blocks.push_back(block);
    }
    for (const int axis : {1, 2}) join_along(axis, blocks);
    if (blocks.size() <= std::max<std::size_t>(most, 8)) break;
  }
  Cloud out;
  out.points = points_, out.dropped = dropped_, out.cell = cell_;
  for (const Block& b : blocks)
    out.boxes.push_back({{b.lower[0] - radius, b.lower[1] - radius, b.lower[2] - radius},
                         {b.upper[0] + radius, b.upper[1] + radius, b.upper[2] + radius}});
  return out;
}

}  // namespace polyarm::clouds
