#pragma once
/// Grippers of the simulation: suction cups and parallel fingers. Metres, N, s. Control thread.
#include "drivers/mujoco/contacts.hpp"
#include "drivers/mujoco/parts.hpp"

namespace polyarm::drivers {

/// Distance along the cup's axis from the lip's centre to the surface of the shape, m (negative inside), if
/// the cup fits on that surface: within the face, and its axis within 20 degrees of the face's normal. `axis`
/// points out of the cup. Infinity if it does not fit. Not for meshes.
double cup_distance(const description::Shape& shape, const Pose& pose, const Vec3& lip,
                    const Vec3& axis) noexcept;
/// The same for the convex pieces of part `i`: along the axis, to the face that the lip's centre meets first.
double cup_distance(const ModelView& view, std::size_t i, const Pose& pose, const Vec3& lip,
                    const Vec3& axis) noexcept;

/// The gripper of one robot: a cup that holds the part it touches while the vacuum is on, or two fingers that
/// hold by friction.
class Gripper {
 public:
  Gripper(const description::Tool* tool, std::size_t robot) : tool_(tool), robot_(robot) {}
  bool suction() const noexcept { return tool_ && tool_->gripper == description::GripperKind::suction; }
  bool parallel() const noexcept { return tool_ && tool_->gripper == description::GripperKind::parallel; }

  void command(double value) noexcept { on_ = value >= 0.5; }
  /// Call it after each step: grips, releases, or loses the part.
  void update(ModelView& view, Parts& parts, ContactReader& contacts, const Vec3& gravity,
              double timestep) noexcept;
  /// Call it before each step: writes the force of the fingers into qfrc_applied.
  void push(const ModelView& view) const noexcept;

  double level() const noexcept { return level_; }
  double width(const ModelView& view) const noexcept;
  int held() const noexcept { return held_; }
  /// What its sensor reports: it holds a part, or the cup is sealed on one that another robot holds.
  bool senses() const noexcept { return held_ >= 0 || touches_; }
  bool moving(const ModelView& view) const noexcept;

 private:
  static constexpr double kLag = 0.05;  // s, of the vacuum
  void take_hold(const ModelView& view, const Pose& tool, Parts& parts, ContactReader& contacts) noexcept;
  void carry(const Pose& tool, Parts& parts, const Vec3& gravity, const Vec3& contact_force,
             double timestep) noexcept;

  const description::Tool* tool_;
  std::size_t robot_;
  bool on_ = false;
  double level_ = 0;
  int held_ = -1;
  Vec3 last_position_, velocity_, acceleration_;  // of the held part, filtered
  bool fresh_ = true;
  bool touches_ = false;
  bool pulled_off_ = false;  // a part was lost: nothing is gripped until the vacuum has been off
};

}  // namespace polyarm::drivers
