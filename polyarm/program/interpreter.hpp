#pragma once
/// Runs a program as explicit state that the cell thread steps: tasks, frames, program counter. It never
/// blocks, so it can be paused between any two statements by not stepping it.
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "polyarm/program/code.hpp"
#include "polyarm/program/evaluator.hpp"
#include "polyarm/program/host.hpp"

namespace polyarm::program {

enum class TaskState { running, waiting, finished, failed, stopped };

const char* name(TaskState state);

enum class WaitKind { none, time, condition, move, user, load };

/// What a task waits for.
struct Waiting {
  WaitKind kind = WaitKind::none;
  std::optional<Nanoseconds> until;  ///< of a time; of a condition its timeout, if it has one
  std::vector<std::string> names;    ///< of a condition: the data and tags that it reads
  std::string text;                  ///< of a move the point, of a load the file, of a user the question
};

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
  int executed = 0;                      ///< steps taken
};

class Interpreter {
 public:
  /// `program` must have been parsed without errors; `host` has to outlive this.
  Interpreter(Program program, Host& host);
  Interpreter(const Interpreter&) = delete;
  Interpreter& operator=(const Interpreter&) = delete;

  /// Takes at most `budget` steps, and returns earlier when every task waits or the program has ended.
  StepResult step(int budget);
  TaskState state() const;
  std::vector<TaskStatus> status() const;
  const Program& program() const { return program_; }

  /// At the end of the nth pass of an outermost while, its condition is set False where it is a plain name,
  /// and the loop ends. 0: no limit.
  void limit_passes(std::uint64_t n) { pass_limit_ = n; }
  /// Ends the program as stopped; what it asked the host for is the host's to end.
  void stop();

 private:
  struct Task {
    std::string name;
    TaskState state = TaskState::running;
    std::size_t pc = 0;
    std::vector<Frame> frames = std::vector<Frame>(1);
    Waiting waiting;
    Handle handle = 0;
    std::uint64_t seen_version = 0;
    std::uint64_t passes = 0;
    std::optional<Problem> problem;
    Frame& frame() { return frames.back(); }
  };

  bool step_task(Task& task, int& budget);
  void execute(Task& task, const Step& step);
  void execute_flow(Task& task, const Step& step);
  void fail(Task& task, Problem problem);

  void begin_load(Task& task, const Statement& s);
  void begin_move(Task& task, const Statement& s);
  void begin_wait(Task& task, const Statement& s);
  void begin_ask(Task& task, const Statement& s);
  void begin_wait_time(Task& task, Nanoseconds duration);
  bool poll(Task& task);
  bool poll_handle(Task& task, const Step& step);
  bool poll_condition(Task& task, const Step& step);
  void time_out(Task& task, const Step& step);
  void end_wait(Task& task);

  void assign(Task& task, const Statement& s);
  void assign_checked(Task& task, const Statement& s, Value value);
  void declare(Task& task, const Statement& s);
  void begin_for(Task& task, const Statement& s);
  void next_of_for(Task& task, const Step& step);
  void end_pass(Task& task, const Step& step);
  void write_log(Task& task, const Statement& s);
  Evaluator evaluator(Task& task) const { return {program_, host_, task.frame()}; }

  Program program_;
  Code code_;
  Host& host_;
  std::vector<Task> tasks_;
  std::uint64_t pass_limit_ = 0;
};

}  // namespace polyarm::program
