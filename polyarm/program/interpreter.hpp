#pragma once
/// Runs a program as explicit state that the cell thread steps: tasks, frames, program counters. It never
/// blocks, so it can be paused between any two statements by not stepping it.
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "polyarm/program/code.hpp"
#include "polyarm/program/host.hpp"
#include "polyarm/program/task_state.hpp"

namespace polyarm::program {

struct TaskStatus {
  std::string name;
  TaskState state = TaskState::running;
  Location where;      ///< the statement that it executes or comes to next
  std::string source;  ///< the text of that line
  Waiting waiting;
  std::uint64_t passes = 0;        ///< of outermost while loops, completed
  std::optional<Problem> problem;  ///< why it failed
};

struct StepResult {
  TaskState state = TaskState::running;  ///< of the whole program
  int executed = 0;                      ///< statements begun
};

class Interpreter {
 public:
  /// `program` must have been parsed without errors; `host` has to outlive this.
  Interpreter(Program program, Host& host);
  Interpreter(const Interpreter&) = delete;
  Interpreter& operator=(const Interpreter&) = delete;
  ~Interpreter();

  /// Begins at most `budget` statements, the tasks in the order of the file, and returns earlier when every
  /// task waits or the program has ended.
  StepResult step(int budget);
  /// Of the whole program. It has ended once its `on stop` block has run, too.
  TaskState state() const;
  /// The lines outside of tasks first, then the tasks in the order of the file.
  std::vector<TaskStatus> status() const;
  /// The task that says most about the program: one that failed, else the first that has not ended.
  TaskStatus overview() const;
  const Program& program() const { return program_; }

  /// At the end of the nth pass of an outermost while, its condition is set False where it is a plain name,
  /// and the loop ends. 0: no limit.
  void limit_passes(std::uint64_t n) { pass_limit_ = n; }
  /// Ends the program as stopped; what it asked the host for is the host's to end. Its `on stop` block is
  /// still stepped.
  void stop();

 private:
  struct Task;
  struct Watch;

  // Tasks: interpreter.cpp
  Task& add_task(std::string name, int entry, bool shown);
  Task* task_of(std::uint64_t id) const;
  bool ended() const;
  bool run_task(Task& task, int& budget);
  void step_whens();
  void step_clean_up(int& budget);
  void finish_when_all_have();
  void end_program(TaskState outcome);
  void end_children(std::uint64_t parent);
  void remove_children();
  void give_back_locks(Task& task, std::size_t keep);
  void raise(Task& task, Problem problem, bool catchable);
  void unwind(Task& task, const Problem& problem);
  void fail(Task& task, Problem problem);
  TaskStatus status_of(const Task& task) const;

  // Waiting: waiting.cpp
  bool poll(Task& task);
  bool poll_handles(Task& task);
  bool poll_until(Task& task);
  bool poll_condition(Task& task);
  bool poll_meeting(Task& task);
  bool poll_lock(Task& task);
  bool poll_together(Task& task);
  bool deadline_passed(const Task& task) const;
  void time_out(Task& task);
  void wait_for(Task& task, WaitKind kind, std::string text = {});
  void go_on(Task& task);
  bool arrived(Task& task);
  void begin_look(Task& task, const Step& step, WaitKind kind);
  Nanoseconds time(const Value& value, Place place, bool bare_seconds) const;

  // Steps: execute.cpp
  void execute(Task& task);
  void execute_value(Task& task, const Step& step);
  void execute_name(Task& task, const Step& step);
  void execute_world(Task& task, const Step& step);
  void execute_flow(Task& task, const Step& step);
  bool push_host(Task& task, const Step& step);
  void push_field(Task& task, const Step& step);
  void call_builtin(Task& task, const Step& step);
  void enter(Task& task, const Step& step);
  void give(Task& task);
  void replace_part(Task& task, const Step& step);
  void change(Value& present, Value value, const Step& step);
  bool set_host(Task& task, const Step& step);
  void set_literal(Task& task, const Step& step);
  void begin_for(Task& task, const Step& step);
  void next_of_for(Task& task, const Step& step);
  void leave(Task& task, const Depths& to);
  void end_pass(Task& task, const Step& step);
  void retry(Task& task, const Step& step);
  void finish(Task& task);
  [[noreturn]] void fail_at(Place place, std::string code, std::string what, std::string advice = {}) const;
  Value pop(Task& task, Place place);
  void require_values(const Task& task, const Step& step, std::size_t count) const;
  bool pop_boolean(Task& task, const Step& step, const char* of);

  // Motion and meetings: motion_steps.cpp
  void move(Task& task, const Step& step);
  void check_targets(const Task& task, const Step& step, std::size_t next) const;
  void use(Task& task, const Step& step);
  Move asked_move(Task& task, const Step& step, std::size_t first) const;
  void look_at_watches();
  void wait_step(Task& task, const Step& step);
  void until_step(Task& task, const Step& step);
  void ask(Task& task, const Step& step);
  void meet(Task& task, const Step& step);
  void lock(Task& task, const Step& step);
  void together(Task& task, const Step& step);

  Program program_;
  Code code_;
  Host& host_;
  std::vector<std::unique_ptr<Task>> tasks_;
  std::vector<Slot> globals_;
  std::map<std::string, std::vector<std::uint64_t>> meetings_;  ///< who has come
  std::map<std::string, std::uint64_t> locks_;                  ///< who has it
  std::vector<Watch> watches_;
  std::uint64_t last_id_ = 0;
  std::uint64_t pass_limit_ = 0;
  std::size_t turn_ = 0;
  int turn_left_ = 0;
  std::optional<Nanoseconds> looked_at_;  ///< when whens and watches were last looked at
  std::optional<TaskState> outcome_;      ///< how it ends, once it does
  bool cleaned_up_ = false;
};

}  // namespace polyarm::program
