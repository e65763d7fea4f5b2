#pragma once
/// Where a task of a program stands, in values that can be looked at from outside.
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

/// What a task waits for.
struct Waiting {
  WaitKind kind = WaitKind::none;
  std::optional<Nanoseconds>
      until;                       ///< of a time; of a condition, meeting or lock its timeout, if it has one
  std::vector<std::string> names;  ///< of a condition: the data and tags that it reads
  std::string
      text;  ///< of a move the point, of a load the file, of a user the question, of a meeting its name
};

/// A variable, or a value on its way through an expression. Where it is not set its value is False.
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
  const std::string* origin = nullptr;  ///< of a point what the host calls it
};

/// What moves take when they do not say it themselves.
struct MoveDefaults {
  std::optional<data::Number> speed, accel, blend, payload;
  bool exact = false;
  std::string robot, tool, frame;
  std::optional<Pose> frame_pose;
};

/// A call of a function, and where it returns to.
struct CallFrame {
  std::size_t return_to = 0;
  std::size_t base = 0, uses = 0, locks = 0, handlers = 0;
};

/// A `try` that is under way, and what was there when it began.
struct Handler {
  std::size_t step = 0;
  std::size_t stack = 0, frames = 0, uses = 0, locks = 0;
};

}  // namespace polyarm::program
