#pragma once
/// How the robots of a cell move: the planned motion of each arm and base, and the speeds that they keep to.
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

/// Robots are told apart by their index in the cell's file. Cell thread.
class Motions {
 public:
  Motions(const CellSetup& setup, Machine& machine, Arming& arming, const ContactWatch& contacts,
          Observer& observer);

  /// After the controllers are made. Planning runs on `planner`.
  void build(Worker& planner);

  /// Where a move of the program comes from, for warnings.
  using PlaceOf = std::function<Location(const moves::RobotMotion& motion, std::uint64_t move)>;
  /// Once before the programs, for what has arrived, and once after them, for what they want next.
  void tick(const PlaceOf& place_of);
  /// A robot that others moved begins its next move where it is now.
  void follow_others();
  void look_at_bases();

  /// Null where no trajectory controller moves all joints of the robot.
  moves::RobotMotion* motion(std::size_t robot) const { return motions_[robot].get(); }
  /// Null where the robot has no wheels to drive.
  moves::BaseMotion* wheels(std::size_t robot) const { return bases_[robot].get(); }
  /// Where the robot's base is.
  const MovingBase& base(std::size_t robot) const { return places_[robot]; }
  /// Something can be moved by a program.
  bool any() const;
  /// No move of a program's is queued, planned or under way.
  bool idle(std::size_t robot) const { return !motions_[robot] || motions_[robot]->idle(); }
  bool all_idle() const;
  /// Something is left of a motion that a resume goes on with: a program's, or one that was sent to a
  /// controller.
  bool motion_left() const;
  /// Where the TCP is, in the world, as if the robot's base stood where the cell's file puts it.
  Pose tcp(std::size_t robot) const;
  std::vector<Vec3> tcps() const;

  /// Where everything is now: joints as commanded, parts as a simulation tells.
  surroundings::Moment moment() const;
  /// Robots and scene as contacts see them; made at the first use.
  const std::shared_ptr<SharedBodies>& bodies() const { return bodies_; }
  /// What is around a robot at a moment, for its moves.
  std::shared_ptr<moves::Obstacles> obstacles(std::size_t robot, surroundings::Moment moment) const;

  /// Moves end on their paths.
  void end();
  /// What is planned is forgotten.
  void drop();
  /// Forgets what bases have left to go, where they stand.
  void drop_bases();
  /// A person has armed the cell: moves begin where the robots are.
  void begin_where_robots_are();

  /// The limits profile, "reduced" or "full". Throws Error("unknown-profile").
  const std::string& profile() const { return profile_; }
  void set_profile(const std::string& name);
  /// Limits of motion by hand now: the profile's, reduced speed where arming says so, slow out of a contact.
  jog::JogLimits jog_limits() const;
  /// What the profile bounds planned moves by; nothing in the first pass of real hardware, which is governed.
  moves::MovePlanOptions plan_options() const;
  /// Planned moves, and at least one, go as the profile wants them planned now.
  bool planned_as_now() const;

  /// Cycle in which the first motion was commanded, if any.
  std::optional<std::uint64_t> first_motion_cycle() const;
  /// Moves go through this controller.
  bool use(const controllers::Controller& controller) const;
  /// It is unloaded: robots that move through it cannot be moved any more. `forget` is called with their
  /// motions.
  void release(const controllers::Controller& controller,
               const std::function<void(moves::RobotMotion&)>& forget,
               const std::function<void(moves::BaseMotion&)>& forget_base);

 private:
  const ProfileEntry& limits() const;
  /// For each joint that has a finite value among `values`, by `index` of its place, that is where its next
  /// motion begins.
  void set_planned(std::size_t robot, int JointPlaces::Place::*index, std::span<const double> values);

  const CellSetup& setup_;
  Machine& machine_;
  Arming& arming_;
  const ContactWatch& contacts_;
  Observer& observer_;
  std::vector<std::unique_ptr<moves::RobotMotion>> motions_;
  std::vector<std::unique_ptr<moves::BaseMotion>> bases_;
  std::vector<MovingBase> places_;
  std::vector<int> movers_;  // index of the state of each mover of the scene; -1: none
  std::shared_ptr<SharedBodies> bodies_;
  std::vector<controllers::JointTrajectoryController*> followers_;
  std::set<std::string> reported_;  // warnings of moves; a loop says them once
  std::string profile_ = "full";
};

}  // namespace polyarm::cell
