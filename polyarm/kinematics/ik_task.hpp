#pragma once
/// Parts of a pose, for inverse kinematics that does not need all of it. Metres, radians.
#include <array>
#include <cstddef>
#include <limits>

namespace polyarm::kinematics {

/// What of a pose is asked for: how far the TCP may be from the target, along and about the axes of the
/// target itself (`tool`) or of the world. Rows: along x y z, m; about x y z, rad (the rotation vector from
/// the target to the TCP). A row from -infinity to infinity is free. IkTask{} is the whole pose.
struct IkTask {
  static constexpr double kFree = std::numeric_limits<double>::infinity();
  enum class Frame { tool, world };
  Frame frame = Frame::tool;
  std::array<double, 6> low{}, high{};
  /// What an error in a row counts where rows are traded against each other.
  std::array<double, 6> weight{1, 1, 1, 1, 1, 1};

  void free(std::size_t row) noexcept { low[row] = -kFree, high[row] = kFree; }
  /// The TCP's place, however it is turned.
  static IkTask position_only() noexcept;
  /// The orientation, wherever.
  static IkTask orientation_only() noexcept;
  /// The whole pose but for a turn about the tool's axis `axis` (0 x, 1 y, 2 z).
  static IkTask free_spin(std::size_t axis = 2) noexcept;
  /// Where the tool's axis points, wherever it is and however it is turned about that axis.
  static IkTask axis_only(std::size_t axis = 2) noexcept;
  friend bool operator==(const IkTask&, const IkTask&) = default;
};

/// What an arm does with joints to spare, once the pose is reached. `away_from_singularities` moves only as
/// far as the smallest singular value requires, `manipulability` as far as it helps.
enum class IkGoal { none, near_seed, mid_range, manipulability, away_from_singularities };

}  // namespace polyarm::kinematics
