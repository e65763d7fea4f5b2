#pragma once
/// What a program needs from the cell it runs in. The interpreter knows no robot, file or clock of its own.
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

namespace polyarm::program {

/// Something the cell was asked for and has not finished yet.
using Handle = std::int64_t;

struct Progress {
  /// ended: a stop, a fault or a person ended it. That is no error of the program: it fails with the problem,
  /// and no handler in it sees it.
  enum class State { running, done, failed, ended } state = State::running;
  std::optional<Problem> problem;  ///< why it failed; its place is filled in where it has none

  static Progress done() { return {State::done, {}}; }
  static Progress failed(Problem why) { return {State::failed, std::move(why)}; }
  static Progress ended(Problem why) { return {State::ended, std::move(why)}; }
};

/// A move as a program asks for it; what is not said is the cell's default.
struct Move {
  /// drive, turn: of a base, by so much.
  enum class Kind { joint, line, arc, drive, turn };
  bool of_base() const { return kind == Kind::drive || kind == Kind::turn; }
  struct Target {
    /// A pose or a joint state; of a base a length or an angle. Of one joint move or line a record: by how
    /// much from where the robot is, of joints by name, of a line x, y, z, rx, ry, rz along the frame's axes.
    data::Value value;
    std::string name;  ///< how the program calls it, for messages
  };
  Kind kind = Kind::joint;
  /// joint, line: one or more, one path. arc: the point on the way and the end.
  std::vector<Target> targets;
  std::optional<data::Number> speed;     ///< a speed, an angular speed, or a share of the limits (1 is all)
  std::optional<data::Number> accel;     ///< an acceleration, an angular acceleration, or a share
  std::optional<data::Number> blend;     ///< a length: how far from its targets the path may leave them
  std::optional<data::Number> duration;  ///< a time: the move takes at least this long
  std::optional<data::Number> payload;   ///< a mass: what the gripper holds
  /// joint: of the configurations that reach a pose, the one nearest to these joints.
  std::optional<data::JointState> near;
  /// It comes to rest at its last target: the program says so, or states no blend.
  bool exact = true;
  bool smooth = false;  ///< line: one curve through all targets instead of lines between them
  /// The statement ends when the move has arrived (moveto); others only queue it.
  bool waits = false;
  std::string robot, tool, frame;  ///< names; empty: the task's own
  /// Moves of several robots that begin and end together.
  struct Step {
    std::uint64_t group = 0;  ///< counts up from 1; 0: none
    std::size_t members = 0;
  } step;
  /// The frame, where the program says it by a value: maps it into the world. Then `frame` is for messages.
  std::optional<Pose> frame_pose;
  /// Of a move in a function the calls that led to it, to be put behind what a message says: "; called from
  /// line 7".
  std::string called;
};

/// How much of a move is done, along its own path.
struct Travel {
  double covered_m = 0, left_m = 0;  ///< of the tool centre point
  Nanoseconds elapsed = 0, left = 0;
};

enum class LoadForm { load, import };

/// Implemented by the cell; called on the cell thread only; must not block. Any call may throw Error, which
/// ends the program as failed with the error's problem.
class Host {
 public:
  virtual ~Host() = default;

  /// The value of data, point or tag, or nullptr. Valid until the next call of set.
  virtual const data::Value* find(std::string_view name) const = 0;
  /// All names there are, for the nearest one in a message.
  virtual std::vector<std::string> names() const = 0;
  /// Changes a value, or makes a new name.
  virtual void set(const std::string& name, data::Value value, const Location& where) = 0;
  /// The loop whose condition `name` is has had all the passes it may have: False is set to it, unless that
  /// would reach somebody outside.
  virtual void end_loop(const std::string& name, const Location& where) { set(name, false, where); }
  /// Grows whenever any value changes; a wait looks at its condition again only then.
  virtual std::uint64_t data_version() const = 0;

  /// Queues a move. Throws Error where its targets cannot be had.
  virtual Handle start_move(const Move& move, const Location& where) = 0;
  /// done: it has arrived. Of a move with `waits`, and of what start_arrival returned.
  virtual Progress poll_move(Handle handle) = 0;
  /// False once the robot has come to the end of a move, whether or not others are blended behind it; of
  /// what start_move returned.
  virtual bool under_way(Handle) const { return false; }
  /// Whether `robot` (empty: the task's own) takes another move now; if not, it is asked again in the next
  /// tick. True where an earlier move has failed: the next call tells.
  virtual bool room_for_move(const std::string& robot) = 0;
  /// Nothing more will be blended with what `robot` has queued; done when all of it has arrived. A failure
  /// names the move at fault, with the place that start_move was given.
  virtual Handle start_arrival(const std::string& robot) = 0;
  /// Ends a move where it is, on its path, as soon as the limits allow, and drops what is queued behind it;
  /// poll_move says done when it stands.
  virtual void end_move(Handle handle, const Location& where);
  /// How far a move with `waits` has come.
  virtual Travel travel(Handle handle) const;
  /// The pose of the tool centre point: T_frame_tool, with empty names the task's own robot and tool and the
  /// world. Asked only when everything queued has arrived.
  virtual data::Value here(const std::string& robot, const std::string& tool, const std::string& frame) const;
  /// Starts to replace the data set that comes from the file called `name` by the file as it is now.
  virtual Handle start_load(const std::string& name, LoadForm form, const Location& where) = 0;
  virtual Progress poll_load(Handle handle) = 0;
  /// Puts a question to whoever operates the cell.
  virtual Handle start_ask(const std::string& text, const Location& where) = 0;
  virtual Progress poll_ask(Handle handle) = 0;
  /// What was answered to the last question that is done.
  virtual std::string answer() const { return {}; }
  /// In tests: begins the program, or another of the cell's; and the functions of tests, by name.
  virtual void run_program(const std::string& name, const Location& where);
  virtual data::Value call(std::string_view function, std::span<const data::Value> arguments,
                           const Location& where);

  virtual Nanoseconds now() const = 0;
  /// True when every robot of the program stands; the clean-up of a program begins only then.
  virtual bool standing() const { return true; }
  /// Holds the cell as a person would; only a person resumes it. The program is not stepped meanwhile.
  virtual void hold(const std::string& reason, const Location& where);
  virtual void log(const std::string& text, const Location& where) = 0;
};

}  // namespace polyarm::program
