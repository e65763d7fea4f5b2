#pragma once
/// A running program of a cell, with its status.
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "polyarm/tasks/program_host.hpp"
#include "polyarm/vm/interpreter.hpp"

namespace polyarm::cell {

/// The robot program, the PLC or a test. Cell thread.
class Task {
 public:
  /// Maximum number of statements per tick.
  static constexpr int kBudget = 200;
  /// Of these, the number reported line by line; after that only the line that was reached is reported.
  static constexpr int kReported = 20;

  /// `test`: index of the test in the program, in text order.
  Task(std::string name, program::Program program, ProgramHost::Context context,
       std::optional<std::size_t> test = {});

  /// Runs until the task waits or ends or the budget is used up; reports reached lines to the observer.
  void tick();
  /// The same; calls `between` between statements: after each of the first kReported, then after the last.
  void tick(const std::function<void()>& between);
  program::Interpreter& interpreter() { return interpreter_; }
  const program::Interpreter& interpreter() const { return interpreter_; }
  /// Call after the interpreter was told where to start.
  void refresh() { look(); }
  const program::TaskStatus& status() const { return status_; }
  const std::string& name() const { return name_; }
  bool ended() const;
  bool failed() const { return status_.state == program::TaskState::failed; }
  bool moving() const { return host_.moving(); }
  /// Duration of the newest complete pass of the outermost loop, in cell time; empty before the second pass
  /// has ended.
  std::optional<Nanoseconds> last_pass() const { return last_pass_; }
  /// Cell time at which the present wait began; empty while it does not wait.
  std::optional<Nanoseconds> waits_since() const { return waits_since_; }
  /// Cell time since which it uses its whole budget each tick; empty if it waits or uses less.
  std::optional<Nanoseconds> busy_since() const { return busy_since_; }
  /// "PAPscript.script:12: wait GripperActive, waits for GripperActive"
  std::string sentence() const;
  /// The same for each of its tasks that has not ended.
  std::string sentences() const;

 private:
  void look();

  std::string name_;
  Observer* observer_;
  const Nanoseconds* now_;
  ProgramHost host_;
  program::Interpreter interpreter_;
  program::TaskStatus status_, before_;  // before_: the status before, whose memory the next one takes
  Location shown_;
  program::Place seen_;
  std::optional<Nanoseconds> pass_ended_, last_pass_, waits_since_, busy_since_;
};

}  // namespace polyarm::cell
