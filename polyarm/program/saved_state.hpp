#pragma once
/// Where a program stands, as values that can be written down and taken up again by another process.
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "polyarm/program/task_state.hpp"

namespace polyarm::program {

struct SavedSlot {
  data::Value value;
  std::string origin;  ///< what the host calls the point that this is; empty: nothing
  bool set = true;
};

struct SavedTask {
  std::uint64_t id = 0;
  std::string name;
  bool shown = true, apart = false, met = false, was_true = false;
  TaskState state = TaskState::running;
  std::size_t step = 0;
  std::vector<SavedSlot> stack;
  std::vector<CallFrame> frames;
  std::vector<MoveDefaults> uses;
  std::vector<std::string> locks;
  std::vector<Handler> handlers;
  WaitKind waits = WaitKind::none;
  std::string waits_at;                  ///< of a meeting or lock its name
  std::optional<Nanoseconds> waits_for;  ///< how much longer a wait for a time lasts
  std::optional<Nanoseconds> deadline;   ///< how much time is left of its time-out
  std::uint64_t passes = 0;
};

struct SavedState {
  std::uint64_t program = 0;  ///< of its text: the state fits this program alone
  std::vector<SavedTask> tasks;
  std::vector<SavedSlot> globals;
  std::map<std::string, std::vector<std::uint64_t>> meetings;
  std::map<std::string, std::uint64_t> locks;
  std::uint64_t last_id = 0, groups = 0;
};

}  // namespace polyarm::program
