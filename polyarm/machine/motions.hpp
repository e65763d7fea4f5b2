#pragma once
/// The planned motion of each arm and base of a cell, and the cell's speed limits.
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "polyarm/jog/jog_controller.hpp"
#include "polyarm/joint_control/joint_trajectory_controller.hpp"
#include "polyarm/machine/arming.hpp"
#include "polyarm/machine/around.hpp"
#include "polyarm/machine/contact_watch.hpp"
#include "polyarm/machine/machine.hpp"
#include "polyarm/moves/base_motion.hpp"
#include "polyarm/moves/robot_motion.hpp"
#include "polyarm/setup/moving_base.hpp"

namespace polyarm::cell {

/// Robots are identified by their index in the cell's file. Cell thread.
class Motions {
 public:
  Motions(const CellSetup& setup, Machine& machine, Arming& arming, const ContactWatch& contacts,
          Observer& observer);

  /// Call after the controllers are made. Planning runs on `planner`.
  void build(Worker& planner);

  /// Returns the program line of a move, for warnings.
  using PlaceOf = std::function<Location(const moves::RobotMotion& motion, std::uint64_t move)>;
  /// Call each tick before the programs, for moves that have arrived, and after them, for new moves.
  void tick(const PlaceOf& place_of);
  /// A robot that another client moved begins its next move at its present position.
  void follow_others();
  void update_bases();

  /// Null if no trajectory controller moves all joints of the robot.
  moves::RobotMotion* motion(std::size_t robot) const { return motions_[robot].get(); }
  /// The robot's own controller, if it interpolates (`motion: forward`); null otherwise.
  hardware::ForwardMoves* forward_moves(std::size_t robot) const;
  /// A trajectory of points that moves a robot, as other programs send them. Valid in this tick.
  struct Points {
    const controllers::TrajectoryGoal* goal;
    const controllers::JointTrajectoryController* controller;
    double time;  ///< s into it
  };
  /// Empty if none does, or several at once move parts of the robot.
  std::optional<Points> points(std::size_t robot) const;
  /// Null if the robot has no driven wheels.
  moves::BaseMotion* wheels(std::size_t robot) const { return bases_[robot].get(); }
  /// The pose of the robot's base.
  const MovingBase& base(std::size_t robot) const { return places_[robot]; }
  /// True if a program can move anything.
  bool any() const;
  /// True if no move of a program is queued, planned or running.
  bool idle(std::size_t robot) const { return !motions_[robot] || motions_[robot]->idle(); }
  bool all_idle() const;
  /// True if a resume would continue a motion: one of a program, or one that was sent to a controller.
  bool motion_left() const;
  /// T_world_tcp, computed as if the robot's base stood at its pose from the cell's file.
  Pose tcp(std::size_t robot) const;
  /// The positions of all TCPs, by robot; valid until the next call.
  std::span<const Vec3> tcps() const;

  /// Where everything is now: joints as commanded, parts as a simulation tells.
  surroundings::Moment moment() const;
  /// The same into a moment that keeps its memory from call to call.
  void moment(surroundings::Moment& out) const;
  /// Robots and scene as contacts see them; made at the first use.
  const std::shared_ptr<SharedBodies>& bodies() const { return bodies_; }
  /// What is around a robot at a moment, for its moves.
  std::shared_ptr<moves::Obstacles> obstacles(std::size_t robot, surroundings::Moment moment) const;

  /// Moves end on their paths.
  void end();
  /// Discards all planned moves.
  void drop();
  /// Discards the remaining motion of bases; they stay where they are.
  void drop_bases();
  /// Call when a person has armed the cell: moves begin at the robots' present positions.
  void begin_where_robots_are();

  /// The limits profile that holds: "reduced" or "full".
  const std::string& profile() const { return profile_; }
  /// The profile that somebody asks for. Throws Error("unknown-profile").
  void set_profile(const std::string& name);
  /// `reduced`: the reduced profile holds, whatever was asked for.
  void set_reduced(bool reduced);
  /// Present limits of jogging: those of the profile, reduced speed if arming requires it, slow during a
  /// contact.
  jog::JogLimits jog_limits() const;
  /// Limits of the profile for planned moves; none in the first pass of real hardware, whose speed is
  /// governed instead.
  moves::MovePlanOptions plan_options() const;
  /// True if there is at least one planned move and all were planned with the present limits.
  bool planned_as_now() const;
  /// True while the program runs through for the first time on real hardware, at reduced speed.
  bool first_pass() const { return arming_.first_pass(); }

  /// Cycle in which the first motion was commanded, if any.
  std::optional<std::uint64_t> first_motion_cycle() const;
  /// True if moves go through this controller.
  bool use(const controllers::Controller& controller) const;
  /// Call when the controller is unloaded: robots that move through it can no longer be moved. `forget` is
  /// called with their motions.
  void release(const controllers::Controller& controller,
               const std::function<void(moves::RobotMotion&)>& forget,
               const std::function<void(moves::BaseMotion&)>& forget_base);

 private:
  const ProfileEntry& limits() const;
  void choose_profile();
  void note_forward(std::size_t robot);
  AroundOptions around_options() const;
  void look_around(std::size_t robot, Worker& planner);
  /// Sets where the next motion of a joint begins, for each joint with a finite value in `values`. `index`
  /// selects the joint's index in `values`.
  void set_planned(std::size_t robot, int JointPlaces::Place::*index, std::span<const double> values);

  const CellSetup& setup_;
  Machine& machine_;
  Arming& arming_;
  const ContactWatch& contacts_;
  Observer& observer_;
  std::vector<std::unique_ptr<moves::RobotMotion>> motions_;
  std::vector<std::unique_ptr<moves::BaseMotion>> bases_;
  std::vector<MovingBase> places_;
  mutable std::vector<Vec3> tcps_;  // the answer of tcps(), which is called each tick
  std::vector<int> components_;  // of the robots' position commands; -1: none
  std::vector<int> movers_;  // index of the state of each mover of the scene; -1: none
  std::shared_ptr<SharedBodies> bodies_;
  std::vector<controllers::JointTrajectoryController*> followers_;
  std::set<std::string> reported_;  // warnings of moves, reported once even in a loop
  std::string asked_ = "full", profile_ = "full";
  bool reduced_ = false;
};

}  // namespace polyarm::cell
