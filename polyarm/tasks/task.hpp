#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "polyarm/tasks/program_host.hpp"
#include "polyarm/vm/interpreter.hpp"

namespace polyarm::cell {

/// A program at work in a cell: the robot program or the PLC. Cell thread.
class Task {
 public:
  /// Statements a task may execute in one tick.
  static constexpr int kBudget = 200;
  /// Of those so many are told line by line; then the line that it has come to.
  static constexpr int kTold = 20;

  /// `test`: that of the program's tests, in the order of the text.
  Task(std::string name, program::Program program, ProgramHost::Context context,
       std::optional<std::size_t> test = {});

  /// Runs until it waits, ends, or the budget is used up; tells the observer of lines that it comes to.
  void tick();
  /// The same; `between` is called behind statements, in front of the next: behind the first each, then the
  /// last.
  void tick(const std::function<void()>& between);
  program::Interpreter& interpreter() { return interpreter_; }
  const program::Interpreter& interpreter() const { return interpreter_; }
  /// After the interpreter was told where to begin.
  void refresh() { look(); }
  const program::TaskStatus& status() const { return status_; }
  const std::string& name() const { return name_; }
  bool ended() const;
  bool failed() const { return status_.state == program::TaskState::failed; }
  bool moving() const { return host_.moving(); }
  /// How long the newest whole pass of the outermost loop took, in cell time; none before the second has
  /// ended.
  std::optional<Nanoseconds> last_pass() const { return last_pass_; }
  /// Since when, in cell time, it waits for what it waits for; nothing while it does not wait.
  std::optional<Nanoseconds> waits_since() const { return waits_since_; }
  /// Since when, in cell time, it has used up all statements that it may begin in a tick; nothing while it
  /// waits or has less to do.
  std::optional<Nanoseconds> busy_since() const { return busy_since_; }
  /// "PAPscript.script:12: wait GripperActive, waits for GripperActive"
  std::string sentence() const;
  /// The same of each of its tasks that has not ended.
  std::string sentences() const;

 private:
  void look();

  std::string name_;
  Observer* observer_;
  const Nanoseconds* now_;
  ProgramHost host_;
  program::Interpreter interpreter_;
  program::TaskStatus status_;
  Location shown_;
  program::Place seen_;
  std::optional<Nanoseconds> pass_ended_, last_pass_, waits_since_, busy_since_;
};

}  // namespace polyarm::cell
