#pragma once
#include <memory>
#include <optional>
#include <string>

#include "polyarm/cell/program_host.hpp"
#include "polyarm/program/interpreter.hpp"

namespace polyarm::cell {

/// A program at work in a cell: the robot program or the PLC. Cell thread.
class Task {
 public:
  /// Statements a task may execute in one tick.
  static constexpr int kBudget = 200;

  Task(std::string name, program::Program program, ProgramHost::Context context);

  /// Runs until it waits, ends, or the budget is used up; tells the observer of each line it comes to.
  void tick();
  program::Interpreter& interpreter() { return interpreter_; }
  const program::TaskStatus& status() const { return status_; }
  const std::string& name() const { return name_; }
  bool ended() const;
  bool failed() const { return status_.state == program::TaskState::failed; }
  bool moving() const { return host_.moving(); }
  /// "PAPscript.script:12: wait GripperActive, waits for GripperActive"
  std::string sentence() const;

 private:
  void look();

  std::string name_;
  Observer* observer_;
  const Nanoseconds* now_;
  ProgramHost host_;
  program::Interpreter interpreter_;
  program::TaskStatus status_;
  Location shown_;
};

}  // namespace polyarm::cell
