#pragma once
/// Joint states to start from that already lead near a pose. Used inside this room only.
///
/// A table of random joint states within limits is made once. What the first joint does to a pose is a turn
/// about its axis, what the last does a turn of the tool about its own: neither changes how far a point of
/// the last axis is from the first axis, how high it is, or how the last axis stands to both. Those few
/// numbers are looked up, and the two joints follow from the pose itself; so a small table is a dense one.
/// Const after construction, any thread; nothing after it allocates.
#include <array>
#include <cstdint>
#include <memory>

#include "polyarm/descent/descent_lanes.hpp"

namespace polyarm::kinematics {

class SeedTable {
 public:
  /// `size` is rounded up to a multiple of 16.
  SeedTable(const DescentArm& arm, std::size_t size);

  /// A target's place in the table's numbers, and how far it has been looked through.
  struct Search {
    std::array<float, FeatureTable::kFeatures> at;
    Vec3 toward, beside;  ///< of the target: the last axis, and what is beside it, as the table sees them
    double turn = 0;      ///< of the target about the first axis, rad
    alignas(64) std::array<float, kNearGroups> beyond;
    NearPoints near;
    std::array<std::uint8_t, kNearGroups> order;  ///< of `near`, the nearer half first, roughly
    std::size_t next = kNearGroups;
    std::size_t rounds = 0;
    std::uint64_t drawn = 0;  ///< random states
  };
  /// `rotation` and `position` (in lengths) of the frame behind the last axis, as in Descents::target; the
  /// position is that of the TCP.
  void begin(const Rotation& rotation, const Vec3& position, Search& search) const noexcept;
  /// The next best state, in the arm's inner units; from the table as long as it has near ones, then random.
  void next(Search& search, double* x) const noexcept;

  std::size_t size() const noexcept { return table_.count; }
  const FeatureTable& places() const noexcept { return table_; }
  /// The table's states are all over these joints' ranges; the first and the last may follow from the pose.
  double value(std::size_t row, std::size_t joint) const noexcept {
    return eight_values(row, joint)[row % kDescents];
  }
  /// Of the eight rows that `row` is one of, whose number is a multiple of eight.
  const double* eight_values(std::size_t row, std::size_t joint) const noexcept {
    return states_ + (row / kDescents * arm_.joints + joint) * kDescents;
  }
  bool first_turns() const noexcept { return first_turns_; }
  bool last_turns() const noexcept { return last_turns_; }
  /// One state of the table, its first and last joint as the search's target has them.
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
  Range range(std::size_t joint) const noexcept;  ///< that states of the table are in
  void advance(Search& search) const noexcept;
  void bring_inside(double* x) const noexcept;

  const DescentArm& arm_;
  bool first_turns_ = false, last_turns_ = false;  ///< so that their part in a pose can be split off
  double first_ratio_ = 1, last_ratio_ = 1;
  std::size_t first_joint_ = 0, last_joint_ = 0;
  Vec3 point_in_end_;  ///< a point of the last axis, from the TCP, as seen behind that axis, whose z it is
  FeatureTable table_;
  /// Each row's state, of its pose the turn about the first axis, and what is beside the last (as EndTable).
  std::unique_ptr<double[]> numbers_;
  const double *states_ = nullptr, *turn_ = nullptr, *beside_ = nullptr;
};

}  // namespace polyarm::kinematics
