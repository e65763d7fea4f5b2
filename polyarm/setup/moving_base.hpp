#pragma once
/// Where a robot's base is that drives.
#include <optional>
#include <string>

#include "polyarm/base/pose.hpp"
#include "polyarm/control/control_loop.hpp"
#include "polyarm/hardware/interface_table.hpp"
#include "polyarm/setup/robots.hpp"
#include "polyarm/wheels/base_controller.hpp"

namespace polyarm::cell {

/// The base of one robot: on wheels, by the odometry of their controller; in physics, by what that knows of a
/// base that stands free; on another robot, where that takes it; else fixed where the cell's file puts it.
/// Poses are those of the robot's root link. Cell thread. The wheels' controller outlives it or is forgotten
/// first.
class MovingBase {
 public:
  /// `wheels` may be null.
  MovingBase(const CellRobot& robot, const hardware::InterfaceTable& table,
             controllers::BaseController* wheels);

  /// It stands on another one, which stays where it is in memory.
  void set_carrier(const MovingBase& carrier) { carrier_ = &carrier; }

  /// Every tick: reads the odometry.
  void look();
  /// Where the odometry has come to stays.
  void forget_wheels() { output_ = nullptr; }

  /// Can it be anywhere but where the cell's file puts it?
  bool moves() const { return carrier_ ? carrier_->moves() : on_wheels() || in_physics(); }
  bool carried() const { return carrier_ != nullptr; }
  bool on_wheels() const { return !odometry_name_.empty(); }
  /// Does physics say where it is?
  bool in_physics() const { return first_state_ >= 0; }
  /// In the world: as physics has it, else by the odometry.
  Pose pose(const control::Snapshot& snapshot) const;
  /// Where the wheels say that it is, in the odometry's frame.
  Pose odometry() const { return odometry_ * inverse(tracked_); }
  /// The odometry's frame in the world: where the base stood at the start, or, where physics knows better,
  /// wherever both agree.
  Pose odometry_frame(const control::Snapshot& snapshot) const;
  /// What the controller calls the frames of its odometry and of the base; empty without wheels.
  const std::string& odometry_name() const { return odometry_name_; }
  const std::string& base_name() const { return base_name_; }

 private:
  std::optional<Pose> known(const control::Snapshot& snapshot) const;

  Pose start_;  ///< in the world
  const MovingBase* carrier_ = nullptr;
  Pose tracked_;          ///< in the root link: the frame that the odometry is of
  Pose odometry_;         ///< of that frame, the newest
  int first_state_ = -1;  ///< of seven; -1: physics does not tell
  controllers::Output* output_ = nullptr;
  std::string odometry_name_, base_name_;
};

}  // namespace polyarm::cell
