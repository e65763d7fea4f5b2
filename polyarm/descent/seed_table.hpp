#pragma once
/// Start states for descents that already end near a pose. Private to the rooms descent and ik.
///
/// The constructor makes a table of random joint states within limits. The first joint rotates a pose about
/// its axis, and the last rotates the tool about its own axis: neither changes the distance of a point of the
/// last axis from the first axis, its height, or the angles of the last axis to both. The table is searched
/// by these few numbers, and the pose itself determines the two joints; so a small table is dense. Const
/// after construction: any thread; then nothing allocates.
#include <array>
#include <cstdint>
#include <memory>

#include "polyarm/descent/descent_lanes.hpp"

namespace polyarm::kinematics {

class SeedTable {
 public:
  /// `size` is rounded up to a multiple of 16.
  SeedTable(const DescentArm& arm, std::size_t size);

  /// A target in the table's numbers, and the state of the search.
  struct Search {
    std::array<float, FeatureTable::kFeatures> at;
    Vec3 toward, beside;  ///< of the target: the last axis and its perpendicular, in the table's view
    double turn = 0;      ///< of the target about the first axis, rad
    alignas(64) std::array<float, kNearGroups> beyond;
    NearPoints near;
    std::array<std::uint8_t, kNearGroups> order;  ///< of `near`, roughly the nearer half first
    std::size_t next = kNearGroups;
    std::size_t rounds = 0;
    std::uint64_t drawn = 0;  ///< number of random states drawn
  };
  /// `rotation` and `position` (in lengths) of the frame behind the last axis, as in Descents::target; the
  /// position is that of the TCP.
  void begin(const Rotation& rotation, const Vec3& position, Search& search) const noexcept;
  /// The next best state, in the arm's internal units: from the table while it has near ones, then random.
  void next(Search& search, double* x) const noexcept;

  std::size_t size() const noexcept { return table_.count; }
  const FeatureTable& places() const noexcept { return table_; }
  /// A value of the table. Its states cover the whole range of each joint; the pose may determine the first
  /// and the last.
  double value(std::size_t row, std::size_t joint) const noexcept {
    return eight_values(row, joint)[row % kDescents];
  }
  /// The values of the eight rows that contain `row`, starting at a multiple of eight.
  const double* eight_values(std::size_t row, std::size_t joint) const noexcept {
    return states_ + (row / kDescents * arm_.joints + joint) * kDescents;
  }
  bool first_turns() const noexcept { return first_turns_; }
  bool last_turns() const noexcept { return last_turns_; }
  /// One state of the table; the search's target determines its first and last joint.
  void read(const Search& search, std::size_t row, double* x) const noexcept;

 private:
  struct Place {
    Vec3 point, toward, beside;
    double turn = 0;
  };
  Place place(const Rotation& rotation, const Vec3& position) const noexcept;
  void find_symmetry();
  void fill(std::size_t size);
  std::array<float, FeatureTable::kFeatures> features(const Place& place) const noexcept;
  struct Range {
    double low = 0, width = 0;
  };
  Range range(std::size_t joint) const noexcept;  ///< of the table's states
  void advance(Search& search) const noexcept;
  void move_inside(double* x) const noexcept;

  const DescentArm& arm_;
  bool first_turns_ = false, last_turns_ = false;  ///< so their part in a pose can be separated
  double first_ratio_ = 1, last_ratio_ = 1;
  std::size_t first_joint_ = 0, last_joint_ = 0;
  Vec3 point_in_end_;  ///< a point of the last axis, relative to the TCP, in the frame behind that axis,
                       ///< whose z it is
  FeatureTable table_;
  /// For each row its state, the rotation about the first axis, and the perpendicular of the last axis (as
  /// EndTable).
  std::unique_ptr<double[]> numbers_;
  const double *states_ = nullptr, *turn_ = nullptr, *beside_ = nullptr;
};

}  // namespace polyarm::kinematics
