#pragma once
/// Partial poses for inverse kinematics: which components of a pose count. Metres, radians. Any thread;
/// nothing allocates.
#include <array>
#include <cstddef>
#include <limits>

namespace polyarm::kinematics {

/// Allowed deviation of the TCP from the target, in the axes of the target itself (`tool`) or of the world.
/// Rows: along x y z, m; about x y z, rad (the rotation vector from the target to the TCP). A row from
/// -infinity to infinity is free. IkTask{} requires the whole pose.
struct IkTask {
  static constexpr double kFree = std::numeric_limits<double>::infinity();
  enum class Frame { tool, world };
  Frame frame = Frame::tool;
  std::array<double, 6> low{}, high{};
  /// The weight of an error in each row, for a compromise between rows.
  std::array<double, 6> weight{1, 1, 1, 1, 1, 1};

  void free(std::size_t row) noexcept { low[row] = -kFree, high[row] = kFree; }
  /// The position of the TCP; the orientation is free.
  static IkTask position_only() noexcept;
  /// The orientation of the TCP; the position is free.
  static IkTask orientation_only() noexcept;
  /// The whole pose except the rotation about the tool's axis `axis` (0 x, 1 y, 2 z).
  static IkTask free_spin(std::size_t axis = 2) noexcept;
  /// The direction of the tool's axis `axis`; the position and the rotation about that axis are free.
  static IkTask axis_only(std::size_t axis = 2) noexcept;
  friend bool operator==(const IkTask&, const IkTask&) = default;
};

/// How redundant joints are used once the pose is reached. `away_from_singularities` moves only as far as the
/// smallest singular value requires; `manipulability` moves as long as it improves.
enum class IkGoal { none, near_seed, mid_range, manipulability, away_from_singularities };

}  // namespace polyarm::kinematics
