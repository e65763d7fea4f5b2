#pragma once
/// Runs a program as explicit state that its owner steps, for a cell the cell thread: tasks, frames, program
/// counters. It never blocks, so it can be paused between any two statements by not stepping it. One thread
/// at a time.
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "polyarm/program/code.hpp"
#include "polyarm/program/task_state.hpp"
#include "polyarm/vm/host.hpp"
#include "polyarm/vm/saved_state.hpp"

namespace polyarm::program {

struct PathStep;
struct Function;

struct TaskStatus {
  std::string name;
  TaskState state = TaskState::running;
  Location where;      ///< the present line: of the move that the robot executes, else of the statement that
                       ///< waits, else of the next statement
  std::string source;  ///< the text of that line
  Waiting waiting;
  std::uint64_t passes = 0;  ///< of outermost while loops, completed by the program, which queues moves ahead
  std::uint64_t cycles = 0;  ///< those of the passes whose moves have ended
  std::optional<Problem> problem;  ///< why it failed
  bool paused = false;             ///< it is before `where`, at a breakpoint or after a step
};

/// How far a paused program continues: to the next statement; to the next statement outside functions called
/// from here; to the statement after the present function call.
enum class StepKind { into, over, out };

/// The assumptions of a program that starts in the middle.
struct StartReport {
  Location where;
  std::string robot, tool, frame;  ///< used by its moves there
  std::string last_point;          ///< target of the last move before that line
  std::vector<std::string> sets;   ///< data and tags that the skipped lines would have set
  std::vector<std::string> reads;  ///< data and tags that the lines from there on read
};

struct VariableValue {
  std::string name;
  Value value;
};

struct StepResult {
  TaskState state = TaskState::running;  ///< of the whole program
  int executed = 0;  ///< number of statements begun; long ones, and work on large texts and lists, count as
                     ///< several
};

class Interpreter {
 public:
  /// `program` must have been parsed without errors; `host` must outlive this object.
  /// `test`: runs this test of the program, by its index in tests().
  Interpreter(Program program, Host& host, std::optional<std::size_t> test = {});
  Interpreter(std::shared_ptr<Compiled> compiled, Host& host, std::optional<std::size_t> test = {});
  Interpreter(const Interpreter&) = delete;
  Interpreter& operator=(const Interpreter&) = delete;
  ~Interpreter();

  /// Begins at most `budget` statements, with tasks in the order of the file, and returns earlier when every
  /// task waits or the program has ended. The cost of one statement is bounded by the length of its line and
  /// by the largest list and text; cost beyond an ordinary statement is deducted from the budget.
  StepResult step(int budget);
  /// Of the whole program. It has ended only after its `on stop` block has run.
  TaskState state() const;
  /// True from the end of its tasks on, while its `on stop` block has not run yet, too.
  bool ending() const { return outcome_.has_value(); }
  /// The lines outside tasks first, then the tasks in the order of the file.
  std::vector<TaskStatus> status() const;
  /// The most important task: one that failed, else the first that has not ended.
  TaskStatus overview() const;
  /// The same into a status that keeps its memory from call to call.
  void overview(TaskStatus& out) const;
  const Program& program() const { return program_; }
  const std::shared_ptr<Compiled>& compiled() const { return compiled_; }

  /// At the end of the nth pass of an outermost while, its condition is set to False if it is a plain name,
  /// and the loop ends. 0: unlimited.
  void limit_passes(std::uint64_t n) { pass_limit_ = n; }
  /// Ends the pulses whose time has passed; step() does so, too. Call it in each tick in which the program is
  /// not stepped.
  void end_pulses();
  /// The time at which the next pulse ends; empty: there is none.
  std::optional<Nanoseconds> next_pulse_end() const;
  /// Ends the program as stopped; the host ends what the program had requested. Its `on stop` block is still
  /// stepped.
  void stop();

  // Debugging: debugging.cpp

  /// Before the first step: starts the program at `line` of its own file. Executes `let`, `use` and `when`
  /// outside of blocks before it, and skips everything else. Throws Error if no statement begins there, or if
  /// the statement needs names that its enclosing block creates.
  StartReport start_at(int line);
  /// Sets breakpoints on these lines; each moves down to the next statement. Returns the resulting places.
  /// Places in unknown files, or after the last statement, are left out.
  std::vector<Location> set_breakpoints(const std::vector<Location>& places);
  std::vector<Location> breakpoints() const;
  /// The lines of the file with this name, or name ending, as read; null if it was not read.
  const std::vector<std::string>* lines_of(const std::string& name) const;
  bool has_file(const std::string& name) const { return lines_of(name) != nullptr; }
  /// Pauses before the next statement; queued motion continues.
  void pause() { pause_requested_ = true; }
  /// Before the first step: pauses at the start.
  void pause_here();
  bool paused() const { return paused_ != 0; }
  void resume();
  /// Executes one statement of the paused task.
  void resume_for(StepKind kind);
  /// The visible names of the task called `task`, innermost last; then those of the whole program.
  std::vector<VariableValue> variables(const std::string& task) const;
  /// The functions that the task is in, outermost first, each with its present line.
  std::vector<Location> calls(const std::string& task) const;
  /// The move defaults of that task at its present place.
  MoveDefaults uses(const std::string& task) const;
  /// True if every task that has not ended waits, without a timeout, for data or for other tasks: no clock and
  /// no motion lets any of them continue.
  bool waits_for_others() const;
  /// The place in overview(), for frequent calls.
  Place position() const;
  /// The cycles in overview(), for frequent calls.
  std::uint64_t cycles() const;
  /// The location of the innermost `on error` that would catch an error of the present task.
  std::optional<Location> handler() const;
  /// `call` is called when the wait of a task is over, before the task continues; it may inspect this object.
  void on_wait_over(std::function<void()> call) { wait_over_ = std::move(call); }

  // Saving and restoring after a power loss: saving.cpp

  /// True if another process could continue the program from here: all requested motion has arrived, and
  /// nothing else is under way.
  bool safe() const;
  /// Only if safe().
  SavedState save() const;
  /// Before the first step: continues from the saved state. Throws Error if the state belongs to another
  /// program.
  StartReport restore(const SavedState& from);

 private:
  struct Task;
  struct Watch;
  struct Course;

  // Tasks: interpreter.cpp
  Task& add_task(std::string name, int entry, bool shown);
  Task* task_of(std::uint64_t id) const;
  bool ended() const;
  bool run_task(Task& task, int& budget);
  void step_whens();
  void step_clean_up(int& budget);
  void finish_when_all_have();
  // Traps, timers, pulses: events.cpp
  void begin_event(Task& task, const Step& step);
  bool is_frozen(const Task& task) const;
  void spring_traps();
  void interrupt(Task& watcher, Task& owner);
  bool gone_back(Task& task);
  void collect_robots(const Task& task, std::vector<std::string>& out) const;
  bool is_due(Task& task, const Step& step);
  void pulse(Task& task, const Step& step);
  void end_program(TaskState outcome);
  void end_children(std::uint64_t parent);
  void end_watched_move(Task& task);
  void remove_children();
  void give_back_locks(Task& task, std::size_t keep);
  void raise(Task& task, Problem problem, bool catchable);
  void unwind(Task& task, const Problem& problem);
  void fail(Task& task, Problem problem);
  std::string called_from(const Task& task) const;
  void status_of(const Task& task, TaskStatus& out) const;
  std::uint64_t cycles_of(const Task& task) const;
  const Task& shown_task() const;
  Place place_of(const Task& task) const;
  const Task* working_child_of(const Task& task) const;
  void forget_arrived(Task& task) const;

  bool stops_here(Task& task);
  bool looks_for_stops() const { return resumed_ || pause_requested_ || stepping_ || !breakpoints_.empty(); }
  void run_prelude(const StartingPoint& start);
  void report_assumptions(const StartingPoint& start, StartReport& out) const;

  // Waiting: waiting.cpp
  bool poll(Task& task);
  bool poll_handles(Task& task);
  bool poll_until(Task& task);
  bool poll_condition(Task& task);
  bool poll_meeting(Task& task);
  bool poll_lock(Task& task);
  bool poll_together(Task& task);
  // Tasks that wait for each other: deadlock.cpp
  void fail_for_deadlock();
  std::vector<const Task*> tasks_in_deadlock() const;
  bool keeps_going(const Task& task, const std::vector<const Task*>& stuck) const;
  std::string why_stuck(const Task& task) const;
  bool deadline_passed(const Task& task) const;
  void time_out(Task& task);
  void wait_for(Task& task, WaitKind kind, std::string_view text = {});
  void go_on(Task& task);
  bool arrived(Task& task);
  void begin_look(Task& task, const Step& step, WaitKind kind);
  Nanoseconds time(const Value& value, Place place, bool bare_seconds) const;

  // Plain steps, many at once: run.cpp
  bool run(Task& task, int& budget);
  bool execute_whole(Task& task, int& budget);
  bool is_too_deep(const Task& task, const Step& step) const;
  void enter_function(Task& task, const Step& step);
  void give(Task& task, const Step& step);
  bool at_field(const data::Record& record, const Step& step, std::size_t& at);

  // Any one step: execute.cpp
  void execute(Task& task);
  void execute_plain(Task& task, const Step& step);
  bool result_of(Task& task, const Step& step, Value& result);
  bool calculate(Task& task, const Step& step);
  bool calculate_into_variable(Task& task, const Step& step);
  void execute_value(Task& task, const Step& step);
  bool push_host(Task& task, const Step& step);
  void take_field(Task& task, const Step& step);
  bool join_texts(Task& task, const Step& step);
  void make_parts(Task& task, const Step& step);
  bool call_function(Task& task, const Step& step);
  void use_one_frame(const Task& task, std::span<Value> arguments) const;
  bool call_in_pieces(Task& task, const Step& step);
  // Functions of the running program, on arguments_: live_functions.cpp
  Value live_call(const Task& task, const Function& function);
  Value joints_at(const MoveDefaults& use) const;
  Value pose_at(const MoveDefaults& use) const;
  Value random();
  bool take_answer(Task& task, const Step& step);

  // Names: execute_names.cpp
  void execute_name(Task& task, const Step& step);
  void change(Slot& variable, Value value, const std::string* origin, const Statement& s);
  void check_type(const Value& present, const Value& value, const Statement& s) const;
  bool set_element(Task& task, const Step& step);
  bool set_field(Task& task, const Step& step);
  bool append(Task& task, const Step& step);
  bool replace_part(Task& task, const Step& step);
  bool set_host(Task& task, const Step& step);
  void set_literal(Task& task, const Step& step);

  // Flow: execute_flow.cpp
  void execute_flow(Task& task, const Step& step);
  void begin_for(Task& task, const Step& step);
  void next_of_for(Task& task, const Step& step);
  void leave(Task& task, const Depths& to, int names);
  void end_pass(Task& task, const Step& step);
  void raise_step(Task& task, const Step& step);
  Location first_of_line(const std::string& file, double line) const;
  void retry(Task& task, const Step& step);
  void finish(Task& task);
  void execute_world(Task& task, const Step& step);
  [[noreturn]] void fail_at(Place place, std::string code, std::string what, std::string advice = {}) const;

  // Registers
  Slot& slot(Task& task, Operand operand);
  /// The value for a step; consumes a temporary; fails if there is none.
  Value take_value(Task& task, Operand operand, const Step& step);
  /// The value for a step, left in place.
  const Value& value_of(Task& task, Operand operand, const Step& step);
  /// Releases a temporary that has been read.
  void drop(Task& task, Operand operand);
  void release_now(Task& task, int first, int count);
  /// Fails unless all these consecutive registers have values.
  void require_values(Task& task, const Step& step, int first, int count);
  bool take_boolean(Task& task, Operand operand, const Step& step, const char* of);
  const StepSource& source(const Step& step) const {
    return code_.sources[static_cast<std::size_t>(&step - code_.steps.data())];
  }
  /// Charges work beyond an ordinary statement, in plain steps.
  void charge(std::size_t steps) { work_ += static_cast<int>(steps); }
  void charge_for(const Value& value);
  /// Continues the large work of the task's step; true when it is done.
  bool continue_work(Task& task);
  /// Makes `whole` and its parts along `path` unshared, with room for `more` values at the end of a list;
  /// false: not finished yet.
  bool part_from_others(Task& task, Value& whole, std::span<const PathStep> path, std::size_t more = 0);
  /// Registers as one text; false: not finished yet.
  bool write(Task& task, int first, int count, std::string_view between, std::string& text);

  // Motion and meetings: motion_steps.cpp
  void move(Task& task, const Step& step);
  void check_targets(const Task& task, const Step& step, std::size_t next) const;
  void note_commanded(Task& task, const std::string& robot);
  void use(Task& task, const Step& step);
  Move requested_move(Task& task, const Step& step, std::size_t first) const;
  void check_watches();
  void measure(Task& task) const;
  // World: world_steps.cpp
  void wait_step(Task& task, const Step& step);
  void until_step(Task& task, const Step& step);
  void ask(Task& task, const Step& step);
  void expect(Task& task, const Step& step);
  void report_unmet(Task& task, const Step& step);
  void meet(Task& task, const Step& step);
  void lock(Task& task, const Step& step);
  void together(Task& task, const Step& step);

  std::shared_ptr<Compiled> compiled_;
  const Program& program_;
  Code& code_;
  Host& host_;
  std::vector<std::unique_ptr<Task>> tasks_;
  std::vector<Slot> globals_;
  std::deque<std::string> origins_;                             ///< of restored slots
  std::map<std::string, std::vector<std::uint64_t>> meetings_;  ///< tasks that have arrived
  std::map<std::string, std::uint64_t> locks_;                  ///< the holder
  std::uint64_t groups_ = 0;                                    ///< number of groups of moves in step so far
  std::vector<Watch> watches_;
  struct Pulse {
    std::string name;
    Nanoseconds until = 0;
    Location where;
  };
  std::vector<Pulse> pulses_;
  std::function<void()> wait_over_;
  std::uint64_t last_id_ = 0;
  std::uint64_t random_;     ///< state of random()
  Nanoseconds began_;        ///< for clock()
  std::optional<std::size_t> test_;
  bool has_moves_;
  std::uint64_t pass_limit_ = 0;
  std::size_t turn_ = 0;
  int turn_left_ = 0;
  int work_ = 0;                      ///< work on large values that is not yet deducted from a budget
  data::Remains remains_;             ///< of large lists
  data::List arguments_;              ///< of the called function
  std::vector<std::uint32_t> found_;  ///< cached positions of fields
  struct Stepping {
    std::uint64_t task = 0;
    std::size_t most_frames = 0;
  };
  std::vector<Place> breakpoints_;
  std::uint64_t paused_ = 0;   ///< the paused task, or 0
  std::uint64_t resumed_ = 0;  ///< the task that continues after a pause
  bool pause_requested_ = false;
  std::optional<Stepping> stepping_;
  std::optional<Nanoseconds> looked_at_;  ///< last check of whens and watches
  std::optional<TaskState> outcome_;      ///< the outcome of an ending program
  bool cleaned_up_ = false;
};

}  // namespace polyarm::program
