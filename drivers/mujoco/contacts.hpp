#pragma once
/// Contacts of the simulation. Metres, N; world frame. Control thread.
#include <array>
#include <vector>

#include "drivers/mujoco/parts.hpp"
#include "polyarm/hardware/world_state.hpp"

namespace polyarm::drivers {

/// Evaluates the contacts of each step: findings, parts to wake, supports, contacts of fingers.
///
/// A finding is a contact of a robot link or tool body (except its gripping surfaces) with anything, or of a
/// held part with anything that it is not being placed on. A held part may rest on a support from below
/// (normal within 45 degrees of vertical, less than 2 mm deep), and may touch what it touched when it was
/// gripped until the two have separated once. Wheels, casters and other supports of a wheeled base may touch
/// the floor. A touching pair counts as one finding until it separates.
class ContactReader {
 public:
  ContactReader(std::size_t robots, std::size_t parts);

  void read(const ModelView& view, Parts& parts, Nanoseconds now, hardware::WorldState& out) noexcept;
  /// Robot `r` now holds another part (or none). The part's present contacts are allowed.
  void forgive(std::size_t robot) noexcept;
  /// The part that both fingers of robot `r` touched in the last step, or -1.
  int between_fingers(std::size_t robot) const noexcept { return gripped_[robot]; }
  /// Sum of the contact forces on the part that the cup of robot `r` holds, in the world, N.
  const Vec3& force_on_held(std::size_t robot) const noexcept { return held_force_[robot]; }

 private:
  static constexpr int kPairs = 256, kForgiven = 16, kClearSteps = 20, kForgiveSteps = 3;
  static constexpr double kPlacingDepth = 2e-3, kPlacingNormal = 0.7071, kWakeSpeed = 2e-3, kWakeDepth = 5e-4;
  struct Pair {
    int a = -1, b = -1;
    std::uint64_t last = 0;
    int finding = -1;   // -1: unused
    double depth = 0;   // in the step `last`
  };
  struct Forgiven {
    int name = -1;
    std::uint64_t last = 0;
  };
  struct Robot {
    std::array<Forgiven, kForgiven> list;
    std::uint64_t since = 0;
  };
  bool is_finding(const Owner& a, const Owner& b, const mjContact& c, const Parts& parts) noexcept;
  bool held_may_touch(std::size_t robot, const Owner& other, const mjContact& c, bool other_second) noexcept;
  void note(const Owner& a, const Owner& b, double depth, const Vec3& at, Nanoseconds now,
            hardware::WorldState& out) noexcept;
  void drop_clear_pairs(hardware::WorldState& out) noexcept;
  static hardware::Contact* finding_of(const Pair& pair, hardware::WorldState& out) noexcept;
  static int add(const hardware::Contact& contact, hardware::WorldState& out) noexcept;
  void wake(const Owner& sleeper, const Owner& other, const mjContact& c, double other_speed,
            Parts& parts) const noexcept;
  void rest(const Owner& part, const Owner& other, const mjContact& c, Parts& parts) const noexcept;
  int name_of(const Owner& owner, const Parts& parts) const noexcept;

  std::array<Pair, kPairs> pairs_;
  std::vector<Robot> robots_;
  std::vector<int> gripped_;
  std::vector<std::array<int, 2>> touched_;  // for each robot: the part at each finger
  std::vector<Vec3> held_force_;
  std::vector<int> part_name_;
  std::uint64_t step_ = 0;
};

}  // namespace polyarm::drivers
