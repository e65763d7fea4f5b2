#pragma once
/// Converts the move statements of a task into moves of its robots.
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "polyarm/data/data_store.hpp"
#include "polyarm/data/frame_chain.hpp"
#include "polyarm/moves/base_motion.hpp"
#include "polyarm/moves/robot_motion.hpp"
#include "polyarm/setup/cell_file.hpp"
#include "polyarm/setup/robots.hpp"
#include "polyarm/tasks/belts.hpp"
#include "polyarm/tasks/force_readings.hpp"
#include "polyarm/vm/host.hpp"

namespace polyarm::cell {

/// The moves of one task. Cell thread.
class ProgramMoves {
 public:
  struct Robot {
    const CellRobot* robot = nullptr;
    moves::RobotMotion* motion = nullptr;  ///< null: no controller moves the robot
    moves::BaseMotion* base = nullptr;     ///< null: no controller drives wheels
  };
  /// `robots`: those that the task may move; empty: it moves nothing. `store` has the points that serve as
  /// frames and tools; it must outlive this object.
  ProgramMoves(std::string task, std::vector<Robot> robots, const MotionEntry& pace,
               const data::DataStore& store);

  /// The point with its pose in the world, by the present pose of its frame: a point of the data (which may
  /// itself be in a frame), `ROBOT/base`, `ROBOT/flange` or `ROBOT/tcp` (their poses after all queued moves).
  /// Throws Error("unknown-frame").
  data::Point in_world(const data::Point& point) const;

  // program::Host.
  program::Handle start(const program::Move& move, const Location& where);
  program::Progress poll(program::Handle handle);
  bool has_room(const std::string& robot);
  /// False while a robot ends a ride on a belt, or waits for its part.
  bool ready_for(const program::Move& move, const Location& where);
  bool next_part(const std::string& belt, const std::string& robot);
  program::Handle start_arrival(const std::string& robot);
  program::Handle suspend(const std::vector<std::string>& robots);
  program::Handle resume(const std::vector<std::string>& robots);
  void abandon(const std::vector<std::string>& robots);
  program::Travel travel(program::Handle handle) const;
  void end(program::Handle handle);
  data::Value here(const std::string& robot, const std::string& tool, const std::string& frame) const;
  data::JointState here_joints(const std::string& robot) const;
  data::JointState joints_at(const data::Value& place, const data::JointState* near, const std::string& robot,
                             const std::string& tool, const std::string& frame);
  data::Value pose_at(const data::JointState& joints, const std::string& robot, const std::string& tool,
                      const std::string& frame) const;

  /// Where the joints of a robot are commanded to be now, by its index in the robots of the constructor.
  /// Without it they are where the planned moves end.
  void set_joints_now(std::function<std::vector<double>(std::size_t)> joints) {
    joints_now_ = std::move(joints);
  }
  /// Null: the cell has no belts. They must outlive this object. `first_pass`: true while the speed of TCPs
  /// is reduced; null: never.
  void set_belts(Belts* belts, std::function<bool()> first_pass = {}) {
    belts_ = belts;
    first_pass_ = std::move(first_pass);
  }
  Belts* belts() const { return belts_; }
  /// Call it in each tick, before the moves: the rides on belts, which end with the window of the belt.
  void tick_rides();
  /// Robots that follow a belt come to rest.
  void end_rides();
  /// The robot yields to forces until stiff(). Throws Error: without a sensor, on a belt, a second time, or
  /// as check_compliance().
  void comply(const std::string& robot, const program::Compliance& how, ForceReadings& force);
  /// Throws Error("forward-mode") if the robot's own controller interpolates: it does not yield.
  static void check_compliance(const RobotEntry& robot);
  /// Throws Error if the compliance has ended by itself.
  void stiff(const std::string& robot);
  /// Call it in each tick, before the moves.
  void tick_compliance(ForceReadings& force);
  /// True between comply() and stiff() of a robot.
  bool yields() const;
  /// True if nothing moves the robot with this name.
  bool stands(const std::string& robot) const;
  /// Robots that yield become stiff.
  void end_compliance();
  /// In a rehearsal, as next_part().
  void suppose_part(const std::string& belt, const std::string& robot);

  /// The name of a robot of the program; empty: its only one.
  const std::string& name_of(const std::string& robot) const;
  /// The line of the move under way, or of the last one, if it is meant to touch something; else empty.
  Location touch_of(const moves::RobotMotion& motion) const;
  Location touch_of(const moves::RobotMotion& motion, std::uint64_t move) const;

  /// A move in the planner's form, not queued. `with`: facts of the robot with another TCP.
  struct Prepared {
    std::size_t arm = 0;  ///< index in the robots of the constructor
    std::vector<moves::Move> moves;
    std::shared_ptr<const moves::RobotFacts> with;
  };
  Prepared prepare(const program::Move& move, const Location& where);
  /// For a rehearsal: returns true if the robot with this index has pending moves. Without it the controller
  /// is asked.
  void set_busy(std::function<bool(std::size_t)> busy) { busy_ = std::move(busy); }
  /// The index of the robot whose base a `drive` or `turn` moves. Throws Error if no controller drives it.
  std::size_t base_of(const program::Move& move, const Location& where) const;
  /// T_world_goal of a `drive` to a pose; empty: it drives by a length, or turns.
  std::optional<Pose> base_goal(const program::Move& move, const Location& where) const;
  /// The index of a robot that is a base without an arm; empty: it is another one. Throws Error for an
  /// unknown robot.
  std::optional<std::size_t> only_base(const std::string& robot) const;
  /// here() of a base that stands at `place` in the world.
  data::Value place_in(const Pose& place, std::size_t base, const std::string& frame) const;
  /// here(), here_joints() and joints_at() for the present joints that `joints_of` returns.
  using JointsOf = std::function<std::vector<double>(std::size_t arm)>;
  /// `shifted`: they contain what a belt has added to the planned paths.
  data::Value here_at(const std::string& robot, const std::string& tool, const std::string& frame,
                      const JointsOf& joints_of, bool shifted = false) const;
  data::JointState here_joints(const std::string& robot, const JointsOf& joints_of) const;
  data::JointState joints_at(const data::Value& place, const data::JointState* near, const std::string& robot,
                             const std::string& tool, const std::string& frame, const JointsOf& joints_of);

  /// Call before their controllers are unloaded.
  void forget(const moves::BaseMotion& base);
  void forget(const moves::RobotMotion& motion);
  /// The program line of a running move; empty if the move is not from this program.
  Location place_of(const moves::RobotMotion& motion, std::uint64_t move) const;
  /// True until the robot has finished the move of this handle.
  bool under_way(program::Handle handle) const;
  bool given_up(program::Handle handle) const;
  /// True while a requested move has not ended.
  bool moving() const;

 private:
  /// A move whose result was not reported yet.
  struct Open {
    std::uint64_t id;
    Location where;
    std::string name;
    std::string called;  ///< by these functions of the program
  };
  /// Facts of the robot with another TCP, and that TCP; points may change while a program runs.
  struct MadeTool {
    Pose tcp;
    std::shared_ptr<const moves::RobotFacts> facts;
  };
  struct Arm {
    Robot robot;
    std::deque<Open> open;
    std::map<std::string, MadeTool> tools;
    struct Touch {
      std::uint64_t from = 0, to = 0;  ///< ids of the moves that may touch
      Location where;
    };
    std::deque<Touch> touches;
    /// The part that the robot follows, and the travel of its belt where the ride began.
    struct Ride {
      std::string belt;
      BeltPart part;
      double travel = 0;
      bool ended = false;  ///< it has failed
    };
    std::optional<Ride> ride;
    /// Of a robot that yields: the force it feels on average, the largest, and why it has ended by itself.
    struct Yielding {
      double most = 0;
      Vec3 felt;
      Nanoseconds felt_at = 0;
      std::optional<Problem> failure;
      bool reported = false;  ///< a move has failed because of it
    };
    std::optional<Yielding> yielding;
    /// Begins when the compliance before it has ended.
    std::optional<moves::ComplianceSettings> yields_next;
  };
  struct Moves {
    std::size_t arm = 0;
    std::uint64_t first = 0, last = 0;
    bool base = false;
  };
  using Asked = std::vector<Moves>;

  bool is_on_its_way(std::size_t arm) const;
  std::vector<double> present_joints(std::size_t arm) const;
  std::size_t robot_of(const std::string& robot, const Location& where) const;
  std::size_t arm_of(const std::string& robot, const Location& where) const;
  program::Handle start_base(const program::Move& move, const Location& where);
  Pose frame_of(const program::Move& move, const Arm& arm, const Location& where) const;
  std::string belt_of_frame(const std::string& name) const;
  std::string belt_of(const program::Move& move, const Location& where) const;
  Pose belt_frame(const std::string& belt, const Arm& arm, const Location& where) const;
  bool follows(const Arm& arm, const std::string& belt) const;
  bool is_too_fast(const std::string& belt, const BeltPart& part, const Arm& arm) const;
  void begin_ride(const program::Move& move, Arm& arm, const Location& where);
  void note_end_of_compliance(Arm& arm) const;
  void begin_next_compliance(Arm& arm, const Wrench& felt, Nanoseconds time) const;
  void require_compliance(Arm& arm, const Location& where) const;
  data::FrameChain chain_of(const std::string& frame) const;
  Pose frame_named(const std::string& name, const Arm& arm, const Location& where) const;
  std::optional<Pose> on_robot(const data::RobotFrame& frame, const Arm* own) const;
  std::shared_ptr<const moves::RobotFacts> tool_of(const std::string& name, Arm& arm, const Location& where);
  Pose tcp_of_tool(const std::string& name, const Arm& arm, const Location& where) const;
  moves::MoveTarget target_of(const program::Move::Target& target, const program::Move& move, const Arm& arm,
                              const Location& where) const;
  std::vector<moves::Move> moves_of(const program::Move& move, const Arm& arm, const Location& where) const;
  void pace(const program::Move& from, moves::Move& to) const;
  void keep_near(const data::JointState& near, const moves::RobotFacts& robot,
                 std::vector<moves::Move>& moves) const;
  void check_forward(const program::Move& move, const std::vector<moves::Move>& moves, const Arm& arm,
                     const Location& where) const;
  void check_payload(const program::Move& move, const Arm& arm, const Location& where) const;
  void forget_ended();
  static void note_touch(Arm& arm, const Moves& moves, bool touch, const Location& where);
  /// Arms that a trap stops, or lets go on.
  struct Interruption {
    std::vector<std::size_t> arms;
    bool ends = false;
  };
  program::Handle interrupt(const std::vector<std::string>& robots, bool ends);
  bool is_over(const Interruption& interruption) const;
  program::Progress result_of(const Interruption& over);
  std::map<program::Handle, Interruption> interruptions_;
  std::shared_ptr<moves::InStep> step_of(const program::Move& move, std::size_t arm, const Location& where);
  std::optional<program::Progress> bad_end(Arm& arm, std::uint64_t through);

  std::string task_;
  std::vector<Arm> arms_;
  std::function<bool(std::size_t)> busy_;
  std::function<std::vector<double>(std::size_t)> joints_now_;
  MotionEntry pace_;
  const data::DataStore& store_;
  Belts* belts_ = nullptr;
  std::function<bool()> first_pass_;
  std::map<program::Handle, Asked> asked_;
  program::Handle last_handle_ = 0;
  struct Step {
    std::uint64_t group = 0;
    std::shared_ptr<moves::InStep> shared;
    std::vector<std::size_t> arms;
  };
  Step step_;  ///< the latest
};

}  // namespace polyarm::cell
