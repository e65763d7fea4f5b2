#pragma once
/// The programs of a cell: robot program, PLC and optional test; their breakpoints and safe points.
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "polyarm/io/parts.hpp"
#include "polyarm/machine/cell_data.hpp"
#include "polyarm/machine/motions.hpp"
#include "polyarm/io/breakpoints.hpp"
#include "polyarm/setup/build.hpp"
#include "polyarm/tasks/program_moves.hpp"
#include "polyarm/tasks/safe_points.hpp"
#include "polyarm/tasks/task.hpp"

namespace polyarm::cell {


/// Cell thread.
class Programs {
 public:
  Programs(const CellSetup& setup, Machine& machine, CellData& data, Motions& motions, Worker& worker,
           Observer& observer);
  ~Programs();

  // Construction; call in this order. Each function throws Error or collects problems.
  /// Reads program and PLC with their data, connects the links, and creates the PLC's task.
  void load(Problems& problems);
  void start_loaded(Problems& problems);

  /// The program's task; null if the cell has no program.
  Task* program() { return program_.get(); }
  const Task* program() const { return program_.get(); }
  Task* plc() { return plc_.get(); }
  const Task* plc() const { return plc_.get(); }
  /// The moves of the program; null without a program.
  ProgramMoves* moves() { return moves_.get(); }
  Answers& answers() { return answers_; }
  /// The context for a new task of the cell.
  ProgramHost::Context context(const std::string& task) const;

  bool begun() const { return begun_; }
  /// True if it has begun and has not ended.
  bool under_way() const { return program_ && begun_ && !program_->ended(); }
  /// True if it is under way and its tasks are: robots come to rest before an `on stop` block.
  bool leads() const { return under_way() && !program_->interpreter().ending(); }
  /// True if it is under way and nobody else may move. Others may move while a program is paused and its
  /// robots are at rest.
  bool runs() const;
  /// How many programs were prepared or started so far.
  std::uint64_t starts() const { return starts_; }
  /// True if the cell continues after its program has ended, so it can be started again.
  bool waits() const { return waits_; }

  /// Starts the program `name` (a script or a script-information file; empty: the cell's own), read again
  /// from its files. Throws Error while another program runs or robots move, and for errors in the program.
  void begin(const std::string& name, const Location& where);
  /// The same, but paused before `line` of its file (0: its first statement), whatever ran before.
  program::StartReport prepare(const std::string& name, int line);
  /// Replaces the present program, which has not begun or has ended; the cell continues after it ends.
  /// let_begin() starts it. Throws Error if no robot can be moved.
  void put(program::Program program);
  void let_begin() { begun_ = true; }
  /// Ends the program at its present line: its moves end on their paths. Its `on stop` still runs.
  void end();
  /// Ends all programs (a person stopped the run).
  void stop_all();
  /// Call before the first tick: continues the program where an earlier run was interrupted. Throws Error if
  /// there is no safe point or the program has changed.
  program::StartReport continue_from_safe_point();
  /// Call at the end of a run: writes the safe point to disk.
  void keep_safe_point();
  /// What the grippers hold now; and, after continue_from_safe_point(), what they held when the earlier run
  /// was interrupted.
  std::vector<std::string> held_parts() const { return held_parts_->names(machine_.snapshot()); }
  const std::vector<std::string>& held_before() const { return held_before_; }
  /// If the program waits for a name that nothing in the cell sets and whose file the run has copied: a hint
  /// how others can set it. Otherwise empty.
  std::string hint_of_live() const;
  /// The line of the program's move by which the robot may touch something now; empty: it may not.
  Location touch_of(const moves::RobotMotion& motion) const;
  /// True if this move is meant to touch.
  bool touches(const moves::RobotMotion& motion, std::uint64_t move) const;
  /// True if any robot may.
  bool touches() const;
  /// The program line of a move; empty if it is not from the program.
  Location place_of(const moves::RobotMotion& motion, std::uint64_t move) const;

  /// Call it in each tick before the motions: belts move, and robots that follow them; streams send and
  /// receive.
  void tick_belts_and_streams();
  /// True if a stream or the sensor of a real belt may end a wait.
  bool hears_devices() const;
  void tick_program();
  /// Call each tick in which the program is not ticked: its pulses end in time.
  void end_pulses();
  void tick_plc() {
    if (plc_) plc_->tick();
  }

  /// The breakpoints of the present program and of other programs in the cell's folder, which apply when
  /// those start.
  std::vector<Location> breakpoints() const;
  /// The same with the texts that the lines belong to, for a rebuilt cell.
  std::vector<FileBreakpoints> kept_breakpoints() const;
  /// Adds a breakpoint at a line of `text`; without it, of the text that the program has read. It moves down
  /// to the next statement. In a program with an older text it is set at the corresponding line, if there is
  /// one. Throws Error if there is no such program or no statement.
  void add_breakpoint(const Location& place, const std::optional<TextLines>& text = {});
  void drop_breakpoint(const Location& place, const std::optional<TextLines>& text = {});
  void clear_breakpoints();
  /// Reports that the file now reads `text`, saved or not: its breakpoints move with their lines, or to
  /// `lines`.
  void edit_breakpoints(const std::string& file, TextLines text,
                        const std::optional<std::vector<int>>& lines);

  /// Call when a controller is unloaded: removes the program's moves through it.
  void forget(const moves::RobotMotion& motion);
  void forget(const moves::BaseMotion& base);

 private:
  data::Point in_world(const data::Point& point) const;
  std::optional<Pose> on_robot(const data::RobotFrame& frame) const;
  void start(program::Program program);
  void keep_breakpoints(const FileBreakpoints& of_file);
  void place_breakpoints();
  const TextLines* lines_of_program(const std::string& file) const;
  int known_line(FileBreakpoints& file, int line, const std::optional<TextLines>& text) const;
  void continue_plc(const SafePoint& point);

  const CellSetup& setup_;
  Machine& machine_;
  CellData& data_;
  Motions& motions_;
  Worker& worker_;
  Observer& observer_;
  std::unique_ptr<ProgramMoves> moves_;  // of the program
  std::unique_ptr<ForceReadings> force_;
  std::unique_ptr<Belts> belts_;
  std::unique_ptr<Streams> streams_;
  Answers answers_;
  std::unique_ptr<Task> program_, plc_;
  bool begun_ = true, waits_;
  std::uint64_t starts_ = 0;
  std::unique_ptr<SafePoints> safe_points_;
  std::unique_ptr<HeldParts> held_parts_;
  std::vector<std::string> held_before_;
  std::optional<program::Program> ready_;  // a test starts it
  LoadedPrograms loaded_;
  Breakpoints breakpoints_;
};

}  // namespace polyarm::cell
