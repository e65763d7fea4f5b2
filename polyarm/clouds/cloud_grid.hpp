#pragma once
/// Point clouds as bodies: points are gathered in cubic cells, and neighbouring cells are joined to boxes
/// that contain every point. Metres, in the frame of the cloud. One thread.
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/pose.hpp"

namespace polyarm::clouds {

/// Larger clouds and files are refused; a body with more boxes gets coarser cells.
inline constexpr std::size_t kMostPoints = bounds::kCloudPoints, kMostBoxes = bounds::kCloudBoxes,
                             kMostBytes = bounds::kCloudBytes;
/// Points farther from the origin than this are left out, m.
inline constexpr double kFarthest = bounds::kCloudMetres;

struct CloudBox {
  Vec3 lower, upper;
};

/// The body of a cloud. Every point, with a ball of the radius around it, is in a box; every place of a box
/// is nearer than sqrt(3) * (cell + radius) to a point.
struct Cloud {
  std::vector<CloudBox> boxes;
  std::size_t points = 0;   ///< that count
  std::size_t dropped = 0;  ///< with NaN, infinity, or farther away than kFarthest
  double cell = 0;          ///< edge of the cells, m
};

class CloudGrid {
 public:
  /// `cell`: edge of a cell, m, at least 1 mm; it doubles whenever the cloud fills more cells than the grid
  /// holds.
  explicit CloudGrid(double cell);
  CloudGrid(const CloudGrid&) = delete;
  CloudGrid& operator=(const CloudGrid&) = delete;
  void add(double x, double y, double z) {
    // False for NaN, too.
    if (!(std::abs(x) <= kFarthest && std::abs(y) <= kFarthest && std::abs(z) <= kFarthest)) {
      ++dropped_;
      return;
    }
    ++points_;
    const std::uint64_t key =
        key_of(floor_of(x * per_cell_), floor_of(y * per_cell_), floor_of(z * per_cell_));
    const float p[3] = {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)};
    if (key == last_key_)
      last_->include(p);
    else
      add_to(key, p);
  }
  std::size_t points() const { return points_; }
  std::size_t dropped() const { return dropped_; }
  /// The boxes, each grown by `radius` on all sides; at most `most`: cells double until so few are left.
  Cloud boxes(double radius, std::size_t most = kMostBoxes);

  /// A key has three indices of so many bits each, shifted to be positive; x is the lowest.
  static constexpr int kBits = 21;
  static constexpr std::int64_t kMiddle = std::int64_t{1} << (kBits - 1);
  static std::uint64_t key_of(std::int64_t x, std::int64_t y, std::int64_t z) {
    const auto part = [](std::int64_t index) { return static_cast<std::uint64_t>(index + kMiddle); };
    return part(z) << (2 * kBits) | part(y) << kBits | part(x);
  }

 private:
  struct Extent {
    float lower[3], upper[3];
    void include(const float (&p)[3]) {
      for (int k = 0; k < 3; ++k) {
        lower[k] = p[k] < lower[k] ? p[k] : lower[k];
        upper[k] = p[k] > upper[k] ? p[k] : upper[k];
      }
    }
  };
  struct Slot {
    std::uint64_t key = 0;  // 0: empty
    Extent extent = {};
  };
  static std::int64_t floor_of(double value) {
    const auto whole = static_cast<std::int64_t>(value);
    return whole - (static_cast<double>(whole) > value);
  }
  void add_to(std::uint64_t key, const float (&p)[3]);
  Slot& find(std::uint64_t key);
  void put(std::uint64_t key, const Extent& extent);
  void put_waiting();
  void grow();
  void coarsen();

  double cell_, per_cell_;
  std::vector<Slot> slots_;
  std::size_t cells_ = 0, points_ = 0, dropped_ = 0;
  // The last points wait here until there are enough of them: meanwhile the processor fetches their slots.
  std::array<Slot, 32> waiting_;
  std::size_t waiting_count_ = 0;
  std::uint64_t last_key_ = 0;  // of `last_`; 0: none
  Extent* last_ = nullptr;      // in `waiting_`
};

}  // namespace polyarm::clouds
