#pragma once
/// The pose of a robot's base, which may move.
#include <optional>
#include <string>

#include "polyarm/base/pose.hpp"
#include "polyarm/control/control_loop.hpp"
#include "polyarm/hardware/interface_table.hpp"
#include "polyarm/setup/robots.hpp"
#include "polyarm/wheels/base_controller.hpp"

namespace polyarm::cell {

/// The base of one robot. On wheels, its pose comes from the odometry of their controller; in physics with a
/// free base, from physics; on another robot, from that robot; otherwise it is fixed where the cell's file
/// places it. Poses are those of the robot's root link. Cell thread. The wheels' controller must outlive this
/// object, or forget_wheels() must be called first.
class MovingBase {
 public:
  /// `wheels` may be null.
  MovingBase(const CellRobot& robot, const hardware::InterfaceTable& table,
             controllers::BaseController* wheels);

  /// Sets the robot that carries this one; its address must not change.
  void set_carrier(const MovingBase& carrier) { carrier_ = &carrier; }

  /// Call each tick: reads the odometry.
  void look();
  /// Keeps the last odometry from now on.
  void forget_wheels() { output_ = nullptr; }

  /// True if the base can move from its place in the cell file.
  bool moves() const { return carrier_ ? carrier_->moves() : on_wheels() || in_physics(); }
  bool carried() const { return carrier_ != nullptr; }
  bool on_wheels() const { return !odometry_name_.empty(); }
  /// True if physics provides the pose.
  bool in_physics() const { return first_state_ >= 0; }
  /// T_world_base: from physics, otherwise from odometry.
  Pose pose(const control::Snapshot& snapshot) const;
  /// The pose from the wheels' odometry, in the odometry frame.
  Pose odometry() const { return odometry_ * inverse(tracked_); }
  /// The frame that the odometry tracks, in the root link.
  const Pose& tracked() const { return tracked_; }
  /// T_world_odometry: the start pose of the tracked frame; if physics provides the pose, the transform that
  /// makes both agree.
  Pose odometry_frame(const control::Snapshot& snapshot) const;
  /// The controller's names of the odometry frame and the base frame; empty without wheels.
  const std::string& odometry_name() const { return odometry_name_; }
  const std::string& base_name() const { return base_name_; }

 private:
  std::optional<Pose> known(const control::Snapshot& snapshot) const;

  Pose start_;  ///< in the world
  const MovingBase* carrier_ = nullptr;
  Pose tracked_;          ///< in the root link: the frame that the odometry tracks
  Pose odometry_;         ///< newest odometry of that frame
  int first_state_ = -1;  ///< first of seven states; -1: not in physics
  controllers::Output* output_ = nullptr;
  std::string odometry_name_, base_name_;
};

}  // namespace polyarm::cell
