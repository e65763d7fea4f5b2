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
/// The cell twice as large that contains the cell.
std::uint64_t coarser(std::uint64_t key) {
  const std::array<std::int64_t, 3> index = indices_of(key);
  return CloudGrid::key_of(index[0] >> 1, index[1] >> 1, index[2] >> 1);
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
  slots_.resize(kFirstSlots);
}

CloudGrid::Slot& CloudGrid::find(std::uint64_t key) {
  const std::size_t mask = slots_.size() - 1;
  std::size_t slot = mix(key) & mask;
  while (slots_[slot].key != 0 && slots_[slot].key != key) slot = (slot + 1) & mask;
  return slots_[slot];
}

void CloudGrid::put(std::uint64_t key, const Extent& extent) {
  Slot& slot = find(key);
  if (slot.key == 0) {
    slot = {key, extent};
    ++cells_;
    return;
  }
  slot.extent.include(extent.lower);
  slot.extent.include(extent.upper);
}

void CloudGrid::add_to(std::uint64_t key, const float (&p)[3]) {
  Slot& slot = waiting_[waiting_count_++];
  slot = {key, {{p[0], p[1], p[2]}, {p[0], p[1], p[2]}}};
  last_key_ = key;
  last_ = &slot.extent;
  __builtin_prefetch(&slots_[mix(key) & (slots_.size() - 1)], 1);
  if (waiting_count_ == waiting_.size()) put_waiting();
}

void CloudGrid::put_waiting() {
  const std::size_t count = std::exchange(waiting_count_, 0);
  last_key_ = 0;
  for (std::size_t i = 0; i < count; ++i) {
    put(waiting_[i].key, waiting_[i].extent);
    if (cells_ > kMostCells) {
      coarsen();
      for (std::size_t k = i + 1; k < count; ++k) waiting_[k].key = coarser(waiting_[k].key);
    } else if (2 * cells_ > slots_.size()) {
      grow();
    }
  }
}

void CloudGrid::grow() {
  std::vector<Slot> before(2 * slots_.size());
  before.swap(slots_);
  cells_ = 0;
  for (const Slot& slot : before)
    if (slot.key != 0) put(slot.key, slot.extent);
}

void CloudGrid::coarsen() {
  std::vector<Slot> before(slots_.size());
  before.swap(slots_);
  cells_ = 0;
  cell_ *= 2;
  per_cell_ = 1 / cell_;
  for (const Slot& slot : before)
    if (slot.key != 0) put(coarser(slot.key), slot.extent);
}

Cloud CloudGrid::boxes(double radius, std::size_t most) {
  put_waiting();
  std::vector<Block> blocks;
  std::vector<std::pair<std::uint64_t, std::uint32_t>> cells;  // by key: along x first
  for (;; coarsen()) {
    blocks.clear();
    cells.clear();
    for (std::size_t i = 0; i < slots_.size(); ++i)
      if (slots_[i].key != 0) cells.emplace_back(slots_[i].key, static_cast<std::uint32_t>(i));
    std::sort(cells.begin(), cells.end());
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const Extent& own = slots_[cells[i].second].extent;
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
