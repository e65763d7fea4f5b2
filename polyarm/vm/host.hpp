#pragma once
/// The interface of a program to its cell. The interpreter itself knows no robot, file or clock. SI units.
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/base/pose.hpp"
#include "polyarm/base/time.hpp"
#include "polyarm/data/value.hpp"
#include "polyarm/language/compliance.hpp"

namespace polyarm::program {

/// A request to the cell that is not finished yet.
using Handle = std::int64_t;

struct Progress {
  /// ended: a stop, a fault or a person ended it. That is no error of the program: it fails with the problem,
  /// and no handler catches it.
  enum class State { running, done, failed, ended } state = State::running;
  std::optional<Problem> problem;  ///< why it failed; a missing location is filled in

  static Progress done() { return {State::done, {}}; }
  static Progress failed(Problem why) { return {State::failed, std::move(why)}; }
  static Progress ended(Problem why) { return {State::ended, std::move(why)}; }
};

/// A move as a program requests it; unset values mean the cell's defaults.
struct Move {
  /// drive, turn: of a base, by an amount; drive: also to a pose.
  enum class Kind { joint, line, arc, drive, turn };
  bool of_base() const { return kind == Kind::drive || kind == Kind::turn; }
  struct Target {
    /// A pose or a joint state; for a base a length, an angle or a pose. A single joint move or line may have
    /// a record: an increment from the present position, of joints by name, or for a line of x, y, z, rx, ry,
    /// rz along the frame's axes.
    data::Value value;
    std::string name;  ///< its name in the program, for messages
  };
  Kind kind = Kind::joint;
  /// joint, line: one or more, as one path. arc: the via point and the end.
  std::vector<Target> targets;
  std::optional<data::Number> speed;     ///< a speed, an angular speed, or a fraction of the limits (1 is the
                                         ///< full limit)
  std::optional<data::Number> accel;     ///< an acceleration, an angular acceleration, or a fraction
  std::optional<data::Number> blend;     ///< a length: the largest distance of the path from its targets
  std::optional<data::Number> duration;  ///< a time: the minimum duration of the move
  std::optional<data::Number> payload;   ///< a mass: the load of the gripper
  /// joint: selects, among the configurations that reach a pose, the one nearest to these joints.
  std::optional<data::JointState> near;
  /// joint: goes around obstacles; line, arc: refused if it hits one.
  std::optional<bool> around;
  /// Stops at its last target: the program requests it, or states no blend.
  bool exact = true;
  bool touch = false;   ///< the tool is meant to touch something: a contact of it is no fault
  bool smooth = false;  ///< line: one curve through all targets instead of lines between them
  /// The statement ends when the move has arrived (moveto); other moves are only queued.
  bool waits = false;
  std::string robot, tool, frame;  ///< names; empty: those of the task
  /// Moves of several robots that begin and end together.
  struct Step {
    std::uint64_t group = 0;  ///< counts from 1; 0: none
    std::size_t members = 0;
  } step;
  /// The frame, if the program gives it as a value: maps it into the frame `pose_in`; empty: the world.
  /// `frame` is then only for messages.
  std::optional<Pose> frame_pose;
  std::string pose_in;
  const std::string& named_frame() const { return frame_pose ? pose_in : frame; }
  /// For a move in a function: the calls that led to it, as a suffix of messages: "; called from line 7".
  std::string called;
};

/// The progress of a move along its own path.
struct Travel {
  double covered_m = 0, left_m = 0;  ///< of the tool centre point
  Nanoseconds elapsed = 0, left = 0;
};

enum class LoadForm { load, import };

/// Implemented by the cell; called on the cell thread only; must not block. Any call may throw Error, which
/// ends the program as failed with that problem.
class Host {
 public:
  virtual ~Host() = default;

  /// The value of data, point or tag, or nullptr. Valid until the next call of set().
  virtual const data::Value* find(std::string_view name) const = 0;
  /// All existing names, to suggest the nearest one in a message.
  virtual std::vector<std::string> names() const = 0;
  /// Changes a value, or creates a name.
  virtual void set(const std::string& name, data::Value value, const Location& where) = 0;
  /// Called when the loop with the condition `name` has reached its pass limit: sets `name` to False, unless
  /// that would reach another system.
  virtual void end_loop(const std::string& name, const Location& where) { set(name, false, where); }
  /// Increases when any value changes; a wait checks its condition again only then.
  virtual std::uint64_t data_version() const = 0;

  /// Queues a move. Throws Error if its targets are impossible.
  virtual Handle start_move(const Move& move, const Location& where) = 0;
  /// done: it has arrived. For a move with `waits`, and for handles from start_arrival().
  virtual Progress poll_move(Handle handle) = 0;
  /// False once the robot has reached the end of a move, even if others are blended after it. For handles
  /// from start_move().
  virtual bool under_way(Handle) const { return false; }
  /// True if the robot did not complete a move: it failed, was refused or was discarded. For handles from
  /// start_move().
  virtual bool given_up(Handle) const { return false; }
  /// True if `robot` (empty: the task's own) accepts another move now; if not, it is called again in the next
  /// tick. True if an earlier move has failed: the next call reports that.
  virtual bool room_for_move(const std::string& robot) = 0;
  /// False while the robot cannot begin this move yet, such as on a part of a belt that is still to come; it
  /// is called again in the next tick. Called after room_for_move().
  virtual bool ready_for(const Move&, const Location&) { return true; }
  /// Ends the blending of what `robot` has queued; done when all of it has arrived. A failure names the
  /// faulty move, with the location given to start_move().
  virtual Handle start_arrival(const std::string& robot) = 0;
  /// Stops a move on its path as soon as the limits allow, and drops the moves queued after it; poll_move()
  /// reports done at standstill.
  virtual void end_move(Handle handle, const Location& where);
  /// For a trap: stops these robots (empty: all of the task) on their paths and sets their moves apart. poll_move()
  /// reports done at standstill; moves that are started then are carried out first.
  virtual Handle suspend(const std::vector<std::string>& /*robots*/) { return 0; }
  /// They return to where they stopped and go on along their paths; poll_move() reports done when they go on.
  virtual Handle resume(const std::vector<std::string>& /*robots*/) { return 0; }
  /// The program has ended between suspend() and resume(): the moves that were set apart end where the robots are.
  virtual void abandon(const std::vector<std::string>& /*robots*/) {}
  /// The progress of a move with `waits`.
  virtual Travel travel(Handle handle) const;
  /// The pose of the tool centre point, T_frame_tool; empty names mean the task's own robot and tool, and the
  /// world. Only called after all queued moves have arrived.
  virtual data::Value here(const std::string& robot, const std::string& tool, const std::string& frame) const;
  /// The joints of the robot after all queued moves; empty: the task's own.
  virtual data::JointState here_joints(const std::string& robot) const;
  /// The joints of `robot` at a place: a joint state in its order, a pose in `frame` of the tool centre point of
  /// `tool`. `near`: the configuration to choose; null: as taught, else near the present joints. Throws Error if
  /// there are none.
  virtual data::JointState joints_at(const data::Value& place, const data::JointState* near, const std::string& robot,
                                     const std::string& tool, const std::string& frame) const;
  /// The point with its pose in the world. It stays as it is if its frame is another one for each robot.
  /// Throws Error if there is no such frame.
  virtual data::Point in_world(const data::Point& point) const { return point; }
  /// The pose of the tool centre point at these joints, T_frame_tool.
  virtual data::Value pose_at(const data::JointState& joints, const std::string& robot, const std::string& tool,
                              const std::string& frame) const;
  /// Force in N and torque in Nm at the force sensor of `robot`, x y z rx ry rz in the axes of the sensor, without
  /// what zero_force() took as zero. Throws Error if it has no sensor.
  virtual std::array<double, 6> wrench(const std::string& robot);
  virtual void zero_force(const std::string& robot);
  /// For a rehearsal, in which nothing is measured: true if the condition of an `until`, whose move has
  /// reached its end, counts as met there.
  virtual bool supposes_met(const Location&, bool /*has_else*/) { return false; }
  /// From now on the tool of `robot` yields to forces, until stiff(). Throw Error: no sensor, or the reason
  /// why it ended.
  virtual void comply(const std::string& robot, const Compliance& how);
  virtual void stiff(const std::string& robot);
  /// The functions of belts. Throw Error if there is no such belt, or its encoder gives no numbers.
  virtual bool next_part(const std::string& belt, const std::string& robot);
  virtual double waiting_parts(const std::string& belt);
  virtual double missed_parts(const std::string& belt);
  virtual void add_part(const std::string& belt, const Pose& at);
  /// The rows of a table in the folder of the cell. Throws Error.
  virtual data::List rows_of(const std::string& file);
  /// The functions of streams. Throw Error if there is no such stream, or it cannot open.
  virtual bool is_connected(const std::string& stream);
  virtual bool has_line(const std::string& stream);
  virtual std::string next_line(const std::string& stream);
  virtual void send_text(const std::string& stream, const std::string& text);
  /// Selects the series of random().
  virtual std::uint64_t seed() const { return 0; }
  /// A handler of the program is about to take this error.
  virtual void caught(const Problem&) {}
  /// Starts to reload the data set from the file called `name`.
  virtual Handle start_load(const std::string& name, LoadForm form, const Location& where) = 0;
  virtual Progress poll_load(Handle handle) = 0;
  /// Asks the operator a question.
  virtual Handle start_ask(const std::string& text, const Location& where) = 0;
  virtual Progress poll_ask(Handle handle) = 0;
  /// The answer to the last finished question; `like` is the value that Enter gives.
  virtual std::string answer(const data::Value& /*like*/) const { return {}; }
  /// In tests: starts the program, or another program of the cell; and the test functions, by name.
  virtual void run_program(const std::string& name, const Location& where);
  virtual data::Value call(std::string_view function, std::span<const data::Value> arguments,
                           const Location& where);

  virtual Nanoseconds now() const = 0;
  /// True if every robot of the program is at standstill; the clean-up of a program begins only then.
  virtual bool standing() const { return true; }
  /// True for a PLC: its `when` and `every` blocks go on after its last line.
  virtual bool keeps_events() const { return false; }
  /// Holds the cell as a person would; only a person resumes it. The program is not stepped meanwhile.
  virtual void hold(const std::string& reason, const Location& where);
  virtual void log(const std::string& text, const Location& where) = 0;
};

}  // namespace polyarm::program
