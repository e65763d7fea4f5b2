#pragma once
/// The state of a program as values that can be stored and restored by another process. Plain data.
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "polyarm/program/task_state.hpp"

namespace polyarm::program {

struct SavedSlot {
  data::Value value;
  std::string origin;  ///< the host's name of the point; empty: none
  bool set = true;
};

struct SavedTask {
  std::uint64_t id = 0;
  std::string name;
  bool shown = true, apart = false, met = false, was_true = false;
  int trap = -1;            ///< what looks at the condition of a trap: its index
  std::uint64_t owner = 0;  ///< the task that it interrupts
  bool sprung = false;
  std::vector<std::string> commanded;   ///< robots that it and its parts have moved
  std::optional<Nanoseconds> next_due;  ///< of an `every`: the rest of its time
  TaskState state = TaskState::running;
  std::size_t step = 0;
  std::vector<SavedSlot> stack;
  std::vector<CallFrame> frames;
  std::vector<MoveDefaults> uses;
  std::vector<std::string> locks;
  std::vector<Handler> handlers;
  WaitKind waits = WaitKind::none;
  std::string waits_at;                  ///< the name of a meeting or lock
  std::optional<Nanoseconds> waits_for;  ///< the rest of a timed wait
  std::optional<Nanoseconds> deadline;   ///< the rest of its timeout
  std::uint64_t passes = 0;
};

struct SavedState {
  std::uint64_t program = 0;  ///< hash of its text: the state is valid only for this program
  std::vector<SavedTask> tasks;
  std::vector<SavedSlot> globals;
  std::map<std::string, std::vector<std::uint64_t>> meetings;
  std::map<std::string, std::uint64_t> locks;
  std::uint64_t last_id = 0, groups = 0;
  std::uint64_t random = 0;       ///< state of random()
  Nanoseconds clock = 0;          ///< of clock()
};

}  // namespace polyarm::program
