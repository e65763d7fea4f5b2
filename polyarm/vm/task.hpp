#pragma once
/// The state of one task. Private to the interpreter's files.
#include <deque>

#include "polyarm/vm/interpreter.hpp"
#include "polyarm/vm/large_work.hpp"

namespace polyarm::program {

/// The item at a step's index.
template <typename Items>
auto& at(Items& items, int index) {
  return items[static_cast<std::size_t>(index)];
}

/// Deeper nesting of function calls is an error.
inline constexpr std::size_t kDeepestCalls = 200;
/// Registers of all calls of a task, allocated once.
inline constexpr std::size_t kMostRegisters = 20000;
/// The cost of a raised and caught error.
inline constexpr int kStatementsOfAnError = 60;
/// The number of statements that a task may begin before the next task runs.
inline constexpr int kTurn = 20;

struct Interpreter::Task {
  std::uint64_t id = 0, parent = 0;
  std::string name;
  bool shown = true;   ///< shown as a task; false for a part of `together` and for a `when`
  bool apart = false;  ///< a `when` or `on stop`: without motion or waiting
  TaskState state = TaskState::running;
  std::size_t pc = 0;
  Place line;  ///< of the last executed step, in which it may wait
  std::vector<Slot>
      stack;  ///< registers of all calls; after the last base there is enough room for any function
  std::vector<CallFrame> frames = std::vector<CallFrame>(1);
  std::vector<MoveDefaults> uses;
  Move::Step step;  ///< for its moves
  std::vector<std::string> locks;
  std::vector<Handler> handlers;

  Waiting waiting;
  std::vector<Handle> handles;      ///< of the requests it waits for
  std::vector<std::string> robots;  ///< with possibly queued motion of this task
  struct Asked {
    Handle handle = 0;
    Place line;
    std::uint64_t passes = 0;  ///< completed when it was requested
    std::string robot;
  };
  std::deque<Asked> moves;              ///< that may not have arrived, in program order
  std::optional<Nanoseconds> deadline;  ///< of the present wait
  std::uint64_t seen_version = 0;
  Nanoseconds seen_at = 0;
  std::string refused;  ///< why the latest answer to its question was refused
  bool met = false, was_true = false;
  // Of its last move with `until`.
  bool until_met = false;
  std::optional<Handle> measured;  ///< while it is under way
  double travelled = 0, whole = 0;  ///< m: its way so far, and up to its end
  // Traps. Of what looks at the condition: its trap, the task that it interrupts, and that it is to do so.
  int trap = -1;
  std::uint64_t owner = 0;
  bool sprung = false;
  // Of the block: the task that it interrupts, and its robots.
  std::uint64_t interrupts = 0;
  std::vector<std::string> stopped_robots;
  bool goes_back = false;
  std::uint64_t frozen = 0;             ///< by this block of a trap
  std::vector<std::string> commanded;   ///< robots that it and its parts have moved
  std::optional<Nanoseconds> next_due;  ///< of an `every`
  std::unique_ptr<Work> work;  ///< of its step, in pieces
  std::uint64_t passes = 0;
  std::optional<std::uint64_t> ended_cycles;  ///< the number of finished cycles when it was stopped
  std::optional<Problem> problem;
  std::optional<Place> ended_in;  ///< the line in which it was stopped

  bool over() const { return state != TaskState::running && state != TaskState::waiting; }
  CallFrame& frame() { return frames.back(); }
  /// True if going back to this place in the present call leaves a `lock` or a `try`, whose robots must have
  /// arrived: the place of a lock is still theirs, and a move that fails belongs to its `try`.
  bool leaves_block(const Depths& to = {}) const {
    const CallFrame& call = frames.back();
    return locks.size() > call.locks + static_cast<std::size_t>(to.locks) ||
           handlers.size() > call.handlers + static_cast<std::size_t>(to.handlers);
  }
  Slot& local(int slot) { return stack[frame().base + static_cast<std::size_t>(slot)]; }
};

/// A value to set when a move has progressed far enough.
struct Interpreter::Watch {
  std::uint64_t task = 0;
  Handle handle = 0;
  const Clause* clause = nullptr;
  std::optional<data::Number> offset;
  Value value;
  Location where;
};

/// A stop, fault or person ended what a task waited for; no handler catches it.
struct Ended {
  Problem problem;
};

}  // namespace polyarm::program
