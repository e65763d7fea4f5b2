#pragma once
/// The programs of a cell: the robot program, the PLC, and a test where there is one; breakpoints and safe
/// points.
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "polyarm/io/parts.hpp"
#include "polyarm/machine/cell_data.hpp"
#include "polyarm/machine/motions.hpp"
#include "polyarm/setup/breakpoints.hpp"
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

  // Building, in this order. Each throws Error, or collects problems.
  /// Reads program and PLC with their data; connects the links; makes the PLC's task.
  void load(Problems& problems);
  void start_loaded(Problems& problems);

  /// The program's task; null when the cell has no program.
  Task* program() { return program_.get(); }
  const Task* program() const { return program_.get(); }
  Task* plc() { return plc_.get(); }
  const Task* plc() const { return plc_.get(); }
  /// The moves of the program; null without one.
  ProgramMoves* moves() { return moves_.get(); }
  Answers& answers() { return answers_; }
  /// What a task of the cell is made with.
  ProgramHost::Context context(const std::string& task) const;

  bool begun() const { return begun_; }
  /// It has begun and has not ended.
  bool under_way() const { return program_ && begun_ && !program_->ended(); }
  /// It is under way, so that nobody else may move. A paused program whose robots stand lets others move.
  bool runs() const;
  /// How often a program was made ready or begun.
  std::uint64_t starts() const { return starts_; }
  /// The cell goes on when its program ends, which begins on a request.
  bool waits() const { return waits_; }

  /// Begins the program `name` (a script or a script-information file; empty: the cell's own), read anew from
  /// its files. Throws Error while another one runs or robots move, and with what is wrong with it.
  void begin(const std::string& name, const Location& where);
  /// The same, paused before `line` of its file (0: its first statement), whatever ran before.
  program::StartReport prepare(const std::string& name, int line);
  /// Puts this program in the place of the present one, which has not begun or has ended; the cell goes on
  /// when it ends. It begins with let_begin(). Throws Error where nothing can be moved.
  void put(program::Program program);
  void let_begin() { begun_ = true; }
  /// Ends the program where it is: its moves end on their paths. Its `on stop` still runs.
  void end();
  /// Ends all of them (a person stopped the run).
  void stop_all();
  /// Before the first tick: the program goes on from where an earlier run was cut off. Throws Error where
  /// there is nothing to go on from, or the program has changed.
  program::StartReport continue_from_safe_point();
  /// At the end of a run: writes to the disk what lets the program go on later.
  void keep_safe_point();
  /// What grippers hold now; and, after continue_from_safe_point(), what they held when the run before was
  /// cut off.
  std::vector<std::string> held_parts() const { return held_parts_->names(machine_.snapshot()); }
  const std::vector<std::string>& held_before() const { return held_before_; }
  /// Of the names that the program waits for, one that nothing in the cell sets and that comes from a file
  /// which the run has copied: how others come to set it. Empty where there is none.
  std::string hint_of_live() const;
  /// Where a move of the program comes from; empty: none of the program's.
  Location place_of(const moves::RobotMotion& motion, std::uint64_t move) const;

  void tick_program();
  void tick_plc() {
    if (plc_) plc_->tick();
  }

  /// Where programs pause: in the present one, and in others of the cell's folder once they begin.
  std::vector<Location> breakpoints() const;
  /// The same with the texts that they are lines of, for the cell after this one.
  std::vector<FileBreakpoints> kept_breakpoints() const;
  /// At a line of `text`, or without one of what the program has read. It moves down to the next statement,
  /// in a program with an older text to that line in there, if it has it. Throws Error where there is no such
  /// program, or no statement.
  void add_breakpoint(const Location& place, const std::optional<TextLines>& text = {});
  void drop_breakpoint(const Location& place, const std::optional<TextLines>& text = {});
  void clear_breakpoints();
  /// The file reads `text` now, saved or not: its breakpoints move with their lines, or are at `lines` of it.
  void edit_breakpoints(const std::string& file, TextLines text,
                        const std::optional<std::vector<int>>& lines);

  /// A controller is unloaded: moves of the program through it are forgotten.
  void forget(const moves::RobotMotion& motion);
  void forget(const moves::BaseMotion& base);

 private:
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
  Answers answers_;
  std::unique_ptr<Task> program_, plc_;
  bool begun_ = true, waits_;
  std::uint64_t starts_ = 0;
  std::unique_ptr<SafePoints> safe_points_;
  std::unique_ptr<HeldParts> held_parts_;
  std::vector<std::string> held_before_;
  std::optional<program::Program> ready_;  // it begins when a test says so
  LoadedPrograms loaded_;
  Breakpoints breakpoints_;
};

}  // namespace polyarm::cell
