#pragma once
/// The state of one task; for the interpreter's own files.
#include <deque>

#include "polyarm/program/interpreter.hpp"
#include "polyarm/program/large_work.hpp"

namespace polyarm::program {

/// What stands at a step's index.
template <typename Items>
auto& at(Items& items, int index) {
  return items[static_cast<std::size_t>(index)];
}

/// Calls of functions inside calls, deeper than this, are an error.
inline constexpr std::size_t kDeepestCalls = 200;
/// Registers of all calls of a task; room for them is made once.
inline constexpr std::size_t kMostRegisters = 20000;
/// What one costs that is raised and caught.
inline constexpr int kStatementsOfAnError = 60;
/// Statements that a task may begin before the next one has its turn.
inline constexpr int kTurn = 20;

struct Interpreter::Task {
  std::uint64_t id = 0, parent = 0;
  std::string name;
  bool shown = true;   ///< it is a task of its own to a person: no part of `together`, no `when`
  bool apart = false;  ///< a `when` or `on stop`: without motion or waiting
  TaskState state = TaskState::running;
  std::size_t pc = 0;
  Place line;  ///< of the step that was executed last, which is what it waits in
  std::vector<Slot>
      stack;  ///< registers of all calls, at least as many behind the last base as any function needs
  std::vector<CallFrame> frames = std::vector<CallFrame>(1);
  std::vector<MoveDefaults> uses;
  Move::Step step;  ///< of its moves
  std::vector<std::string> locks;
  std::vector<Handler> handlers;

  Waiting waiting;
  std::vector<Handle> handles;      ///< of what it waits for
  std::vector<std::string> robots;  ///< that may have queued motion of this task
  struct Asked {
    Handle handle = 0;
    Place line;
    std::uint64_t passes = 0;  ///< completed when it was asked for
  };
  std::deque<Asked> moves;              ///< that may not have arrived, in the order of the program
  std::optional<Nanoseconds> deadline;  ///< of the wait that is being looked at
  std::uint64_t seen_version = 0;
  Nanoseconds seen_at = 0;
  bool met = false, was_true = false;
  std::unique_ptr<Work> work;  ///< that its step is at, in pieces
  std::uint64_t passes = 0;
  std::optional<std::uint64_t> ended_cycles;  ///< where it was stopped, those whose moves had ended
  std::optional<Problem> problem;
  std::optional<Place> ended_in;  ///< the line, where it was stopped in one

  bool over() const { return state != TaskState::running && state != TaskState::waiting; }
  CallFrame& frame() { return frames.back(); }
  Slot& local(int slot) { return stack[frame().base + static_cast<std::size_t>(slot)]; }
};

/// A value that is set when a move has come far enough.
struct Interpreter::Watch {
  std::uint64_t task = 0;
  Handle handle = 0;
  const Clause* clause = nullptr;
  std::optional<data::Number> offset;
  Value value;
  Location where;
};

/// A stop, fault or person ended what a task waited for; no handler sees it.
struct Ended {
  Problem problem;
};

}  // namespace polyarm::program
