#pragma once
/// The position of a task in a program, as values for display. Plain data.
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/base/pose.hpp"
#include "polyarm/base/time.hpp"
#include "polyarm/data/value.hpp"

namespace polyarm::program {

enum class TaskState { running, waiting, finished, failed, stopped };

const char* name(TaskState state);

enum class WaitKind {
  none,
  time,
  condition,
  move,
  user,
  load,
  arrival,
  room,
  until,
  meet,
  lock,
  together,
  turn
};

/// The reason why a task waits.
struct Waiting {
  WaitKind kind = WaitKind::none;
  std::optional<Nanoseconds>
      until;                       ///< of a time; for a condition, meeting or lock its timeout, if it has one
  std::vector<std::string> names;  ///< for a condition: the data and tags that it reads
  std::string
      text;  ///< for a move the point, for a load the file, for a user the question, for a meeting its name
  std::string note = {};  ///< for a question: the answer of Enter, and why the latest answer was refused

  /// Becomes a wait of this kind with nothing else set; its texts keep their memory.
  void begin(WaitKind of) {
    kind = of;
    until.reset();
    names.clear();
    text.clear();
    note.clear();
  }
};

/// A variable, or a temporary value of an expression. If it is not set, its value is False.
struct Slot {
  Slot() = default;
  Slot(data::Value of, const std::string* called, bool is_set)
      : value(std::move(of)), set(is_set), origin(called) {}

  void fill(data::Value with) {
    value = std::move(with);
    set = true;
    origin = nullptr;
  }
  void fill_plain(const auto& with) {
    value.set(with);
    set = true;
    origin = nullptr;
  }

  [[no_unique_address]] data::Value value;
  bool set = true;
  const std::string* origin = nullptr;  ///< for a point: its name in the host
};

/// The options of moves that do not state their own.
struct MoveDefaults {
  std::optional<data::Number> speed, accel, blend, payload;
  bool exact = false;
  std::optional<bool> around;
  std::string robot, tool, frame;
  std::optional<Pose> frame_pose;  ///< the frame, if it was given as a value
  std::string pose_in;             ///< the frame that frame_pose is in; empty: the world
  /// The frame that the host knows by name: `frame`, or the one around frame_pose.
  const std::string& named_frame() const { return frame_pose ? pose_in : frame; }
};

/// A call of a function, with its return place.
struct CallFrame {
  std::size_t return_to = 0;
  std::size_t base = 0, uses = 0, locks = 0, handlers = 0;
};

/// An active `try`, with the stack heights at its start.
struct Handler {
  std::size_t step = 0;
  std::size_t stack = 0, frames = 0, uses = 0, locks = 0;
};

}  // namespace polyarm::program
